//! Between RGB frames and planar Y'CbCr, the form in which video travels.
//!
//! Matrices and ranges: ITU-R BT.601-7, BT.709-6 and BT.2020-2 (non-constant luminance), 8 bits.
//! Sums are whole numbers with 18 bits of fraction and are rounded once, halves upwards. Subsampled
//! chroma is interpolated linearly on the way in and averaged over its area on the way out, both
//! before that one rounding, so that a flat colour comes back within 2 of itself.

use rayon::prelude::*;

use crate::frame::{Colorimetry, Rgba};
use crate::geom::Size;

/// Bits of fraction in a conversion; the largest sum stays below 2^30.
const FRACTION: u32 = 18;
/// Interpolated chroma is in sixteenths, averaged RGB in eighths.
const CHROMA_BITS: u32 = 4;
const MEAN_BITS: u32 = 3;

/// How RGB is mixed to luma and chroma.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matrix {
    /// ITU-R BT.601: standard definition, JPEG.
    Bt601,
    /// ITU-R BT.709: high definition.
    Bt709,
    /// ITU-R BT.2020, non-constant luminance: ultra high definition.
    Bt2020,
}

/// Which of the 256 codes carry the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Luma 16..=235, chroma 16..=240 (`tv`).
    Limited,
    /// All codes (`pc`, JPEG).
    Full,
}

/// The meaning of the codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coding {
    /// Mixing of RGB.
    pub matrix: Matrix,
    /// Codes in use.
    pub range: Range,
}

impl Coding {
    /// What `tags` say of a picture of `size`. What they leave out, or name but is none of
    /// [`Matrix`], is limited range and the players' convention: BT.709 for pictures that are wider
    /// than 1279 or higher than 576 pixels, BT.601 for smaller ones (as mpv and browsers have it).
    pub fn of(tags: &Colorimetry, size: Size) -> Self {
        let matrix = match tags.matrix.as_deref() {
            Some("bt709") => Matrix::Bt709,
            Some("smpte170m" | "bt470bg" | "fcc") => Matrix::Bt601,
            Some("bt2020nc" | "bt2020c") => Matrix::Bt2020,
            _ if size.width >= 1280 || size.height > 576 => Matrix::Bt709,
            _ => Matrix::Bt601,
        };
        let full = matches!(tags.range.as_deref(), Some("pc" | "full" | "jpeg"));
        Self { matrix, range: if full { Range::Full } else { Range::Limited } }
    }
}

/// How many chroma samples there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// No chroma at all.
    Gray,
    /// Half in both directions (rounded up).
    Yuv420,
    /// Half in each row (rounded up).
    Yuv422,
    /// As many as luma.
    Yuv444,
}

/// Where a chroma sample that belongs to two columns of luma sits; between rows always halfway.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Siting {
    /// On the left column (MPEG-2, H.264, VP9).
    Left,
    /// Halfway between them (JPEG, MPEG-1).
    Centre,
}

/// Planes one after the other, without padding: Y, Cb, Cr and, if there is one, alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Size of the picture and of its luma.
    pub size: Size,
    /// Chroma samples.
    pub sampling: Sampling,
    /// Their place.
    pub siting: Siting,
    /// Whether a plane of alpha (0..=255, straight) follows.
    pub alpha: bool,
}

impl Layout {
    /// Width and height of a chroma plane, zero when there is none.
    pub fn chroma(&self) -> (usize, usize) {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        match self.sampling {
            Sampling::Gray => (0, 0),
            Sampling::Yuv420 => (width.div_ceil(2), height.div_ceil(2)),
            Sampling::Yuv422 => (width.div_ceil(2), height),
            Sampling::Yuv444 => (width, height),
        }
    }

    /// Bytes of a picture.
    pub fn bytes(&self) -> usize {
        let (width, height) = self.chroma();
        self.size.pixels() * if self.alpha { 2 } else { 1 } + 2 * width * height
    }
}

/// Fixed-point factors from codes to RGB.
struct FromYuv {
    black: i32,
    luma: i32,
    red_v: i32,
    green_u: i32,
    green_v: i32,
    blue_u: i32,
}

/// Luma weights of red and blue.
fn weights(matrix: Matrix) -> (f64, f64) {
    match matrix {
        Matrix::Bt601 => (0.299, 0.114),
        Matrix::Bt709 => (0.2126, 0.0722),
        Matrix::Bt2020 => (0.2627, 0.0593),
    }
}

/// Offset of black, and codes between black and white, of luma; codes of all chroma.
fn codes(range: Range) -> (i32, f64, f64) {
    match range {
        Range::Limited => (16, 219.0, 224.0),
        Range::Full => (0, 255.0, 255.0),
    }
}

fn fixed(value: f64, bits: u32) -> i32 {
    (value * f64::from(1u32 << bits)).round() as i32
}

