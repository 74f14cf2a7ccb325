//! Algorithm 1 of the paper: seeds by the density of feature points in the cells of the grid.

use crate::chance::{Purpose, rank, unit};
use crate::feature::mask::Mask;
use crate::focus::FocusMap;
use crate::geom::Point;
use crate::hex::HexGrid;
use crate::options::Thresholds;

/// The number of points that a cell keeps (paper, Algorithm 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quota {
    /// Number for the densest cells.
    pub max_points: u32,
    /// Densities that separate the classes.
    pub thresholds: Thresholds,
    /// Number for cells below all thresholds.
    pub default_points: u32,
}

impl Quota {
    /// The quota of a cell with `candidates` feature points on `area` square pixels.
    pub fn of(&self, candidates: usize, area: f64) -> u32 {
        let density = candidates as f64 / area;
        let quota = if density > self.thresholds.high {
            self.max_points
        } else if density > self.thresholds.medium {
            self.max_points / 2
        } else if density > self.thresholds.low {
            self.max_points / 4
        } else {
            self.default_points
        };
        // At least one: a dense cell never keeps fewer than a sparse one.
        quota.max(self.default_points)
    }
}

/// A feature point, with its random rank within its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    rank: u32,
    x: u16,
    y: u16,
}

/// The feature points of a frame, cell by cell.
#[derive(Clone, Debug)]
pub struct Binned {
    candidates: Vec<Candidate>,
    /// The start of each cell's candidates, and the end of the last cell's.
    starts: Vec<u32>,
    quotas: Vec<f64>,
    /// A random number in 0..1 for each cell: the dither by which fractional quotas are rounded.
    dither: Vec<f64>,
}

