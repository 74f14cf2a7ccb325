//! From pixels to planes.

use rayon::prelude::*;

use super::{Coding, FRACTION, Layout, MEAN_BITS, Sampling, Siting, codes, fixed, weights};
use crate::frame::Rgba;
use crate::geom::Size;

/// Fixed-point factors from RGB to codes: of red, green and blue, and what is added.
struct ToYuv {
    luma: [i32; 4],
    u: [i32; 4],
    v: [i32; 4],
}

impl ToYuv {
    fn new(coding: Coding) -> Self {
        let (red, blue) = weights(coding.matrix);
        let green = 1.0 - red - blue;
        let (black, luma, chroma) = codes(coding.range);
        // The last factor balances the others to the exact sum, so that white is white and greys
        // are neutral.
        let half = 1 << (FRACTION - 1);
        let scale = luma / 255.0;
        let (r, b) = (fixed(red * scale, FRACTION), fixed(blue * scale, FRACTION));
        let luma = [r, fixed(scale, FRACTION) - r - b, b, (black << FRACTION) + half];
        let bits = FRACTION - MEAN_BITS;
        let main = fixed(0.5 * chroma / 255.0, bits);
        let minor = |weight: f64, of: f64| fixed(-0.5 * weight / (1.0 - of) * chroma / 255.0, bits);
        let add = (128 << FRACTION) + half;
        let (u_red, v_blue) = (minor(red, blue), minor(blue, red));
        debug_assert!(green > 0.0, "green carries most of the luma");
        Self { luma, u: [u_red, -main - u_red, main, add], v: [main, -main - v_blue, v_blue, add] }
    }
}

fn mix(factors: &[i32; 4], [r, g, b]: [i32; 3]) -> u8 {
    let sum = factors[0] * r + factors[1] * g + factors[2] * b + factors[3];
    (sum >> FRACTION).clamp(0, 255) as u8
}

/// Turns pixels of `size` into planes of `layout`, which replace the contents of `out`. A layout
/// that is larger than `size` is filled up by repeating the last column and row. Alpha goes to its
/// plane, or is lost if there is none.
///
/// # Panics
/// When `pixels` are not width x height, or the layout is smaller than they are.
pub fn from_rgba(size: Size, pixels: &[Rgba], layout: &Layout, coding: Coding, out: &mut Vec<u8>) {
    assert_eq!(pixels.len(), size.pixels(), "a frame holds width x height pixels");
    let full = layout.size;
    assert!(full.width >= size.width && full.height >= size.height, "the layout holds the frame");
    out.resize(layout.bytes(), 0);
    let factors = ToYuv::new(coding);
    let width = full.width as usize;
    let row = |y: usize| {
        let y = y.min(size.height as usize - 1);
        &pixels[y * size.width as usize..][..size.width as usize]
    };
    let (luma, rest) = out.split_at_mut(full.pixels());
    luma.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let source = row(y);
        for (out, &[r, g, b, _]) in out.iter_mut().zip(source) {
            *out = mix(&factors.luma, [r.into(), g.into(), b.into()]);
        }
        let edge = out[source.len() - 1];
        out[source.len()..].fill(edge);
    });
    let (chroma_width, chroma_height) = layout.chroma();
    let (u, rest) = rest.split_at_mut(chroma_width * chroma_height);
    let (v, alpha) = rest.split_at_mut(chroma_width * chroma_height);
    if chroma_width > 0 {
        let rows = u.par_chunks_mut(chroma_width).zip(v.par_chunks_mut(chroma_width));
        rows.enumerate().for_each(|(y, (u, v))| {
            let (upper, lower) = match layout.sampling {
                Sampling::Yuv420 => (row(2 * y), row((2 * y + 1).min(full.height as usize - 1))),
                _ => (row(y), row(y)),
            };
            for (x, (u, v)) in u.iter_mut().zip(v).enumerate() {
                let mean = mean(layout, upper, lower, x);
                *u = mix(&factors.u, mean);
                *v = mix(&factors.v, mean);
            }
        });
    }
    if layout.alpha {
        alpha.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            let source = row(y);
            for (x, out) in out.iter_mut().enumerate() {
                *out = source[x.min(source.len() - 1)][3];
            }
        });
    }
}

/// The RGB that chroma sample `x` stands for, in eighths: the mean over the columns that are
/// nearest to its place, weighted by how much of them it covers.
fn mean(layout: &Layout, upper: &[Rgba], lower: &[Rgba], x: usize) -> [i32; 3] {
    let last = upper.len() - 1;
    let column = |x: usize| {
        let (a, b) = (upper[x.min(last)], lower[x.min(last)]);
        [0, 1, 2].map(|i| i32::from(a[i]) + i32::from(b[i]))
    };
    if layout.sampling == Sampling::Yuv444 {
        return column(x).map(|c| 4 * c);
    }
    let (left, right) = (column(2 * x), column(2 * x + 1));
    match layout.siting {
        Siting::Centre => [0, 1, 2].map(|i| 2 * (left[i] + right[i])),
        Siting::Left => {
            let before = column((2 * x).saturating_sub(1));
            [0, 1, 2].map(|i| before[i] + 2 * left[i] + right[i])
        }
    }
}