impl FromYuv {
    fn new(coding: Coding) -> Self {
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
    fn pixel(&self, y: u8, u: u16, v: u16, alpha: u8) -> Rgba {
        const NEUTRAL: i32 = 128 << CHROMA_BITS;
        let luma = (i32::from(y) - self.black) * self.luma + (1 << (FRACTION - 1));
        let (u, v) = (i32::from(u) - NEUTRAL, i32::from(v) - NEUTRAL);
        let byte = |sum: i32| (sum >> FRACTION).clamp(0, 255) as u8;
        [
            byte(luma + self.red_v * v),
            byte(luma + self.green_u * u + self.green_v * v),
            byte(luma + self.blue_u * u),
            alpha,
        ]
    }
}

/// Turns the planes in `data` into pixels, which replace the contents of `out`.
///
/// # Panics
/// When `data` is not [`Layout::bytes`] long.
pub fn to_rgba(layout: &Layout, coding: Coding, data: &[u8], out: &mut Vec<Rgba>) {
    assert_eq!(data.len(), layout.bytes(), "the planes fit the layout");
    let (width, pixels) = (layout.size.width as usize, layout.size.pixels());
    let (luma, rest) = data.split_at(pixels);
    let (chroma_width, chroma_height) = layout.chroma();
    let (u, rest) = rest.split_at(chroma_width * chroma_height);
    let (v, alpha) = rest.split_at(chroma_width * chroma_height);
    let factors = FromYuv::new(coding);
    out.resize(pixels, [0; 4]);
    out.par_chunks_mut(width).enumerate().for_each_init(
        || [vec![0u16; width], vec![0u16; width], vec![0u16; chroma_width]],
        |[us, vs, blend], (row, out)| {
            if layout.sampling == Sampling::Gray {
                us.fill(128 << CHROMA_BITS);
                vs.fill(128 << CHROMA_BITS);
            } else {
                upsample(layout, u, row, blend, us);
                upsample(layout, v, row, blend, vs);
            }
            let luma = &luma[row * width..][..width];
            let chroma = us.iter().zip(vs.iter());
            if layout.alpha {
                let alpha = &alpha[row * width..][..width];
                for (((out, &y), (&u, &v)), &a) in out.iter_mut().zip(luma).zip(chroma).zip(alpha) {
                    *out = factors.pixel(y, u, v, a);
                }
            } else {
                for ((out, &y), (&u, &v)) in out.iter_mut().zip(luma).zip(chroma) {
                    *out = factors.pixel(y, u, v, 255);
                }
            }
        },
    );
}

/// The chroma of luma row `row`, a sample for each column, in sixteenths.
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
fn widen(siting: Siting, row: &[u16], out: &mut [u16]) {
    let last = row.len() - 1;
    for (x, pair) in out.chunks_mut(2).enumerate() {
        let (here, next) = (row[x], row[(x + 1).min(last)]);
        let (even, odd) = match siting {
            Siting::Left => (4 * here, 2 * (here + next)),
            Siting::Centre => (3 * here + row[x.saturating_sub(1)], 3 * here + next),
        };
        pair[0] = even;
        if let Some(second) = pair.get_mut(1) {
            *second = odd;
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    const MATRICES: [Matrix; 3] = [Matrix::Bt601, Matrix::Bt709, Matrix::Bt2020];
    const RANGES: [Range; 2] = [Range::Limited, Range::Full];
    const SAMPLINGS: [Sampling; 3] = [Sampling::Yuv420, Sampling::Yuv422, Sampling::Yuv444];

    fn layout(width: u32, height: u32, sampling: Sampling) -> Layout {
        let size = Size::new(width, height);
        Layout { size, sampling, siting: Siting::Left, alpha: false }
    }

    #[test]
    fn flat_colours_come_back_within_two() {
        for matrix in MATRICES {
            for range in RANGES {
                for sampling in SAMPLINGS {
                    let (coding, layout) = (Coding { matrix, range }, layout(5, 3, sampling));
                    let (mut planes, mut back) = (vec![], vec![]);
                    for colour in (0..=255u32).step_by(15).flat_map(|r| {
                        (0..=255).step_by(17).flat_map(move |g| {
                            (0..=255).step_by(51).map(move |b| [r as u8, g as u8, b as u8, 255])
                        })
                    }) {
                        from_rgba(layout.size, &[colour; 15], &layout, coding, &mut planes);
                        to_rgba(&layout, coding, &planes, &mut back);
                        for pixel in &back {
                            let far = (0..3).map(|i| pixel[i].abs_diff(colour[i])).max();
                            assert!(far <= Some(2), "{colour:?} -> {pixel:?} {coding:?}");
                        }
                    }
                }
            }
        }
    }

    /// The textbook formula in floating point, codes of one pixel.
    fn reference(coding: Coding, [r, g, b]: [f64; 3]) -> [f64; 3] {
        let (kr, kb) = weights(coding.matrix);
        let y = kr * r + (1.0 - kr - kb) * g + kb * b;
        let (u, v) = ((b - y) / (2.0 * (1.0 - kb)), (r - y) / (2.0 * (1.0 - kr)));
        let (black, luma, chroma) = codes(coding.range);
        let chroma = |c: f64| 128.0 + c * chroma / 255.0;
        [f64::from(black) + y * luma / 255.0, chroma(u), chroma(v)]
    }

    #[test]
    fn codes_are_the_nearest_to_the_formula() {
        for matrix in MATRICES {
            for range in RANGES {
                let (coding, layout) = (Coding { matrix, range }, layout(1, 1, Sampling::Yuv444));
                let mut planes = vec![];
                for n in 0..4096u32 {
                    let [r, g, b] = [n * 97 % 256, n * 61 % 256, n * 13 % 256];
                    let pixel = [r as u8, g as u8, b as u8, 255];
                    from_rgba(layout.size, &[pixel], &layout, coding, &mut planes);
                    let wanted = reference(coding, [r, g, b].map(f64::from));
                    for (code, wanted) in planes.iter().zip(wanted) {
                        let off = (f64::from(*code) - wanted.clamp(0.0, 255.0)).abs();
                        assert!(off < 0.51, "{pixel:?}: {planes:?} not {wanted}, {coding:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn known_codes() {
        let mut planes = vec![];
        let mut codes = |matrix, range, pixel| {
            let layout = layout(1, 1, Sampling::Yuv444);
            from_rgba(layout.size, &[pixel], &layout, Coding { matrix, range }, &mut planes);
            planes.clone()
        };
        // BT.601 and BT.709 colour bars at 100 %.
        assert_eq!(codes(Matrix::Bt601, Range::Limited, [255, 0, 0, 255]), [81, 90, 240]);
        assert_eq!(codes(Matrix::Bt709, Range::Limited, [255, 0, 0, 255]), [63, 102, 240]);
        assert_eq!(codes(Matrix::Bt709, Range::Limited, [0, 0, 255, 255]), [32, 240, 118]);
        assert_eq!(codes(Matrix::Bt601, Range::Full, [255; 4]), [255, 128, 128]);
        assert_eq!(codes(Matrix::Bt601, Range::Limited, [0, 0, 0, 255]), [16, 128, 128]);
    }

    #[test]
    fn greys_stay_grey() {
        for range in RANGES {
            let coding = Coding { matrix: Matrix::Bt709, range };
            let grey = layout(256, 1, Sampling::Gray);
            let pixels: Vec<Rgba> = (0..=255).map(|v| [v, v, v, 255]).collect();
            let (mut planes, mut back) = (vec![], vec![]);
            from_rgba(grey.size, &pixels, &grey, coding, &mut planes);
            to_rgba(&grey, coding, &planes, &mut back);
            for (pixel, wanted) in back.iter().zip(&pixels) {
                assert!(pixel[0] == pixel[1] && pixel[1] == pixel[2]);
                assert!(pixel[0].abs_diff(wanted[0]) <= 1);
            }
        }
    }

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

    #[test]
    fn padding_repeats_the_edge() {
        let coding = Coding { matrix: Matrix::Bt601, range: Range::Full };
        let pixels: Vec<Rgba> = (0..15).map(|i| [i * 16, 0, 0, 255]).collect();
        let (mut planes, mut back) = (vec![], vec![]);
        let padded = layout(6, 4, Sampling::Yuv444);
        from_rgba(Size::new(5, 3), &pixels, &padded, coding, &mut planes);
        to_rgba(&padded, coding, &planes, &mut back);
        for y in 0..4usize {
            for x in 0..6usize {
                let wanted = pixels[y.min(2) * 5 + x.min(4)][0];
                assert!(back[y * 6 + x][0].abs_diff(wanted) <= 2, "{x},{y}");
            }
        }
    }

    #[test]
    fn alpha_has_its_own_plane() {
        let with = Layout { alpha: true, ..layout(3, 3, Sampling::Yuv420) };
        assert_eq!(with.bytes(), 9 + 4 + 4 + 9);
        let coding = Coding { matrix: Matrix::Bt709, range: Range::Limited };
        let pixels: Vec<Rgba> = (0..9).map(|i| [90, 80, 70, i * 30]).collect();
        let (mut planes, mut back) = (vec![], vec![]);
        from_rgba(with.size, &pixels, &with, coding, &mut planes);
        to_rgba(&with, coding, &planes, &mut back);
        assert!(back.iter().zip(&pixels).all(|(a, b)| a[3] == b[3]));
    }

    #[test]
    fn untold_matrices_follow_the_size() {
        let of = |width, height| Coding::of(&Colorimetry::default(), Size::new(width, height));
        assert_eq!(of(720, 576).matrix, Matrix::Bt601);
        assert_eq!(of(1280, 534).matrix, Matrix::Bt709);
        assert_eq!(of(608, 1080).matrix, Matrix::Bt709);
        let tags = Colorimetry {
            matrix: Some("bt709".into()),
            range: Some("pc".into()),
            ..Colorimetry::default()
        };
        let wanted = Coding { matrix: Matrix::Bt709, range: Range::Full };
        assert_eq!(Coding::of(&tags, Size::new(64, 64)), wanted);
    }
}
