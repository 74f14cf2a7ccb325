//! Runs of the pipeline with a stub source and a stub sink.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use polyreel::error::{Error, Result};
use polyreel::frame::{Buffers, Frame, Rational};
use polyreel::geom::Size;
use polyreel::options::{Options, Points};
use polyreel::pipeline::{FrameReport, Observer, Settings, Stop, Summary, run};
use polyreel::render::{Rendered, Renderer};
use polyreel::sink::{Origin, Picture, Sink};
use polyreel::source::{Decoded, Source};
use polyreel::stream::Span;

use crate::wait::until;

/// Frame `index` of an endless film: a disc that wanders over a gradient.
pub(super) fn frame(index: u64) -> Decoded {
    let size = Size::new(64, 48);
    let centre = (10.0 + 3.0 * index as f64 % 44.0, 24.0);
    let pixels = (0..size.pixels() as u32).map(|i| {
        let (x, y) = (i % size.width, i / size.width);
        if (f64::from(x) - centre.0).hypot(f64::from(y) - centre.1) < 9.0 {
            [200, 30, (y * 5) as u8, 255]
        } else {
            [(x * 3) as u8, (y * 4) as u8, 90, 255]
        }
    });
    let start = Rational::new(index as i64, 25);
    let frame = Frame::new(size, pixels.collect()).expect("a small frame");
    Decoded::new(frame, Span { start, length: Some(Rational::new(1, 25)) })
}

/// A failure at a frame.
#[derive(Clone, Copy)]
pub(super) enum Mishap {
    Error,
    Truncation,
    Corruption,
    Panic,
    Closed,
}

pub(super) fn happen(mishap: Mishap) -> Error {
    match mishap {
        Mishap::Error => Error::output("stub", "an invented error"),
        Mishap::Truncation => Error::input("stub", "an invented end").truncated(),
        Mishap::Corruption => Error::input("stub", "invented damage").corrupt(),
        Mishap::Panic => panic!("an invented panic"),
        Mishap::Closed => Error::Closed,
    }
}

/// Records of the stubs, for the test.
#[derive(Default)]
pub(super) struct Log {
    pub(super) decoded: AtomicU64,
    pub(super) recycled: Mutex<Vec<Frame>>,
    pub(super) most_in_flight: AtomicU64,
    pub(super) source_failed: AtomicBool,
    pub(super) pictures: Mutex<Vec<Picture>>,
    pub(super) finished: AtomicBool,
    pub(super) sink_dropped: AtomicBool,
}

impl Log {
    pub(super) fn written(&self) -> u64 {
        self.pictures.lock().expect("the lock").len() as u64
    }
}

struct StubSource {
    log: Arc<Log>,
    frames: u64,
    mishap: Option<(u64, Mishap)>,
    pace: Duration,
}

impl Source for StubSource {
    fn recycle(&mut self, frame: Frame) {
        self.log.recycled.lock().expect("the lock").push(frame);
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        std::thread::sleep(self.pace);
        let index = self.log.decoded.load(SeqCst);
        match self.mishap {
            Some((at, mishap)) if at == index => {
                self.log.source_failed.store(true, SeqCst);
                return Err(happen(mishap));
            }
            _ if index == self.frames => return Ok(None),
            _ => {}
        }
        let in_flight = self.log.decoded.fetch_add(1, SeqCst) + 1 - self.log.written();
        self.log.most_in_flight.fetch_max(in_flight, SeqCst);
        Ok(Some(frame(index)))
    }
}

pub(super) struct StubSink {
    pub(super) log: Arc<Log>,
    pub(super) mishap: Option<(u64, Mishap)>,
    pub(super) pace: Duration,
    /// Whether the failure waits for that of the source.
    pub(super) fails_last: bool,
}

