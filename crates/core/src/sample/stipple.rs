//! Weighted Voronoi stippling (Secord, "Weighted Voronoi Stippling", NPAR 2002) between points that stay: each of the
//! others moves to the centre of what is nearest to it, again and again, until they lie evenly, and closer where places
//! matter more.

use super::spread::throw;
use crate::chance::{Purpose, rank, unit};
use crate::feature::mask::Mask;
use crate::focus::FocusMap;
use crate::geom::{Point, Size};
use crate::hex::HexGrid;
use crate::parallel::prelude::*;

/// Rounds of moves: later ones move points by less than a tenth of their distance.
const ROUNDS: usize = 12;

/// Places that are looked at for each point.
const PLACES: f64 = 16.0;

/// Places that are drawn for a point, before it takes the last.
const THROWS: u32 = 8;

/// What matters most weighs this much.
const MOST: f64 = 4.0;

/// `target` pixels, or slightly fewer: those of `fixed`, and others between them.
pub(super) fn stipple(
    fixed: Vec<(u32, u32)>,
    target: usize,
    grid: &HexGrid,
    focus: Option<&FocusMap>,
    seed: u64,
) -> Vec<(u32, u32)> {
    let size = grid.size();
    if target <= fixed.len() {
        return fixed;
    }
    let first = fixed.len();
    let mut sites: Vec<(f64, f64)> =
        fixed.iter().map(|&(x, y)| (f64::from(x) + 0.5, f64::from(y) + 0.5)).collect();
    sites.extend((0..target - first).map(|i| start(i, grid, focus, seed)));
    let step = (size.pixels() as f64 / (PLACES * target as f64)).sqrt().max(1.0);
    let places = Places::new(size, step, focus);
    for _ in 0..ROUNDS {
        settle(&mut sites, first, &places, size);
    }
    let mut taken = Mask::of(size, &fixed);
    let mut points = fixed;
    for &(x, y) in &sites[first..] {
        let (x, y) = ((x as u32).min(size.width - 1), (y as u32).min(size.height - 1));
        if taken.put(x, y) {
            points.push((x, y));
        }
    }
    points
}

/// How much a place matters.
fn weight(focus: Option<&FocusMap>, x: f64, y: f64) -> f64 {
    focus.map_or(1.0, |focus| focus.at(Point::from_pixels(x, y)))
}

/// The first place of point `i`: random, where places matter more likely.
fn start(i: usize, grid: &HexGrid, focus: Option<&FocusMap>, seed: u64) -> (f64, f64) {
    let mut place = (0.5, 0.5);
    for round in 0..THROWS {
        let cell = rank(seed, Purpose::Keep, i as u32, round) % grid.cells().max(1) as u64;
        // The rounds of `spread` come before these.
        let Some((x, y)) = throw(grid, cell as usize, 64 + round, seed ^ i as u64) else {
            continue;
        };
        place = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        if unit(seed, Purpose::Trim, i as u32, round) * MOST < weight(focus, place.0, place.1) {
            break;
        }
    }
    place
}

/// Places all over the frame, and how much each matters.
struct Places(Vec<(f64, f64, f64)>);

impl Places {
    fn new(size: Size, step: f64, focus: Option<&FocusMap>) -> Self {
        let count = |side: u32| ((f64::from(side) / step) as usize).max(1);
        let (columns, rows) = (count(size.width), count(size.height));
        let at =
            |i: usize, count: usize, side: u32| (i as f64 + 0.5) / count as f64 * f64::from(side);
        let place = |i: usize| {
            let (x, y) = (at(i % columns, columns, size.width), at(i / columns, rows, size.height));
            (x, y, weight(focus, x, y))
        };
        Self((0..rows * columns).map(place).collect())
    }
}

/// Moves the sites from `first` on to the weighted centres of the places that are nearest to them.
fn settle(sites: &mut [(f64, f64)], first: usize, places: &Places, size: Size) {
    let buckets = Buckets::new(sites, size);
    let nearest: Vec<u32> = places
        .0
        .par_iter()
        .with_min_len(1 << 10)
        .map(|&(x, y, _)| buckets.nearest(sites, x, y))
        .collect();
    // One after the other: sums of floats depend on their order.
    let mut sums = vec![(0.0, 0.0, 0.0); sites.len()];
    for (&site, &(x, y, weight)) in nearest.iter().zip(&places.0) {
        let sum = &mut sums[site as usize];
        *sum = (sum.0 + weight * x, sum.1 + weight * y, sum.2 + weight);
    }
    for (site, (x, y, weight)) in sites.iter_mut().zip(sums).skip(first) {
        if weight > 0.0 {
            *site = (x / weight, y / weight);
        }
    }
}

