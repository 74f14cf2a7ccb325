//! The three stages between decode and encode, each on its own thread.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::thread::{Scope, ScopedJoinHandle};

use crossbeam_channel::{Receiver, Sender, bounded};

use crate::chain::{self, FeatureStage, MeshStage, PaintStage};
use crate::colour::Form;
use crate::error::Result;
use crate::frame::{Buffers, Frame};
use crate::mesh::Mesh;
use crate::options::Options;
use crate::rasterise::Painting;
use crate::residual::Residual;
use crate::sink::{Origin, Picture};
use crate::stage::Stage;

use super::CAPACITY;
use super::detail::DetailController;
use super::hop::{Admitted, Featured, FrameContext, Meshed, Painted};
use super::pool::Pool;
use super::spawn;
use super::worker::{Process, StageTimer, StageWorker};

/// The running stages, and the output of the last one.
pub(super) struct Stages<'s> {
    pub(super) threads: Vec<ScopedJoinHandle<'s, ()>>,
    pub(super) painted: Receiver<Result<Painted>>,
}

/// The needs of the sink, and channels for recycled buffers.
pub(super) struct Output {
    /// The form of planes of pictures.
    pub(super) form: Option<Form>,
    /// Returns painted frames to the source. Without it they go to the sink.
    pub(super) frames: Option<Sender<Frame>>,
    /// Those of pictures that have been written.
    pub(super) pictures: Receiver<Buffers>,
}

/// Starts the stages.
///
/// # Errors
/// When the system gives no more threads.
pub(super) fn spawn_stages<'s, 'e>(
    scope: &'s Scope<'s, 'e>,
    admitted: Receiver<Result<Admitted>>,
    options: &Arc<Options>,
    controller: &'e DetailController,
    threads: Option<NonZeroUsize>,
    output: Output,
) -> Result<Stages<'s>> {
    let Output { form, frames, pictures } = output;
    let (residual_tx, residual_rx) = bounded(CAPACITY);
    let (mesh_tx, mesh_rx) = bounded(CAPACITY);
    let features =
        Features { stage: FeatureStage::new(options), options: options.clone(), controller };
    let mesh = BuildMesh {
        stage: MeshStage::new(options),
        options: options.clone(),
        controller,
        meshes: mesh_rx,
        residuals: Residuals { receiver: residual_rx, is_requested: false },
    };
    let paint = Paint {
        stage: PaintStage::new(options).with_form(form),
        options: options.clone(),
        controller,
        pictures,
        residuals: residual_tx,
        frames,
        meshes: mesh_tx,
    };
    let features = spawn_stage(scope, threads, features, admitted)?;
    let mesh = spawn_stage(scope, threads, mesh, features.output)?;
    let paint = spawn_stage(scope, threads, paint, mesh.output)?;
    let threads = vec![features.thread, mesh.thread, paint.thread];
    Ok(Stages { threads, painted: paint.output })
}

/// A running stage, and its output.
struct Running<'s, T> {
    thread: ScopedJoinHandle<'s, ()>,
    output: Receiver<Result<T>>,
}

/// Starts the thread of `process`.
fn spawn_stage<'s, P: Process + 's>(
    scope: &'s Scope<'s, '_>,
    threads: Option<NonZeroUsize>,
    process: P,
    inbox: Receiver<Result<P::Input>>,
) -> Result<Running<'s, P::Output>> {
    let (outbox, output) = bounded(CAPACITY);
    let worker = StageWorker::new(P::STAGE, outbox);
    let thread = spawn(scope, P::NAME, move || worker.run_in_pool(threads, inbox, process))?;
    Ok(Running { thread, output })
}

/// Level one.
struct Features<'e> {
    stage: FeatureStage,
    /// Those that the stage works by.
    options: Arc<Options>,
    controller: &'e DetailController,
}

impl Process for Features<'_> {
    type Input = Admitted;
    type Output = Featured;
    const STAGE: Stage = Stage::Features;
    const NAME: &'static str = "features";

    fn process(&mut self, hop: Admitted, pool: &Pool, timer: &mut StageTimer) -> Result<Featured> {
        let Admitted { mut context, frame } = hop;
        if let Some(options) = context.settings.changed_options(&mut self.options) {
            self.stage.retune(options);
        }
        let controller = self.controller.for_frame(context.is_full);
        controller.before_features(&mut context);
        let look = context.settings.detail.look;
        let mut probe = timer.probe(pool, &mut context.report);
        let features = self.stage.run(&frame, look, &mut probe);
        context.report.candidates = features.candidates.len();
        controller.after_features(&context, &features);
        Ok(Featured { context, frame, features })
    }
}

/// Level two, the triangulation, and level three.
struct BuildMesh<'e> {
    stage: MeshStage,
    /// Those that the stage works by.
    options: Arc<Options>,
    controller: &'e DetailController,
    /// Meshes that have been painted.
    meshes: Receiver<Mesh>,
    residuals: Residuals,
}