impl Sink for StubSink {
    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        std::thread::sleep(self.pace);
        match self.mishap {
            Some((at, mishap)) if at == self.log.written() => {
                let source_failed = || self.log.source_failed.load(SeqCst).then_some(());
                if self.fails_last {
                    until("the source fails", source_failed);
                }
                Err(happen(mishap))
            }
            _ => {
                self.log.pictures.lock().expect("the lock").push(picture);
                Ok(Buffers::default())
            }
        }
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.log.finished.store(true, SeqCst);
        Ok(())
    }
}

impl Drop for StubSink {
    fn drop(&mut self) {
        self.log.sink_dropped.store(true, SeqCst);
    }
}

/// One run with stubs.
#[derive(Clone)]
pub(super) struct Trial {
    pub(super) frames: u64,
    pub(super) source: Option<(u64, Mishap)>,
    pub(super) sink: Option<(u64, Mishap)>,
    pub(super) source_pace: Duration,
    pub(super) sink_pace: Duration,
    pub(super) sink_fails_last: bool,
    pub(super) settings: Settings,
    pub(super) stop: Stop,
}

impl Default for Trial {
    fn default() -> Self {
        let options = Options { points: Points::Count(60), ..Options::default() };
        Self {
            frames: 12,
            source: None,
            sink: None,
            source_pace: Duration::ZERO,
            sink_pace: Duration::ZERO,
            sink_fails_last: false,
            settings: Settings { options, ..Settings::default() },
            stop: Stop::default(),
        }
    }
}

impl Trial {
    pub(super) fn run(&self, observer: &mut dyn Observer) -> (Result<Summary>, Arc<Log>) {
        let log = Arc::new(Log::default());
        (self.run_with(&log, observer), log)
    }

    pub(super) fn run_with(&self, log: &Arc<Log>, observer: &mut dyn Observer) -> Result<Summary> {
        let source = StubSource {
            log: log.clone(),
            frames: self.frames,
            mishap: self.source,
            pace: self.source_pace,
        };
        let sink = StubSink {
            log: log.clone(),
            mishap: self.sink,
            pace: self.sink_pace,
            fails_last: self.sink_fails_last,
        };
        let start = || Ok(Box::new(source) as Box<dyn Source>);
        let ended = run(start, Box::new(sink), &self.settings, observer, &self.stop);
        assert!(log.sink_dropped.load(SeqCst), "the sink outlived the run");
        ended
    }

    /// Runs a trial that panics: the panic's message, and the log.
    pub(super) fn panic(&self, observer: &mut dyn Observer) -> (String, Arc<Log>) {
        let log = Arc::new(Log::default());
        let caught = catch_unwind(AssertUnwindSafe(|| self.run_with(&log, observer)));
        let payload = caught.expect_err("the panic is resumed");
        (payload.downcast_ref::<&str>().expect("a message").to_string(), log)
    }
}

/// The pictures that the serial renderer makes of the first `frames` frames.
pub(super) fn oracle(options: &Options, frames: u64) -> Vec<Picture> {
    let mut renderer = Renderer::new(options).expect("sound options");
    (0..frames)
        .map(|index| {
            let Decoded { frame, span, .. } = frame(index);
            let Rendered { picture, mesh, .. } = renderer.render(&frame).expect("renders");
            Picture { frame: picture, fills: mesh.fills, span }
        })
        .collect()
}

/// Asserts that exactly the first `frames` frames were written, as the serial renderer makes them.
pub(super) fn assert_written(log: &Log, frames: u64) {
    let written = log.pictures.lock().expect("the lock");
    assert_eq!(written.len() as u64, frames);
    assert!(*written == oracle(&Trial::default().settings.options, frames), "pictures differ");
}

pub(super) fn finished(log: &Log) -> bool {
    log.finished.load(SeqCst)
}

/// Collects reports, and asks to stop after some.
#[derive(Default)]
pub(super) struct Watcher {
    pub(super) reports: Vec<FrameReport>,
    pub(super) stop_after: Option<usize>,
}

impl Observer for Watcher {
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        self.reports.push(report.clone());
        match self.stop_after {
            Some(n) if self.reports.len() >= n => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}
