//! Whole files: the program's `render`, with sound, variable rate and transparency.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{Sender, bounded};
use polyreel::pipeline::{InputReport, OutputReport};
use polyreel::program::embed::{self, Control, Watcher};
use polyreel::{
    Buffers, Ending, Error, FrameReport, Needs, Origin, Picture, Sink, SourceOptions, StreamInfo,
    Summary,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::away::{self, away};
use crate::error::{PolyreelError, fault, raise};
use crate::options::command_line;
use crate::picture::{Kind, Packed};
use crate::work::wait;

/// What is known of `source` before its frames are read, as JSON.
#[pyfunction]
pub(crate) fn probe(py: Python<'_>, source: PathBuf) -> PyResult<String> {
    let names = [source.into_os_string()];
    let input = away(py, || polyreel::open(&names, &SourceOptions::default())).map_err(raise)?;
    let report = InputReport::new(&names, input.info().clone());
    serde_json::to_string(&report).map_err(|error| PolyreelError::new_err(error.to_string()))
}

/// What a run tells while it goes on.
enum Event {
    Begins(Option<u64>),
    Frame(u64),
    Look(Packed),
    Warns(String),
    Ended(Ended),
}

/// What there is to say of a run that did not fail.
struct Ended {
    frames: u64,
    dropped: u64,
    seconds: f64,
    size: (u32, u32),
    truncated: Option<String>,
}

/// Sends what happens to the thread that Python is on, and waits until it takes it.
struct Teller {
    events: Sender<Event>,
    cancelled: Arc<AtomicBool>,
    shows: bool,
}

impl Teller {
    fn tell(&self, event: Event) -> ControlFlow<()> {
        match self.events.send(event) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    }
}

impl Watcher for Teller {
    fn begins(&mut self, info: &StreamInfo) {
        let _ = self.tell(Event::Begins(info.frames));
    }

    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        self.tell(Event::Frame(report.index + 1))
    }

    fn warns(&mut self, text: &str) {
        let _ = self.tell(Event::Warns(text.to_owned()));
    }

    fn taps(&mut self, sink: Box<dyn Sink>) -> Box<dyn Sink> {
        let looks = self.shows.then(|| self.events.clone());
        Box::new(Tap { inner: sink, cancelled: self.cancelled.clone(), looks, last: None })
    }

    fn ended(&mut self, _: &StreamInfo, written: &OutputReport, summary: &Summary) {
        let truncated = match &summary.ending {
            Ending::Truncated(error) => Some(format!("{error}; the output holds what came before")),
            _ => None,
        };
        let _ = self.tell(Event::Ended(Ended {
            frames: summary.frames,
            dropped: summary.dropped,
            seconds: summary.wall.as_secs_f64(),
            size: (written.size.width, written.size.height),
            truncated,
        }));
    }
}

/// Between two pictures that are shown while a run goes on.
const PAUSE: Duration = Duration::from_millis(500);

/// A sink that is dropped unfinished when the run is cancelled, and whose pictures may be looked at.
struct Tap {
    inner: Box<dyn Sink>,
    cancelled: Arc<AtomicBool>,
    looks: Option<Sender<Event>>,
    last: Option<Instant>,
}

impl Tap {
    fn check(&self) -> polyreel::Result<()> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Error::Closed) } else { Ok(()) }
    }

    fn look(&mut self, picture: &Picture) {
        let Some(looks) = &self.looks else { return };
        // Sinks that hold facets get no pixels.
        let is_due = self.last.is_none_or(|last| last.elapsed() >= PAUSE);
        if is_due && !self.inner.needs().plain {
            self.last = Some(Instant::now());
            let packed = Packed::of(&picture.frame, Kind::RGB);
            // Nobody may listen any more.
            let _ = looks.send(Event::Look(packed));
        }
    }
}

