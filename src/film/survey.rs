//! The pass over a film that a plan is made from: decode, hash, detect changes. No mesh is made.

use std::thread;

use crossbeam_channel::{Receiver, Sender, bounded};

use super::hash::{self, Hash, ShotHasher};
use super::plan::{Begins, Chunk, Shot};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::feature::change::{Change, Watcher};
use crate::frame::{Frame, Rational};
use crate::options::{Detail, Options, Points};
use crate::pipeline::Stop;
use crate::source::{Decoded, Input};
use crate::stream::Span;

/// Frames that wait between decoding and detection.
const CAPACITY: usize = 2;

/// How a film is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Division {
    /// The most frames of a chunk, unless it is one shot that has more.
    pub max_frames: u64,
    /// Frames that are rendered before a piece of a shot that is split; `None` leaves shots whole.
    pub warm_up: Option<u64>,
}

/// What a pass over a film finds.
#[derive(Debug)]
pub struct Survey {
    /// The number of frames.
    pub frames: u64,
    /// The options, with the number of points found.
    pub options: Options,
    /// The shots.
    pub shots: Vec<Shot>,
    /// What cut the film short, where that is allowed.
    pub truncated: Option<Error>,
}

/// Looks through `input`, whose frames will be rendered by `options`. Calls `seen` after every frame.
///
/// # Errors
/// When it cannot be read; where `allow_truncated` says so, only if there is no frame. [`Error::NoFrames`]
/// when there is none. When the number of points that `auto` asks for cannot be found.
pub fn survey(
    input: Input,
    options: &Options,
    division: Division,
    allow_truncated: bool,
    stop: &Stop,
    seen: &mut dyn FnMut(),
) -> Result<Survey> {
    thread::scope(|scope| {
        let (frame_tx, frame_rx) = bounded(CAPACITY);
        let (back_tx, back_rx) = bounded(CAPACITY);
        let decode = thread::Builder::new().name("decode".into());
        decode
            .spawn_scoped(scope, move || {
                if let Err(error) = decode_all(input, &frame_tx, &back_rx, stop) {
                    // The receiver is gone where the pass has ended.
                    let _ = frame_tx.send(Err(error));
                }
            })
            .map_err(|error| Error::thread("decode", error))?;
        let mut shots = Shots::new(options, division);
        let mut truncated = None;
        for hop in frame_rx {
            match hop {
                Ok((decoded, hash)) => {
                    let Decoded { frame, span, .. } = decoded;
                    shots.add(&frame, span, &hash)?;
                    // Where there is no room enough are on their way.
                    let _ = back_tx.try_send(frame);
                    seen();
                }
                Err(error) if allow_truncated && shots.frames > 0 && error.breaks_off() => {
                    truncated = Some(error);
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        shots.end(truncated)
    })
}

type Hop = Result<(Decoded, Hash)>;

/// Reads all frames, and hashes them.
fn decode_all(
    input: Input,
    frames: &Sender<Hop>,
    back: &Receiver<Frame>,
    stop: &Stop,
) -> Result<()> {
    let mut source = input.start()?;
    while !stop.is_requested() {
        if let Ok(frame) = back.try_recv() {
            source.recycle(frame);
        }
        let Some(decoded) = source.next()? else { break };
        let hash = hash::of_frame(&decoded);
        if frames.send(Ok((decoded, hash))).is_err() {
            break;
        }
    }
    Ok(())
}

/// Collects shots, frame by frame.
struct Shots {
    options: Options,
    division: Division,
    watcher: Watcher,
    hasher: ShotHasher,
    frames: u64,
    done: Vec<Shot>,
    open: Option<Shot>,
    /// When the last frame ends.
    end: Option<Rational>,
}

impl Shots {
    fn new(options: &Options, division: Division) -> Self {
        Self {
            options: options.clone(),
            division,
            watcher: Watcher::default(),
            hasher: ShotHasher::default(),
            frames: 0,
            done: Vec::new(),
            open: None,
            end: None,
        }
    }

    fn add(&mut self, frame: &Frame, span: Span, hash: &Hash) -> Result<()> {
        // Without an error to reach, each shot finds its own.
        let is_one = self.options.points == Points::Auto && self.options.error.is_some();
        if self.frames == 0 && is_one {
            self.options.points = points_of(&self.options, frame)?;
        }
        if let Some(begins) = self.begins(frame) {
            self.close(Some(span.start));
            let (first, start, end) = (self.frames, span.start, None);
            self.open = Some(Shot { first, frames: 0, start, end, begins, hash: String::new() });
        }
        if let Some(shot) = &mut self.open {
            shot.frames += 1;
        }
        self.hasher.add(hash);
        self.frames += 1;
        self.end = span.length.map(|length| span.start + length);
        Ok(())
    }

    /// Why a shot begins with `frame`, if one does.
    fn begins(&mut self, frame: &Frame) -> Option<Begins> {
        let is_full =
            self.open.as_ref().is_some_and(|shot| shot.frames >= self.division.max_frames);
        if self.options.coherence == 0.0 {
            return (is_full || self.open.is_none()).then_some(Begins::Alone);
        }
        match self.watcher.watch(frame) {
            Change::Cut => Some(Begins::Cut),
            Change::FadeIn => Some(Begins::FadeIn),
            Change::Continues(_) => {
                (is_full && self.division.warm_up.is_some()).then_some(Begins::Split)
            }
        }
    }

    fn close(&mut self, end: Option<Rational>) {
        if let Some(shot) = self.open.take() {
            let hash = self.hasher.take();
            self.done.push(Shot { end, hash, ..shot });
        }
    }

    fn end(mut self, truncated: Option<Error>) -> Result<Survey> {
        if self.frames == 0 {
            return Err(Error::NoFrames);
        }
        self.close(self.end);
        let Self { options, frames, done, .. } = self;
        Ok(Survey { frames, options, shots: done, truncated })
    }
}

/// The number of points that `auto` finds on the film's first `frame`.
fn points_of(options: &Options, frame: &Frame) -> Result<Points> {
    let mut chain = Chain::new(options)?;
    chain.run(frame, &Detail::FULL, &mut ())?;
    Ok(chain.options().points)
}

/// Divides `shots` among chunks of whole shots. Those that are split, or of frames alone, have chunks of their own.
pub fn chunks_of(shots: &[Shot], division: Division) -> Vec<Chunk> {
    let mut chunks: Vec<Chunk> = Vec::new();
    for (number, shot) in shots.iter().enumerate() {
        let (warm_up, exact) = match shot.begins {
            Begins::Cut | Begins::FadeIn => (0, true),
            // Frames after the first have fewer steps than that.
            Begins::Alone => (1, true),
            Begins::Split => (division.warm_up.unwrap_or(0), false),
        };
        let warm_up = warm_up.min(shot.first);
        if let Some(last) = chunks.last_mut()
            && (warm_up, last.warm_up) == (0, 0)
            && last.frames + shot.frames <= division.max_frames
        {
            last.frames += shot.frames;
            last.shots.1 += 1;
            continue;
        }
        let (chunk, shots) = (chunks.len(), (number, 1));
        let (first, frames) = (shot.first, shot.frames);
        chunks.push(Chunk { chunk, first, frames, shots, warm_up, exact });
    }
    chunks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shots(lengths: &[(u64, Begins)]) -> Vec<Shot> {
        let mut first = 0;
        let shot = |&(frames, begins): &(u64, Begins)| {
            let shot = Shot {
                first,
                frames,
                start: Rational::new(first as i64, 25),
                end: None,
                begins,
                hash: String::new(),
            };
            first += frames;
            shot
        };
        lengths.iter().map(shot).collect()
    }

    #[test]
    fn chunks_hold_whole_shots() {
        let all = shots(&[30, 50, 40, 300, 20].map(|frames| (frames, Begins::Cut)));
        let whole = Division { max_frames: 100, warm_up: None };
        let chunks = chunks_of(&all, whole);
        let bounds: Vec<_> = chunks.iter().map(|c| (c.first, c.frames, c.shots)).collect();
        assert_eq!(
            bounds,
            [(0, 80, (0, 2)), (80, 40, (2, 1)), (120, 300, (3, 1)), (420, 20, (4, 1))]
        );
        assert!(chunks.iter().all(|chunk| chunk.exact && chunk.warm_up == 0));
    }

    #[test]
    fn pieces_of_a_shot_stand_alone_with_their_warm_up() {
        let split = Division { max_frames: 100, warm_up: Some(12) };
        let cut = (100, Begins::Cut);
        let all = shots(&[
            cut,
            (100, Begins::Split),
            (5, Begins::Split),
            (20, Begins::Cut),
            (9, Begins::Cut),
        ]);
        let chunks = chunks_of(&all, split);
        let kinds: Vec<_> = chunks.iter().map(|c| (c.frames, c.warm_up, c.exact)).collect();
        assert_eq!(kinds, [(100, 0, true), (100, 12, false), (5, 12, false), (29, 0, true)]);
        let alone = shots(&[(100, Begins::Alone), (100, Begins::Alone)]);
        let chunks = chunks_of(&alone, Division { max_frames: 100, warm_up: None });
        let kinds: Vec<_> = chunks.iter().map(|c| (c.warm_up, c.exact)).collect();
        assert_eq!(kinds, [(0, true), (1, true)]);
    }
}
