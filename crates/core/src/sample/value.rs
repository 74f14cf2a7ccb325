//! Algorithm 3 of the paper: seeds by the mean value of the cells of the grid.

use std::ops::Range;

use crate::parallel::prelude::*;

use super::spread::throw;
use crate::chance::{Purpose, rank};
use crate::feature::Features;
use crate::geom::Size;
use crate::hex::HexGrid;
use crate::options::CellPercentiles;

/// The shares of high and of medium cells, in per cent, of the points that are left after every cell has
/// `min_points`. Low cells share the others (paper, Algorithm 3, with the sign of the low share corrected).
const HIGH_SHARE: usize = 50;
const MEDIUM_SHARE: usize = 30;

/// Mean number of seeds in a cell, where no option gives the grid. See `docs/calibration.md`.
const CELL_POINTS: f64 = 4.0;

/// Rows in one parallel piece of work.
const BAND: usize = 32;

/// Scores are rounded to this fraction, so that their sums are the same in any order.
const STEPS: f32 = 65_536.0;

/// Random positions that are tried for a pixel of a cell without enough feature points, before all its pixels are
/// listed.
const THROWS: u32 = 24;

/// The distribution of points over cells (paper, Algorithm 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sharing {
    /// Number for every cell, before the others are distributed.
    pub min_points: u32,
    /// The percentiles of high and of low cells.
    pub percentiles: CellPercentiles,
}

/// The grid for `target` seeds: of cells of `hex_density` if given, else with four seeds in a cell on average. Cells
/// are large enough for `min_points` in each.
pub fn value_grid(size: Size, target: usize, min_points: u32, hex_density: Option<f64>) -> HexGrid {
    let mean = size.pixels() as f64 / target.max(1) as f64;
    let mut area = match hex_density {
        Some(density) => size.pixels() as f64 * density,
        None => mean * CELL_POINTS.max(f64::from(2 * min_points)),
    };
    // The finest grid; smaller values give the same.
    area = area.max(f64::MIN_POSITIVE);
    while 1.05 * area < HexGrid::new(size, 0.0).cell_area() {
        area *= 1.05;
    }
    loop {
        let grid = HexGrid::with_cell_area(size, area);
        let cells = counted(&grid);
        if cells * min_points as usize <= target || cells <= 1 {
            return grid;
        }
        area *= 1.05;
    }
}

/// Whether a cell gets points: at least half of it lies in the frame.
fn takes_part(area: f64, grid: &HexGrid) -> bool {
    2.0 * area >= grid.cell_area() * 0.999
}

/// Approximate number of cells of `grid` that get points: those with their centre in the closed frame.
fn counted(grid: &HexGrid) -> usize {
    let size = grid.size();
    let inside = |(x, y): (f64, f64)| {
        x >= 0.0 && y >= 0.0 && x <= f64::from(size.width) && y <= f64::from(size.height)
    };
    (0..grid.cells()).filter(|&cell| inside(grid.centre(cell))).count()
}

/// `target` pixels of the frame. Every cell that lies in it by half has `min_points`. Of the others, cells above the
/// high percentile of the mean value share 50 %, those between the percentiles 30 %, those below the medium one 20 %,
/// each class by the areas of its cells in the frame. The share of a class without cells goes to the medium class. In
/// a cell feature points are taken at random (level one has weighted them by value already), then any pixels.
///
/// Fewer than `target` if cells are too small for their share.
pub fn share_by_value(
    features: &Features,
    grid: &HexGrid,
    sharing: Sharing,
    target: usize,
    seed: u64,
) -> Vec<(u32, u32)> {
    let cells = measure(features, grid);
    let quotas = quotas(&cells, grid, sharing, target, seed);
    let mut binned = vec![Vec::new(); grid.cells()];
    for (x, y) in features.candidates.iter() {
        let cell = grid.cell_of_pixel(x, y);
        if quotas[cell] > 0 {
            binned[cell].push((rank(seed, Purpose::Trim, x, y), y, x));
        }
    }
    let mut points = Vec::with_capacity(target);
    for (cell, mut held) in binned.into_iter().enumerate() {
        let quota = quotas[cell];
        if quota > 0 && held.len() > quota {
            held.select_nth_unstable(quota - 1);
            held.truncate(quota);
        }
        held.sort_unstable();
        let first = points.len();
        points.extend(held.iter().map(|&(_, y, x)| (x, y)));
        fill_cell(&mut points, first, quota, (grid, cell), seed);
    }
    points
}

/// Area in the frame and mean value of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    pixels: u64,
    sum: u64,
}

impl Cell {
    fn mean(self) -> f64 {
        self.sum as f64 / self.pixels.max(1) as f64
    }
}

