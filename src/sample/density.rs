//! Algorithm 1 of the paper: seeds by the density of feature points in the cells of the grid.

use crate::chance::{Purpose, rank};
use crate::feature::mask::Mask;
use crate::hex::HexGrid;
use crate::options::Thresholds;

/// How many points a cell keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quota {
    /// The densest cells keep this many.
    pub max_points: u32,
    /// Where dense begins.
    pub thresholds: Thresholds,
    /// Cells below all thresholds keep this many.
    pub default_points: u32,
}

impl Quota {
    /// The quota of a cell with `candidates` feature points on `area` square pixels.
    pub fn of(&self, candidates: usize, area: f64) -> usize {
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
        // A quarter of few points is still one: a denser cell never keeps less than a sparse one.
        quota.max(self.default_points) as usize
    }
}

/// A candidate pixel in its cell, with its rank by chance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    cell: u32,
    rank: u32,
    x: u32,
    y: u32,
}

/// The candidates that the quota keeps: of each cell those with the smallest ranks. Cell by cell, in
/// the order of ranks inside a cell.
pub fn sample(candidates: &Mask, grid: &HexGrid, quota: &Quota, seed: u64) -> Vec<(u32, u32)> {
    let mut sorted: Vec<Candidate> = candidates
        .iter()
        .map(|(x, y)| Candidate {
            cell: grid.cell_of_pixel(x, y) as u32,
            rank: (rank(seed, Purpose::Keep, x, y) >> 32) as u32,
            x,
            y,
        })
        .collect();
    sorted.sort_unstable();
    let area = grid.cell_area();
    sorted
        .chunk_by(|a, b| a.cell == b.cell)
        .flat_map(|cell| &cell[..quota.of(cell.len(), area).min(cell.len())])
        .map(|candidate| (candidate.x, candidate.y))
        .collect()
}

/// The number of points that [`sample`] would keep.
pub fn count(candidates: &Mask, grid: &HexGrid, quota: &Quota) -> usize {
    let mut cells = vec![0usize; grid.cells()];
    for (x, y) in candidates.iter() {
        cells[grid.cell_of_pixel(x, y)] += 1;
    }
    let area = grid.cell_area();
    cells.iter().map(|&n| quota.of(n, area).min(n)).sum()
}
