//! The chain on threads: decode, features, mesh, rasterise and encode work on successive frames at the
//! same time.
//!
//! ```text
//! decode -> features -> mesh (sample, triangulate, refine) -> rasterise -> encode -> the caller's observer
//! ```
//!
//! Every arrow is a channel with room for one frame, one producer and one consumer: frames stay in
//! order, and at most [`IN_FLIGHT`] of them exist at a time, however long the input is. Sampling and
//! triangulation share a thread, because the seeds that a frame ends with are those that the next one
//! starts from; one thing goes back, the [echo](crate::echo) that the next frame's refinement waits for, and
//! memory to be filled again. rayon works inside a frame; nothing waits for a channel inside its work.
//!
//! The pictures are those of [`crate::render::Renderer`], byte for byte.

mod admission;
mod controls;
mod delivery;
mod histogram;
mod hop;
mod pilot;
mod pool;
mod replay;
mod report;
mod station;

use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::Instant;

use crossbeam_channel::{Receiver, Sender, bounded};

use crate::colour::Form;
use crate::echo::Echo;
use crate::error::{Error, Result};
use crate::feature::Extractor;
use crate::frame::{Buffers, Frame};
use crate::options::Options;
use crate::rasterise::{Brief, Painter};
use crate::render::{Mesher, triangulate_start};
use crate::sink::{Origin, Picture, Sink};
use crate::source::Source;
use crate::stage::Stage;

pub use admission::Stop;
use admission::{Door, decode};
pub use controls::Controls;
use delivery::Delivery;
use histogram::StageHistograms;
use hop::{Admitted, Featured, Meshed, Orders, Painted, Ticket};
pub use pilot::Guide;
use pilot::{Pilot, longest};
use pool::Pool;
pub use replay::Script;
pub use report::{
    BudgetReport, Ending, FrameReport, InputReport, OutputReport, Report, StageTimes, Summary,
};
use station::{Clock, Station};

/// The most frames that exist at a time: one in the hands of each of the five threads, one in each of
/// the four channels between them. Two more, painted already, may wait to be filled again.
pub const IN_FLIGHT: usize = 9;

/// Frames that wait in a channel.
const ROOM: usize = 1;

/// How to run, beside what to render.
#[derive(Clone, Debug, Default)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Settings {
    /// How to render.
    pub options: Options,
    /// Options that may change during the run, in place of [`Settings::options`]. Default `None`: they
    /// stay. The sink [adapts](crate::sink::Needs::adapt) them when the run begins.
    pub controls: Option<Controls>,
    /// What decides how much detail frames have. Default [`Guide::Options`].
    pub guide: Guide,
    /// Threads that work inside a frame, for each of the three stages between decode and encode, the
    /// stage's own among them; `None` is a thread a core. Default `None`.
    pub threads: Option<NonZeroUsize>,
    /// Whether the source is live: frames that find no room are dropped, the newest is kept.
    /// Default `false`.
    pub live: bool,
    /// Whether an input that breaks off still gives an output, of the frames before. Default `false`.
    pub allow_truncated: bool,
}

/// Watches a run, on the thread that called [`run`].
pub trait Observer {
    /// A frame has been written. Called for every frame in order; the pipeline waits meanwhile once its
    /// channels are full. `Break` asks for a [`Stop`].
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()>;
}

