//! Greedy maxima with Gaussian suppression: level two of the baseline ENTROPY. The maximum of the score becomes a
//! seed, and the score around it is lowered; this repeats until there are enough seeds.
//!
//! The published form searches the whole map for every seed, which is feasible for small images only. Here a
//! tournament tree over tiles holds the maxima, so that the work is about 40 operations for each pixel with any
//! number of seeds: more seeds suppress smaller areas. The algorithm is sequential and uses one thread.

use crate::geom::Size;
use crate::plane::Plane;

/// Side of a tile in pixels.
const TILE: u32 = 16;

/// Standard deviation of the suppression in mean distances between seeds. See `docs/calibration.md`.
const SIGMA: f64 = 0.5;

/// Radius of the suppression in standard deviations: it is 1 % there.
const REACH: f64 = 3.0;

/// Scores below this share of the largest count as 0: they are rounding errors.
const NOTHING: f32 = 1e-6;

/// Up to `target` pixels of `score`, the highest first; of equal ones the first in rows. Fewer if no score is left.
pub fn suppress(score: &Plane<f32>, target: usize) -> Vec<(u32, u32)> {
    let mut points = Vec::with_capacity(target);
    if target == 0 || score.size().pixels() == 0 {
        return points;
    }
    let distance = (score.size().pixels() as f64 / target as f64).sqrt();
    let dent = Dent::new((SIGMA * distance).max(0.5));
    let mut field = Field::new(score.clone());
    let least = field.highest().0 * NOTHING;
    while points.len() < target {
        let (value, x, y) = field.highest();
        if value <= least {
            break;
        }
        points.push((x, y));
        field.press(&dent, x, y);
    }
    points
}

/// The factor, 0..1, by which the score at a distance from a seed is multiplied.
struct Dent {
    reach: u32,
    remains: Vec<f32>,
}

impl Dent {
    fn new(sigma: f64) -> Self {
        let reach = (REACH * sigma).ceil() as u32;
        let at = |i: u32| f64::from(i.abs_diff(reach)).powi(2);
        let side = 2 * reach + 1;
        let remains = (0..side * side)
            .map(|i| (1.0 - (-(at(i % side) + at(i / side)) / (2.0 * sigma * sigma)).exp()) as f32)
            .collect();
        Self { reach, remains }
    }
}

/// A score with its maxima: the highest pixel of each tile, and a tournament tree over them.
struct Field {
    score: Plane<f32>,
    columns: u32,
    /// A complete binary tree: node n has the children 2n and 2n + 1; the second half are the tiles.
    tree: Vec<(f32, u32, u32)>,
}

