//! Level two: which of the feature points become seeds, and how seeds live on from frame to frame.

use crate::feature::Features;
use crate::geom::Point;
use crate::options::Options;

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

    /// The seeds of the next frame.
    pub fn sample(&mut self, features: &Features) -> Sampled {
        let target = self.options.points.target(features.candidates.size());
        let seeds: Vec<_> = features
            .candidates
            .iter()
            .map(|(x, y)| Point::pixel_centre(x, y))
            .take(target)
            .collect();
        Sampled { born: seeds.len(), seeds, ..Sampled::default() }
    }
}