/// The observer that does not look.
impl Observer for () {
    fn frame_done(&mut self, _: &FrameReport) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Renders all that the source has to the sink. `start` is called on the decoding thread. Of the threads
/// of a run rayon keeps some 30 KiB for good (measured on two cores): for very many short runs in one
/// process there is [`crate::render::Renderer`], which keeps nothing.
///
/// # Errors
/// The first error in frame order, with the frame's number and the stage; the frames before it have
/// been written, but the sink is dropped unfinished. [`Error::Usage`] for options out of range, and for
/// an input without frames. A reader who closed the output is no error but [`Ending::Closed`].
///
/// # Panics
/// A panic in a stage, in the source, the sink or the observer is resumed here, after the sink has been
/// dropped unfinished.
pub fn run(
    start: impl FnOnce() -> Result<Box<dyn Source>> + Send,
    sink: Box<dyn Sink>,
    settings: &Settings,
    observer: &mut dyn Observer,
    stop: &Stop,
) -> Result<Summary> {
    let controls = match &settings.controls {
        Some(controls) => controls.clone(),
        None => Controls::new(settings.options.clone())?,
    };
    let needs = sink.needs();
    let mut options = (*controls.options()).clone();
    needs.adapt(&mut options);
    controls.set(options)?;
    let pilot = &Pilot::new(&settings.guide);
    let began = Instant::now();
    let over = AtomicBool::new(false);
    let dropped = AtomicU64::new(0);
    let mut histograms = StageHistograms::new();
    let (mut frames, mut short, mut least) = (0, 0, None);
    let allowed = settings.guide.budget();
    let mut budget = BudgetReport::new(allowed);
    let ending = thread::scope(|scope| {
        let end = End(&over);
        let (admit, admitted) = bounded(ROOM);
        let queue = settings.live.then(|| admitted.clone());
        let (return_spent, spent) = bounded(ROOM);
        let (over, dropped) = (&over, &dropped);
        let door = Door { controls: &controls, pilot, stop, over, queue, spent, dropped };
        let station = Station::new(Stage::Decode, admit);
        let decoding = spawn(scope, "decode", move || decode(start, station, &door))?;
        let spent = (!needs.origin).then_some(return_spent);
        let (return_canvas, canvases) = bounded(ROOM);
        let exit = Exit { form: needs.form, spent, canvases };
        let (chain, painted) =
            spawn_chain(scope, admitted, &controls, pilot, settings.threads, exit)?;
        let (tell, told) = bounded(ROOM);
        let keep_truncated = settings.allow_truncated;
        let delivery = Delivery { sink, tell, return_canvas, stop, keep_truncated };
        let encoding = spawn(scope, "encode", move || delivery.run(painted))?;

        for report in told {
            frames += 1;
            short += u64::from(report.short);
            if let Some(likeness) = report.likeness {
                least = Some(least.map_or(likeness, |least: f64| least.min(likeness)));
            }
            histograms.add(&report.timing);
            budget.missed += u64::from(allowed.is_some_and(|most| longest(&report.timing) > most));
            budget.changes += report.changes.len() as u64;
            if observer.frame_done(&report).is_break() {
                stop.request();
            }
        }
        drop(end);
        for stage in chain.into_iter().chain([decoding]) {
            resume(stage);
        }
        resume(encoding)
    })?;
    Ok(Summary {
        frames,
        dropped: dropped.into_inner(),
        short,
        likeness: least,
        budget,
        wall: began.elapsed(),
        stages: StageTimes(histograms.percentiles()),
        ending,
    })
}

/// Tells the way in that all is over, however the caller's part of the run ends.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Running stages, and what comes out of the last of them.
type Chain<'s> = (Vec<ScopedJoinHandle<'s, ()>>, Receiver<Result<Painted>>);

/// What the way out wants, and memory on its way back, to be filled again.
struct Exit {
    /// How pictures are wanted.
    form: Option<Form>,
    /// Takes frames that have been painted to the source. Without it they go on to the sink.
    spent: Option<Sender<Frame>>,
    /// That of pictures that have been written.
    canvases: Receiver<Buffers>,
}

/// The stages between decode and encode, each on a thread of its own.
fn spawn_chain<'s, 'e>(
    scope: &'s Scope<'s, 'e>,
    admitted: Receiver<Result<Admitted>>,
    controls: &Controls,
    pilot: &'e Pilot,
    threads: Option<NonZeroUsize>,
    Exit { form, spent, canvases }: Exit,
) -> Result<Chain<'s>> {
    let options = controls.options();
    let (extract, extracted) = bounded(ROOM);
    let station = Station::new(Stage::Features, extract);
    let mut extractor = Extractor::new(&options);
    let mut tuned = options.clone();
    let look_thread = spawn(scope, "features", move || {
        station.run_in_pool(threads, admitted, |pool, clock, hop| {
            if let Some(options) = hop.ticket.orders.news(&mut tuned) {
                extractor.retune(options);
            }
            features(&mut extractor, hop, clock, pilot, pool)
        });
    })?;
    let (mesh, meshed) = bounded(ROOM);
    let station = Station::new(Stage::Sample, mesh);
    let mut mesher = Mesher::new(&options);
    let (tell, told) = bounded(1);
    let (return_mesh, meshes) = bounded(ROOM);
    let mut echoes = Echoes { told, called: false };
    let mut tuned = options.clone();
    let mesh_thread = spawn(scope, "mesh", move || {
        station.run_in_pool(threads, extracted, |pool, clock, hop| {
            if let Some(options) = hop.ticket.orders.news(&mut tuned) {
                mesher.retune(options);
            }
            if let Ok(mesh) = meshes.try_recv() {
                mesher.recycle(mesh);
            }
            build_mesh(&mut mesher, hop, clock, pilot, pool, &mut echoes)
        });
    })?;
    let (paint, painted) = bounded(ROOM);
    let station = Station::new(Stage::Rasterise, paint);
    let mut painter = Painter::new(&options).with_form(form);
    let mut tuned = options;
    let paint_thread = spawn(scope, "rasterise", move || {
        station.run_in_pool(threads, meshed, |pool, clock, hop| {
            if let Some(options) = hop.ticket.orders.news(&mut tuned) {
                painter.retune(options);
            }
            if let Ok(canvas) = canvases.try_recv() {
                painter.recycle(canvas);
            }
            let mut painted = fill(&mut painter, hop, clock, pilot, pool, &tell)?;
            if let Some(spent) = &spent
                && let Some(origin) = painted.origin.take()
            {
                // Without room there are enough of them: then they are let go.
                let _ = (spent.try_send(origin.frame), return_mesh.try_send(origin.mesh));
            }
            Ok(painted)
        });
    })?;
    Ok((vec![look_thread, mesh_thread, paint_thread], painted))
}

