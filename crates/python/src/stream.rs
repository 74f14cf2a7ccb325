//! A stream of frames on the pipeline's threads.

use std::ops::ControlFlow;
use std::sync::PoisonError;
use std::thread::{self, JoinHandle};

use crossbeam_channel::{Receiver, Sender, TrySendError, bounded, unbounded};
use polyreel::{
    Buffers, Controls, Decoded, Frame, FrameReport, Observer, Origin, Picture, Rational, Rgba,
    Settings, Sink, Size, Source, Span, Stop, Summary,
};
use pyo3::prelude::*;
use pyo3::types::PyIterator;

use crate::away::away;
use crate::error::{PolyreelError, UsageError, fault, raise};
use crate::picture::{self, Kind, Packed};
use crate::renderer::{LastStats, Stats};
use crate::work::wait;

/// A frame, and what it is to be given back as.
type Given = (Frame, Kind);

/// Frames that come through a channel.
struct Incoming {
    frames: Receiver<Given>,
    kinds: Sender<Kind>,
    spare: Sender<Vec<Rgba>>,
    number: i64,
}

impl Source for Incoming {
    fn next(&mut self) -> polyreel::Result<Option<Decoded>> {
        let Ok((frame, kind)) = self.frames.recv() else { return Ok(None) };
        // If nobody takes it the run has ended.
        let _ = self.kinds.send(kind);
        let start = Rational::new(self.number, 25);
        self.number += 1;
        Ok(Some(Decoded::new(frame, Span { start, length: Some(Rational::new(1, 25)) })))
    }

    fn recycle(&mut self, frame: Frame) {
        // Where there is no room there is memory enough.
        let _ = self.spare.try_send(frame.into_pixels());
    }
}

/// Pictures that leave through a channel.
struct Outgoing {
    pictures: Sender<Packed>,
    kinds: Receiver<Kind>,
}

impl Sink for Outgoing {
    fn write(&mut self, picture: Picture, _: Option<Origin>) -> polyreel::Result<Buffers> {
        let kind = self.kinds.recv().map_err(|_| polyreel::Error::Closed)?;
        let packed = Packed::of(&picture.frame, kind);
        self.pictures.send(packed).map_err(|_| polyreel::Error::Closed)?;
        Ok(picture.frame.into_buffers())
    }

    fn finish(self: Box<Self>) -> polyreel::Result<()> {
        Ok(())
    }
}

/// Sends the figures of every frame after its picture.
struct Reports(Sender<Stats>);

impl Observer for Reports {
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        match self.0.send(Stats::of(report)) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    }
}

/// The threads that render.
struct Running {
    frames: Option<Sender<Given>>,
    spare: Receiver<Vec<Rgba>>,
    pictures: Receiver<Packed>,
    stats: Receiver<Stats>,
    thread: Option<JoinHandle<polyreel::Result<Summary>>>,
    stop: Stop,
}

impl Running {
    fn start(controls: Controls) -> PyResult<Self> {
        let (frames, incoming) = bounded(1);
        let (outgoing, pictures) = bounded(1);
        let (spare_in, spare) = bounded(2);
        let (stats_in, stats) = bounded(2);
        // No more wait in it than there are frames in the pipeline.
        let (kinds_in, kinds) = unbounded();
        let stop = Stop::default();
        let mine = stop.clone();
        let work = move || {
            let settings = Settings { controls: Some(controls), ..Settings::default() };
            let source = Incoming { frames: incoming, kinds: kinds_in, spare: spare_in, number: 0 };
            let start = move || Ok(Box::new(source) as Box<dyn Source>);
            let sink = Box::new(Outgoing { pictures: outgoing, kinds });
            polyreel::run(start, sink, &settings, &mut Reports(stats_in), &mine)
        };
        let thread = thread::Builder::new()
            .name("polyreel".into())
            .spawn(work)
            .map_err(|error| PolyreelError::new_err(format!("a thread cannot be had: {error}")))?;
        Ok(Self { frames: Some(frames), spare, pictures, stats, thread: Some(thread), stop })
    }

