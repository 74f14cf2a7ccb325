//! Level one: which pixels of a frame matter.

pub mod mask;
pub mod region;

use crate::frame::Frame;
use crate::options::{Method, Options};
use mask::Mask;
use region::Picks;

/// What level one found in a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Features {
    /// The feature points: pixels that level two may choose from.
    pub candidates: Mask,
}

/// Level one for a stream of frames.
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
        match self.options.method {
            Method::Hrlp => {
                let regions = region::segment(frame, self.options.clusters as usize, None);
                Features { candidates: region::pick_points(&regions, self.picks()) }
            }
        }
    }

    fn picks(&self) -> Picks {
        Picks { seed: self.options.seed, interval: self.options.interval, interior: 0.01 }
    }
}