/// Area and mean value of all cells: of the score, or without one the density of feature points.
fn measure(features: &Features, grid: &HexGrid) -> Vec<Cell> {
    let height = grid.size().height;
    let most = features.score.as_ref().map_or(0.0, |score| {
        score.values().par_iter().with_min_len(1 << 14).copied().reduce(|| 0.0, f32::max)
    });
    let scale = if most > 0.0 { STEPS / most } else { 0.0 };
    let value = |y: u32, columns: Range<u32>| match &features.score {
        Some(score) => {
            let values = &score.row(y)[columns.start as usize..columns.end as usize];
            // A float cast to an integer saturates, and takes NaN to 0. A row's steps fit 32 bits.
            u64::from(values.iter().map(|v| (v * scale) as u32).sum::<u32>())
        }
        None => {
            columns.filter(|&x| features.candidates.contains(x, y)).count() as u64 * STEPS as u64
        }
    };
    let band = |band: usize| {
        let rows = (band * BAND) as u32..((band + 1) * BAND).min(height as usize) as u32;
        let (mut sums, mut first) = (Vec::<Cell>::new(), usize::MAX);
        for y in rows {
            grid.row_runs(y, |cell, columns| {
                if cell < first {
                    let missing = if sums.is_empty() { 0 } else { first - cell };
                    sums.splice(0..0, std::iter::repeat_n(Cell::default(), missing));
                    first = cell;
                }
                if cell - first >= sums.len() {
                    sums.resize(cell - first + 1, Cell::default());
                }
                let sum = &mut sums[cell - first];
                sum.pixels += u64::from(columns.end - columns.start);
                sum.sum += value(y, columns);
            });
        }
        (first, sums)
    };
    let bands: Vec<_> = (0..(height as usize).div_ceil(BAND)).into_par_iter().map(band).collect();
    let mut cells = vec![Cell::default(); grid.cells()];
    for (first, sums) in bands {
        for (cell, sum) in cells[first.min(grid.cells())..].iter_mut().zip(sums) {
            cell.pixels += sum.pixels;
            cell.sum += sum.sum;
        }
    }
    cells
}

/// The number of points of each cell: `target` in total, if any cell gets points.
fn quotas(
    cells: &[Cell],
    grid: &HexGrid,
    sharing: Sharing,
    target: usize,
    seed: u64,
) -> Vec<usize> {
    let mut quotas = vec![0; cells.len()];
    let mut part: Vec<usize> =
        (0..cells.len()).filter(|&c| takes_part(cells[c].pixels as f64, grid)).collect();
    // In random order, so that the remainders of divisions go to cells all over the frame.
    part.sort_unstable_by_key(|&c| (rank(seed, Purpose::Phase, c as u32, 1), c));
    if part.is_empty() {
        return quotas;
    }
    let least = (sharing.min_points as usize).min(target / part.len());
    part.iter().for_each(|&c| quotas[c] = least);
    let remaining = target - least * part.len();

    let mut means: Vec<f64> = part.iter().map(|&c| cells[c].mean()).collect();
    means.sort_unstable_by(f64::total_cmp);
    let high_above = percentile(&means, sharing.percentiles.high);
    let low_below = percentile(&means, sharing.percentiles.medium);
    let (high, rest): (Vec<usize>, _) =
        part.into_iter().partition(|&c| cells[c].mean() > high_above);
    let (low, medium): (Vec<usize>, _) =
        rest.into_iter().partition(|&c| cells[c].mean() < low_below);

    let share = |per_cent: usize, class: &[usize]| {
        if class.is_empty() { 0 } else { remaining * per_cent / 100 }
    };
    let high_share = share(HIGH_SHARE, &high);
    let low_share = match (low.is_empty(), medium.is_empty()) {
        (true, _) => 0,
        (false, true) => remaining - high_share,
        (false, false) => remaining - remaining * HIGH_SHARE / 100 - remaining * MEDIUM_SHARE / 100,
    };
    let medium_share = remaining - high_share - low_share;
    for (class, share) in [(high, high_share), (medium, medium_share), (low, low_share)] {
        hand_out(&mut quotas, &class, share, cells);
    }
    quotas
}

/// Distributes `share` points over the cells of `class` in proportion to their areas: the cumulative number is
/// rounded down after each cell.
fn hand_out(quotas: &mut [usize], class: &[usize], share: usize, cells: &[Cell]) {
    let total: u64 = class.iter().map(|&c| cells[c].pixels).sum();
    let (mut area, mut given) = (0, 0);
    for &cell in class {
        area += cells[cell].pixels;
        let due = (u128::from(area) * share as u128 / u128::from(total)) as usize;
        quotas[cell] += due - given;
        given = due;
    }
}

/// The percentile `p` (0..100) of `sorted` values, interpolated linearly as by numpy.
fn percentile(sorted: &[f64], p: f64) -> f64 {
    let at = p / 100.0 * (sorted.len() - 1) as f64;
    let (low, weight) = (at as usize, at.fract());
    let high = (low + 1).min(sorted.len() - 1);
    // Equal neighbours are returned without rounding.
    if sorted[low] == sorted[high] {
        sorted[low]
    } else {
        sorted[low] + (sorted[high] - sorted[low]) * weight
    }
}

