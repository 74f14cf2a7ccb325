//! Converts pixels to planes.

use super::{Coding, FRACTION, Layout, MEAN_BITS, Rgba, Sampling, Siting, codes, fixed, weights};
use crate::geom::Size;
use crate::simd::dispatch;

/// Fixed-point factors from RGB to codes: of red, green and blue, and the offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ToYuv {
    luma: [i32; 4],
    u: [i32; 4],
    v: [i32; 4],
}

impl ToYuv {
    /// The factors for `coding`.
    pub(crate) fn new(coding: Coding) -> Self {
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

    /// The codes of `colour`: luma, Cb, Cr. Alpha is ignored.
    pub(crate) fn codes(&self, [r, g, b, _]: Rgba) -> [u8; 3] {
        let sums = [r, g, b].map(u32::from);
        // The factors of chroma are for sums of eight pixels.
        let eight = sums.map(|sum| sum << MEAN_BITS);
        [code(self.luma, sums), code(self.u, eight), code(self.v, eight)]
    }
}

/// Red, green and blue mixed.
#[inline(always)]
fn code([of_red, of_green, of_blue, add]: [i32; 4], sums: [u32; 3]) -> u8 {
    let [red, green, blue] = sums.map(|sum| sum as i32);
    ((of_red * red + of_green * green + of_blue * blue + add) >> FRACTION).clamp(0, 255) as u8
}

/// Converts pixels of `size` to planes of `layout`, which replace the contents of `out`. A layout larger than `size`
/// is filled by repeating the last column and row. Alpha goes to its plane, if the layout has one.
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
    let [luma, u, v, alpha] = layout.split_mut(out);
    let chroma_width = layout.chroma().0;
    if chroma_width == 0 {
        for (y, out) in luma.chunks_mut(width).enumerate() {
            dispatch(
                #[inline(always)]
                || brightness(&factors, row(y), out),
            );
        }
    } else {
        // The rows with the same row of chroma, while they are in the cache.
        let rows = if layout.sampling == Sampling::Yuv420 { 2 } else { 1 };
        let chroma = u.chunks_mut(chroma_width).zip(v.chunks_mut(chroma_width));
        let mut columns = Columns::default();
        for (y, (luma, (u, v))) in luma.chunks_mut(rows * width).zip(chroma).enumerate() {
            let first = rows * y;
            let last = (first + rows).min(full.height as usize) - 1;
            dispatch(
                #[inline(always)]
                || {
                    for (y, out) in (first..).zip(luma.chunks_mut(width)) {
                        brightness(&factors, row(y), out);
                    }
                    columns.take(row(first), row(last), 2 * u.len());
                    columns.narrow(layout, &factors, u, v);
                },
            );
        }
    }
    if layout.alpha {
        for (y, out) in alpha.chunks_mut(width).enumerate() {
            let source = row(y);
            for (x, out) in out.iter_mut().enumerate() {
                *out = source[x.min(source.len() - 1)][3];
            }
        }
    }
}

/// Both samples of chroma from sums over eight pixels: red and blue in one number, and green.
#[inline(always)]
fn chroma(factors: &ToYuv, red_blue: u32, green: u32) -> (u8, u8) {
    let sums = [red_blue & 0xffff, green, red_blue >> 16];
    (code(factors.u, sums), code(factors.v, sums))
}

/// A row of luma.
#[inline(always)]
fn brightness(factors: &ToYuv, source: &[Rgba], out: &mut [u8]) {
    for (out, &pixel) in out.iter_mut().zip(source) {
        let pixel = u32::from_le_bytes(pixel);
        *out = code(factors.luma, [0, 8, 16].map(|shift| pixel >> shift & 0xff));
    }
    let edge = out[source.len() - 1];
    out[source.len()..].fill(edge);
}

/// The sums of the columns of two rows of pixels, with one more column on the left, and on the right one more or as
/// many as the layout has; these repeat their neighbours.
#[derive(Default)]
struct Columns {
    /// Red in the lower and blue in the upper half of each number.
    red_blue: Vec<u32>,
    green: Vec<u32>,
}

impl Columns {
    /// Sums `upper` and `lower`, for `count` columns or one more.
    #[inline(always)]
    fn take(&mut self, upper: &[Rgba], lower: &[Rgba], count: usize) {
        let [red_blue, green] = [&mut self.red_blue, &mut self.green];
        red_blue.resize(count + 2, 0);
        green.resize(count + 2, 0);
        let columns = red_blue[1..].iter_mut().zip(&mut green[1..]);
        for ((red_blue, green), (&a, &b)) in columns.zip(upper.iter().zip(lower)) {
            let [a, b] = [a, b].map(u32::from_le_bytes);
            *red_blue = (a & 0x00ff_00ff) + (b & 0x00ff_00ff);
            *green = (a >> 8 & 0xff) + (b >> 8 & 0xff);
        }
        for sums in [red_blue, green] {
            sums[0] = sums[1];
            let last = sums[upper.len()];
            sums[upper.len() + 1..].fill(last);
        }
    }

    /// A row of chroma: each sample is the mean of the nearest columns, weighted by its overlap with them.
    #[inline(always)]
    fn narrow(&self, layout: &Layout, factors: &ToYuv, u: &mut [u8], v: &mut [u8]) {
        let [red_blue, green] = [&self.red_blue, &self.green].map(|sums| sums.as_chunks::<2>().0);
        let out = u.iter_mut().zip(v);
        if layout.sampling == Sampling::Yuv444 {
            let columns = self.red_blue[1..].iter().zip(&self.green[1..]);
            for (out, (&red_blue, &green)) in out.zip(columns) {
                (*out.0, *out.1) = chroma(factors, 4 * red_blue, 4 * green);
            }
            return;
        }
        let sums = red_blue.iter().zip(&red_blue[1..]).zip(green.iter().zip(&green[1..]));
        match layout.siting {
            Siting::Centre => {
                for (out, (([_, r], [s, _]), ([_, g], [h, _]))) in out.zip(sums) {
                    let (red_blue, green) = (2 * (r + s), 2 * (g + h));
                    (*out.0, *out.1) = chroma(factors, red_blue, green);
                }
            }
            Siting::Left => {
                for (out, (([q, r], [s, _]), ([f, g], [h, _]))) in out.zip(sums) {
                    let (red_blue, green) = (q + 2 * r + s, f + 2 * g + h);
                    (*out.0, *out.1) = chroma(factors, red_blue, green);
                }
            }
        }
    }
}
