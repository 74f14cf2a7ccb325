//! The whole chain on one thread: the still-image API, and the oracle for the threaded pipeline.

mod reach;

use crate::colour::Form;
use crate::echo::{Call, Echo};
use crate::error::Result;
use crate::feature::{Extractor, Features};
use crate::frame::Frame;
use crate::geom::Size;
use crate::mesh::Mesh;
use crate::options::{Detail, Options, Points};
use crate::rasterise::{Brief, Painter, Painting};
use crate::refine::{RefineOptions, Refined, Refiner};
use crate::sample::{Life, Sampler, Start};
use crate::triangulate::triangulate;
use reach::{Goal, fewest, reach};

/// A frame that went through the chain.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Rendered {
    /// The picture and its colours.
    pub painting: Painting,
    /// The mesh behind it.
    pub mesh: Mesh,
    /// How its seeds came to be.
    pub life: Life,
    /// Steps of refinement that were done.
    pub refine_steps: u32,
    /// Likeness to the source in the measure of [`Options::error`], where it was refined to that.
    pub likeness: Option<f64>,
    /// Number of feature points that level one found.
    pub candidates: usize,
}

/// Renders frame after frame; the mesh and its colours live on between them.
///
/// ```
/// use polyreel_core::{Frame, Options, Points, Renderer, Size};
/// # fn main() -> polyreel_core::Result<()> {
/// let size = Size::new(64, 48);
/// let gradient = (0..size.pixels()).map(|i| [(i % 64 * 4) as u8, (i / 64 * 5) as u8, 90, 255]);
/// let frame = Frame::new(size, gradient.collect())?;
///
/// let mut options = Options::default();
/// options.points = Points::Count(60);
/// let rendered = Renderer::new(&options)?.render(&frame)?;
/// assert_eq!(rendered.mesh.seeds().len(), 60);
/// assert_eq!(rendered.painting.frame.size(), size);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Renderer {
    extractor: Extractor,
    mesher: Mesher,
    painter: Painter,
    /// Of the last frame, where there was a call for it.
    echo: Option<Echo>,
}

impl Renderer {
    /// A renderer for one stream of frames.
    ///
    /// # Errors
    /// When an option is out of range.
    pub fn new(options: &Options) -> Result<Self> {
        options.validate()?;
        Ok(Self {
            extractor: Extractor::new(options),
            mesher: Mesher::new(options),
            painter: Painter::new(options),
            echo: None,
        })
    }

    /// The same, and pictures are painted as planes where they can be: see [`Painter::with_form`].
    #[doc(hidden)]
    pub fn with_form(mut self, form: Option<Form>) -> Self {
        self.painter = self.painter.with_form(form);
        self
    }

    /// Changes the options from the next frame on. The mesh lives on where what changed only concerns
    /// what is done with it (coherence, refinement, outline); else the next frame begins anew.
    ///
    /// # Errors
    /// When an option is out of range; nothing is changed then.
    pub fn retune(&mut self, options: &Options) -> Result<()> {
        options.validate()?;
        self.extractor.retune(options);
        self.mesher.retune(options);
        self.painter.retune(options);
        Ok(())
    }

    /// The next frame as low-poly art.
    ///
    /// # Errors
    /// Where [`Options::error`] cannot be measured (SSIM of a frame smaller than its window), or not be
    /// reached by any number of [`Points::Auto`].
    pub fn render(&mut self, frame: &Frame) -> Result<Rendered> {
        self.render_in(frame, &Detail::FULL)
    }

    /// The next frame, at the cost of `detail`.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    #[doc(hidden)]
    pub fn render_in(&mut self, frame: &Frame, detail: &Detail) -> Result<Rendered> {
        let features = self.extractor.extract(frame, detail.look);
        let (mut mesh, fresh) =
            triangulate_start(frame, self.mesher.sample(&features, frame, detail)?)?;
        let refined = self.mesher.refine(&mut mesh, frame, fresh, detail, self.echo.take())?;
        let life = self.mesher.remember(&mesh, fresh, &refined);
        let (refine_steps, likeness) = (refined.steps, refined.likeness);
        let call = self.mesher.call(&refined);
        let brief = Brief { fresh, known: refined.fills, call };
        let answer = |echo| self.echo = echo;
        let painting = self.painter.paint(&mesh, frame, detail.rows, brief, answer);
        let candidates = features.candidates.len();
        Ok(Rendered { painting, mesh, life, refine_steps, likeness, candidates })
    }
}

/// The rooms that share one thread, because the mesh that a frame ends with is the one that the next
/// frame starts from: sample, triangulate, refine.
#[derive(Debug)]
pub struct Mesher {
    /// What was asked for.
    asked: Options,
    /// The same with [`Points::Auto`] as the number that was found.
    options: Options,
    sampler: Sampler,
    refiner: Refiner,
    /// Whether a frame was refined already: then this is no still.
    begun: bool,
}

impl Mesher {
    /// As `options` ask for it.
    pub fn new(options: &Options) -> Self {
        Self {
            asked: options.clone(),
            options: options.clone(),
            sampler: Sampler::new(options),
            refiner: Refiner::default(),
            begun: false,
        }
    }

