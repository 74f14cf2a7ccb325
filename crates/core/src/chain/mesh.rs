//! Sampling, triangulation and refinement. They share one thread, because a frame's mesh is the start of the next
//! one's.

use super::StageProbe;
use super::abstraction::Abstraction;
use super::goal::{Goal, fewest, reach};
use crate::error::Result;
use crate::feature::Features;
use crate::focus::FocusKeeper;
use crate::frame::Frame;
use crate::geom::Size;
use crate::mesh::Mesh;
use crate::options::{Detail, Options, Points, Shape};
use crate::rasterise::PaintHints;
use crate::refine::{RefineOptions, Refined, Refiner};
use crate::residual::{Residual, ResidualRequest};
use crate::sample::{Life, Sampler, Start};
use crate::stage::Stage;
use crate::triangulate::triangulate;
use crate::voronoi::cells;

/// The result of the mesh stage for a frame.
#[derive(Debug)]
pub struct Meshed {
    /// The mesh.
    pub mesh: Mesh,
    /// Whether its seeds are fresh, not carried from the last frame.
    pub is_fresh: bool,
    /// Where its seeds come from.
    pub life: Life,
    /// The number of faces in focus, where they were asked for.
    pub faces: Option<usize>,
    /// The result of refinement; its fills are in the `hints`.
    pub refined: Refined,
    /// For the paint stage.
    pub hints: PaintHints,
}

/// Gets the mesh and its squared error, see [`Refined::error_before`], before every step of refinement.
pub type Observer<'a> = &'a mut (dyn FnMut(&Mesh, f64) + Send);

/// The middle of the chain: chooses seeds, or carries those of the last frame, and refines their mesh.
#[derive(Debug)]
pub struct MeshStage {
    /// As the user gave them.
    requested: Options,
    /// The same with the number that was found for [`Points::Auto`].
    options: Options,
    /// The number for [`Points::Auto`] without an error to reach.
    abstraction: Abstraction,
    focus: FocusKeeper,
    sampler: Sampler,
    refiner: Refiner,
    /// Whether a frame was refined already: then this is a stream, not a still.
    has_begun: bool,
}

impl MeshStage {
    /// A stage for one stream of frames.
    pub fn new(options: &Options) -> Self {
        Self {
            requested: options.clone(),
            options: options.clone(),
            abstraction: Abstraction::default(),
            focus: FocusKeeper::new(options.focus.as_ref()),
            sampler: Sampler::new(options),
            refiner: Refiner::default(),
            has_begun: false,
        }
    }

    /// Changes the options from the next frame on, see [`Sampler::retune`]. The number for [`Points::Auto`] is kept
    /// as long as the options that it depends on.
    pub fn retune(&mut self, options: &Options) {
        let keeps_seeds = options.keeps_seeds_of(&self.requested);
        let points = if keeps_seeds { self.options.points } else { options.points };
        self.requested = options.clone();
        self.options = Options { points, ..options.clone() };
        self.sampler.retune(&self.options);
        if !keeps_seeds {
            self.abstraction = Abstraction::default();
            self.focus = FocusKeeper::new(options.focus.as_ref());
        }
    }

    /// The options as they were given, with [`Points::Auto`] as such.
    pub fn requested_options(&self) -> &Options {
        &self.requested
    }

    /// The options, [`Points::Auto`] as the number that was found once there was a frame.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Takes the buffers of a mesh that is no longer needed: see [`Sampler::recycle`].
    pub fn recycle(&mut self, mesh: Mesh) {
        self.sampler.recycle(mesh);
    }

    /// The number of refinement steps by the options, for a frame of `size` with a fresh or a carried mesh.
    pub fn requested_steps(&self, is_fresh: bool, size: Size) -> u32 {
        self.plan(is_fresh, size).steps
    }

    /// The mesh of the next `frame`, with this `detail`. `last` is called once, after the triangulation and outside
    /// of all stages, for the residual of the last frame; it may wait until that frame is painted.
    ///
    /// # Errors
    /// When [`Options::error`] cannot be measured on a frame of this size, or no number of points reaches it.
    pub fn run(
        &mut self,
        features: &Features,
        frame: &Frame,
        detail: &Detail,
        last: impl FnOnce() -> Option<Residual>,
        probe: &mut impl StageProbe,
    ) -> Result<Meshed> {
        self.build(features, frame, detail, last, None, probe)
    }

    /// As [`MeshStage::run`] for a still at full detail. `observer` gets the mesh and its error before every step;
    /// without steps, once.
    ///
    /// # Errors
    /// As [`MeshStage::run`].
    pub fn run_observed(
        &mut self,
        features: &Features,
        frame: &Frame,
        observer: Observer<'_>,
    ) -> Result<Meshed> {
        self.build(features, frame, &Detail::FULL, || None, Some(observer), &mut ())
    }