/// The residuals of painted frames.
struct Residuals {
    receiver: Receiver<Option<Residual>>,
    /// Whether the residual of the last frame was requested.
    is_requested: bool,
}

impl Residuals {
    /// The residual of the last frame, when it is painted.
    fn last(&mut self) -> Option<Residual> {
        // If the paint stage has ended this frame will not be painted either.
        let is_requested = std::mem::take(&mut self.is_requested);
        if is_requested { self.receiver.recv().ok().flatten() } else { None }
    }
}

impl Process for BuildMesh<'_> {
    type Input = Featured;
    type Output = Meshed;
    const STAGE: Stage = Stage::Sample;
    const NAME: &'static str = "mesh";

    fn process(&mut self, hop: Featured, pool: &Pool, timer: &mut StageTimer) -> Result<Meshed> {
        let Featured { mut context, frame, features } = hop;
        if let Some(options) = context.settings.changed_options(&mut self.options) {
            self.stage.retune(options);
        }
        if let Ok(mesh) = self.meshes.try_recv() {
            self.stage.recycle(mesh);
        }
        let controller = self.controller.for_frame(context.is_full);
        controller.before_mesh(&mut context, &features, &self.stage);
        let detail = context.settings.detail;
        let last = || self.residuals.last();
        let mut probe = timer.probe(pool, &mut context.report);
        let meshed = self.stage.run(&features, &frame, &detail, last, &mut probe);
        let meshed = meshed.map_err(|error| probe.error(error))?;
        self.residuals.is_requested = meshed.hints.residual.is_some();
        report_mesh(&mut context, &meshed);
        controller.after_mesh(&context, meshed.is_fresh);
        Ok(Meshed { context, frame, mesh: meshed.mesh, hints: meshed.hints })
    }
}

/// Writes the results of the mesh stage into the frame's report.
fn report_mesh(context: &mut FrameContext, meshed: &chain::Meshed) {
    let chain::Meshed { mesh, life, faces, refined, .. } = meshed;
    let report = &mut context.report;
    report.seeds = mesh.seed_ids().count();
    report.seeds_kept = life.kept;
    report.seeds_moved = life.moved;
    report.seeds_born = life.born;
    report.seeds_died = life.died;
    report.cut = life.cut;
    report.triangles = mesh.triangles.len();
    report.refine_steps = refined.steps;
    report.likeness = refined.likeness;
    report.faces = *faces;
    let target = context.settings.options.error.zip(refined.likeness);
    report.short = target.is_some_and(|(target, likeness)| likeness < target.value());
}

/// Mean colours, and the picture.
struct Paint<'e> {
    stage: PaintStage,
    /// Those that the stage works by.
    options: Arc<Options>,
    controller: &'e DetailController,
    /// Buffers of pictures that have been written.
    pictures: Receiver<Buffers>,
    residuals: Sender<Option<Residual>>,
    /// The channel of frames to the source, unless the sink needs them.
    frames: Option<Sender<Frame>>,
    /// The channel of meshes to the mesh stage.
    meshes: Sender<Mesh>,
}

impl Process for Paint<'_> {
    type Input = Meshed;
    type Output = Painted;
    const STAGE: Stage = Stage::Rasterise;
    const NAME: &'static str = "rasterise";

    fn process(&mut self, hop: Meshed, pool: &Pool, timer: &mut StageTimer) -> Result<Painted> {
        let Meshed { mut context, frame, mesh, hints } = hop;
        if let Some(options) = context.settings.changed_options(&mut self.options) {
            self.stage.retune(options);
        }
        if let Ok(buffers) = self.pictures.try_recv() {
            self.stage.recycle(buffers);
        }
        let controller = self.controller.for_frame(context.is_full);
        controller.before_painting(&mut context);
        let rows = context.settings.detail.rows;
        let residuals = hints.residual.is_some().then_some(&self.residuals);
        let send = |residual| {
            if let Some(residuals) = residuals {
                // The mesh stage waits for the residual, unless the run has ended.
                let _ = residuals.send(residual);
            }
        };
        let FrameContext { span, is_warmup, mut report, .. } = context;
        let mut probe = timer.probe(pool, &mut report);
        let painting = self.stage.run(&mesh, &frame, rows, hints, send, &mut probe);
        controller.after_painting(&report);
        let Painting { frame: picture, fills } = painting;
        let picture = Picture { frame: picture, fills, span };
        let origin = self.recycle(Origin { frame, mesh });
        Ok(Painted { is_warmup, report, picture, origin })
    }
}

impl Paint<'_> {
    /// Recycles frame and mesh, unless the sink needs them.
    fn recycle(&self, origin: Origin) -> Option<Origin> {
        let Some(frames) = &self.frames else { return Some(origin) };
        // If the channel is full they are dropped.
        let _ = (frames.try_send(origin.frame), self.meshes.try_send(origin.mesh));
        None
    }
}
