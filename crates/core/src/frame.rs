//! Frames, exact fractions for times, and fills.

mod planar;

pub use crate::colour::{Colorimetry, Rgba};
pub use planar::Buffers;

use crate::colour::Planes;
use crate::error::{Error, Result};
use crate::geom::{MAX_SIDE, Size};
use planar::Pixels;

/// The most pixels that a frame may have: 16384 x 16384, 1 GiB of memory.
pub const MAX_PIXELS: u64 = MAX_SIDE as u64 * MAX_SIDE as u64;

/// A picture of `size` pixels, row by row from the top left. Pixels are red, green, blue, alpha (straight), 0..255
/// each. A frame of [planes](Frame::planar) converts its pixels on demand.
#[derive(Clone, Debug)]
pub struct Frame {
    size: Size,
    opaque: bool,
    planes: Option<Planes>,
    pixels: Pixels,
}

impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        self.size == other.size
            && (self.planes.is_some() && self.planes == other.planes
                || self.pixels() == other.pixels())
    }
}

impl Eq for Frame {}

impl Frame {
    /// A frame of `pixels`, row by row from the top left.
    ///
    /// # Errors
    /// When `pixels` are not width x height, or a side is 0 or above [`MAX_SIDE`].
    pub fn new(size: Size, pixels: Vec<Rgba>) -> Result<Self> {
        Self::known(size, pixels, false)
    }

    /// As [`Frame::new`]; `opaque` says that all pixels have alpha 255, so that they are not checked.
    ///
    /// # Errors
    /// As [`Frame::new`].
    #[doc(hidden)]
    pub fn known(size: Size, pixels: Vec<Rgba>, opaque: bool) -> Result<Self> {
        check_size(size)?;
        if pixels.len() != size.pixels() {
            let what = format!("has {} pixels, not {}", size.pixels(), pixels.len());
            return Err(Error::FrameSize { size, what });
        }
        debug_assert!(!opaque || pixels.iter().all(|pixel| pixel[3] == 255), "opaque pixels");
        // Whole pieces at once, not pixel by pixel up to the first transparent one: ten times as fast.
        let both = |all: u32, pixel: &Rgba| all & u32::from_le_bytes(*pixel);
        let whole = |piece: &[Rgba]| piece.iter().fold(u32::MAX, both) >> 24 == 255;
        let opaque = opaque || pixels.chunks(4096).all(whole);
        Ok(Self { size, opaque, planes: None, pixels: pixels.into() })
    }

    /// A frame of one colour.
    ///
    /// # Errors
    /// When a side is 0 or above [`MAX_SIDE`].
    pub fn filled(size: Size, colour: Rgba) -> Result<Self> {
        check_size(size)?;
        Self::known(size, vec![colour; size.pixels()], colour[3] == 255)
    }

    /// The frame in `image`.
    ///
    /// # Errors
    /// As [`Frame::new`].
    #[cfg(feature = "image")]
    pub fn from_image(image: image::RgbaImage) -> Result<Self> {
        let size = Size::new(image.width(), image.height());
        let raw = image.into_raw();
        let (pixels, _) = raw.as_chunks::<4>();
        Self::new(size, pixels.to_vec())
    }

    /// The frame as an image of the `image` crate, without copying.
    #[cfg(feature = "image")]
    pub fn into_image(self) -> image::RgbaImage {
        let Size { width, height } = self.size;
        image::RgbaImage::from_raw(width, height, self.into_pixels().into_flattened())
            .expect("a frame holds exactly width x height pixels")
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Whether every pixel has alpha 255.
    pub fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> &[Rgba] {
        self.pixels.of(self.planes.as_ref())
    }

    /// The pixels of row `y`.
    pub fn row(&self, y: u32) -> &[Rgba] {
        let width = self.size.width as usize;
        &self.pixels()[y as usize * width..][..width]
    }

    /// The pixel at `(x, y)`.
    pub fn at(&self, x: u32, y: u32) -> Rgba {
        self.row(y)[x as usize]
    }

    /// The pixels, without copying.
    pub fn into_pixels(self) -> Vec<Rgba> {
        self.pixels.into_vec(self.planes.as_ref())
    }
}

/// Checks the size of a frame, before memory is allocated for it.
///
/// # Errors
/// When a side is 0 or above [`MAX_SIDE`].
pub fn check_size(size: Size) -> Result<()> {
    if size.width == 0 || size.height == 0 {
        return Err(Error::FrameSize { size, what: "has no pixels".into() });
    }
    if size.width > MAX_SIDE || size.height > MAX_SIDE {
        let what = format!("is larger than {MAX_SIDE} pixels a side");
        return Err(Error::FrameSize { size, what });
    }
    Ok(())
}

/// Luma of a pixel, 0..255: BT.601 weights in 8.8 fixed point, rounded, as usual for grayscale conversion (ITU-R
/// BT.601; OpenCV `COLOR_RGB2GRAY`).
pub const fn luma([r, g, b, _]: Rgba) -> u8 {
    ((r as u32 * 4899 + g as u32 * 9617 + b as u32 * 1868 + (1 << 13)) >> 14) as u8
}

/// `pixel` composed over `background`, opaque: channels are mixed by the pixel's alpha and rounded to the nearest.
/// The background's alpha is ignored.
pub fn over(pixel: Rgba, background: Rgba) -> Rgba {
    let alpha = u32::from(pixel[3]);
    let mix = |c: usize| {
        let sum = u32::from(pixel[c]) * alpha + u32::from(background[c]) * (255 - alpha);
        ((sum + 127) / 255) as u8
    };
    [mix(0), mix(1), mix(2), 255]
}

/// An exact fraction, for times in seconds and rates in frames per second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rational {
    /// Numerator.
    pub num: i64,
    /// Denominator, positive.
    pub den: i64,
}

