//! How much a frame is refined.

use super::RefineOptions;
use crate::geom::Size;
use crate::options::{Detail, Options, Quality, Steps};

/// The least number of steps that the first frame of a shot gets, where any are done at all: the
/// frames after it start from its mesh.
const SHOT_STEPS: u32 = 4;

/// Pixels of a frame, 1280 x 720, that gets [`RefineOptions::live`]'s steps at the normal quality, as larger
/// ones do. Smaller ones get more, in the same time.
const LIVE_PIXELS: f64 = 1280.0 * 720.0;

/// The most steps that a frame gets for being small. Measured on seven clips of 256 x 256 to 864 x 480: with 8
/// steps in place of 3 squared error falls by 0.3 to 9 %, and by 28 % where a sprite leaps; on the three smallest
/// with 10 by 1 % more, 9 % on the sprite, with 12 hardly any more, 3 % on the sprite.
const MOST_LIVE: f64 = 10.0;

impl RefineOptions {
    /// The plan for a mesh of its own, of a still or the first frame of a shot.
    pub fn fresh(options: &Options) -> Self {
        Self { regularity: options.regularity, ..Self::fresh_plan(options) }
    }

    /// The plan for a mesh that comes from the frame before, of `size`: a few steps, fewer changes and only
    /// such as are clearly worth it.
    pub fn next(options: &Options, size: Size) -> Self {
        let steps = Self::live_steps(options, size);
        Self { steps, regularity: options.regularity, ..Self::live() }
    }

    /// The plan for a frame of `size` that has nothing to do with the one before it, of a video whose frames
    /// are all alone: at most as many steps as those of one whose mesh lives on. So what a video takes hardly
    /// depends on coherence, and flicker only falls with it.
    pub fn alone(options: &Options, size: Size) -> Self {
        let plan = Self::fresh(options);
        Self { steps: plan.steps.min(Self::live_steps(options, size)), ..plan }
    }

    /// The same plan at the cost of `detail`, which may name another number of steps; where there were
    /// none there are none.
    #[must_use]
    pub fn at(self, detail: &Detail) -> Self {
        let steps = detail.steps.filter(|_| self.steps > 0);
        let steps = steps.unwrap_or(Steps::new(self.steps));
        Self { steps: steps.whole(), part: steps.part(), ..self }
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
            Quality::Normal => normal,
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