    /// Waits for the threads to end, and says how.
    fn end(&mut self, py: Python<'_>) -> PyResult<()> {
        self.frames = None;
        let Some(thread) = self.thread.take() else { return Ok(()) };
        match away(py, || thread.join()) {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(raise(error)),
            Err(_) => Err(fault()),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.request();
        // Whoever waits for a channel goes on when its other end is gone.
        self.frames = None;
        (self.pictures, self.stats) = (bounded(0).1, bounded(0).1);
        if let Some(thread) = self.thread.take() {
            // How it ended does not matter any more.
            let _ = thread.join();
        }
    }
}

/// An iterator over rendered frames.
#[pyclass(module = "polyreel._polyreel")]
pub(crate) struct FrameStream {
    iterator: Option<Py<PyIterator>>,
    controls: Controls,
    stats: LastStats,
    running: Option<Running>,
    size: Option<Size>,
    /// A frame that has found no room yet.
    pending: Option<Given>,
}

impl FrameStream {
    pub(crate) fn new(iterator: Py<PyIterator>, controls: Controls, stats: LastStats) -> Self {
        let iterator = Some(iterator);
        Self { iterator, controls, stats, running: None, size: None, pending: None }
    }

    /// Takes the next frame from the iterator into `pending`, if there is one and no other waits.
    fn pull(&mut self, py: Python<'_>) -> PyResult<()> {
        let (Some(iterator), None) = (&self.iterator, &self.pending) else { return Ok(()) };
        let Some(item) = iterator.bind(py).clone().next() else {
            self.iterator = None;
            return Ok(());
        };
        let room = self.running.as_ref().and_then(|running| running.spare.try_recv().ok());
        let (frame, kind) = picture::frame(&item?, room.unwrap_or_default())?;
        let size = *self.size.get_or_insert(frame.size());
        if frame.size() != size {
            return Err(UsageError::new_err(format!(
                "frames of a stream have one size: the first is {size}, this one {}",
                frame.size()
            )));
        }
        self.pending = Some((frame, kind));
        Ok(())
    }

    /// Hands `pending` on. Returns whether there is room for more.
    fn push(&mut self) -> PyResult<bool> {
        let Some(given) = self.pending.take() else { return Ok(true) };
        let running = match &mut self.running {
            Some(running) => running,
            empty => empty.insert(Running::start(self.controls.clone())?),
        };
        let Some(frames) = &running.frames else { return Ok(true) };
        match frames.try_send(given) {
            Err(TrySendError::Full(given)) => {
                self.pending = Some(given);
                Ok(false)
            }
            // If the threads have ended, the channel of pictures tells.
            _ => Ok(true),
        }
    }

    fn advance(&mut self, py: Python<'_>) -> PyResult<Option<Packed>> {
        let mut is_full = false;
        while !is_full && (self.iterator.is_some() || self.pending.is_some()) {
            self.pull(py)?;
            is_full = !self.push()?;
            // One in, one out, once the threads are at work.
            if let Some(running) = &self.running
                && let Ok(picture) = running.pictures.try_recv()
            {
                return Ok(Some(picture));
            }
        }
        let Some(running) = &mut self.running else { return Ok(None) };
        if self.iterator.is_none() && self.pending.is_none() {
            running.frames = None;
        }
        match wait(py, &running.pictures)? {
            Some(picture) => Ok(Some(picture)),
            None => running.end(py).map(|()| None),
        }
    }

    /// Notes the figures of the frame whose picture has come.
    fn note(&self, py: Python<'_>) -> PyResult<()> {
        let Some(running) = &self.running else { return Ok(()) };
        if let Some(stats) = wait(py, &running.stats)? {
            *self.stats.lock().unwrap_or_else(PoisonError::into_inner) = Some(stats);
        }
        Ok(())
    }
}

#[pymethods]
impl FrameStream {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let outcome = self.advance(py);
        if !matches!(outcome, Ok(Some(_))) {
            self.close(py);
        }
        let Some(picture) = outcome? else { return Ok(None) };
        self.note(py)?;
        Ok(Some(picture.array(py)))
    }

    /// Ends the stream and its threads; frames under way are lost.
    fn close(&mut self, py: Python<'_>) {
        (self.iterator, self.pending) = (None, None);
        let running = self.running.take();
        away(py, || drop(running));
    }
}
