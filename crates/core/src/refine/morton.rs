//! Sorts points along a Z-order (Morton) curve, so that neighbours in the picture are close in memory.

use crate::geom::{Point, SUBPIXEL, Size};

/// Side of a square in pixels, as a power of two: a few triangles of a typical mesh.
const SQUARE_BITS: u32 = 5;

/// Sorts points, in buffers that are kept.
#[derive(Debug, Default)]
pub(super) struct MortonOrder {
    squares: Vec<u32>,
    begins: Vec<u32>,
    order: Vec<u32>,
}

impl MortonOrder {
    /// The indices of `places`, in a frame of `size`, sorted along a Z-order curve through squares of 32 x 32 pixels;
    /// those of one square in their own order. Work in this order finds its neighbours in the cache. O(n).
    pub(super) fn sort(&mut self, size: Size, places: impl Iterator<Item = Point>) -> &[u32] {
        self.squares.clear();
        self.squares.extend(places.map(square));
        // The last corner has the highest code.
        self.begins.clear();
        self.begins.resize(square(size.far()) as usize + 2, 0);
        for &square in &self.squares {
            self.begins[square as usize + 1] += 1;
        }
        let mut sum = 0;
        for begin in &mut self.begins {
            sum += *begin;
            *begin = sum;
        }
        self.order.resize(self.squares.len(), 0);
        for (number, &square) in (0u32..).zip(&self.squares) {
            let at = &mut self.begins[square as usize];
            self.order[*at as usize] = number;
            *at += 1;
        }
        &self.order
    }
}

/// The Morton code of the square that holds `p`: the bits of its column and its row interleaved.
fn square(p: Point) -> u32 {
    let spread = |v: i32| {
        let mut v = v as u32 >> (SQUARE_BITS + SUBPIXEL.trailing_zeros());
        v = (v | v << 8) & 0x00ff_00ff;
        v = (v | v << 4) & 0x0f0f_0f0f;
        v = (v | v << 2) & 0x3333_3333;
        (v | v << 1) & 0x5555_5555
    };
    spread(p.x) | spread(p.y) << 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn as_a_stable_sort_by_squares(
            (width, height) in (1u32..3000, 1u32..3000),
            places in proptest::collection::vec((0.0..=1.0f64, 0.0..=1.0f64), 0..200),
        ) {
            let size = Size::new(width, height);
            let far = size.far();
            let part = |share: f64, far: i32| (share * f64::from(far)) as i32;
            let places: Vec<_> =
                places.iter().map(|&(x, y)| Point::new(part(x, far.x), part(y, far.y))).collect();
            let mut slow: Vec<u32> = (0..places.len() as u32).collect();
            slow.sort_by_key(|&i| square(places[i as usize]));
            let mut morton = MortonOrder::default();
            // The second time in used memory.
            for _ in 0..2 {
                prop_assert_eq!(morton.sort(size, places.iter().copied()), &slow[..]);
            }
        }
    }

    #[test]
    fn squares_go_right_then_down() {
        let at = |x, y| square(Point::new(x * 32 * SUBPIXEL, y * 32 * SUBPIXEL));
        assert_eq!([at(0, 0), at(1, 0), at(0, 1), at(1, 1), at(2, 0)], [0, 1, 2, 3, 4]);
    }
}