/// Adds pixels of the cell until there are `quota` from `first` on, or the cell is full.
fn fill_cell(
    points: &mut Vec<(u32, u32)>,
    first: usize,
    quota: usize,
    (grid, cell): (&HexGrid, usize),
    seed: u64,
) {
    for round in 0..THROWS {
        if points.len() - first >= quota {
            return;
        }
        let Some((x, y)) = throw(grid, cell, round, seed) else { continue };
        if grid.cell_of_pixel(x, y) == cell && !points[first..].contains(&(x, y)) {
            points.push((x, y));
        }
    }
    if points.len() - first >= quota {
        return;
    }
    let mut free: Vec<_> = pixels_of(grid, cell)
        .filter(|pixel| !points[first..].contains(pixel))
        .map(|(x, y)| (rank(seed, Purpose::Phase, x, y), x, y))
        .collect();
    free.sort_unstable();
    let lacking = quota - (points.len() - first);
    points.extend(free.iter().take(lacking).map(|&(_, x, y)| (x, y)));
}

/// All pixels of a cell.
fn pixels_of(grid: &HexGrid, cell: usize) -> impl Iterator<Item = (u32, u32)> + '_ {
    let (x, y) = grid.centre(cell);
    let Size { width, height } = grid.size();
    // The corners of a hexagon are 1 / sqrt(3) widths away from its centre.
    let range = |centre: f64, reach: f64, side: u32| {
        ((centre - reach - 1.0).max(0.0) as u32)..((centre + reach + 1.0).max(0.0) as u32).min(side)
    };
    let columns = range(x, grid.width() / 2.0, width);
    let rows = range(y, grid.width() / 3f64.sqrt(), height);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
        .filter(move |&(x, y)| grid.cell_of_pixel(x, y) == cell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feature::mask::Mask;
    use crate::plane::Plane;
    use proptest::prelude::*;

    const SHARING: Sharing =
        Sharing { min_points: 1, percentiles: CellPercentiles { high: 75.0, medium: 25.0 } };

    fn ramp(size: Size) -> Features {
        let score = (0..size.pixels()).map(|i| (i % size.width as usize) as f32).collect();
        Features { score: Plane::new(size, score), ..Mask::new(size).into() }
    }

    #[test]
    fn shares_are_those_of_algorithm_3() {
        let size = Size::new(400, 300);
        let grid = HexGrid::new(size, 20.0);
        let cells = measure(&ramp(size), &grid);
        let target = 1500;
        let quotas = quotas(&cells, &grid, SHARING, target, 1);
        assert_eq!(quotas.iter().sum::<usize>(), target);
        let part: Vec<_> =
            (0..grid.cells()).filter(|&c| takes_part(cells[c].pixels as f64, &grid)).collect();
        assert!(part.iter().all(|&c| quotas[c] >= 1), "every cell has its minimum");
        let mut means: Vec<_> = part.iter().map(|&c| cells[c].mean()).collect();
        means.sort_unstable_by(f64::total_cmp);
        let (high, low) = (percentile(&means, 75.0), percentile(&means, 25.0));
        let extra = |wanted: &dyn Fn(f64) -> bool| -> usize {
            part.iter().filter(|&&c| wanted(cells[c].mean())).map(|&c| quotas[c] - 1).sum()
        };
        let remaining = target - part.len();
        assert_eq!(extra(&|v| v > high), remaining / 2);
        assert_eq!(
            extra(&|v| v < low),
            remaining - remaining / 2 - remaining * 30 / 100,
            "the low share has its sign set right"
        );
    }

    #[test]
    fn cells_grow_until_all_can_have_their_minimum() {
        let size = Size::new(200, 200);
        for (target, min_points) in [(100, 1), (100, 20), (7, 64)] {
            let grid = value_grid(size, target, min_points, Some(1e-4));
            let cells = counted(&grid);
            assert!(cells * min_points as usize <= target || cells <= 1, "{target} {min_points}");
        }
    }

    #[test]
    fn cells_of_one_value_are_all_medium() {
        let size = Size::new(100, 100);
        let flat = Features { score: Some(Plane::filled(size, 2.0)), ..ramp(size) };
        let grid = HexGrid::new(size, 10.0);
        let cells = measure(&flat, &grid);
        let quotas = quotas(&cells, &grid, SHARING, 700, 0);
        assert_eq!(quotas.iter().sum::<usize>(), 700);
        let full = (0..grid.cells()).filter(|&c| cells[c].pixels >= 80).map(|c| quotas[c]);
        let (least, most) = full.fold((usize::MAX, 0), |(a, b), q| (a.min(q), b.max(q)));
        assert!(most - least <= 2, "{least} to {most}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]

        #[test]
        fn points_are_distinct_and_within_the_target(
            width in 1u32..70, height in 1u32..70, target in 0usize..900, cell in 2.0f64..20.0,
            seed: u64,
        ) {
            let size = Size::new(width, height);
            let grid = HexGrid::new(size, cell);
            let mut points = share_by_value(&ramp(size), &grid, SHARING, target, seed);
            let count = points.len();
            prop_assert!(count <= target);
            points.sort_unstable();
            points.dedup();
            prop_assert_eq!(points.len(), count);
            prop_assert!(points.iter().all(|&(x, y)| x < width && y < height));
        }
    }
}
