//! Limits of the area of triangles.

use crate::geom::{SUBPIXEL, Size};
use crate::options::FacetSides;

/// The cost of each pixel that a triangle is too large or too small by, in squared 8-bit steps: more than colours can
/// gain.
const PENALTY: f64 = 3.0 * 200.0 * 200.0;

/// Twice the area of a pixel, in squared subpixels.
const PIXEL: f64 = 2.0 * (SUBPIXEL as f64) * (SUBPIXEL as f64);

/// The least and the largest area of a triangle, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    least: f64,
    most: f64,
}

impl Limits {
    /// Those of triangles with these `sides` on a frame of `size`, if there are any.
    pub(super) fn of(sides: FacetSides, size: Size) -> Option<Self> {
        let (least, most) = sides.areas(size);
        sides.are_limited().then_some(Self { least, most })
    }

    /// What a triangle costs for its size, `doubled` being its `orient`.
    pub(super) fn penalty(self, doubled: i64) -> f64 {
        let area = doubled as f64 / PIXEL;
        PENALTY * (self.least - area).max(area - self.most).max(0.0)
    }
}