impl Rational {
    /// Zero.
    pub const ZERO: Self = Self { num: 0, den: 1 };

    /// `num / den` in lowest terms. A negative `den` turns both signs; `den` must not be 0.
    pub fn new(num: i64, den: i64) -> Self {
        debug_assert!(den != 0, "a fraction's denominator is not 0");
        Self::reduced(i128::from(num), i128::from(den))
    }

    fn reduced(num: i128, den: i128) -> Self {
        let (mut a, mut b) = (num.unsigned_abs(), den.unsigned_abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        let divisor = a.max(1) as i128 * den.signum();
        let (mut num, mut den) = (num / divisor, den / divisor);
        // Sums over many odd time bases may outgrow 64 bits: halving both loses less than 1e-18.
        while i64::try_from(num).is_err() || i64::try_from(den).is_err() {
            (num, den) = (num >> 1, (den >> 1).max(1));
        }
        Self { num: num as i64, den: den as i64 }
    }

    /// The value as a float.
    pub fn to_f64(self) -> f64 {
        self.num as f64 / self.den as f64
    }

    /// `1 / self`; `None` for zero.
    pub fn recip(self) -> Option<Self> {
        (self.num != 0).then(|| Self::new(self.den, self.num))
    }
}

fn product(a: i64, b: i64) -> i128 {
    i128::from(a) * i128::from(b)
}

impl std::ops::Add for Rational {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let (a, b) = (product(self.num, o.den), product(o.num, self.den));
        Self::reduced(a + b, product(self.den, o.den))
    }
}

impl std::ops::Neg for Rational {
    type Output = Self;
    fn neg(self) -> Self {
        Self { num: -self.num, den: self.den }
    }
}

impl std::ops::Sub for Rational {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl std::ops::Mul for Rational {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::reduced(product(self.num, o.num), product(self.den, o.den))
    }
}

impl PartialOrd for Rational {
    fn partial_cmp(&self, o: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(o))
    }
}

impl Ord for Rational {
    fn cmp(&self, o: &Self) -> std::cmp::Ordering {
        (i128::from(self.num) * i128::from(o.den)).cmp(&(i128::from(o.num) * i128::from(self.den)))
    }
}

impl std::fmt::Display for Rational {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.den == 1 {
            write!(f, "{}", self.num)
        } else {
            write!(f, "{}/{}", self.num, self.den)
        }
    }
}

/// A colour of a picture and the number of pixels that it covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fill {
    /// The colour.
    pub colour: Rgba,
    /// Pixels that have it.
    pub area: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_stay_exact_over_an_hour_of_ntsc() {
        let step = Rational::new(1001, 30000);
        let mut t = Rational::ZERO;
        for _ in 0..108_000 {
            t = t + step;
        }
        assert_eq!(t, Rational::new(1001 * 108_000, 30000));
        assert!(t > Rational::new(3603, 1) && t < Rational::new(3604, 1));
    }

    #[test]
    fn luma_of_greys_is_themselves() {
        for v in 0..=255 {
            assert_eq!(luma([v, v, v, 255]), v);
        }
    }

    #[test]
    fn what_is_laid_over_shows_by_its_alpha() {
        let (red, white) = ([200, 0, 0], [255, 255, 255, 255]);
        let with = |alpha| over([red[0], red[1], red[2], alpha], white);
        assert_eq!(with(255), [200, 0, 0, 255]);
        assert_eq!(with(0), white);
        assert_eq!(with(51), [244, 204, 204, 255]);
    }

    #[test]
    fn frames_refuse_wrong_sizes() {
        assert!(Frame::new(Size::new(2, 2), vec![[0; 4]; 3]).is_err());
        assert!(Frame::filled(Size::new(0, 2), [0; 4]).is_err());
        assert!(Frame::filled(Size::new(MAX_SIDE + 1, 1), [0; 4]).is_err());
    }

    #[cfg(feature = "image")]
    #[test]
    fn an_image_goes_in_and_out_unchanged() {
        let image = image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba([x as u8, y as u8, 7, 200]));
        let frame = Frame::from_image(image.clone()).expect("a small frame");
        assert!(!frame.is_opaque());
        assert_eq!(frame.at(2, 1), [2, 1, 7, 200]);
        assert_eq!(frame.into_image(), image);
    }
}
