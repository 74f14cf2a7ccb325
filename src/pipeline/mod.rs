//! The chain on threads: decode, features, mesh, rasterise and encode work on successive frames at the
//! same time.
//!
//! ```text
//! decode -> features -> mesh (sample, triangulate, refine) -> rasterise -> encode -> the caller's observer
//! ```
//!
//! Every arrow is a channel with room for one frame, one producer and one consumer: frames stay in
//! order, and at most [`IN_FLIGHT`] of them exist at a time, however long the input is. Two things go back: the
//! [residual](crate::residual) of a painted frame, which the next frame's refinement waits for, and buffers to be
//! filled again. rayon works inside a frame; nothing waits for a channel inside its work.
//!
//! The stages are those of [`crate::chain`]; the pictures are those of [`crate::render::Renderer`], byte for
//! byte.

mod admission;
mod controls;
mod detail;
mod histogram;
mod hop;
mod pool;
mod repaint;
mod replay;
mod report;
mod sink_loop;
mod stages;
mod worker;

use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::bounded;

use crate::error::{Error, Result};
use crate::options::Options;
use crate::sink::Sink;
use crate::source::Source;
use crate::stage::Stage;

pub use admission::Stop;
use admission::{Admission, decode};
pub use controls::Controls;
pub use detail::DetailPolicy;
use detail::{DetailController, longest};
use histogram::{Histogram, StageHistograms};
pub use repaint::{Part, repaint};
pub use replay::Script;
pub use report::{
    BudgetReport, Ending, FrameReport, InputReport, OutputReport, Report, StageTimes, Summary,
};
use sink_loop::SinkLoop;
use stages::{Output, Stages, spawn_stages};
use worker::StageWorker;

/// The maximum number of frames that exist at a time: one in each of the five threads, one in each of the
/// four channels between them. The buffers of two more, painted already, may wait to be filled again.
pub const IN_FLIGHT: usize = 9;

/// The most threads that [`Settings::threads`] may ask for, for each of the three stages.
pub const MOST_THREADS: usize = 256;

/// Frames that wait in a channel.
const CAPACITY: usize = 1;

/// How to run, apart from what to render.
#[derive(Clone, Debug, Default)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Settings {
    /// How to render.
    pub options: Options,
    /// Options that may change during the run, in place of [`Settings::options`]. Default `None`: they
    /// stay. The sink [adapts](crate::sink::Needs::adapt) them when the run begins.
    pub controls: Option<Controls>,
    /// How the detail of frames is chosen. Default [`DetailPolicy::Options`].
    pub detail_policy: DetailPolicy,
    /// Threads that work inside a frame, for each of the three stages between decode and encode, the
    /// stage's own among them; `None` is a thread a core. Default `None`.
    pub threads: Option<NonZeroUsize>,
    /// Whether the source is live: frames that find no room are dropped, the newest is kept.
    /// Default `false`.
    pub live: bool,
    /// Whether an input that [breaks off](crate::Error::breaks_off) still gives an output, of the frames before.
    /// Default `false`.
    pub allow_truncated: bool,
}

/// Watches a run, on the thread that called [`run`].
pub trait Observer {
    /// A frame has been written. Called for every frame in order; the pipeline waits meanwhile once its
    /// channels are full. `Break` asks for a [`Stop`].
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()>;
}

