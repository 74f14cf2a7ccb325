//! Level two: chooses seeds among the feature points, and carries them from frame to frame.

pub mod bands;
pub mod border;
pub mod carry;
pub mod density;
mod ids;
mod occupy;
mod ranked;
mod scatter;
pub mod spread;
mod stipple;
pub mod suppress;
pub mod thin;
pub mod value;

use crate::feature::Features;
use crate::feature::change::Change;
use crate::focus::FocusMap;
use crate::frame::Frame;
use crate::geom::{Point, Size};
use crate::hex::HexGrid;
use crate::mesh::Mesh;
use crate::options::{Detail, Method, Options, Points};
use crate::refine::thinning;
use bands::share_bands;
use border::border_points;
use carry::Carrier;
use density::{Binned, Quota};
use ids::Ids;
use occupy::occupy;
use ranked::ranked;
use scatter::scatter;
use spread::spread;
use stipple::stipple;
use suppress::suppress;
use thin::thin;
use value::{Sharing, share_by_value, value_grid};

/// The start of a frame's mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Start {
    /// Fresh seeds: distinct points of the closed frame, none of them a corner; border points among them.
    Seeds(Vec<Point>),
    /// The mesh of the frame before, moved with the picture.
    Mesh(Mesh),
}

/// Where the seeds of a frame come from, as numbers of seeds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Life {
    /// Seeds of the last frame that have not moved.
    pub kept: usize,
    /// Seeds of the last frame that have moved.
    pub moved: usize,
    /// New seeds.
    pub born: usize,
    /// Seeds of the last frame that were removed.
    pub died: usize,
    /// Whether the frame begins a new shot.
    pub cut: bool,
}

/// Level two for a stream of frames: seeds are chosen for the first frame of a shot, and carried from there on.
#[derive(Debug)]
pub struct Sampler {
    options: Options,
    /// How much places matter; `None` for all the same.
    pub(crate) focus: Option<FocusMap>,
    /// The final mesh of the last frame.
    living: Option<Mesh>,
    /// Buffers of a mesh that is no longer needed.
    recycled: Option<Mesh>,
    carrier: Carrier,
    /// The positions of its seeds before.
    before: Vec<Point>,
    /// Number of seeds, in per cent of the options' number.
    seeds: u32,
    /// Whether the options' number has changed since the last frame.
    is_resized: bool,
    /// The ids of the seeds that survive a change of the number of seeds.
    survivors: Option<Vec<u64>>,
    ids: Ids,
    /// Whether the frame starts afresh without a cut.
    fades_in: bool,
}

impl Sampler {
    /// Level two as `options` ask for it.
    pub fn new(options: &Options) -> Self {
        Self {
            options: options.clone(),
            focus: None,
            living: None,
            recycled: None,
            carrier: Carrier::default(),
            before: Vec::new(),
            seeds: Detail::FULL.seeds,
            is_resized: false,
            survivors: None,
            ids: Ids::default(),
            fades_in: false,
        }
    }

    /// Changes the options from the next frame on. The mesh is kept if its seeds are still valid, see
    /// [`Options::keeps_seeds_of`].
    pub fn retune(&mut self, options: &Options) {
        if !options.keeps_seeds_of(&self.options) || options.coherence == 0.0 {
            self.living = None;
        }
        self.options = options.clone();
    }

    /// Changes the number of seeds from the next frame on: a living mesh loses some, or gets more.
    pub(crate) fn aim_at(&mut self, points: Points) {
        self.is_resized |= points != self.options.points;
        self.options.points = points;
    }

    /// The grid over a frame of `size`. It depends on size and options only, and thus is constant in a stream.
    pub fn grid(&self, size: Size) -> HexGrid {
        let Options { hex_density, min_points, .. } = self.options;
        if matches!(self.options.method, Method::Help | Method::Hslp) {
            let target = self.options.seeds(size);
            return value_grid(size, target, min_points, hex_density);
        }
        match hex_density {
            Some(density) => HexGrid::with_density(size, density),
            None => {
                let target = self.options.seeds(size).max(1);
                let cell_points = f64::from(self.options.max_points) / CELLS_PER_MAX_POINTS;
                HexGrid::with_cell_area(size, size.pixels() as f64 / target as f64 * cell_points)
            }
        }
    }