impl Field {
    fn new(score: Plane<f32>) -> Self {
        let Size { width, height } = score.size();
        let (columns, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let leaves = ((columns * rows) as usize).next_power_of_two();
        let nothing = (f32::NEG_INFINITY, u32::MAX, u32::MAX);
        let mut field = Self { score, columns, tree: vec![nothing; 2 * leaves] };
        for row in 0..rows {
            for column in 0..columns {
                field.look(column, row);
            }
        }
        for node in (1..leaves).rev() {
            field.play(node);
        }
        field
    }

    fn highest(&self) -> (f32, u32, u32) {
        self.tree[1]
    }

    fn leaf(&self, column: u32, row: u32) -> usize {
        self.tree.len() / 2 + (row * self.columns + column) as usize
    }

    /// Updates the highest pixel of a tile.
    fn look(&mut self, column: u32, row: u32) {
        let Size { width, height } = self.score.size();
        let mut best = (f32::NEG_INFINITY, u32::MAX, u32::MAX);
        for y in row * TILE..((row + 1) * TILE).min(height) {
            let first = column * TILE;
            let line =
                &self.score.row(y)[first as usize..((column + 1) * TILE).min(width) as usize];
            for (&value, x) in line.iter().zip(first..) {
                if value > best.0 {
                    best = (value, x, y);
                }
            }
        }
        let leaf = self.leaf(column, row);
        self.tree[leaf] = best;
    }

    fn play(&mut self, node: usize) {
        let (a, b) = (self.tree[2 * node], self.tree[2 * node + 1]);
        // Of equal ones the upper, then the left one.
        let second = b.0 > a.0 || (b.0 == a.0 && (b.2, b.1) < (a.2, a.1));
        self.tree[node] = if second { b } else { a };
    }

    /// Suppresses the score around `(x, y)`.
    fn press(&mut self, dent: &Dent, x: u32, y: u32) {
        let Size { width, height } = self.score.size();
        let Dent { reach, ref remains } = *dent;
        let (left, top) = (x.saturating_sub(reach), y.saturating_sub(reach));
        let (right, bottom) = ((x + reach).min(width - 1), (y + reach).min(height - 1));
        let side = (2 * reach + 1) as usize;
        for v in top..=bottom {
            let from = (v + reach - y) as usize * side + (left + reach - x) as usize;
            let start = (v * width) as usize;
            let line = &mut self.score.values_mut()[start + left as usize..=start + right as usize];
            line.iter_mut().zip(&remains[from..]).for_each(|(value, keep)| *value *= keep);
        }
        for row in top / TILE..=bottom / TILE {
            for column in left / TILE..=right / TILE {
                let before = self.tree[self.leaf(column, row)];
                // The maximum of a tile is unchanged if its highest pixel was not lowered.
                let held = (left..=right).contains(&before.1) && (top..=bottom).contains(&before.2);
                if held {
                    self.look(column, row);
                    let mut node = self.leaf(column, row) / 2;
                    while node > 0 {
                        self.play(node);
                        node /= 2;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, unit};

    fn noise(size: Size) -> Plane<f32> {
        let value = |i: u32| unit(2, Purpose::Noise, i % size.width, i / size.width) as f32;
        Plane::new(size, (0..size.pixels() as u32).map(value).collect()).expect("as many as pixels")
    }

    /// The published form: a search of the whole map for every seed.
    fn plainly(score: &Plane<f32>, target: usize) -> Vec<(u32, u32)> {
        let mut field = score.clone();
        let Size { width, height } = score.size();
        let sigma = (SIGMA * (score.size().pixels() as f64 / target as f64).sqrt()).max(0.5);
        let dent = Dent::new(sigma);
        let mut points = Vec::new();
        for _ in 0..target {
            let mut best = (f32::NEG_INFINITY, 0);
            for (&value, i) in field.values().iter().zip(0..) {
                if value > best.0 {
                    best = (value, i);
                }
            }
            let (x, y) = (best.1 % width, best.1 / width);
            points.push((x, y));
            for v in 0..height {
                for u in 0..width {
                    let reach = dent.reach;
                    if u.abs_diff(x) <= reach && v.abs_diff(y) <= reach {
                        let at = (v + reach - y) * (2 * reach + 1) + u + reach - x;
                        field.values_mut()[(v * width + u) as usize] *= dent.remains[at as usize];
                    }
                }
            }
        }
        points
    }

    #[test]
    fn the_tournament_finds_what_a_plain_search_finds() {
        for (width, height, target) in [(50, 37, 30), (16, 16, 5), (70, 3, 12), (1, 40, 6)] {
            let score = noise(Size::new(width, height));
            assert_eq!(suppress(&score, target), plainly(&score, target), "{width}x{height}");
        }
    }

    #[test]
    fn seeds_keep_their_distance() {
        let score = Plane::filled(Size::new(80, 80), 1.0);
        let points = suppress(&score, 64);
        assert_eq!((points.len(), points[0]), (64, (0, 0)));
        for (i, a) in points.iter().enumerate() {
            for b in &points[..i] {
                let apart = f64::from(a.0.abs_diff(b.0)).hypot(f64::from(a.1.abs_diff(b.1)));
                assert!(apart >= 5.0, "{a:?} {b:?}: the mean distance is 10");
            }
        }
    }

    #[test]
    fn nothing_is_taken_from_nothing() {
        assert!(suppress(&Plane::filled(Size::new(20, 20), 0.0), 10).is_empty());
        assert_eq!(suppress(&Plane::filled(Size::new(1, 1), 1.0), 10), [(0, 0)]);
        let all = suppress(&noise(Size::new(9, 7)), 63);
        assert!(all.len() <= 63);
    }
}
