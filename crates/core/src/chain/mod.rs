//! The chain from a frame to its picture: the order in which its stages depend on each other.
//!
//! ```text
//! features -> sample -> triangulate -> refine -> rasterise
//!               ^                        ^           |
//!               | the mesh, remembered   | residual  |
//!               +------------------------+-----------+
//! ```
//!
//! Its three parts each keep what they learn from frame to frame, and may run on a thread each:
//! [`FeatureStage`], [`MeshStage`] and [`PaintStage`]. Whoever drives them hands the residual of the last painted
//! frame to the mesh stage. [`Chain`] drives them on one thread.

mod goal;
mod mesh;

use crate::colour::Form;
use crate::error::Result;
use crate::feature::{Extractor, Features};
use crate::frame::{Buffers, Frame};
use crate::mesh::Mesh;
use crate::options::{Detail, Look, Options};
use crate::rasterise::{PaintHints, Painter, Painting};
use crate::residual::Residual;
use crate::stage::Stage;

pub use mesh::{MeshStage, Meshed, Observer};

/// Runs the work of each stage, and may measure it.
pub trait StageProbe {
    /// Runs `work`, the part of one frame that belongs to `stage`, and returns what it returns.
    fn stage<T: Send>(&mut self, stage: Stage, work: impl FnOnce() -> T + Send) -> T;
}

/// The probe that measures nothing.
impl StageProbe for () {
    fn stage<T: Send>(&mut self, _: Stage, work: impl FnOnce() -> T + Send) -> T {
        work()
    }
}

/// Level one of the chain: finds the pixels that matter.
#[derive(Debug)]
pub struct FeatureStage(Extractor);

impl FeatureStage {
    /// A stage for one stream of frames.
    pub fn new(options: &Options) -> Self {
        Self(Extractor::new(options))
    }

    /// Changes the options from the next frame on.
    pub fn retune(&mut self, options: &Options) {
        self.0.retune(options);
    }

    /// The features of the next `frame`, looked at as closely as `look` says.
    pub fn run(&mut self, frame: &Frame, look: Look, probe: &mut impl StageProbe) -> Features {
        probe.stage(Stage::Features, || self.0.extract(frame, look))
    }
}

/// The last part of the chain: paints each triangle in its mean colour.
#[derive(Debug)]
pub struct PaintStage(Painter);

impl PaintStage {
    /// A stage for one stream of frames.
    pub fn new(options: &Options) -> Self {
        Self(Painter::new(options))
    }

    /// The same, and pictures are painted as planes where they can be: see [`Painter::with_form`].
    pub fn with_form(self, form: Option<Form>) -> Self {
        Self(self.0.with_form(form))
    }

    /// Changes the options from the next frame on.
    pub fn retune(&mut self, options: &Options) {
        self.0.retune(options);
    }

    /// Takes back the buffers of a picture that is no longer needed.
    pub fn recycle(&mut self, buffers: Buffers) {
        self.0.recycle(buffers);
    }

    /// Paints `mesh` in the colours of `frame`, of which every `rows`-th row is read. Calls `send` once, with
    /// the picture's residual where the `hints` ask for it.
    pub fn run(
        &mut self,
        mesh: &Mesh,
        frame: &Frame,
        rows: u32,
        hints: PaintHints,
        send: impl FnOnce(Option<Residual>) + Send,
        probe: &mut impl StageProbe,
    ) -> Painting {
        probe.stage(Stage::Rasterise, || self.0.paint(mesh, frame, rows, hints, send))
    }
}

/// The whole chain on one thread.
#[derive(Debug)]
pub struct Chain {
    features: FeatureStage,
    mesh: MeshStage,
    paint: PaintStage,
    /// Of the last frame, where the mesh stage requested it.
    residual: Option<Residual>,
}

impl Chain {
    /// A chain for one stream of frames.
    ///
    /// # Errors
    /// When an option is out of range.
    pub fn new(options: &Options) -> Result<Self> {
        options.validate()?;
        Ok(Self {
            features: FeatureStage::new(options),
            mesh: MeshStage::new(options),
            paint: PaintStage::new(options),
            residual: None,
        })
    }

    /// The same, and pictures are painted as planes where they can be: see [`Painter::with_form`].
    pub fn with_form(self, form: Option<Form>) -> Self {
        Self { paint: self.paint.with_form(form), ..self }
    }

    /// Changes the options from the next frame on. The mesh lives on where the options keep its seeds, see
    /// [`Options::keeps_seeds_of`]; else the next frame starts afresh.
    ///
    /// # Errors
    /// When an option is out of range; nothing is changed then.
    pub fn retune(&mut self, options: &Options) -> Result<()> {
        options.validate()?;
        self.features.retune(options);
        self.mesh.retune(options);
        self.paint.retune(options);
        Ok(())
    }

    /// Takes back the buffers of a picture that is no longer needed.
    pub fn recycle(&mut self, buffers: Buffers) {
        self.paint.recycle(buffers);
    }

    /// Takes back a mesh that is no longer needed.
    pub fn recycle_mesh(&mut self, mesh: Mesh) {
        self.mesh.recycle(mesh);
    }

    /// Takes the next frame through the chain, at the cost of `detail`.
    ///
    /// # Errors
    /// Where [`Options::error`] cannot be measured (SSIM of a frame smaller than its window), or not be
    /// reached by any number of [`Points::Auto`](crate::options::Points::Auto).
    pub fn run(
        &mut self,
        frame: &Frame,
        detail: &Detail,
        probe: &mut impl StageProbe,
    ) -> Result<(Features, Meshed, Painting)> {
        let features = self.features.run(frame, detail.look, probe);
        let last = || self.residual.take();
        let mut meshed = self.mesh.run(&features, frame, detail, last, probe)?;
        let hints = std::mem::take(&mut meshed.hints);
        let send = |residual| self.residual = residual;
        let painting = self.paint.run(&meshed.mesh, frame, detail.rows, hints, send, probe);
        Ok((features, meshed, painting))
    }
}