    /// The start of the next frame's mesh: the last [remembered](Self::remember) mesh, moved with the picture; or
    /// fresh seeds, for the first frame of a shot and for every frame without coherence. If `detail` asks for another
    /// number of seeds than the last frame had, cells of the grid are vacated or occupied, and the other seeds stay.
    pub fn sample(&mut self, features: &Features, frame: &Frame, detail: &Detail) -> Start {
        let size = features.candidates.size();
        let before = std::mem::replace(&mut self.seeds, detail.seeds);
        let is_resized = std::mem::take(&mut self.is_resized);
        self.survivors = None;
        self.fades_in = features.change == Change::FadeIn;
        let living = self.living.take();
        self.before.clear();
        self.before.extend(living.iter().flat_map(|mesh| mesh.seeds()));
        match (&features.change, living) {
            (Change::Continues(motion), Some(mut mesh)) if mesh.size == size => {
                self.carrier.carry(&mut mesh, motion);
                if before == self.seeds && !is_resized {
                    return Start::Mesh(mesh);
                }
                // Where the number follows from the grid, the mesh has it.
                let now = match self.counted(size) {
                    Some(target) => target,
                    None => mesh.seeds().len() * self.seeds as usize / before.max(1) as usize,
                };
                let occupied = occupy(&mesh, now, &self.grid(size), self.options.seed);
                self.survivors = Some(occupied.survivors);
                Start::Seeds(occupied.seeds)
            }
            _ => Start::Seeds(self.choose(features, frame)),
        }
    }

    /// Takes the buffers of a mesh that is no longer needed.
    pub fn recycle(&mut self, mesh: Mesh) {
        self.recycled = Some(mesh);
    }

    /// Stores the final mesh of a frame as the start of the next. `fresh` says that its seeds are fresh; else
    /// `replaced` are the vertices that refinement re-placed. Gives the vertices their [lasting ids](Mesh::ids), and
    /// returns where the seeds come from.
    pub fn remember(&mut self, mesh: &mut Mesh, fresh: bool, replaced: &[u32]) -> Life {
        let survivors = self.survivors.take();
        if fresh {
            self.ids.number(mesh, survivors.as_deref().unwrap_or_default());
        }
        self.ids.renew(mesh, replaced);
        let mesh = &*mesh;
        let seeds = mesh.seeds();
        if self.options.coherence > 0.0 {
            self.living = Some(match self.recycled.take() {
                Some(mut living) => {
                    living.clone_from(mesh);
                    living
                }
                None => mesh.clone(),
            });
        }
        if let Some(survivors) = survivors {
            let moved = survivors.len();
            let (born, died) = (seeds.len() - moved, self.before.len() - moved);
            return Life { moved, born, died, ..Life::default() };
        }
        if fresh {
            let died = self.before.len();
            return Life {
                born: seeds.len(),
                died,
                cut: died > 0 && !self.fades_in,
                ..Life::default()
            };
        }
        let stayed = seeds.iter().zip(&self.before).filter(|(now, then)| now == then).count();
        // A seed that was re-placed at its own position cannot be distinguished from one that stayed.
        let born = replaced.len().min(seeds.len() - stayed);
        Life { kept: stayed, moved: seeds.len() - stayed - born, born, died: born, cut: false }
    }

    /// Chooses fresh seeds for `frame`.
    ///
    /// Their number is the target of [`Options::points`]: all quotas are multiplied by one factor to meet it. With
    /// [`Options::hex_density`] the quotas of [`Method::Hrlp`] are exact, and the number follows from them.
    pub fn choose(&self, features: &Features, frame: &Frame) -> Vec<Point> {
        let size = features.candidates.size();
        let seed = self.options.seed;
        let grid = self.grid(size);
        let Some(target) = self.counted(size) else {
            let inside = self.binned(features, &grid).keep(f64::from(self.seeds) / 100.0);
            let mut seeds = border_points(size, border_count(size, inside.len()));
            seeds.extend(inside.iter().map(|&(x, y)| Point::pixel_centre(x, y)));
            return seeds;
        };
        let mut seeds = border_points(size, border_count(size, target));
        let target = target - seeds.len();
        let scattered = (self.options.scatter * target as f64).round() as usize;
        let mut inside = self.pick(features, frame, &grid, &seeds, target - scattered);
        scatter(&mut inside, size, scattered, seed);
        spread(&mut inside, target, &grid, seed);
        seeds.extend(inside.iter().map(|&(x, y)| Point::pixel_centre(x, y)));
        seeds
    }

