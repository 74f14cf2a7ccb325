//! Points anywhere, at random.

use crate::chance::{Purpose, rank};
use crate::feature::mask::Mask;
use crate::geom::Size;

/// Adds up to `count` random pixels of a frame of `size` to the distinct `points`; fewer where those that are drawn are
/// taken already.
pub(super) fn scatter(points: &mut Vec<(u32, u32)>, size: Size, count: usize, seed: u64) {
    if count == 0 || size.pixels() == 0 {
        return;
    }
    let mut taken = Mask::of(size, points);
    let part = |bits: u64, side: u32| (((bits & 0xffff_ffff) * u64::from(side)) >> 32) as u32;
    for i in 0..count as u32 {
        let bits = rank(seed, Purpose::Phase, i, u32::MAX);
        let (x, y) = (part(bits, size.width), part(bits >> 32, size.height));
        if taken.put(x, y) {
            points.push((x, y));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_all_over_and_are_distinct() {
        let size = Size::new(200, 100);
        let mut points = vec![(5, 5)];
        scatter(&mut points, size, 1000, 3);
        // A twentieth of the pixels: some 25 are drawn twice.
        assert!((950..=1001).contains(&points.len()), "{}", points.len());
        let left = points.iter().filter(|p| p.0 < 100).count();
        assert!((420..580).contains(&left), "{left}");
        points.sort_unstable();
        points.windows(2).for_each(|pair| assert_ne!(pair[0], pair[1]));
    }
}
