//! Converts planes to pixels.

use super::{CHROMA_BITS, Coding, FRACTION, Layout, Rgba, Sampling, Siting, codes, fixed, weights};
use crate::simd::dispatch;

/// Fixed-point factors from codes to RGB.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FromYuv {
    black: i32,
    luma: i32,
    red_v: i32,
    green_u: i32,
    green_v: i32,
    blue_u: i32,
}

impl FromYuv {
    /// The factors for `coding`.
    pub(crate) fn new(coding: Coding) -> Self {
        let (red, blue) = weights(coding.matrix);
        let green = 1.0 - red - blue;
        let (black, luma, chroma) = codes(coding.range);
        let chroma = |factor: f64| fixed(factor * 255.0 / chroma, FRACTION - CHROMA_BITS);
        Self {
            black,
            luma: fixed(255.0 / luma, FRACTION),
            red_v: chroma(2.0 * (1.0 - red)),
            green_u: chroma(-2.0 * (1.0 - blue) * blue / green),
            green_v: chroma(-2.0 * (1.0 - red) * red / green),
            blue_u: chroma(2.0 * (1.0 - blue)),
        }
    }

    /// The colour of luma `y` and chroma `u`, `v` in sixteenths.
    #[inline(always)]
    fn pixel(&self, y: u8, u: u16, v: u16, alpha: u8) -> Rgba {
        const NEUTRAL: i32 = 128 << CHROMA_BITS;
        let luma = (i32::from(y) - self.black) * self.luma + (1 << (FRACTION - 1));
        let (u, v) = (i32::from(u) - NEUTRAL, i32::from(v) - NEUTRAL);
        let byte = |sum: i32| (sum >> FRACTION).clamp(0, 255) as u32;
        let red = byte(luma + self.red_v * v);
        let green = byte(luma + self.green_u * u + self.green_v * v);
        let blue = byte(luma + self.blue_u * u);
        // One 32-bit number for each pixel: compilers vectorise these.
        (red | green << 8 | blue << 16 | u32::from(alpha) << 24).to_le_bytes()
    }

    /// The opaque colour of mean codes: luma, Cb and Cr, each as a sum and the number of its samples, above 0.
    pub(crate) fn mean(&self, codes: [(u64, u64); 3]) -> Rgba {
        // Means are rounded to 1/256 code before the colour is rounded.
        const BITS: u32 = 8;
        let [y, u, v] = codes.map(|(sum, count)| (((sum << BITS) + count / 2) / count) as i64);
        let luma = (y - (i64::from(self.black) << BITS)) * i64::from(self.luma);
        let chroma =
            |factor: i32, code: i64| ((code - (128 << BITS)) * i64::from(factor)) << CHROMA_BITS;
        let byte = |sum: i64| {
            let half = 1 << (FRACTION + BITS - 1);
            ((luma + sum + half) >> (FRACTION + BITS)).clamp(0, 255) as u8
        };
        let green = chroma(self.green_u, u) + chroma(self.green_v, v);
        [byte(chroma(self.red_v, v)), byte(green), byte(chroma(self.blue_u, u)), 255]
    }
}

/// Converts the planes in `data` to pixels, which replace the contents of `out`.
///
/// # Panics
/// When `data` is not [`Layout::bytes`] long.
pub fn to_rgba(layout: &Layout, coding: Coding, data: &[u8], out: &mut Vec<Rgba>) {
    out.resize(layout.size.pixels(), [0; 4]);
    RowsToRgba::new(layout, coding, data).make(0, out);
}

/// Converts planes to pixels, some rows at a time.
#[derive(Debug)]
pub(crate) struct RowsToRgba<'a> {
    layout: &'a Layout,
    data: &'a [u8],
    factors: FromYuv,
    /// Scratch for the chroma of a row.
    us: Vec<u16>,
    vs: Vec<u16>,
    blend: Vec<u16>,
}

impl<'a> RowsToRgba<'a> {
    /// Of the planes in `data`.
    ///
    /// # Panics
    /// When `data` is not [`Layout::bytes`] long.
    pub(crate) fn new(layout: &'a Layout, coding: Coding, data: &'a [u8]) -> Self {
        assert_eq!(data.len(), layout.bytes(), "the planes fit the layout");
        let row = || vec![128 << CHROMA_BITS; layout.size.width as usize];
        let (factors, blend) = (FromYuv::new(coding), vec![0; layout.chroma().0]);
        Self { layout, data, factors, us: row(), vs: row(), blend }
    }

