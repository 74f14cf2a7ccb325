//! Random thinning: level two of the baseline RLP, which has no grid.

use crate::chance::{Purpose, rank};
use crate::feature::mask::Mask;
use crate::focus::FocusMap;
use crate::geom::Point;

/// `target` random ones of the `candidates`, all of them if there are no more. The rank of a pixel does not depend on
/// the other candidates. Where places matter more by `focus`, more are kept.
pub(crate) fn thin(
    candidates: &Mask,
    target: usize,
    focus: Option<&FocusMap>,
    seed: u64,
) -> Vec<(u32, u32)> {
    keep(candidates.iter().collect(), target, focus, seed)
}

/// The `target` of `points` whose ranks are smallest, row by row.
pub(super) fn keep(
    points: Vec<(u32, u32)>,
    target: usize,
    focus: Option<&FocusMap>,
    seed: u64,
) -> Vec<(u32, u32)> {
    let key = |x, y| {
        let rank = rank(seed, Purpose::Trim, x, y);
        match focus {
            // Priority sampling: a float cast to an integer saturates.
            Some(focus) => (rank as f64 / focus.at(Point::pixel_centre(x, y))) as u64,
            None => rank,
        }
    };
    least(points, target, key)
}

/// The `target` of `points` whose keys are smallest, row by row.
pub(super) fn least<K: Ord>(
    points: Vec<(u32, u32)>,
    target: usize,
    key: impl Fn(u32, u32) -> K,
) -> Vec<(u32, u32)> {
    if points.len() <= target {
        return points;
    }
    let mut ranked: Vec<_> = points.into_iter().map(|(x, y)| (key(x, y), y, x)).collect();
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
            let kept = thin(&mask, target, None, 3);
            assert_eq!(kept.len(), target.min(1200));
            let ordered = kept.windows(2).all(|p| (p[0].1, p[0].0) < (p[1].1, p[1].0));
            assert!(ordered, "distinct, row by row");
        }
    }

    #[test]
    fn fewer_are_a_part_of_more_and_lie_evenly() {
        let mask = full(Size::new(200, 100));
        let (few, more) = (thin(&mask, 2000, None, 1), thin(&mask, 4000, None, 1));
        assert!(few.iter().all(|p| more.contains(p)));
        // Binomial: mean 1000, standard deviation 22.
        let left = few.iter().filter(|p| p.0 < 100).count();
        assert!((900..1100).contains(&left), "{left}");
        assert_ne!(few, thin(&mask, 2000, None, 2));
    }
}