impl Binned {
    /// Sorts `candidates` into the cells of `grid`.
    pub fn new(candidates: &Mask, grid: &HexGrid, quota: &Quota, seed: u64) -> Self {
        let mut unsorted = Vec::with_capacity(candidates.len());
        let mut starts = vec![0u32; grid.cells() + 1];
        for (x, y) in candidates.iter() {
            let cell = grid.cell_of_pixel(x, y);
            starts[cell + 1] += 1;
            let rank = (rank(seed, Purpose::Keep, x, y) >> 32) as u32;
            unsorted.push((cell as u32, Candidate { rank, x: x as u16, y: y as u16 }));
        }
        let area = grid.cell_area();
        let quotas = starts[1..].iter().map(|&n| quota.of(n as usize, area).into()).collect();
        for cell in 0..grid.cells() {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        let mut candidates = vec![Candidate { rank: 0, x: 0, y: 0 }; unsorted.len()];
        for (cell, candidate) in unsorted {
            let place = &mut next[cell as usize];
            candidates[*place as usize] = candidate;
            *place += 1;
        }
        let dither =
            (0..grid.cells()).map(|cell| unit(seed, Purpose::Trim, cell as u32, 0)).collect();
        Self { candidates, starts, quotas, dither }
    }

    /// Multiplies the quotas of the cells of `grid` by how much their centres matter.
    pub(crate) fn weigh(&mut self, grid: &HexGrid, focus: &FocusMap) {
        for (cell, quota) in self.quotas.iter_mut().enumerate() {
            let (x, y) = grid.centre(cell);
            *quota *= focus.at(Point::from_pixels(x, y));
        }
    }

    /// Draws the quotas of all cells towards their mean: 0 not at all, 1 all the way.
    pub(crate) fn even_out(&mut self, share: f64) {
        let mean = self.quotas.iter().sum::<f64>() / self.quotas.len().max(1) as f64;
        self.quotas.iter_mut().for_each(|quota| *quota += share * (mean - *quota));
    }

    fn held(&self, cell: usize) -> usize {
        (self.starts[cell + 1] - self.starts[cell]) as usize
    }

    /// The number of candidates that `cell` keeps when quotas are multiplied by `scale`.
    fn kept(&self, cell: usize, scale: f64) -> usize {
        let quota = self.quotas[cell] * scale + self.dither[cell];
        // A scale of exactly 1 keeps the quota itself: the dither is below 1.
        (quota as usize).min(self.held(cell))
    }

    /// The number of points kept at `scale`.
    pub fn count(&self, scale: f64) -> usize {
        (0..self.quotas.len()).map(|cell| self.kept(cell, scale)).sum()
    }

    /// The largest scale at which at most `target` points are kept, to the precision of the bisection.
    pub fn solve(&self, target: usize) -> f64 {
        let most = self.candidates.len();
        let (mut low, mut high) = (0.0, 1.0);
        while self.count(high) <= target {
            // No scale keeps more than all candidates.
            if high > most as f64 {
                return high;
            }
            (low, high) = (high, high * 2.0);
        }
        // Only cells whose number still changes are counted again.
        let mut open: Vec<usize> = (0..self.quotas.len()).collect();
        let mut settled = 0;
        // 40 halvings separate scales that differ by 1e-12, so that points are added one by one.
        for _ in 0..40 {
            open.retain(|&cell| {
                let (least, most) = (self.kept(cell, low), self.kept(cell, high));
                settled += if least == most { least } else { 0 };
                least < most
            });
            let middle = (low + high) / 2.0;
            let count = settled + open.iter().map(|&cell| self.kept(cell, middle)).sum::<usize>();
            if count <= target { low = middle } else { high = middle }
        }
        low
    }

    /// The points kept at `scale`: in each cell those of the smallest ranks, in rising order of rank.
    pub fn keep(&mut self, scale: f64) -> Vec<(u32, u32)> {
        let mut points = Vec::with_capacity(self.count(scale));
        for cell in 0..self.quotas.len() {
            let kept = self.kept(cell, scale);
            let (start, end) = (self.starts[cell] as usize, self.starts[cell + 1] as usize);
            let held = &mut self.candidates[start..end];
            if kept > 0 && kept < held.len() {
                held.select_nth_unstable(kept - 1);
            }
            held[..kept].sort_unstable();
            points.extend(held[..kept].iter().map(|c| (u32::from(c.x), u32::from(c.y))));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use proptest::prelude::*;

    fn quota() -> Quota {
        let thresholds = Thresholds { high: 0.2, medium: 0.1, low: 0.02 };
        Quota { max_points: 8, thresholds, default_points: 1 }
    }

    #[test]
    fn quotas_follow_algorithm_1() {
        for (candidates, kept) in [(0, 1), (2, 1), (3, 2), (10, 2), (11, 4), (20, 4), (21, 8)] {
            assert_eq!(quota().of(candidates, 100.0), kept, "{candidates} on 100 pixels");
        }
        assert_eq!(Quota { max_points: 2, ..quota() }.of(3, 100.0), 1, "a quarter of two");
    }

    /// As [`Binned::solve`], counting all cells every time.
    fn solve_slowly(binned: &Binned, target: usize) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        while binned.count(high) <= target {
            if high > binned.candidates.len() as f64 {
                return high;
            }
            (low, high) = (high, high * 2.0);
        }
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            if binned.count(middle) <= target { low = middle } else { high = middle }
        }
        low
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn kept_points_are_candidates_within_quota_and_near_the_target(
            share in 0.0f64..1.0,
            width in 4.0f64..30.0,
            target in 0usize..2000,
            seed: u64,
        ) {
            let size = Size::new(90, 70);
            let mut mask = Mask::new(size);
            for y in 0..size.height {
                for x in (0..size.width).filter(|&x| unit(seed, Purpose::Noise, x, y) < share) {
                    mask.insert(x, y);
                }
            }
            let grid = HexGrid::new(size, width);
            let mut binned = Binned::new(&mask, &grid, &quota(), seed);
            let scale = binned.solve(target);
            prop_assert_eq!(scale, solve_slowly(&binned, target));
            let mut points = binned.keep(scale);
            prop_assert!(points.len() <= target);
            // Cells differ in their dither, so that bisection reaches the target to the point.
            prop_assert!(points.len() + 1 >= target.min(mask.len()));
            prop_assert!(points.iter().all(|&(x, y)| mask.contains(x, y)));
            let mut per_cell = vec![0; grid.cells()];
            for &(x, y) in &points {
                per_cell[grid.cell_of_pixel(x, y)] += 1;
            }
            prop_assert!((0..grid.cells()).all(|cell| per_cell[cell] == binned.kept(cell, scale)));
            points.sort_unstable();
            points.dedup();
            prop_assert_eq!(points.len(), per_cell.iter().sum::<usize>(), "no point twice");
        }
    }

    #[test]
    fn quotas_at_scale_one_are_kept_to_the_letter() {
        let size = Size::new(60, 60);
        let mut mask = Mask::new(size);
        (0..60).for_each(|y| (0..60).for_each(|x| mask.insert(x, y)));
        let grid = HexGrid::new(size, 12.0);
        let binned = Binned::new(&mask, &grid, &quota(), 3);
        for cell in 0..grid.cells() {
            assert_eq!(binned.kept(cell, 1.0), binned.held(cell).min(binned.quotas[cell] as usize));
        }
    }
}
