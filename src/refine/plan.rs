//! How much a frame is refined.

use super::RefineOptions;
use crate::options::{Detail, Options, Quality, Steps};

/// The least number of steps that the first frame of a shot gets, where any are done at all: the
/// frames after it start from its mesh.
const SHOT_STEPS: u32 = 4;

impl RefineOptions {
    /// The plan for a frame: a `fresh` mesh, of a still or the first frame of a shot, takes many steps;
    /// one that comes from the frame before a few, fewer changes and only such as are clearly worth it.
    pub fn plan(options: &Options, fresh: bool) -> Self {
        let plan = if fresh { Self::fresh(options) } else { Self::next(options) };
        Self { regularity: options.regularity, ..plan }
    }

    /// The plan for a frame that has nothing to do with the one before it, of a video whose frames are
    /// all alone: as many steps as those of one whose mesh lives on. So what a video takes does not depend
    /// on coherence, and flicker only falls with it.
    pub fn alone(options: &Options) -> Self {
        let plan = Self::plan(options, true);
        Self { steps: plan.steps.min(Self::live_steps(options)), ..plan }
    }

    /// The same plan at the cost of `detail`, which may name another number of steps; where there were
    /// none there are none.
    #[must_use]
    pub fn at(self, detail: &Detail) -> Self {
        let steps = detail.steps.filter(|_| self.steps > 0);
        let steps = steps.unwrap_or(Steps::new(self.steps));
        Self { steps: steps.whole(), part: steps.part(), ..self }
    }

    fn fresh(options: &Options) -> Self {
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
            (None, Quality::Normal) => Self::normal(),
            (None, Quality::Best) => Self::best(),
        }
    }

    /// Steps that `options` ask for on a mesh that comes from the frame before.
    pub fn live_steps(options: &Options) -> u32 {
        options.refine.unwrap_or(match options.quality {
            Quality::Draft => 0,
            Quality::Normal => Self::live().steps,
            Quality::Best => 2 * Self::live().steps,
        })
    }

    fn next(options: &Options) -> Self {
        Self { steps: Self::live_steps(options), ..Self::live() }
    }
}
