//! Scan conversion: the pixels that a triangle covers, as exact spans, row by row.
//!
//! A pixel belongs to the triangle that holds its centre; a centre on an edge belongs to the triangle
//! on the edge's right or, for level edges, below it (the top-left rule). Both neighbours of an edge
//! compute the same whole numbers for it, so the triangles of a mesh share out the pixels without gap
//! or overlap.

pub(crate) mod bytes;
mod crossing;
pub(crate) mod lanes;
pub(crate) mod runs;

use std::ops::Range;

use crate::geom::{Point, SUBPIXEL};
pub(crate) use crossing::Crossing;

const HALF: i32 = SUBPIXEL / 2;

/// The first row (or column) whose centre lies at `v` or after it, for `v` in 1/256 pixel.
pub const fn first_centre(v: i32) -> i32 {
    // ceil((v - 128) / 256), in whole numbers.
    (v - HALF + SUBPIXEL - 1).div_euclid(SUBPIXEL)
}

/// The rows whose centres a triangle spans.
pub fn rows([a, b, c]: [Point; 3]) -> Range<u32> {
    let top = a.y.min(b.y).min(c.y);
    let bottom = a.y.max(b.y).max(c.y);
    first_centre(top) as u32..first_centre(bottom) as u32
}

/// Calls `visit(y, columns)` for every row of `band` in which the triangle covers pixels, from top to
/// bottom. The triangle lies in a frame and may have either orientation.
#[inline(always)]
pub fn spans(triangle: [Point; 3], band: Range<u32>, mut visit: impl FnMut(u32, Range<usize>)) {
    let [a, b, c] = triangle;
    // Three exchanges sort by height.
    let (a, b) = if b.y < a.y { (b, a) } else { (a, b) };
    let (a, c) = if c.y < a.y { (c, a) } else { (a, c) };
    let (b, c) = if c.y < b.y { (c, b) } else { (b, c) };
    let start = (first_centre(a.y)).max(band.start as i32);
    let bend = first_centre(b.y);
    let end = first_centre(c.y).min(band.end as i32);
    if start >= end {
        return;
    }
    let mut long = Crossing::new(a, c, start);
    let lower = Crossing::new(b, c, bend.max(start));
    // If no row is above the middle vertex, the upper edge is never read.
    let mut short = if bend > start { Crossing::new(a, b, start) } else { lower };
    for y in start..end {
        // A conditional move, not a branch, and one loop, not two: a mispredicted branch costs more than a row.
        short = if y == bend { lower } else { short };
        let (l, s) = (long.next(), short.next());
        // Crossings are exact: what lies further left crosses no later.
        let columns = l.min(s)..l.max(s);
        if columns.start < columns.end {
            visit(y as u32, columns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient;
    use proptest::prelude::*;

    /// The definition, pixel by pixel: the centre, nudged to the right and then down by less than any
    /// distance that can be distinguished, lies inside.
    fn covers([a, b, c]: [Point; 3], p: Point) -> bool {
        [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| {
            let side = orient(from, to, p);
            let (dx, dy) = (to.x - from.x, to.y - from.y);
            side > 0 || (side == 0 && (dy < 0 || (dy == 0 && dx > 0)))
        })
    }

    proptest! {
        #[test]
        fn spans_cover_what_the_definition_says(
            corners in proptest::array::uniform3((0i32..=20 * SUBPIXEL, 0i32..=20 * SUBPIXEL)),
            snap in prop_oneof![Just(1), Just(HALF), Just(SUBPIXEL)],
            (from, to) in (0u32..20, 0u32..=20),
        ) {
            let mut t = corners.map(|(x, y)| Point::new(x / snap * snap, y / snap * snap));
            prop_assume!(orient(t[0], t[1], t[2]) != 0);
            let mut found = vec![0; 400];
            spans(t, from..to, |y, xs| for x in xs { found[y as usize * 20 + x] += 1; });
            if orient(t[0], t[1], t[2]) < 0 {
                t.swap(0, 1);
            }
            for y in 0..20 {
                for x in 0..20 {
                    let inside = (from..to).contains(&y) && covers(t, Point::pixel_centre(x, y));
                    prop_assert_eq!(found[(y * 20 + x) as usize], i32::from(inside), "({}, {})", x, y);
                }
            }
        }
    }

    #[test]
    fn the_largest_frame_does_not_overflow() {
        let far = 16384 * SUBPIXEL;
        let t = [Point::new(0, 0), Point::new(far, 1), Point::new(3, far)];
        let mut area = 0u64;
        spans(t, 0..16384, |_, xs| area += xs.len() as u64);
        let exact = 16384.0 * 16384.0 / 2.0;
        assert!((area as f64 / exact - 1.0).abs() < 1e-3, "{area}");
    }
}