impl Sink for Tap {
    fn needs(&self) -> Needs {
        self.inner.needs()
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> polyreel::Result<Buffers> {
        self.check()?;
        self.look(&picture);
        self.inner.write(picture, origin)
    }

    fn finish(self: Box<Self>) -> polyreel::Result<()> {
        self.check()?;
        self.inner.finish()
    }

    fn warnings(&self) -> &[String] {
        self.inner.warnings()
    }
}

/// The runs that are under way and their processes' numbers, so that the interpreter's end is theirs. A process that
/// was forked has its parent's list.
static RUNS: Mutex<Vec<(u32, Control)>> = Mutex::new(Vec::new());

/// A run in the list.
struct Listed(Control);

impl Listed {
    fn new(control: Control) -> Self {
        let entry = (process::id(), control.clone());
        RUNS.lock().unwrap_or_else(PoisonError::into_inner).push(entry);
        Self(control)
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        let mut runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
        runs.retain(|(_, run)| run.processes != self.0.processes);
    }
}

/// Ends all runs of this process and the programs that they have started, and removes what they have not finished. For
/// the interpreter's end.
#[pyfunction]
pub(crate) fn end_all(py: Python<'_>) {
    away::end(py);
    let runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
    for (_, run) in runs.iter().filter(|(process, _)| *process == process::id()) {
        run.stop.request();
        run.processes.end_all();
        run.unfinished.remove_all();
    }
}

/// The process that rendered a file first: its threads are not in the processes that are forked from it.
static FIRST: AtomicU32 = AtomicU32::new(0);

fn refuse_fork() -> PyResult<()> {
    let me = process::id();
    match FIRST.compare_exchange(0, me, Ordering::SeqCst, Ordering::SeqCst) {
        Err(first) if first != me => Err(PolyreelError::new_err(
            "this process was forked from one that had rendered a file, and lacks its threads: begin processes \
             with multiprocessing.get_context('spawn')",
        )),
        _ => Ok(()),
    }
}

/// Renders the files `sources` to `destination`; see `polyreel.render_file`.
#[pyfunction]
pub(crate) fn render_file<'py>(
    py: Python<'py>,
    sources: Vec<PathBuf>,
    destination: PathBuf,
    progress: Option<Bound<'py, PyAny>>,
    preview: Option<Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut line = command_line(options, false)?;
    let mut output = OsString::from("--output=");
    output.push(destination);
    line.extend([output, "--".into()]);
    line.extend(sources.into_iter().map(PathBuf::into_os_string));
    refuse_fork()?;

    let (events_in, events) = bounded(1);
    let cancelled = Arc::<AtomicBool>::default();
    let mut teller =
        Teller { events: events_in, cancelled: cancelled.clone(), shows: preview.is_some() };
    let listed = Listed::new(Control::default());
    let control = listed.0.clone();
    let thread = thread::Builder::new()
        .name("polyreel".into())
        .spawn(move || embed::render(&line, &control, &mut teller))
        .map_err(|error| PolyreelError::new_err(format!("a thread cannot be had: {error}")))?;
    let mut listener = Listener::new(progress, preview);
    let heard = loop {
        match wait(py, &events) {
            Ok(Some(event)) => match listener.hear(py, event) {
                Ok(()) => {}
                Err(error) => break Err(error),
            },
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    if heard.is_err() {
        cancelled.store(true, Ordering::Relaxed);
        listed.0.stop.request();
        listed.0.processes.end_all();
    }
    drop(events);
    let ended = away(py, || thread.join());
    heard?;
    ended.map_err(|_| fault())?.map_err(raise)?;
    listener.report(py)
}

/// Calls back to Python.
struct Listener<'py> {
    progress: Option<Bound<'py, PyAny>>,
    preview: Option<Bound<'py, PyAny>>,
    frames: Option<u64>,
    warnings: Vec<String>,
    ended: Option<Ended>,
}

impl<'py> Listener<'py> {
    fn new(progress: Option<Bound<'py, PyAny>>, preview: Option<Bound<'py, PyAny>>) -> Self {
        Self { progress, preview, frames: None, warnings: Vec::new(), ended: None }
    }

    fn hear(&mut self, py: Python<'py>, event: Event) -> PyResult<()> {
        match event {
            Event::Begins(frames) => self.frames = frames,
            Event::Warns(text) => self.warnings.push(text),
            Event::Frame(done) => {
                if let Some(progress) = &self.progress {
                    progress.call1((done, self.frames))?;
                }
                py.check_signals()?;
            }
            Event::Look(picture) => {
                if let Some(preview) = &self.preview {
                    preview.call1((picture.array(py),))?;
                }
            }
            Event::Ended(mut ended) => {
                self.warnings.extend(ended.truncated.take());
                self.ended = Some(ended);
            }
        }
        Ok(())
    }

    fn report(self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let ended = self.ended.ok_or_else(fault)?;
        let dict = PyDict::new(py);
        dict.set_item("frames", ended.frames)?;
        dict.set_item("dropped", ended.dropped)?;
        dict.set_item("seconds", ended.seconds)?;
        dict.set_item("size", ended.size)?;
        dict.set_item("warnings", self.warnings)?;
        Ok(dict)
    }
}
