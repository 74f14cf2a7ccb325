//! Level two: which of the feature points become seeds, and how seeds live on from frame to frame.

pub mod bands;
pub mod border;
pub mod density;
pub mod spread;
pub mod suppress;
pub mod thin;
pub mod value;

use crate::feature::Features;
use crate::geom::{Point, Size};
use crate::hex::HexGrid;
use crate::options::{Method, Options};
use bands::share_bands;
use border::border_points;
use density::{Binned, Quota};
use spread::spread;
use suppress::suppress;
use thin::thin;
use value::{Sharing, share_by_value, value_grid};

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

    /// The grid over a frame of `size`. It depends on nothing else, so that it stays the same for a
    /// whole stream.
    pub fn grid(&self, size: Size) -> HexGrid {
        let Options { hex_density, min_points, .. } = self.options;
        if matches!(self.options.method, Method::Help | Method::Hslp) {
            let target = self.options.points.target(size);
            return value_grid(size, target, min_points, hex_density);
        }
        match hex_density {
            Some(density) => HexGrid::with_density(size, density),
            None => {
                let target = self.options.points.target(size).max(1);
                let cell_points = f64::from(self.options.max_points) / CELLS_PER_MAX_POINTS;
                HexGrid::with_cell_area(size, size.pixels() as f64 / target as f64 * cell_points)
            }
        }
    }

    /// The seeds of the next frame.
    ///
    /// The number of seeds is the target of [`Options::points`]: quotas are multiplied by one common
    /// factor to meet it. With [`Options::hex_density`] the quotas of [`Method::Hrlp`] are taken to the
    /// letter instead, and the number follows from them.
    pub fn sample(&mut self, features: &Features) -> Sampled {
        let size = features.candidates.size();
        let seed = self.options.seed;
        let grid = self.grid(size);
        let mut seeds;
        let mut inside;
        if self.options.method == Method::Hrlp && self.options.hex_density.is_some() {
            inside = self.binned(features, &grid).keep(1.0);
            seeds = border_points(size, border_count(size, inside.len()));
        } else {
            let target = self.options.points.target(size);
            seeds = border_points(size, border_count(size, target));
            let target = target - seeds.len();
            inside = self.choose(features, &grid, target);
            spread(&mut inside, target, &grid, seed);
        }
        seeds.extend(inside.iter().map(|&(x, y)| Point::pixel_centre(x, y)));
        Sampled { born: seeds.len(), seeds, ..Sampled::default() }
    }

    /// At most `target` pixels, by the method's own level two.
    fn choose(&self, features: &Features, grid: &HexGrid, target: usize) -> Vec<(u32, u32)> {
        let seed = self.options.seed;
        let Features { candidates, score } = features;
        match self.options.method {
            Method::Hrlp => {
                let mut binned = self.binned(features, grid);
                binned.keep(binned.solve(target))
            }
            Method::Help | Method::Hslp => {
                let Options { min_points, percentiles, .. } = self.options;
                share_by_value(features, grid, Sharing { min_points, percentiles }, target, seed)
            }
            Method::Rlp => thin(candidates, target, seed),
            Method::Entropy => match score {
                Some(score) => suppress(score, target),
                None => suppress(&candidates.to_plane(), target),
            },
            Method::Pic2polyart => match score {
                Some(score) => share_bands(candidates, score, target, seed),
                None => thin(candidates, target, seed),
            },
        }
    }

    fn binned(&self, features: &Features, grid: &HexGrid) -> Binned {
        Binned::new(&features.candidates, grid, &self.quota(), self.options.seed)
    }

    fn quota(&self) -> Quota {
        Quota {
            max_points: self.options.max_points,
            thresholds: self.options.thresholds,
            default_points: self.options.default_points,
        }
    }
}

/// Where the number of seeds is given, a cell's area is that of `max_points` seeds divided by this:
/// most cells keep far less than the most. From `docs/calibration.md`.
const CELLS_PER_MAX_POINTS: f64 = 8.0;

/// How many of `seeds` seeds go to the border: one every two mean distances between seeds.
fn border_count(size: Size, seeds: usize) -> usize {
    let perimeter = 2.0 * (f64::from(size.width) + f64::from(size.height));
    let distance = (size.pixels() as f64 / seeds.max(1) as f64).sqrt();
    ((perimeter / (2.0 * distance)) as usize).min(seeds / 4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feature::mask::Mask;
    use crate::options::Points;
    use crate::triangulate::triangulate;

    fn features(size: Size, every: usize) -> Features {
        let mut candidates = Mask::new(size);
        for y in (0..size.height).step_by(every) {
            for x in (0..size.width / 2).step_by(every) {
                candidates.insert(x, y);
            }
        }
        candidates.into()
    }

    #[test]
    fn the_number_of_seeds_is_met_and_never_passed() {
        let size = Size::new(120, 80);
        for points in [1, 2, 3, 10, 57, 500, 4000, 9600] {
            for every in [1, 3, 200] {
                let options = Options { points: Points::Count(points), ..Options::default() };
                let sampled = Sampler::new(&options).sample(&features(size, every));
                assert_eq!(sampled.seeds.len(), points as usize, "{points} points, every {every}");
                let mesh = triangulate(size, &sampled.seeds).expect("distinct seeds");
                assert_eq!(mesh.check(), Ok(()));
            }
        }
    }

    #[test]
    fn a_frame_too_small_for_seeds_has_none() {
        let sampled = Sampler::new(&Options::default()).sample(&features(Size::new(1, 1), 1));
        assert!(sampled.seeds.is_empty());
    }

    #[test]
    fn a_given_density_fixes_the_grid_and_the_number_follows() {
        let size = Size::new(120, 80);
        let options = Options { hex_density: Some(0.01), ..Options::default() };
        let mut sampler = Sampler::new(&options);
        assert!((sampler.grid(size).cell_area() - 96.0).abs() < 1e-9);
        // Half of about 100 cells are dense and keep four.
        let seeds = sampler.sample(&features(size, 1)).seeds.len();
        assert!((200..300).contains(&seeds), "{seeds}");
    }
}
