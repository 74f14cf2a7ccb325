//! The frames of one chunk.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::hash::{self, ShotHasher};
use super::plan::{Chunk, Plan, Shot};
use crate::error::{Error, Result};
use crate::frame::{Frame, Rational};
use crate::source::{Decoded, Input, Source};

/// How the frames of a chunk are found.
#[derive(Clone, Debug, PartialEq)]
struct Extent {
    /// The last shot that begins with the first frame or before: its number and its time.
    anchor: (u64, Rational),
    /// The number of the first frame, one of the warm-up perhaps.
    first: u64,
    warm_up: u64,
    shots: Vec<Shot>,
}

/// Where a source is sought, and whether what came of it was another film.
#[derive(Clone, Debug, Default)]
pub struct Seek {
    /// The film is read from its beginning.
    pub from_start: bool,
    /// Frames were others than planned, and the film was not read from its beginning: then it has to be.
    pub missed: Arc<AtomicBool>,
}

/// Frames of a chunk, those of its warm-up first. They are counted from the film's first frame, or from a shot that
/// is found by its time; and compared with the plan, shot by shot.
pub struct Range {
    inner: Box<dyn Source>,
    extent: Extent,
    seek: Seek,
    /// Frames that are passed over before the first.
    passed: u64,
    warmed: u64,
    hasher: ShotHasher,
    /// The shot that is read, and how many frames of it have been.
    shot: usize,
    read: u64,
}

impl Range {
    /// The frames of `chunk` of the film `input`.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(mut input: Input, plan: &Plan, chunk: &Chunk, seek: &Seek) -> Result<Self> {
        let extent = Extent::of(plan, chunk);
        let mut seek = seek.clone();
        let mut inner = input.restart()?;
        let (mut passed, mut found) = (extent.first, None);
        if !seek.from_start {
            inner.skip_to(extent.anchor.1);
            found = at_time(&mut *inner, extent.anchor.1)?;
            if found.is_none() {
                // Not a frame has gone through the chain yet.
                (seek.from_start, inner) = (true, input.restart()?);
            }
        }
        if found.is_some() {
            passed = extent.first - extent.anchor.0;
        }
        let ahead = Ahead { first: found, inner };
        Ok(Self {
            inner: Box::new(ahead),
            extent,
            seek,
            passed,
            warmed: 0,
            hasher: ShotHasher::default(),
            shot: 0,
            read: 0,
        })
    }

    /// Takes `decoded` into account, which is no warm-up.
    fn check(&mut self, decoded: &Decoded) -> Result<()> {
        self.hasher.add(&hash::of_frame(decoded));
        self.read += 1;
        let Some(shot) = self.extent.shots.get(self.shot) else { return Ok(()) };
        if self.read == shot.frames {
            (self.shot, self.read) = (self.shot + 1, 0);
            if self.hasher.take() != shot.hash {
                let from = shot.first;
                return Err(self.other(from));
            }
        }
        Ok(())
    }

    /// The error of a film that is not the one that was planned.
    fn other(&self, from: u64) -> Error {
        if !self.seek.from_start {
            self.seek.missed.store(true, Ordering::Relaxed);
        }
        Error::failed(format!(
            "the film is not the one that was planned, or this ffmpeg decodes it otherwise: frames from number \
             {from} on differ; plan it again"
        ))
    }
}

impl Extent {
    fn of(plan: &Plan, chunk: &Chunk) -> Self {
        let first = chunk.first - chunk.warm_up;
        let anchor = plan.shots.iter().rev().find(|shot| shot.first <= first);
        let anchor = anchor.map_or((0, Rational::ZERO), |shot| (shot.first, shot.start));
        Self { anchor, first, warm_up: chunk.warm_up, shots: plan.shots_of(chunk).to_vec() }
    }
}

/// The frame of `source` that starts at `time`, all before it passed over; `None` if there is none.
fn at_time(source: &mut dyn Source, time: Rational) -> Result<Option<Decoded>> {
    loop {
        match source.next()? {
            Some(decoded) if decoded.span.start < time => source.recycle(decoded.frame),
            Some(decoded) if decoded.span.start == time => return Ok(Some(decoded)),
            _ => return Ok(None),
        }
    }
}

impl Source for Range {
    fn next(&mut self) -> Result<Option<Decoded>> {
        if self.shot == self.extent.shots.len() {
            return Ok(None);
        }
        while self.passed > 0 {
            let Some(decoded) = self.inner.next()? else {
                return Err(self.other(self.extent.first));
            };
            self.inner.recycle(decoded.frame);
            self.passed -= 1;
        }
        let Some(mut decoded) = self.inner.next()? else {
            let shot = &self.extent.shots[self.shot];
            return Err(self.other(shot.first));
        };
        if self.warmed < self.extent.warm_up {
            self.warmed += 1;
            decoded.is_warmup = true;
            return Ok(Some(decoded));
        }
        self.check(&decoded)?;
        Ok(Some(decoded))
    }

    fn recycle(&mut self, frame: Frame) {
        self.inner.recycle(frame);
    }
}

/// A source of which a frame has been taken already.
struct Ahead {
    first: Option<Decoded>,
    inner: Box<dyn Source>,
}

impl Source for Ahead {
    fn next(&mut self) -> Result<Option<Decoded>> {
        match self.first.take() {
            Some(decoded) => Ok(Some(decoded)),
            None => self.inner.next(),
        }
    }

    fn recycle(&mut self, frame: Frame) {
        self.inner.recycle(frame);
    }
}
