//! The whole chain on one thread: the still-image API, and the oracle for the threaded pipeline.

use crate::error::Result;
use crate::feature::Extractor;
use crate::frame::Frame;
use crate::mesh::Mesh;
use crate::options::Options;
use crate::rasterise::{Painting, rasterise};
use crate::sample::{Sampled, Sampler};
use crate::triangulate::triangulate;

/// A frame that went through the chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// The picture and its colours.
    pub painting: Painting,
    /// The mesh behind it.
    pub mesh: Mesh,
    /// How its seeds came to be.
    pub sampled: Sampled,
    /// Number of feature points that level one found.
    pub candidates: usize,
}

/// Renders frame after frame; seeds and palette live on between them.
#[derive(Debug)]
pub struct Renderer {
    options: Options,
    extractor: Extractor,
    sampler: Sampler,
}

impl Renderer {
    /// A renderer for one stream of frames.
    ///
    /// # Errors
    /// When an option is out of range.
    pub fn new(options: &Options) -> Result<Self> {
        options.validate()?;
        Ok(Self {
            options: options.clone(),
            extractor: Extractor::new(options),
            sampler: Sampler::new(options),
        })
    }

    /// The next frame as low-poly art.
    ///
    /// # Errors
    /// None for frames of one stream; the error type leaves room for methods with needs of their own.
    pub fn render(&mut self, frame: &Frame) -> Result<Rendered> {
        let features = self.extractor.extract(frame);
        let sampled = self.sampler.sample(&features);
        let mesh = triangulate(frame.size(), &sampled.seeds)?;
        let painting = rasterise(&mesh, frame, self.options.outline.map(|colour| colour.0));
        Ok(Rendered { painting, mesh, sampled, candidates: features.candidates.len() })
    }
}