    /// Fills `out` with the rows from row `first` on.
    pub(crate) fn make(&mut self, first: usize, out: &mut [Rgba]) {
        let Self { layout, data, factors, us, vs, blend } = self;
        let width = layout.size.width as usize;
        let [luma, u, v, alpha] = layout.split(data);
        for (row, out) in (first..).zip(out.chunks_mut(width)) {
            dispatch(
                #[inline(always)]
                || {
                    upsample(layout, u, row, blend, us);
                    upsample(layout, v, row, blend, vs);
                    let luma = &luma[row * width..][..width];
                    let alpha = layout.alpha.then(|| &alpha[row * width..][..width]);
                    join(factors, luma, (us, vs), alpha, out);
                },
            );
        }
    }
}

/// A row of pixels from luma, chroma in sixteenths, and alpha if there is any.
#[inline(always)]
fn join(
    factors: &FromYuv,
    luma: &[u8],
    (us, vs): (&[u16], &[u16]),
    alpha: Option<&[u8]>,
    out: &mut [Rgba],
) {
    let planes = luma.iter().zip(us.iter().zip(vs));
    if let Some(alpha) = alpha {
        for ((out, (&y, (&u, &v))), &a) in out.iter_mut().zip(planes).zip(alpha) {
            *out = factors.pixel(y, u, v, a);
        }
    } else {
        for (out, (&y, (&u, &v))) in out.iter_mut().zip(planes) {
            *out = factors.pixel(y, u, v, 255);
        }
    }
}

/// The chroma of luma row `row`, a sample for each column, in sixteenths. Without chroma `out` is not changed.
#[inline(always)]
fn upsample(layout: &Layout, plane: &[u8], row: usize, blend: &mut [u16], out: &mut [u16]) {
    let (width, height) = layout.chroma();
    let line = |y: usize| &plane[y * width..][..width];
    match layout.sampling {
        Sampling::Gray => {}
        Sampling::Yuv444 => {
            for (out, &c) in out.iter_mut().zip(line(row)) {
                *out = u16::from(c) << 4;
            }
        }
        Sampling::Yuv422 => {
            for (out, &c) in blend.iter_mut().zip(line(row)) {
                *out = u16::from(c) << 2;
            }
            widen(layout.siting, blend, out);
        }
        Sampling::Yuv420 => {
            // A row of luma lies a quarter of the way from its own row of chroma to the next one
            // above (even rows) or below (odd ones).
            let near = row / 2;
            let far = if row.is_multiple_of(2) {
                near.saturating_sub(1)
            } else {
                (near + 1).min(height - 1)
            };
            for ((out, &n), &f) in blend.iter_mut().zip(line(near)).zip(line(far)) {
                *out = 3 * u16::from(n) + u16::from(f);
            }
            widen(layout.siting, blend, out);
        }
    }
}

/// Two columns for each sample of `row` (in quarters); `out` is in sixteenths.
#[inline(always)]
fn widen(siting: Siting, row: &[u16], out: &mut [u16]) {
    let last = row.len() - 1;
    // The columns between two samples, and before the first one.
    let (head, rest) = out.split_at_mut(1);
    let near = row.windows(2);
    match siting {
        Siting::Left => {
            head[0] = 4 * row[0];
            for (pair, w) in rest.chunks_exact_mut(2).zip(near) {
                pair[0] = 2 * (w[0] + w[1]);
                pair[1] = 4 * w[1];
            }
        }
        Siting::Centre => {
            head[0] = 4 * row[0];
            for (pair, w) in rest.chunks_exact_mut(2).zip(near) {
                pair[0] = 3 * w[0] + w[1];
                pair[1] = 3 * w[1] + w[0];
            }
        }
    }
    // An even width ends half a sample after the last one.
    if let Some(end) = rest.get_mut(2 * last) {
        *end = 4 * row[last];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chroma_ramps_are_interpolated_where_they_sit() {
        // Chroma that rises with x, sampled at its siting, must come back at every column.
        for (siting, offset) in [(Siting::Left, 0), (Siting::Centre, 8)] {
            let row: Vec<u16> = (0..8).map(|x| (16 * (2 * x + 4) + offset) as u16 / 4).collect();
            let mut out = [0; 16];
            widen(siting, &row, &mut out);
            for (x, &c) in out.iter().enumerate().take(15).skip(1) {
                assert_eq!(c, 16 * (x as u16 + 4), "{siting:?}, column {x}");
            }
        }
    }
}
