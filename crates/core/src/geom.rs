//! Points, sizes and the exact predicates on them.
//!
//! A [`Point`] is a place in the continuous frame: the frame spans `[0, width] x [0, height]`, x to
//! the right and y downwards, and the centre of pixel `(i, j)` lies at `(i + 0.5, j + 0.5)`.
//! Coordinates are whole numbers of 1/256 pixel, so that every predicate is exact, on any machine.

/// Steps of a coordinate in one pixel (24.8 fixed point, as graphics hardware has it).
pub const SUBPIXEL: i32 = 256;

/// The longest side of a frame, in pixels. With [`SUBPIXEL`] it bounds a coordinate to 2^22, a
/// doubled area to 2^45 and an in-circle determinant to less than 2^96.
pub const MAX_SIDE: u32 = 16384;

/// A place in the frame, in 1/256 pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Point {
    /// To the right, in 1/256 pixel.
    pub x: i32,
    /// Downwards, in 1/256 pixel.
    pub y: i32,
}

impl Point {
    /// The point at `(x, y)` in 1/256 pixel.
    pub const fn new(x: i32, y: i32) -> Self {
        Self { x, y }
    }

    /// The centre of pixel `(x, y)`.
    pub const fn pixel_centre(x: u32, y: u32) -> Self {
        Self::new(x as i32 * SUBPIXEL + SUBPIXEL / 2, y as i32 * SUBPIXEL + SUBPIXEL / 2)
    }

    /// The nearest representable point to `(x, y)` in pixels; halves away from zero.
    pub fn from_pixels(x: f64, y: f64) -> Self {
        let scale = f64::from(SUBPIXEL);
        Self::new((x * scale).round() as i32, (y * scale).round() as i32)
    }

    /// The coordinates in pixels.
    pub fn to_pixels(self) -> (f64, f64) {
        let scale = f64::from(SUBPIXEL);
        (f64::from(self.x) / scale, f64::from(self.y) / scale)
    }

    /// The pixel that holds this point, the last one for points on the far border of `size`.
    pub fn pixel(self, size: Size) -> (u32, u32) {
        let x = (self.x.max(0) / SUBPIXEL) as u32;
        let y = (self.y.max(0) / SUBPIXEL) as u32;
        (x.min(size.width.saturating_sub(1)), y.min(size.height.saturating_sub(1)))
    }
}

/// Width and height of a frame in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Size {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Size {
    /// A size of `width` by `height` pixels.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// Number of pixels.
    pub const fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The far corner of the frame, in 1/256 pixel.
    pub const fn far(self) -> Point {
        Point::new(self.width as i32 * SUBPIXEL, self.height as i32 * SUBPIXEL)
    }

    /// Whether `p` lies in the closed frame.
    pub const fn contains(self, p: Point) -> bool {
        let far = self.far();
        p.x >= 0 && p.y >= 0 && p.x <= far.x && p.y <= far.y
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// Twice the signed area of the triangle `abc` in (1/256 pixel)^2, exact: positive when the way
/// a, b, c turns from the x axis towards the y axis (clockwise as seen on a screen, y down).
pub const fn orient(a: Point, b: Point, c: Point) -> i64 {
    (b.x as i64 - a.x as i64) * (c.y as i64 - a.y as i64)
        - (b.y as i64 - a.y as i64) * (c.x as i64 - a.x as i64)
}

/// Whether `d` lies strictly inside the circle through `a`, `b`, `c`, exact. The triangle must have
/// a positive [`orient`].
pub fn in_circle(a: Point, b: Point, c: Point, d: Point) -> bool {
    let rel = |p: Point| (i64::from(p.x) - i64::from(d.x), i64::from(p.y) - i64::from(d.y));
    let (ax, ay) = rel(a);
    let (bx, by) = rel(b);
    let (cx, cy) = rel(c);
    let reach = [ax, ay, bx, by, cx, cy].iter().map(|v| v.abs()).max().unwrap_or(0);
    let (al, bl, cl) = (ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy);
    let (bc, ca, ab) = (bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx);
    // Lifts and minors are at most 2 reach^2 each, their three products 12 reach^4: below 2^62
    // while reach < 2^14 (64 pixels), which nearly every triangle of a dense mesh is.
    if reach < 1 << 14 {
        al * bc + bl * ca + cl * ab > 0
    } else {
        i128::from(al) * i128::from(bc)
            + i128::from(bl) * i128::from(ca)
            + i128::from(cl) * i128::from(ab)
            > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientation_is_positive_from_x_to_y() {
        let (a, b, c) = (Point::new(0, 0), Point::new(256, 0), Point::new(0, 256));
        assert_eq!(orient(a, b, c), 256 * 256);
        assert_eq!(orient(a, c, b), -256 * 256);
    }

    #[test]
    fn in_circle_is_strict_and_exact_at_both_widths() {
        for scale in [1, 1 << 12, 1 << 20] {
            let p = |x, y| Point::new(x * scale, y * scale);
            let (a, b, c) = (p(0, 0), p(2, 0), p(0, 2));
            assert!(in_circle(a, b, c, p(1, 1)));
            assert!(!in_circle(a, b, c, p(2, 2)), "cocircular is not inside");
            assert!(!in_circle(a, b, c, p(3, 3)));
        }
    }

    #[test]
    fn pixel_of_a_border_point_is_the_last_one() {
        let size = Size::new(3, 2);
        assert_eq!(size.far().pixel(size), (2, 1));
        assert_eq!(Point::pixel_centre(1, 1).pixel(size), (1, 1));
    }
}
