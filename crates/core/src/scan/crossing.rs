//! Where an edge crosses the rows of pixels.

use crate::geom::{Point, SUBPIXEL};

/// The first column whose centre lies on an edge or right of it, row by row, in 16.48 fixed point.
///
/// Exact, with one division an edge: a crossing that is no whole column lies at least 1 / (256 dy) >=
/// 2^-30 pixel from one, while all rounding here stays below 2^-33. So [`NUDGE`] between the two tells
/// "on" from "right of" as whole numbers would.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    at: i64,
    step: i64,
}

const FRACTION: u32 = 48;

/// 2^-32 pixel.
const NUDGE: f64 = 1.0 / 4_294_967_296.0;

impl Crossing {
    /// The edge from `upper` down to `lower` at row `row`, whose centre the edge spans.
    #[inline(always)]
    pub(crate) fn new(upper: Point, lower: Point, row: i32) -> Self {
        let slope = f64::from(lower.x - upper.x) / f64::from(lower.y - upper.y);
        let down = f64::from(row * SUBPIXEL + SUBPIXEL / 2 - upper.y);
        let x = (f64::from(upper.x) + down * slope) / f64::from(SUBPIXEL);
        let scale = (1i64 << FRACTION) as f64;
        // Steeper slopes than 2^15 saturate, but cross one row only.
        Self { at: ((x + 0.5 - NUDGE) * scale) as i64, step: (slope * scale) as i64 }
    }

    /// The column of this row, then on to the next.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> usize {
        let column = (self.at >> FRACTION) as usize;
        self.at = self.at.wrapping_add(self.step);
        column
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::first_centre;
    use proptest::prelude::*;

    proptest! {
        /// Against whole numbers, up to the largest frame.
        #[test]
        fn crossings_are_exact(
            (ax, bx) in (0i64..=1 << 22, 0i64..=1 << 22),
            (ay, height) in (0i64..1 << 22, 1i64..1 << 22),
            snap in prop_oneof![Just(1), Just(128), Just(256), Just(255)],
            near in any::<bool>(),
        ) {
            let bx = if near { (ax + bx % 3000).min(1 << 22) } else { bx };
            let height = if near { height % 3000 + 1 } else { height };
            let [ax, bx, ay] = [ax, bx, ay].map(|v| v / snap * snap);
            let by = (ay + height).min(1 << 22) / snap * snap;
            prop_assume!(by > ay);
            let (a, b) = (Point::new(ax as i32, ay as i32), Point::new(bx as i32, by as i32));
            let (start, end) = (first_centre(a.y), first_centre(b.y));
            prop_assume!(start < end);
            let mut crossing = Crossing::new(a, b, start);
            for row in start..end {
                let down = i128::from(row) * 256 + 128 - i128::from(ay);
                let dy = i128::from(by - ay);
                let numerator = i128::from(ax - 128) * dy + down * i128::from(bx - ax);
                let exact = -(-numerator).div_euclid(256 * dy);
                prop_assert_eq!(crossing.next() as i128, exact, "row {}", row);
            }
        }
    }
}