    /// The number of seeds of a frame of `size`; `None` where it follows from the grid.
    fn counted(&self, size: Size) -> Option<usize> {
        if self.options.method == Method::Hrlp && self.options.hex_density.is_some() {
            return None;
        }
        let asked = self.options.seeds(size);
        Some((asked * self.seeds as usize).div_ceil(100))
    }

    /// At most `target` pixels, by the method's own level two; `border` are the seeds there.
    fn pick(
        &self,
        features: &Features,
        frame: &Frame,
        grid: &HexGrid,
        border: &[Point],
        target: usize,
    ) -> Vec<(u32, u32)> {
        let seed = self.options.seed;
        let focus = self.focus.as_ref();
        let Features { candidates, score, .. } = features;
        match self.options.method {
            Method::Hrlp => {
                let mut binned = self.binned(features, grid);
                binned.keep(binned.solve(target))
            }
            Method::Help | Method::Hslp => {
                let Options { min_points, percentiles, .. } = self.options;
                share_by_value(features, grid, Sharing { min_points, percentiles }, target, seed)
            }
            Method::Rlp => thin(candidates, target, focus, seed),
            Method::Entropy => match score {
                Some(score) => suppress(score, target),
                None => suppress(&candidates.to_plane(), target),
            },
            Method::Pic2polyart => match score {
                Some(score) => share_bands(candidates, score, target, focus, seed),
                None => thin(candidates, target, focus, seed),
            },
            Method::Ranked => ranked(features, target, seed),
            Method::Thinning => {
                let mut many = ranked(features, THINNED * target, seed);
                spread(&mut many, THINNED * target, grid, seed);
                thinning::thin(frame, border, many, target, focus)
            }
            Method::Stippling => {
                stipple(ranked(features, target / 2, seed), target, grid, focus, seed)
            }
        }
    }

    fn binned(&self, features: &Features, grid: &HexGrid) -> Binned {
        let mut binned = Binned::new(&features.candidates, grid, &self.quota(), self.options.seed);
        binned.even_out(self.options.evenness());
        if let Some(focus) = &self.focus {
            binned.weigh(grid, focus);
        }
        binned
    }

    fn quota(&self) -> Quota {
        Quota {
            max_points: self.options.max_points,
            thresholds: self.options.thresholds,
            default_points: self.options.default_points,
        }
    }
}

/// Points of which adaptive thinning leaves one.
const THINNED: usize = 4;

/// If the number of seeds is given, a cell has the area of `max_points` seeds divided by this: most cells keep far
/// fewer. From `docs/calibration.md`.
const CELLS_PER_MAX_POINTS: f64 = 8.0;

/// The number of `seeds` that are put on the border: one every two mean distances between seeds.
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

    fn grey(size: Size) -> Frame {
        Frame::filled(size, [128, 128, 128, 255]).expect("a small frame")
    }

    #[test]
    fn the_number_of_seeds_is_met_and_never_passed() {
        let size = Size::new(120, 80);
        for points in [1, 2, 3, 10, 57, 500, 4000, 9600] {
            for every in [1, 3, 200] {
                let options = Options { points: Points::Count(points), ..Options::default() };
                let seeds = Sampler::new(&options).choose(&features(size, every), &grey(size));
                assert_eq!(seeds.len(), points as usize, "{points} points, every {every}");
                let mesh = triangulate(size, &seeds).expect("distinct seeds");
                assert_eq!(mesh.check(), Ok(()));
            }
        }
    }

    #[test]
    fn a_frame_too_small_for_seeds_has_none() {
        let seeds = Sampler::new(&Options::default())
            .choose(&features(Size::new(1, 1), 1), &grey(Size::new(1, 1)));
        assert!(seeds.is_empty());
    }

    #[test]
    fn a_given_density_fixes_the_grid_and_the_number_follows() {
        let size = Size::new(120, 80);
        let options = Options { hex_density: Some(0.01), ..Options::default() };
        let sampler = Sampler::new(&options);
        assert!((sampler.grid(size).cell_area() - 96.0).abs() < 1e-9);
        // Half of about 100 cells are dense and keep four.
        let seeds = sampler.choose(&features(size, 1), &grey(size)).len();
        assert!((200..300).contains(&seeds), "{seeds}");
    }
}