/// Sites in the squares of a grid.
struct Buckets {
    side: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    sites: Vec<u32>,
}

impl Buckets {
    fn new(sites: &[(f64, f64)], size: Size) -> Self {
        let side = (size.pixels() as f64 / sites.len().max(1) as f64).sqrt().max(1.0);
        let count = |length: u32| (f64::from(length) / side) as usize + 1;
        let (columns, rows) = (count(size.width), count(size.height));
        let mut buckets =
            Self { side, columns, rows, starts: vec![0; columns * rows + 1], sites: Vec::new() };
        let numbers: Vec<usize> = sites.iter().map(|&(x, y)| buckets.of(x, y)).collect();
        numbers.iter().for_each(|&bucket| buckets.starts[bucket + 1] += 1);
        (0..columns * rows).for_each(|i| buckets.starts[i + 1] += buckets.starts[i]);
        let mut next = buckets.starts.clone();
        buckets.sites.resize(sites.len(), 0);
        for (site, bucket) in (0u32..).zip(numbers) {
            buckets.sites[next[bucket] as usize] = site;
            next[bucket] += 1;
        }
        buckets
    }

    fn of(&self, x: f64, y: f64) -> usize {
        let place = |v: f64, count: usize| ((v / self.side) as usize).min(count - 1);
        place(y, self.rows) * self.columns + place(x, self.columns)
    }

    /// The site nearest to a place; of equally near ones the first.
    fn nearest(&self, sites: &[(f64, f64)], x: f64, y: f64) -> u32 {
        let bucket = self.of(x, y);
        let (column, row) = ((bucket % self.columns) as i64, (bucket / self.columns) as i64);
        let (mut best, mut found) = (f64::INFINITY, 0);
        for reach in 0..=self.columns.max(self.rows) as i64 {
            // What lies further out is further away than the best.
            if best <= ((reach - 1).max(0) as f64 * self.side).powi(2) {
                break;
            }
            for r in (row - reach).max(0)..=(row + reach).min(self.rows as i64 - 1) {
                let edge = (r - row).abs() == reach;
                let step = if edge || reach == 0 { 1 } else { 2 * reach };
                for c in (column - reach..=column + reach).step_by(step as usize) {
                    if !(0..self.columns as i64).contains(&c) {
                        continue;
                    }
                    let bucket = r as usize * self.columns + c as usize;
                    let range = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
                    for &site in &self.sites[range] {
                        let (sx, sy) = sites[site as usize];
                        let far = (sx - x).powi(2) + (sy - y).powi(2);
                        if far < best || (far == best && site < found) {
                            (best, found) = (far, site);
                        }
                    }
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_site_is_found() {
        let size = Size::new(90, 40);
        let place = |i: u32, n: u32| {
            (90.0 * unit(n.into(), Purpose::Keep, i, 0), 40.0 * unit(n.into(), Purpose::Keep, i, 1))
        };
        // Crowded on one side, so that rings of squares are empty.
        let sites: Vec<_> = (0..60).map(|i| place(i, 1)).map(|(x, y)| (x * x / 90.0, y)).collect();
        let buckets = Buckets::new(&sites, size);
        for i in 0..500 {
            let (x, y) = place(i, 2);
            let far = |&(sx, sy): &(f64, f64)| (sx - x).powi(2) + (sy - y).powi(2);
            let least = sites.iter().map(far).fold(f64::INFINITY, f64::min);
            assert_eq!(far(&sites[buckets.nearest(&sites, x, y) as usize]), least);
        }
    }

    #[test]
    fn fixed_points_stay_and_others_settle_evenly() {
        let size = Size::new(200, 150);
        let grid = HexGrid::new(size, 12.0);
        let fixed = vec![(10, 10), (11, 10), (12, 11)];
        let points = stipple(fixed.clone(), 300, &grid, None, 5);
        assert_eq!(points[..3], fixed);
        assert!((296..=300).contains(&points.len()), "{}", points.len());
        let nearest = |i: usize| {
            let (x, y) = points[i];
            let far = |p: &(u32, u32)| x.abs_diff(p.0).pow(2) + y.abs_diff(p.1).pow(2);
            let others = points.iter().enumerate().filter(|&(j, _)| j != i);
            f64::from(others.map(|(_, p)| far(p)).min().expect("others")).sqrt()
        };
        // Evenly spread points are a mean distance of 10 pixels apart; random ones have near neighbours.
        let close = (3..points.len()).filter(|&i| nearest(i) < 5.0).count();
        assert!(close <= 3, "{close} points have a neighbour at less than half the distance");
    }
}
