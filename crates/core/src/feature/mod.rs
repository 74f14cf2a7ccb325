//! Level one: finds the pixels that matter.

pub mod bilateral;
pub mod canny;
pub mod change;
pub mod contour;
pub mod diffusion;
pub mod edge_drawing;
pub mod edges;
pub mod entropy;
mod front;
mod half;
pub(crate) mod lab;
pub mod maps;
pub mod mask;
pub mod prefilter;
pub mod priority;
pub mod region;
pub mod saliency;
pub mod simplify;
pub mod slic;
pub mod smooth;

use crate::frame::Frame;
use crate::geom::Size;
use crate::options::{Look, Options, Points, Quality};
use crate::plane::Plane;
use change::{Change, Watcher};
use mask::Mask;
use region::{Picks, Regions};
use smooth::smooth;

/// Level one looks at no more pixels than that for a seed, and than [`ENOUGH`].
const PIXELS_A_POINT: usize = 160;

/// Pixels that level one looks at in any case: 512 x 512.
const ENOUGH: usize = 1 << 18;

/// The result of level one for a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// The feature points: pixels that level two may choose from. Empty if the mesh is carried from the last frame.
    pub candidates: Mask,
    /// The importance of every pixel, at least 0, in any unit, if the front end scores pixels.
    pub score: Option<Plane<f32>>,
    /// How the frame continues its stream.
    pub change: Change,
}

impl From<Mask> for Features {
    fn from(candidates: Mask) -> Self {
        Self { candidates, score: None, change: Change::Cut }
    }
}

/// Level one for a stream of frames.
#[derive(Debug)]
pub struct Extractor {
    options: Options,
    watcher: Watcher,
    /// Whether the next frame starts afresh, whatever it shows.
    anew: bool,
}

impl Extractor {
    /// Level one with `options`, which must be valid ([`Options::validate`]).
    pub fn new(options: &Options) -> Self {
        Self { options: options.clone(), watcher: Watcher::default(), anew: false }
    }

    /// Changes the options, which must be valid, from the next frame on. That frame starts afresh if the seeds are no
    /// longer valid, see [`Options::keeps_seeds_of`].
    pub fn retune(&mut self, options: &Options) {
        self.anew |= !options.keeps_seeds_of(&self.options);
        self.options = options.clone();
    }

    /// The features of the next frame, with as much work as `look` allows.
    pub fn extract(&mut self, frame: &Frame, look: Look) -> Features {
        if look == Look::Reuse
            && !self.anew
            && self.options.coherence > 0.0
            && let Some(motion) = self.watcher.pause(frame.size())
        {
            return Features {
                change: Change::Continues(motion),
                ..Mask::new(frame.size()).into()
            };
        }
        let change = if self.options.coherence > 0.0 {
            self.watcher.watch(frame)
        } else {
            // This frame is not compared: later ones cannot be compared with earlier ones.
            self.watcher = Watcher::default();
            Change::Cut
        };
        let anew = std::mem::take(&mut self.anew);
        let change = if anew && !change.is_fresh() { Change::Cut } else { change };
        let features = match look {
            _ if !change.is_fresh() => Mask::new(frame.size()).into(),
            Look::Full => self.features(frame),
            _ => half::features(self, frame),
        };
        Features { change, ..features }
    }

    /// The features of `frame`, independent of earlier frames.
    pub fn features(&self, frame: &Frame) -> Features {
        if self.is_enough_at_half(frame.size()) {
            return half::features(self, frame);
        }
        front::features(self, frame)
    }

    /// Whether half the width and height of a frame of `size` have more than enough feature points to choose from.
    /// Large pictures take no longer then, and have the features of small ones. Without refinement, as in the paper,
    /// the features decide all.
    fn is_enough_at_half(&self, size: Size) -> bool {
        let Options { points, quality, error, .. } = self.options;
        // A search for the fewest points may end with many.
        let is_searched = points == Points::Auto && error.is_some();
        if is_searched || quality == Quality::Draft {
            return false;
        }
        size.pixels() / 4 >= (PIXELS_A_POINT * self.options.seeds(size)).max(ENOUGH)
    }

    /// The colour regions that [`Extractor::extract`] would find in `frame`.
    pub fn regions(&self, frame: &Frame) -> Regions {
        let clusters = self.options.clusters as usize;
        let smoothed = (0..self.options.smoothing).fold(None, |smoothed: Option<Frame>, _| {
            Some(smooth(smoothed.as_ref().unwrap_or(frame)))
        });
        region::segment(smoothed.as_ref().unwrap_or(frame), clusters, None)
    }

    fn picks(&self) -> Picks {
        Picks {
            seed: self.options.seed,
            interval: self.options.interval,
            interior: self.options.interior,
        }
    }
}
