//! The feature points with the highest scores: level two where level one says what matters.

use std::cmp::Reverse;

use super::thin::{keep, least};
use crate::chance::{Purpose, rank};
use crate::feature::Features;

/// The `target` feature points with the highest scores, row by row; of equal ones random ones, and all of them if there
/// are no more. Random ones without scores.
pub(super) fn ranked(features: &Features, target: usize, seed: u64) -> Vec<(u32, u32)> {
    let points = features.candidates.iter().collect();
    match &features.score {
        // Scores are not negative: their bits are in their order.
        Some(score) => least(points, target, |x, y| {
            (Reverse(score.at(x, y).to_bits()), rank(seed, Purpose::Trim, x, y))
        }),
        None => keep(points, target, None, seed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feature::mask::Mask;
    use crate::geom::Size;
    use crate::plane::Plane;

    #[test]
    fn the_highest_scores_are_kept() {
        let size = Size::new(20, 10);
        let mut candidates = Mask::new(size);
        (0..20).for_each(|x| candidates.insert(x, 3));
        let score = Plane::new(size, (0..200).map(|i| (i % 20) as f32 / 3.0).collect());
        let features = Features { score, ..candidates.into() };
        let kept = ranked(&features, 4, 0);
        assert_eq!(kept, [(16, 3), (17, 3), (18, 3), (19, 3)]);
        assert_eq!(ranked(&features, 99, 0).len(), 20);
        assert!(ranked(&features, 0, 0).is_empty());
    }
}
