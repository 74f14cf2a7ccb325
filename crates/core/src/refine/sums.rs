//! Sums over the pixels of a triangle.
//!
//! The squared error of a triangle is the sum of its pixels' squares less |sum|^2 / count. The squares of all
//! triangles together never change, so that gains depend on the sums alone, and three of them fit one 64-bit number.
//! All are whole numbers, and an edge is summed once for both of its triangles: the gain of a trial is exact.

use std::ops::{Add, Neg, Sub};

use crate::frame::{Fill, Rgba};

/// Number of pixels and sums of their values, wrapping: the sums of an edge have no meaning alone, but the total of a
/// triangle's edges is right if it has fewer than [`NARROW`] pixels. Larger ones are summed by
/// [`RowSums::wide`](super::rows::RowSums::wide). The fields of a number borrow from each other in parts; in the
/// total the borrows cancel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sums {
    /// Pixels in the lower half; in the upper one alpha, in frames that are not opaque, or the squares of
    /// [subsampled](super::subsampled) sums.
    pub(super) weight: u64,
    /// Premultiplied red, green and blue, [`FIELD`] bits each from the lowest.
    pub(super) colour: u64,
}

/// Bits of a colour sum.
const FIELD: u32 = 21;

/// Pixels whose sums fit [`FIELD`] bits: 8192 x 255 < 2^21.
pub(super) const NARROW: usize = 8192;

/// Red, green and blue in one number, [`FIELD`] bits each.
#[inline(always)]
pub(super) const fn pack(pixel: Rgba) -> u64 {
    // Computed from one number, not three, so that several pixels can be packed at once.
    let pixel = u32::from_le_bytes(pixel) as u64;
    pixel & 0xff | (pixel & 0xff00) << (FIELD - 8) | (pixel & 0xff_0000) << (2 * FIELD - 16)
}

/// Red, green and blue of a packed sum.
#[inline]
pub(super) const fn unpack(colour: u64) -> [i64; 3] {
    const MASK: u64 = (1 << FIELD) - 1;
    [(colour & MASK) as i64, (colour >> FIELD & MASK) as i64, (colour >> (2 * FIELD) & MASK) as i64]
}

impl Add for Sums {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            weight: self.weight.wrapping_add(o.weight),
            colour: self.colour.wrapping_add(o.colour),
        }
    }
}

impl Sub for Sums {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self {
            weight: self.weight.wrapping_sub(o.weight),
            colour: self.colour.wrapping_sub(o.colour),
        }
    }
}

impl Neg for Sums {
    type Output = Self;
    fn neg(self) -> Self {
        Self::default() - self
    }
}

/// Sums over the pixels of one triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Total {
    count: f64,
    /// Red, green, blue, alpha.
    channels: [f64; 4],
}

impl Total {
    /// The whole that parts add up to.
    #[inline]
    pub(super) const fn of(sums: &Sums) -> Self {
        Self::new((sums.weight as u32) as i64, unpack(sums.colour), (sums.weight >> 32) as i64)
    }

    /// The sums over `count` pixels: colour, alpha.
    #[inline]
    pub(super) const fn new(count: i64, [r, g, b]: [i64; 3], alpha: i64) -> Self {
        Self { count: count as f64, channels: [r as f64, g as f64, b as f64, alpha as f64] }
    }

    /// Number of pixels.
    pub(super) fn count(&self) -> f64 {
        self.count
    }

    /// The part of the pixels' squares that the mean colour explains: |sum|^2 / count, in squared 8-bit steps. The
    /// other part is the error.
    #[inline]
    pub(super) fn explained(&self) -> f64 {
        if self.count <= 0.0 {
            return 0.0;
        }
        let [r, g, b, a] = self.channels;
        (r * r + g * g + (b * b + a * a)) / self.count
    }

    /// The mean colour, rounded to the nearest, halves up, and the area.
    pub(super) fn fill(&self) -> Fill {
        let (count, [r, g, b, _]) = (self.count as u64, self.channels);
        let rounded = |sum: f64| (sum as u64 + count / 2).checked_div(count).unwrap_or(0) as u8;
        Fill { colour: [rounded(r), rounded(g), rounded(b), 255], area: count as u32 }
    }

    /// The mean of the channels; `None` where no pixel's centre is covered.
    #[inline]
    pub(super) fn mean(&self) -> Option<[f32; 4]> {
        if self.count <= 0.0 {
            return None;
        }
        let scale = 1.0 / self.count;
        let [r, g, b, a] = self.channels;
        Some([(r * scale) as f32, (g * scale) as f32, (b * scale) as f32, (a * scale) as f32])
    }
}
