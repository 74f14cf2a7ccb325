//! How a mesh is refined, and how much.

use crate::geom::Size;
use crate::options::{Detail, FacetSides, Options, Quality, Shape, Steps};

/// How to refine a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineOptions {
    /// Steps at most; fewer are done where nothing is left to gain.
    pub steps: u32,
    /// Eighths of one more step: it visits that share of the vertices, which take turns over the frames of a video.
    /// 0..=7.
    pub part: u32,
    /// Weight of well-shaped triangles against the error, 0 (none: any sliver that fits) to 1 (no change makes
    /// triangles flatter in total).
    pub regularity: f64,
    /// The share of the vertices that a step may re-place, 0 (none) to 1.
    pub replace: f64,
    /// The minimum gain of a change, as a share of the error of a triangle of a regular grid with as many triangles
    /// on this picture. 0 and more.
    pub threshold: f64,
    /// The work of a step.
    pub mode: Mode,
    /// What is kept for the next frame of a fresh mesh for which no step is done.
    pub unrefined: Unrefined,
    /// Whether triangles are filled with planes of colour, not with their means: of opaque frames the error is that
    /// of the planes then.
    pub planes: bool,
    /// How small and how large triangles may be.
    pub facets: FacetSides,
}

/// The work of a refinement step. `cargo bench -p polyreel-bench --bench refine` prints the time and the error of each
/// mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// A still: most of the gain in little time. A step evaluates the vertices of a part of the mesh, in turn, for
    /// re-placing.
    Quick,
    /// A still: more samples along an edge, and more vertices and positions to choose from where some are re-placed.
    /// 3 % less error than [`Mode::Quick`], for a fifth more time.
    Thorough,
    /// A frame of a stream, the picture of which keeps changing, so that a change must not wait for its turn. A step
    /// evaluates the vertices of the whole mesh for re-placing, but skips vertices with little error around them. On
    /// a still, more steps in one of the other modes gain more in the same time.
    Stream,
}

/// What is kept for the next frame of a fresh mesh for which no step is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unrefined {
    /// Nothing: the next frame has a fresh mesh too.
    Forget,
    /// Its links: the next frame takes steps on it.
    Prepare,
    /// Its links and its colours: later frames only [maintain](super::Refiner::frame) it.
    Adopt,
}

/// The default of [`RefineOptions::regularity`]: about 0.3 % of the triangles have an angle below 5
/// degrees then.
pub const REGULARITY: f64 = 0.5;

impl RefineOptions {
    /// No refinement at all.
    pub const fn draft() -> Self {
        Self {
            steps: 0,
            part: 0,
            regularity: REGULARITY,
            replace: 0.0,
            threshold: 0.01,
            mode: Mode::Quick,
            unrefined: Unrefined::Forget,
            planes: false,
            facets: FacetSides::FREE,
        }
    }

    /// Most of the gain for a third of the time of [`RefineOptions::best`].
    pub const fn normal() -> Self {
        Self { steps: 5, replace: 0.05, ..Self::draft() }
    }

    /// Until nothing is left to gain.
    pub const fn best() -> Self {
        Self { steps: 60, replace: 0.05, threshold: 0.001, mode: Mode::Thorough, ..Self::draft() }
    }

    /// A frame of a video whose mesh comes from the frame before.
    pub const fn live() -> Self {
        Self { steps: 3, replace: 0.03, threshold: 0.02, mode: Mode::Stream, ..Self::draft() }
    }

    /// Whether errors are estimated from every second row where that will do.
    pub(super) fn estimates(&self) -> bool {
        self.mode == Mode::Stream && !self.planes && !self.facets.are_limited()
    }

    /// Steps, one in part among them.
    pub(crate) fn passes(&self) -> u32 {
        self.steps + u32::from(self.part > 0)
    }
}

/// The least number of steps that the first frame of a shot gets, where any are done at all: the
/// frames after it start from its mesh.
const SHOT_STEPS: u32 = 4;

/// Factors where more than a colour changes with the mesh: a line jumps with an edge, panes and cells with a triangle.
const CALM_REPLACE: f64 = 0.3;
const CALM_THRESHOLD: f64 = 4.0;

/// Pixels of a frame, 1280 x 720, that gets [`RefineOptions::live`]'s steps at the normal quality, as larger
/// ones do. Smaller ones get more, in the same time.
const LIVE_PIXELS: f64 = 1280.0 * 720.0;

/// The most steps that a frame gets for being small. Measured on seven clips of 256 x 256 to 864 x 480: with 8
/// steps in place of 3 squared error falls by 0.3 to 9 %, and by 28 % where a sprite leaps; on the three smallest
/// with 10 by 1 % more, 9 % on the sprite, with 12 hardly any more, 3 % on the sprite.
/// Measured by `cargo xtask measure small-frames`.
const MOST_LIVE: f64 = 10.0;