/// Level one.
fn features(
    extractor: &mut Extractor,
    hop: Admitted,
    clock: &mut Clock,
    pilot: &Pilot,
    pool: &Pool,
) -> Result<Featured> {
    let Admitted { mut ticket, frame } = hop;
    let pilot = pilot.in_charge(ticket.rehearsal);
    pilot.before_features(&mut ticket);
    let look = ticket.orders.detail.look;
    let report = &mut ticket.report;
    let features =
        pool.work(|| clock.time(Stage::Features, report, || Ok(extractor.extract(&frame, look))))?;
    report.candidates = features.candidates.len();
    pilot.after_features(&ticket, &features);
    Ok(Featured { ticket, frame, features })
}

/// Level two, the triangulation, and level three.
fn build_mesh(
    mesher: &mut Mesher,
    hop: Featured,
    clock: &mut Clock,
    pilot: &Pilot,
    pool: &Pool,
    echoes: &mut Echoes,
) -> Result<Meshed> {
    let Featured { mut ticket, frame, features } = hop;
    let pilot = pilot.in_charge(ticket.rehearsal);
    pilot.before_mesh(&mut ticket, &features, mesher);
    let Orders { options, detail } = &ticket.orders;
    let report = &mut ticket.report;
    let start = pool.work(|| {
        clock.time(Stage::Sample, report, || {
            mesher.sample(&features, &frame, detail).map_err(Error::from)
        })
    })?;
    let (mut mesh, fresh) = pool.work(|| {
        clock.time(Stage::Triangulate, report, || {
            triangulate_start(&frame, start).map_err(Error::from)
        })
    })?;
    let echo = echoes.last();
    let refined = pool.work(|| {
        clock.time(Stage::Refine, report, || {
            mesher.refine(&mut mesh, &frame, fresh, detail, echo).map_err(Error::from)
        })
    })?;
    let life = mesher.remember(&mesh, fresh, &refined);
    report.seeds = mesh.seeds().len();
    report.seeds_kept = life.kept;
    report.seeds_moved = life.moved;
    report.seeds_born = life.born;
    report.seeds_died = life.died;
    report.cut = life.cut;
    report.triangles = mesh.triangles.len();
    report.refine_steps = refined.steps;
    report.likeness = refined.likeness;
    report.short = options
        .error
        .zip(refined.likeness)
        .is_some_and(|(target, likeness)| likeness < target.value());
    pilot.after_mesh(&ticket, fresh);
    let call = mesher.call(&refined);
    echoes.called = call.is_some();
    let brief = Brief { fresh, known: refined.fills, call };
    Ok(Meshed { ticket, frame, mesh, brief })
}

/// What comes back from those frames for which there was a call.
struct Echoes {
    told: Receiver<Option<Echo>>,
    /// Whether there was one for the last frame.
    called: bool,
}

impl Echoes {
    /// The last frame's, once it is painted.
    fn last(&mut self) -> Option<Echo> {
        // When the painting has ended nobody will see this frame either.
        if std::mem::take(&mut self.called) { self.told.recv().ok().flatten() } else { None }
    }
}

/// Mean colours, and the picture.
fn fill(
    painter: &mut Painter,
    hop: Meshed,
    clock: &mut Clock,
    pilot: &Pilot,
    pool: &Pool,
    tell: &Sender<Option<Echo>>,
) -> Result<Painted> {
    let Meshed { mut ticket, frame, mesh, brief } = hop;
    let pilot = pilot.in_charge(ticket.rehearsal);
    pilot.before_painting(&mut ticket);
    let Ticket { orders, span, rehearsal, mut report, .. } = ticket;
    let rows = orders.detail.rows;
    let called = brief.call.is_some();
    let answer = |echo| {
        if called {
            // Who called waits for an answer; nobody listens any more where the run has ended.
            let _ = tell.send(echo);
        }
    };
    let painting = pool.work(|| {
        let paint = || Ok(painter.paint(&mesh, &frame, rows, brief, answer));
        clock.time(Stage::Rasterise, &mut report, paint)
    })?;
    pilot.after_painting(&report);
    let picture = Picture { frame: painting.frame, fills: painting.fills, span };
    Ok(Painted { rehearsal, report, picture, origin: Some(Origin { frame, mesh }) })
}

/// A thread called `name`. When it cannot be had, those that were begun end by themselves, because
/// their channels do.
fn spawn<'s, T: Send + 's>(
    scope: &'s Scope<'s, '_>,
    name: &str,
    job: impl FnOnce() -> T + Send + 's,
) -> Result<ScopedJoinHandle<'s, T>> {
    thread::Builder::new()
        .name(name.to_owned())
        .spawn_scoped(scope, job)
        .map_err(|error| Error::usage(format!("the {name} thread cannot be had: {error}")))
}

/// What the thread returned; its panic goes on here.
fn resume<T>(handle: ScopedJoinHandle<'_, T>) -> T {
    handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