/// The observer that ignores all reports.
impl Observer for () {
    fn frame_done(&mut self, _: &FrameReport) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Renders all frames of the source to the sink. `start` is called on the decoding thread. rayon keeps some
/// 30 KiB of every run for good (measured on two cores): use [`crate::render::Renderer`] for very many short
/// runs in one process.
///
/// # Errors
/// The first error in frame order, with the frame's number and the stage; the frames before it have
/// been written, but the sink is dropped unfinished. [`Error::Usage`] for options out of range, and for
/// an input without frames. That a reader closed the output is not an error, but [`Ending::Closed`].
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
    if settings.threads.is_some_and(|threads| threads.get() > MOST_THREADS) {
        return Err(Error::usage(format!("a stage can have 1 to {MOST_THREADS} threads")));
    }
    let controls = match &settings.controls {
        Some(controls) => controls.clone(),
        None => Controls::new(settings.options.clone())?,
    };
    let needs = sink.needs();
    let mut options = (*controls.options()).clone();
    needs.adapt(&mut options);
    controls.set(options)?;
    let controller = &DetailController::new(&settings.detail_policy);
    let began = Instant::now();
    let over = AtomicBool::new(false);
    let dropped = AtomicU64::new(0);
    let mut totals = Totals::new(settings.detail_policy.budget());
    let ending = thread::scope(|scope| {
        let end = End(&over);
        let (admit_tx, admit_rx) = bounded(CAPACITY);
        let (frame_tx, frame_rx) = bounded(CAPACITY);
        let (buffer_tx, buffer_rx) = bounded(CAPACITY);
        let (report_tx, report_rx) = bounded(CAPACITY);
        let admission = Admission {
            controls: &controls,
            controller,
            stop,
            over: &over,
            queue: settings.live.then(|| admit_rx.clone()),
            frames: frame_rx,
            dropped: &dropped,
        };
        let worker = StageWorker::new(Stage::Decode, admit_tx);
        let decoding = spawn(scope, "decode", move || decode(start, worker, &admission))?;
        let frames = (!needs.origin).then_some(frame_tx);
        let output = Output { form: needs.form, frames, pictures: buffer_rx };
        let options = controls.options();
        let Stages { threads, painted } =
            spawn_stages(scope, admit_rx, &options, controller, settings.threads, output)?;
        let keep_truncated = settings.allow_truncated;
        let sink_loop =
            SinkLoop { sink, reports: report_tx, buffers: buffer_tx, stop, keep_truncated };
        let encoding = spawn(scope, "encode", move || sink_loop.run(painted))?;

        for report in report_rx {
            totals.add(&report);
            if observer.frame_done(&report).is_break() {
                stop.request();
            }
        }
        drop(end);
        for thread in threads.into_iter().chain([decoding]) {
            resume(thread);
        }
        resume(encoding)
    })?;
    Ok(totals.summary(dropped.into_inner(), began.elapsed(), ending))
}

/// The sums of a run, from the reports of its frames.
struct Totals {
    frames: u64,
    short: u64,
    faceless: u64,
    /// The lowest.
    likeness: Option<f64>,
    /// The time that each of the governed threads has for a frame.
    allowed: Option<Duration>,
    budget: BudgetReport,
    histograms: StageHistograms,
    /// Of live sources, the time that frames took.
    delays: Option<Histogram>,
}

impl Totals {
    fn new(allowed: Option<Duration>) -> Self {
        let (budget, histograms) = (BudgetReport::new(allowed), StageHistograms::new());
        Self {
            frames: 0,
            short: 0,
            faceless: 0,
            likeness: None,
            allowed,
            budget,
            histograms,
            delays: None,
        }
    }

    fn add(&mut self, report: &FrameReport) {
        self.frames += 1;
        self.short += u64::from(report.short);
        self.faceless += u64::from(report.faces == Some(0));
        if let Some(likeness) = report.likeness {
            self.likeness = Some(self.likeness.map_or(likeness, |least| least.min(likeness)));
        }
        self.histograms.add(&report.timing);
        if let Some(delay) = report.delay_ms {
            let delays = self.delays.get_or_insert_with(Histogram::new);
            delays.add(Duration::from_secs_f64(delay / 1e3));
        }
        let is_late = self.allowed.is_some_and(|allowed| longest(&report.timing) > allowed);
        self.budget.missed += u64::from(is_late);
        self.budget.changes += report.changes.len() as u64;
    }

    fn summary(self, dropped: u64, wall: Duration, ending: Ending) -> Summary {
        let Self { frames, short, faceless, likeness, budget, histograms, .. } = &self;
        let (frames, short, faceless) = (*frames, *short, *faceless);
        let (likeness, budget) = (*likeness, *budget);
        let stages = StageTimes(histograms.percentiles());
        let delay = self.delays.as_ref().map(Histogram::percentiles);
        Summary { frames, dropped, short, faceless, likeness, budget, delay, wall, stages, ending }
    }
}

/// Signals the decode stage that the run is over, however the caller's part of it ends.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Starts a thread called `name`. If that fails, threads that run already end by themselves, because their
/// channels are closed.
fn spawn<'s, T: Send + 's>(
    scope: &'s Scope<'s, '_>,
    name: &str,
    job: impl FnOnce() -> T + Send + 's,
) -> Result<ScopedJoinHandle<'s, T>> {
    thread::Builder::new()
        .name(name.to_owned())
        .spawn_scoped(scope, job)
        .map_err(|error| Error::thread(name, error))
}

/// Waits for the thread and returns its result; resumes its panic here.
fn resume<T>(handle: ScopedJoinHandle<'_, T>) -> T {
    handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
