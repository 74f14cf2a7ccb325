//! From pixels to planes.

use rayon::prelude::*;

use super::{Coding, FRACTION, Layout, MEAN_BITS, ROWS, Sampling, Siting, codes, fixed, weights};
use crate::frame::Rgba;
use crate::geom::Size;
use crate::vector::widest;

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

/// Red, green and blue mixed by `factors`, without what is added.
#[inline(always)]
fn mix(factors: &[i32; 4], pixel: Rgba) -> i32 {
    let pixel = u32::from_le_bytes(pixel);
    let channel = |shift: u32| (pixel >> shift & 0xff) as i32;
    factors[0] * channel(0) + factors[1] * channel(8) + factors[2] * channel(16)
}

#[inline(always)]
fn code(factors: &[i32; 4], sum: i32) -> u8 {
    ((sum + factors[3]) >> FRACTION).clamp(0, 255) as u8
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
    luma.par_chunks_mut(width).enumerate().with_min_len(ROWS).for_each(|(y, out)| {
        let source = row(y);
        widest(
            #[inline(always)]
            || {
                for (out, &pixel) in out.iter_mut().zip(source) {
                    *out = code(&factors.luma, mix(&factors.luma, pixel));
                }
            },
        );
        let edge = out[source.len() - 1];
        out[source.len()..].fill(edge);
    });
    let (chroma_width, chroma_height) = layout.chroma();
    let (u, rest) = rest.split_at_mut(chroma_width * chroma_height);
    let (v, alpha) = rest.split_at_mut(chroma_width * chroma_height);
    if chroma_width > 0 {
        let rows = u.par_chunks_mut(chroma_width).zip(v.par_chunks_mut(chroma_width));
        rows.enumerate().with_min_len(ROWS).for_each_init(Vec::new, |mixed, (y, (u, v))| {
            let pair = match layout.sampling {
                Sampling::Yuv420 => (row(2 * y), row((2 * y + 1).min(full.height as usize - 1))),
                _ => (row(y), row(y)),
            };
            for (out, factors) in [(u, &factors.u), (v, &factors.v)] {
                widest(
                    #[inline(always)]
                    || narrow(layout, pair, factors, mixed, out),
                );
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

/// A row of chroma: each sample the mean over the columns that are nearest to its place, weighted by
/// how much of them it covers, in the two rows of `pair`. `mixed` is memory to work in.
#[inline(always)]
fn narrow(
    layout: &Layout,
    (upper, lower): (&[Rgba], &[Rgba]),
    factors: &[i32; 4],
    mixed: &mut Vec<i32>,
    out: &mut [u8],
) {
    // The columns' sums, the first and the last once more for what lies beyond them.
    mixed.clear();
    mixed.resize(2 * out.len() + 2, 0);
    let (first, columns) = mixed.split_at_mut(1);
    let (columns, beyond) = columns.split_at_mut(upper.len());
    for (sum, (&a, &b)) in columns.iter_mut().zip(upper.iter().zip(lower)) {
        *sum = mix(factors, a) + mix(factors, b);
    }
    first[0] = columns[0];
    beyond.fill(columns[columns.len() - 1]);
    if layout.sampling == Sampling::Yuv444 {
        for (out, &sum) in out.iter_mut().zip(&mixed[1..]) {
            *out = code(factors, 4 * sum);
        }
        return;
    }
    let (pairs, _) = mixed.as_chunks::<2>();
    match layout.siting {
        Siting::Centre => {
            for (out, (&[_, left], &[right, _])) in
                out.iter_mut().zip(pairs.iter().zip(&pairs[1..]))
            {
                *out = code(factors, 2 * (left + right));
            }
        }
        Siting::Left => {
            for (out, (&[before, left], &[right, _])) in
                out.iter_mut().zip(pairs.iter().zip(&pairs[1..]))
            {
                *out = code(factors, before + 2 * left + right);
            }
        }
    }
}