    fn build(
        &mut self,
        features: &Features,
        frame: &Frame,
        detail: &Detail,
        last: impl FnOnce() -> Option<Residual>,
        observer: Option<Observer<'_>>,
        probe: &mut impl StageProbe,
    ) -> Result<Meshed> {
        if self.options.focus.is_some() {
            let map = probe.stage(Stage::Sample, || {
                self.focus.map(frame, features.change.is_fresh()).cloned()
            });
            self.sampler.focus.clone_from(&map);
            self.refiner.focus = map;
        } else {
            (self.sampler.focus, self.refiner.focus) = (None, None);
        }
        let start = probe.stage(Stage::Sample, || self.sample(features, frame, detail))?;
        let (mut mesh, is_fresh) = probe.stage(Stage::Triangulate, || first_mesh(frame, start))?;
        let residual = last();
        probe.stage(Stage::Refine, || {
            let mut refined = match observer {
                Some(observer) => self.refine_observed(&mut mesh, frame, observer)?,
                None if is_fresh => self.refine_fresh(&mut mesh, frame, detail, residual)?,
                None => self.refine_next(&mut mesh, frame, detail, residual),
            };
            let life = self.sampler.remember(&mut mesh, is_fresh, &refined.replaced);
            let mut fills = std::mem::take(&mut refined.fills);
            let shape = self.options.shape;
            // If the means are known the frame is opaque, and the next one probably takes steps too. What is painted
            // of panes and cells says nothing about the triangles.
            let is_fed_back = !fills.is_empty() && shape == Shape::Triangles;
            let residual = if is_fed_back { self.request_residual() } else { None };
            if shape == Shape::Voronoi {
                (mesh, fills) = (cells(&mesh), Vec::new());
            }
            let hints = PaintHints { is_fresh, fills, residual };
            let faces = self.focus.faces();
            Ok(Meshed { mesh, is_fresh, life, faces, refined, hints })
        })
    }

    /// Level two: see [`Sampler::sample`]. The number for [`Points::Auto`] is found at the first frame; without an error
    /// to reach, at the first of each shot, and it follows the picture from there on.
    fn sample(&mut self, features: &Features, frame: &Frame, detail: &Detail) -> Result<Start> {
        if let (Points::Auto, Some(goal)) = (self.options.points, Goal::of(&self.options)) {
            let count = fewest(&self.options, goal, features, frame)?;
            self.options.points = Points::Count(count);
            self.sampler.retune(&self.options);
        }
        if self.requested.points == Points::Auto && self.requested.error.is_none() {
            let is_fresh = features.change.is_fresh();
            if let Some(count) = self.abstraction.next(frame, is_fresh) {
                self.options.points = Points::Count(count);
                self.sampler.aim_at(self.options.points);
            }
        }
        Ok(self.sampler.sample(features, frame, detail))
    }

    fn plan(&self, is_fresh: bool, size: Size) -> RefineOptions {
        if self.has_begun && self.options.coherence == 0.0 {
            RefineOptions::alone(&self.options, size)
        } else if is_fresh {
            RefineOptions::fresh(&self.options)
        } else {
            RefineOptions::next(&self.options, size)
        }
    }

    /// Level three for a fresh `mesh`. The `residual` is of another mesh: only its buffers are used.
    fn refine_fresh(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        detail: &Detail,
        residual: Option<Residual>,
    ) -> Result<Refined> {
        if let Some(residual) = residual {
            self.refiner.recycle(residual.into_buffers());
        }
        let plan = self.plan(true, frame.size()).at(detail);
        self.has_begun = true;
        match Goal::of(&self.options).filter(|_| plan.passes() > 0) {
            Some(goal) => reach(goal, &mut self.refiner, mesh, frame, &plan, &mut |_, _| ()),
            None => Ok(self.refiner.still(mesh, frame, &plan, None)),
        }
    }

    /// Level three for a carried `mesh`.
    fn refine_next(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        detail: &Detail,
        residual: Option<Residual>,
    ) -> Refined {
        let plan = self.plan(false, frame.size()).at(detail);
        self.has_begun = true;
        self.refiner.frame(mesh, frame, &plan, residual)
    }

    /// Level three for a still.
    fn refine_observed(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        observer: Observer<'_>,
    ) -> Result<Refined> {
        let plan = RefineOptions::fresh(&self.options);
        if let Some(goal) = Goal::of(&self.options) {
            return reach(goal, &mut self.refiner, mesh, frame, &plan, observer);
        }
        // Without a step the refiner does not measure the error.
        let measured = RefineOptions { steps: plan.steps.max(1), ..plan };
        let mut watch = |mesh: &Mesh, error: f64| {
            observer(mesh, error);
            plan.steps > 0
        };
        Ok(self.refiner.still(mesh, frame, &measured, Some(&mut watch)))
    }

    fn request_residual(&mut self) -> Option<ResidualRequest> {
        ResidualRequest::new(self.options.coherence, self.refiner.take_buffers())
    }
}

/// The mesh before refinement, and whether it is fresh.
fn first_mesh(frame: &Frame, start: Start) -> Result<(Mesh, bool)> {
    match start {
        Start::Seeds(seeds) => Ok((triangulate(frame.size(), &seeds)?, true)),
        Start::Mesh(mesh) => Ok((mesh, false)),
    }
}
