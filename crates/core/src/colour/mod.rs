//! Conversion between RGB frames and planar Y'CbCr, the form of video.
//!
//! Matrices and ranges: ITU-R BT.601-7, BT.709-6 and BT.2020-2 (non-constant luminance), 8 bits.
//! Sums are whole numbers with 18 bits of fraction and are rounded once, halves upwards. Subsampled
//! chroma is interpolated linearly on the way in and averaged over its area on the way out, both
//! before that one rounding, so that a flat colour comes back within 2 of itself.

mod from_rgba;
mod to_rgba;

pub(crate) use from_rgba::ToYuv;
pub use from_rgba::from_rgba;
pub use to_rgba::to_rgba;
pub(crate) use to_rgba::{FromYuv, RowsToRgba};

use crate::geom::Size;

/// A pixel or a colour: red, green, blue, alpha (straight, not premultiplied), 0..255 each, in the
/// source's own transfer curve (no linearisation, as in the paper).
pub type Rgba = [u8; 4];

/// Colour tags of a video, by ffmpeg's names (`bt709`, `smpte170m`, `tv`, `pc` ...); `None` is unspecified.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Colorimetry {
    /// Matrix coefficients.
    pub matrix: Option<String>,
    /// `tv` (limited) or `pc` (full).
    pub range: Option<String>,
    /// Primaries.
    pub primaries: Option<String>,
    /// Transfer curve.
    pub transfer: Option<String>,
}

/// Bits of fraction in a conversion; the largest sum stays below 2^30.
const FRACTION: u32 = 18;
/// Interpolated chroma is in sixteenths, averaged RGB in eighths.
const CHROMA_BITS: u32 = 4;
const MEAN_BITS: u32 = 3;

/// The mixing of RGB to luma and chroma.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matrix {
    /// ITU-R BT.601: standard definition, JPEG.
    Bt601,
    /// ITU-R BT.709: high definition.
    Bt709,
    /// ITU-R BT.2020, non-constant luminance: ultra high definition.
    Bt2020,
}

/// The range of codes.
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
    /// The coding that `tags` mean for a picture of `size`. Missing tags and unsupported ones mean limited range and
    /// the convention of players: BT.709 for pictures wider than 1279 or higher than 576 pixels, BT.601 for smaller
    /// ones (as in mpv and browsers).
    pub fn of(tags: &Colorimetry, size: Size) -> Self {
        let matrix = match tags.matrix.as_deref() {
            // SMPTE 240M is nearly the same: no colour differs by more than 6.
            Some("bt709" | "smpte240m") => Matrix::Bt709,
            Some("smpte170m" | "bt470bg" | "fcc") => Matrix::Bt601,
            Some("bt2020nc" | "bt2020c") => Matrix::Bt2020,
            _ if size.width >= 1280 || size.height > 576 => Matrix::Bt709,
            _ => Matrix::Bt601,
        };
        let full = matches!(tags.range.as_deref(), Some("pc" | "full" | "jpeg"));
        Self { matrix, range: if full { Range::Full } else { Range::Limited } }
    }

    /// The code of black, and the number of codes from black to white.
    pub(crate) fn luma_codes(self) -> (f32, f32) {
        let (black, luma, _) = codes(self.range);
        (black as f32, luma as f32)
    }
}

/// The resolution of chroma.
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

/// The horizontal position of a chroma sample for two columns of luma; vertically it is always halfway.
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
    /// The layout of `size` that is usual for video: 4:2:0, chroma sited left, opaque.
    #[doc(hidden)]
    pub const fn of_video(size: Size) -> Self {
        Self { size, sampling: Sampling::Yuv420, siting: Siting::Left, alpha: false }
    }

    /// Width and height of a chroma plane; zero without chroma.
    pub fn chroma(&self) -> (usize, usize) {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        match self.sampling {
            Sampling::Gray => (0, 0),
            Sampling::Yuv420 => (width.div_ceil(2), height.div_ceil(2)),
            Sampling::Yuv422 => (width.div_ceil(2), height),
            Sampling::Yuv444 => (width, height),
        }
    }

    /// Whether each sample of chroma belongs to a complete square of four pixels, and there is no alpha.
    pub fn is_squared(&self) -> bool {
        let even = self.size.width.is_multiple_of(2) && self.size.height.is_multiple_of(2);
        self.sampling == Sampling::Yuv420 && even && !self.alpha
    }

    /// Bytes of a picture.
    pub fn bytes(&self) -> usize {
        let (width, height) = self.chroma();
        self.size.pixels() * if self.alpha { 2 } else { 1 } + 2 * width * height
    }

    /// Luma, Cb, Cr and alpha in a picture's `data`, which has [this length](Layout::bytes).
    fn split<'a>(&self, data: &'a [u8]) -> [&'a [u8]; 4] {
        let (width, height) = self.chroma();
        let (luma, rest) = data.split_at(self.size.pixels());
        let (u, rest) = rest.split_at(width * height);
        let (v, alpha) = rest.split_at(width * height);
        [luma, u, v, alpha]
    }

    /// The same, to be written.
    fn split_mut<'a>(&self, data: &'a mut [u8]) -> [&'a mut [u8]; 4] {
        let (width, height) = self.chroma();
        let (luma, rest) = data.split_at_mut(self.size.pixels());
        let (u, rest) = rest.split_at_mut(width * height);
        let (v, alpha) = rest.split_at_mut(width * height);
        [luma, u, v, alpha]
    }
}

/// How a picture is stored as planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form {
    /// Sizes and order of the planes.
    pub layout: Layout,
    /// What the codes mean.
    pub coding: Coding,
}

/// A picture as planes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Planes {
    /// How it is stored.
    pub form: Form,
    /// The planes.
    pub data: Vec<u8>,
}

impl Planes {
    /// Luma, Cb and Cr.
    pub(crate) fn split(&self) -> [&[u8]; 3] {
        let [luma, u, v, _] = self.form.layout.split(&self.data);
        [luma, u, v]
    }

    /// The same, to be written.
    pub(crate) fn split_mut(&mut self) -> [&mut [u8]; 3] {
        let [luma, u, v, _] = self.form.layout.split_mut(&mut self.data);
        [luma, u, v]
    }

    /// The samples nearest to pixel `(x, y)` of a [squared](Layout::is_squared) picture.
    pub(crate) fn at(&self, x: u32, y: u32) -> [u8; 3] {
        let [luma, u, v] = self.split();
        let (x, y) = (x as usize, y as usize);
        let chroma = y / 2 * self.form.layout.chroma().0 + x / 2;
        [luma[y * self.form.layout.size.width as usize + x], u[chroma], v[chroma]]
    }
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
    fn one_colour_is_converted_as_all_of_a_picture_are() {
        for matrix in MATRICES {
            for range in RANGES {
                let (coding, layout) = (Coding { matrix, range }, layout(2, 2, Sampling::Yuv420));
                let (mut planes, mut back) = (vec![], vec![]);
                for n in 0..4096u32 {
                    let colour = [n * 97, n * 61, n * 13, 255].map(|v| v as u8);
                    from_rgba(layout.size, &[colour; 4], &layout, coding, &mut planes);
                    let codes = ToYuv::new(coding).codes(colour);
                    assert_eq!(codes, [planes[0], planes[4], planes[5]]);
                    to_rgba(&layout, coding, &planes, &mut back);
                    let means = codes.map(|code| (7 * u64::from(code), 7));
                    assert_eq!(FromYuv::new(coding).mean(means), back[0], "{codes:?} {coding:?}");
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
    fn missing_matrices_follow_the_size() {
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