impl RefineOptions {
    /// The plan for a mesh of its own, of a still or the first frame of a shot.
    pub fn fresh(options: &Options) -> Self {
        let plan = Self::fresh_plan(options);
        // Without a step, later frames are only maintained.
        let adopts = plan.passes() == 0 && options.coherence > 0.0;
        let unrefined = if adopts { Unrefined::Adopt } else { Unrefined::Forget };
        let planes = options.fill.is_gradient();
        let replace = plan.replace * (1.0 - options.evenness());
        let facets = options.facet_sides();
        Self { regularity: options.regularity, replace, unrefined, planes, facets, ..plan }
    }

    /// The plan for a mesh that comes from the frame before, of `size`: a few steps, fewer changes and only
    /// such as are clearly worth it.
    pub fn next(options: &Options, size: Size) -> Self {
        let steps = Self::live_steps(options, size);
        let planes = options.fill.is_gradient();
        let live = Self::live();
        let mut replace = live.replace * (1.0 - options.evenness());
        let mut threshold = live.threshold;
        if options.line_colour().is_some() || options.shape != Shape::Triangles {
            replace *= CALM_REPLACE;
            threshold *= CALM_THRESHOLD;
        }
        let facets = options.facet_sides();
        Self { steps, regularity: options.regularity, replace, threshold, planes, facets, ..live }
    }

    /// The plan for a frame of `size` that has nothing to do with the one before it, of a video whose frames
    /// are all alone: at most as many steps as those of one whose mesh lives on. So what a video takes hardly
    /// depends on coherence, and flicker only falls with it.
    pub fn alone(options: &Options, size: Size) -> Self {
        // Nothing of a stream is a still.
        let quality = match options.quality {
            Quality::Auto => Quality::Normal,
            quality => quality,
        };
        let plan = Self::fresh(&Options { quality, ..options.clone() });
        Self { steps: plan.steps.min(Self::live_steps(options, size)), ..plan }
    }

    /// The same plan at the cost of `detail`, which may name another number of steps; where there were
    /// none there are none.
    #[must_use]
    pub fn at(self, detail: &Detail) -> Self {
        let steps = detail.steps.filter(|_| self.steps > 0);
        let steps = steps.unwrap_or(Steps::new(self.steps));
        // A step that there is no time for now is left to the next frame.
        let unrefined = if self.passes() > 0 { Unrefined::Prepare } else { self.unrefined };
        Self { steps: steps.whole(), part: steps.part(), unrefined, ..self }
    }

    fn fresh_plan(options: &Options) -> Self {
        if options.error.is_some() {
            // The target says when to stop.
            return Self::best();
        }
        match (options.refine, options.quality) {
            (Some(0), _) | (None, Quality::Draft) => Self::draft(),
            (Some(steps), _) if options.coherence > 0.0 => {
                Self { steps: steps.max(SHOT_STEPS), ..Self::normal() }
            }
            (Some(steps), _) => Self { steps, ..Self::normal() },
            // What holds to the frame before is no still.
            (None, Quality::Auto) if options.coherence > 0.0 => Self::normal(),
            (None, Quality::Auto) => Self::best(),
            (None, Quality::Normal) => Self::normal(),
            (None, Quality::Best) => Self::best(),
        }
    }

    /// Steps that `options` ask for on a mesh that comes from the frame before, of `size`.
    pub fn live_steps(options: &Options, size: Size) -> u32 {
        let steps = Self::live().steps;
        let room = LIVE_PIXELS / size.pixels().max(1) as f64;
        let normal = (f64::from(steps) * room).clamp(f64::from(steps), MOST_LIVE) as u32;
        options.refine.unwrap_or(match options.quality {
            Quality::Draft => 0,
            Quality::Auto | Quality::Normal => normal,
            Quality::Best => 2 * normal,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_frames_get_more_steps() {
        let steps = |width, height, options: &Options| {
            RefineOptions::next(options, Size::new(width, height)).steps
        };
        let normal = Options::default();
        let sizes = [(3840, 2160), (1280, 720), (1024, 576), (864, 480), (256, 256), (1, 1)];
        assert_eq!(sizes.map(|(w, h)| steps(w, h, &normal)), [3, 3, 4, 6, 10, 10]);
        let best = Options { quality: Quality::Best, ..normal.clone() };
        assert_eq!(steps(864, 480, &best), 12);
        let counted = Options { refine: Some(2), ..normal };
        assert_eq!(sizes.map(|(w, h)| steps(w, h, &counted)), [2; 6]);
    }
}
