//! The chain from a frame to its picture: the order of its stages.
//!
//! ```text
//! features -> sample -> triangulate -> refine -> rasterise
//!               ^                        ^           |
//!               | the mesh is remembered | residual  |
//!               +------------------------+-----------+
//! ```
//!
//! Each of its three parts has its own state, and may run on its own thread: [`FeatureStage`], [`MeshStage`] and
//! [`PaintStage`]. The caller passes the residual of the last painted frame to the mesh stage. [`Chain`] runs them on
//! one thread.

mod abstraction;
mod content;
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

/// Runs the work of each stage, and can measure it.
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

    /// The features of the next `frame`, with as much work as `look` allows.
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

    /// Paints `mesh` in the mean colours of `frame`, from every `rows`-th row. Calls `send` once, with the picture's
    /// residual if the `hints` request it.
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
    form: Option<Form>,
    /// The residual of the last frame, if the mesh stage requested it.
    residual: Option<Residual>,
}

impl Chain {
    /// A chain for one stream of frames.
    ///
    /// # Errors
    /// When an option is out of range.
    pub fn new(options: &Options) -> Result<Self> {
        options.validate()?;
        Ok(Self::begin(options, None))
    }

    fn begin(options: &Options, form: Option<Form>) -> Self {
        Self {
            features: FeatureStage::new(options),
            mesh: MeshStage::new(options),
            paint: PaintStage::new(options).with_form(form),
            form,
            residual: None,
        }
    }

    /// The same, and pictures are painted as planes where they can be: see [`Painter::with_form`].
    pub fn with_form(self, form: Option<Form>) -> Self {
        Self { paint: self.paint.with_form(form), form, ..self }
    }

    /// Forgets all frames: the next one is the first of a new stream, with the options as they are.
    pub fn reset(&mut self) {
        *self = Self::begin(self.mesh.requested_options(), self.form);
    }

    /// Changes the options from the next frame on. The mesh is kept if its seeds are still valid, see
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

    /// As [`MeshStage::options`].
    pub fn options(&self) -> &Options {
        self.mesh.options()
    }

    /// Takes back the buffers of a picture that is no longer needed.
    pub fn recycle(&mut self, buffers: Buffers) {
        self.paint.recycle(buffers);
    }

    /// Takes back a mesh that is no longer needed.
    pub fn recycle_mesh(&mut self, mesh: Mesh) {
        self.mesh.recycle(mesh);
    }

    /// Renders the next frame with this `detail`.
    ///
    /// # Errors
    /// When [`Options::error`] cannot be measured (SSIM of a frame smaller than its window), or no number of points
    /// reaches it ([`Points::Auto`](crate::options::Points::Auto)).
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
