//! Level two: which of the feature points become seeds, and how seeds live on from frame to frame.

pub mod border;
pub mod density;

use crate::chance::{Purpose, rank};
use crate::feature::Features;
use crate::feature::mask::Mask;
use crate::geom::{Point, Size};
use crate::hex::HexGrid;
use crate::options::Options;
use density::Quota;

/// The seeds of a frame and how they came to be.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sampled {
    /// Distinct points of the closed frame, none of them a corner; border points among them.
    pub seeds: Vec<Point>,
    /// Seeds of the frame before that stayed where they were.
    pub kept: usize,
    /// Seeds of the frame before that moved with the picture.
    pub moved: usize,
    /// Seeds that were not there before.
    pub born: usize,
    /// Seeds of the frame before that are gone.
    pub died: usize,
    /// Whether a scene cut was found and everything begins anew.
    pub cut: bool,
}

/// Level two for a stream of frames.
#[derive(Debug)]
pub struct Sampler {
    options: Options,
}

impl Sampler {
    /// Level two as `options` ask for it.
    pub fn new(options: &Options) -> Self {
        Self { options: options.clone() }
    }

    /// The grid and the seeds' quota for these candidates: what [`Sampler::sample`] works with.
    pub fn grid(&self, features: &Features) -> HexGrid {
        let size = features.candidates.size();
        match self.options.hex_density {
            Some(density) => HexGrid::with_density(size, density),
            None => {
                let target = self.options.points.target(size);
                let inside = target - border::border_points(size, border_count(size, target)).len();
                solve_grid(&features.candidates, &self.quota(), inside)
            }
        }
    }

    /// The seeds of the next frame.
    pub fn sample(&mut self, features: &Features) -> Sampled {
        let candidates = &features.candidates;
        let size = candidates.size();
        let seed = self.options.seed;
        let grid = self.grid(features);
        let mut chosen = density::sample(candidates, &grid, &self.quota(), seed);
        let mut seeds;
        if self.options.hex_density.is_some() {
            seeds = border::border_points(size, border_count(size, chosen.len()));
        } else {
            let target = self.options.points.target(size);
            seeds = border::border_points(size, border_count(size, target));
            let inside = target - seeds.len();
            trim(&mut chosen, inside, seed);
            top_up(&mut chosen, inside, size, seed);
        }
        seeds.extend(chosen.iter().map(|&(x, y)| Point::pixel_centre(x, y)));
        Sampled { born: seeds.len(), seeds, ..Sampled::default() }
    }

    fn quota(&self) -> Quota {
        Quota {
            max_points: self.options.max_points,
            thresholds: self.options.thresholds,
            default_points: self.options.default_points,
        }
    }
}

/// How many of `seeds` seeds go to the border: one every two mean distances between seeds.
fn border_count(size: Size, seeds: usize) -> usize {
    let perimeter = 2.0 * (f64::from(size.width) + f64::from(size.height));
    let distance = (size.pixels() as f64 / seeds.max(1) as f64).sqrt();
    ((perimeter / (2.0 * distance)) as usize).min(seeds / 4)
}

/// A grid whose cells keep at least `target` of the candidates and hardly more: the coarsest that
/// bisection finds. Where even the finest grid keeps fewer, the finest.
fn solve_grid(candidates: &Mask, quota: &Quota, target: usize) -> HexGrid {
    let size = candidates.size();
    let enough = |width: f64| {
        let grid = HexGrid::new(size, width);
        let kept = density::count(candidates, &grid, quota);
        (kept >= target, kept)
    };
    // A frame-wide cell keeps max_points; cells of a pixel keep every candidate.
    let (mut fine, mut coarse) = (1.0, f64::from(size.width.max(size.height)) * 2.0);
    // The count goes nearly with 1 / width^2: begin close to the answer.
    let mut width = (size.pixels() as f64 / target.max(1) as f64 * 2.0).sqrt().clamp(fine, coarse);
    for _ in 0..24 {
        let (is_enough, kept) = enough(width);
        if is_enough {
            fine = width;
            if kept <= target + target / 200 {
                break;
            }
        } else {
            coarse = width;
        }
        let guess = width * (kept.max(1) as f64 / (target as f64 * 1.002).max(1.0)).sqrt();
        let inside = fine + (coarse - fine) * 0.02..coarse - (coarse - fine) * 0.02;
        width = if inside.contains(&guess) { guess } else { (fine + coarse) / 2.0 };
        if coarse / fine < 1.0005 {
            break;
        }
    }
    HexGrid::new(size, fine)
}

/// Drops points until `target` are left: those with the largest ranks by chance.
fn trim(points: &mut Vec<(u32, u32)>, target: usize, seed: u64) {
    if points.len() > target {
        points.sort_unstable_by_key(|&(x, y)| (rank(seed, Purpose::Trim, x, y), x, y));
        points.truncate(target);
    }
}

/// Adds pixels by chance, spread over the frame, until there are `target` points: a flat picture has
/// few feature points, yet gets the seeds that it was asked to have.
fn top_up(points: &mut Vec<(u32, u32)>, target: usize, size: Size, seed: u64) {
    if points.len() >= target {
        return;
    }
    let missing = target - points.len();
    let mut taken = Mask::new(size);
    for &(x, y) in points.iter() {
        taken.insert(x, y);
    }
    // One free pixel of the smallest rank in each of as many cells as are missing, in finer grids
    // until enough are found.
    let mut free = Vec::new();
    let mut area = size.pixels() as f64 / missing as f64;
    while points.len() < target {
        let grid = HexGrid::with_cell_area(size, area);
        free.clear();
        free.resize(grid.cells(), None);
        for y in 0..size.height {
            for x in (0..size.width).filter(|&x| !taken.contains(x, y)) {
                let best: &mut Option<(u64, u32, u32)> = &mut free[grid.cell_of_pixel(x, y)];
                let mine = (rank(seed, Purpose::Interior, x, y), x, y);
                if best.is_none_or(|best| mine < best) {
                    *best = Some(mine);
                }
            }
        }
        let mut found: Vec<_> = free.iter().flatten().copied().collect();
        found.sort_unstable();
        for &(_, x, y) in found.iter().take(target - points.len()) {
            taken.insert(x, y);
            points.push((x, y));
        }
        area /= 2.0;
    }
}
