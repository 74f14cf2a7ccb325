//! Random thinning: level two of the baseline RLP, which has no grid.

use crate::chance::{Purpose, rank};
use crate::feature::mask::Mask;

/// `target` random ones of the `candidates`, all of them if there are no more. The rank of a pixel does not depend on
/// the other candidates.
pub fn thin(candidates: &Mask, target: usize, seed: u64) -> Vec<(u32, u32)> {
    keep(candidates.iter().collect(), target, seed)
}

/// The `target` of `points` whose ranks are smallest, row by row.
pub(super) fn keep(points: Vec<(u32, u32)>, target: usize, seed: u64) -> Vec<(u32, u32)> {
    if points.len() <= target {
        return points;
    }
    let ranked = points.into_iter().map(|(x, y)| (rank(seed, Purpose::Trim, x, y), y, x));
    let mut ranked: Vec<_> = ranked.collect();
    if target > 0 {
        ranked.select_nth_unstable(target - 1);
    }
    ranked.truncate(target);
    let mut kept: Vec<_> = ranked.into_iter().map(|(_, y, x)| (y, x)).collect();
    kept.sort_unstable();
    kept.into_iter().map(|(y, x)| (x, y)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    fn full(size: Size) -> Mask {
        let mut mask = Mask::new(size);
        (0..size.height).for_each(|y| (0..size.width).for_each(|x| mask.insert(x, y)));
        mask
    }

    #[test]
    fn as_many_are_kept_as_are_asked_for() {
        let mask = full(Size::new(40, 30));
        for target in [0, 1, 7, 1199, 1200, 5000] {
            let kept = thin(&mask, target, 3);
            assert_eq!(kept.len(), target.min(1200));
            let ordered = kept.windows(2).all(|p| (p[0].1, p[0].0) < (p[1].1, p[1].0));
            assert!(ordered, "distinct, row by row");
        }
    }

    #[test]
    fn fewer_are_a_part_of_more_and_lie_evenly() {
        let mask = full(Size::new(200, 100));
        let (few, more) = (thin(&mask, 2000, 1), thin(&mask, 4000, 1));
        assert!(few.iter().all(|p| more.contains(p)));
        // Binomial: mean 1000, standard deviation 22.
        let left = few.iter().filter(|p| p.0 < 100).count();
        assert!((900..1100).contains(&left), "{left}");
        assert_ne!(few, thin(&mask, 2000, 2));
    }
}