    /// Changes the options from the next frame on, see [`Sampler::retune`]. A number found for
    /// [`Points::Auto`] stays as long as what it was found for.
    pub fn retune(&mut self, options: &Options) {
        let points =
            if options.keeps_seeds_of(&self.asked) { self.options.points } else { options.points };
        self.asked = options.clone();
        self.options = Options { points, ..options.clone() };
        self.sampler.retune(&self.options);
    }

    /// Level two: see [`Sampler::sample`]. The first time, [`Points::Auto`] is found and becomes a
    /// count.
    ///
    /// # Errors
    /// When no number of points reaches the target, or it cannot be measured.
    pub fn sample(&mut self, features: &Features, frame: &Frame, detail: &Detail) -> Result<Start> {
        if let (Points::Auto, Some(goal)) = (self.options.points, Goal::of(&self.options)) {
            let count = fewest(&self.options, goal, features, frame)?;
            self.options.points = Points::Count(count);
            self.sampler.retune(&self.options);
        }
        Ok(self.sampler.sample(features, detail))
    }

    /// Steps of refinement that the options ask for on a frame of `size`, of a fresh mesh or of one that
    /// lives on.
    pub fn asked(&self, fresh: bool, size: Size) -> u32 {
        self.plan(fresh, size).steps
    }

    fn plan(&self, fresh: bool, size: Size) -> RefineOptions {
        if self.begun && self.options.coherence == 0.0 {
            RefineOptions::alone(&self.options, size)
        } else if fresh {
            RefineOptions::fresh(&self.options)
        } else {
            RefineOptions::next(&self.options, size)
        }
    }

    /// Level three: refines `mesh`, anew when it is `fresh`, else as the mesh of the frame before, with
    /// its `echo`, at the cost of `detail`.
    ///
    /// # Errors
    /// When [`Options::error`] cannot be measured on a frame of this size.
    pub fn refine(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        fresh: bool,
        detail: &Detail,
        echo: Option<Echo>,
    ) -> Result<Refined> {
        let full = self.plan(fresh, frame.size());
        let plan = full.at(detail);
        self.begun = true;
        if !fresh && plan.passes() > 0 {
            return Ok(self.refiner.resume(mesh, frame, &plan, echo));
        }
        if let Some(echo) = echo {
            self.refiner.pass_over(echo);
        }
        if !fresh {
            return Ok(self.refiner.tend(mesh, frame, &plan));
        }
        if plan.passes() > 0 {
            return match Goal::of(&self.options) {
                Some(goal) => reach(goal, &mut self.refiner, mesh, frame, &plan, &mut |_| ()),
                None => Ok(self.refiner.refine(mesh, frame, &plan)),
            };
        }
        if full.passes() > 0 {
            // There is no time for it now: what the next frame needs for it is done.
            self.refiner.prepare(mesh);
        } else if self.options.coherence > 0.0 {
            self.refiner.take_up(mesh, frame);
        }
        Ok(Refined::default())
    }

    /// Whether whoever paints the frame that was `refined` is to tell its echo, for the next one.
    pub fn call(&mut self, refined: &Refined) -> Option<Call> {
        // Where the means are known the frame is opaque, and the next one is likely to take steps too.
        if refined.fills.is_empty() { None } else { self.refiner.call(self.options.coherence) }
    }

    /// As [`Mesher::refine`] does with a fresh `mesh`, and shows `seen` its squared error, as in
    /// [`Refined::error_before`], before every step; where no step is asked for, once.
    ///
    /// # Errors
    /// When [`Options::error`] cannot be measured on a frame of this size.
    pub fn refine_seen(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        seen: &mut (dyn FnMut(f64) + Send),
    ) -> Result<Refined> {
        let plan = RefineOptions::fresh(&self.options);
        if let Some(goal) = Goal::of(&self.options) {
            return reach(goal, &mut self.refiner, mesh, frame, &plan, seen);
        }
        // A refiner that is asked for no step does not look at the error.
        let looking = RefineOptions { steps: plan.steps.max(1), ..plan };
        let mut watch = |_: &Mesh, error: f64| {
            seen(error);
            plan.steps > 0
        };
        Ok(self.refiner.refine_while(mesh, frame, &looking, &mut watch))
    }

    /// Takes back a mesh that is no longer needed: see [`Sampler::recycle`].
    pub fn recycle(&mut self, mesh: Mesh) {
        self.sampler.recycle(mesh);
    }

    /// Takes up the mesh for the next frame: see [`Sampler::remember`].
    pub fn remember(&mut self, mesh: &Mesh, fresh: bool, refined: &Refined) -> Life {
        self.sampler.remember(mesh, fresh, &refined.replaced)
    }
}

/// The mesh that a frame starts from, and whether it is fresh.
///
/// # Errors
/// As [`triangulate`].
pub fn triangulate_start(frame: &Frame, start: Start) -> Result<(Mesh, bool)> {
    match start {
        Start::Seeds(seeds) => Ok((triangulate(frame.size(), &seeds)?, true)),
        Start::Mesh(mesh) => Ok((mesh, false)),
    }
}
