//! Records the shown pictures: from one press of a key to the next.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use polyreel::error::{Error, Result};
use polyreel::frame::Rational;
use polyreel::sink::{self, Picture, Sink, SinkOptions};
use polyreel::stream::{Span, StreamInfo};

use super::name::free;

/// Duration of a picture of unknown duration.
const UNKNOWN: Rational = Rational { num: 1, den: 25 };

/// Steps between pictures above this number of seconds are jumps, not dropped frames.
const JUMP: Rational = Rational { num: 1, den: 1 };

/// A recording in progress.
struct Tape {
    name: String,
    sink: Box<dyn Sink>,
    /// The last picture, its time in the stream, and its time in the recording.
    last: Option<(Span, Rational)>,
    pictures: u64,
}

/// Writes pictures to a file while there is a recording.
pub(super) struct Recorder {
    info: StreamInfo,
    options: SinkOptions,
    stem: String,
    tape: Mutex<Option<Tape>>,
    /// Recordings that are being completed.
    finishing: Mutex<Vec<JoinHandle<String>>>,
}

impl Recorder {
    /// Records a stream of `info` to files called after `stem`.
    pub(super) fn new(info: &StreamInfo, options: SinkOptions, stem: &str) -> Self {
        // The length is unknown, and there is no sound.
        let info = StreamInfo {
            frames: None,
            duration: None,
            audio: None,
            still: false,
            live: false,
            ..info.clone()
        };
        let (tape, finishing) = (Mutex::default(), Mutex::default());
        Self { info, options, stem: stem.to_owned(), tape, finishing }
    }

    fn tape(&self) -> MutexGuard<'_, Option<Tape>> {
        self.tape.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether there is a recording.
    pub(super) fn is_on(&self) -> bool {
        self.tape().is_some()
    }

    /// Starts a recording, or ends the current one. Returns a note for the user.
    pub(super) fn toggle(&self) -> String {
        let ended = self.tape().take();
        if let Some(tape) = ended {
            // Completing a video takes a moment: it has its own thread, so that neither the window nor the pipeline
            // waits.
            let name = tape.name.clone();
            let done = move || finish(tape);
            match thread::Builder::new().name("finish".to_owned()).spawn(done) {
                Ok(thread) => self.finishing().push(thread),
                Err(error) => return format!("{name} cannot be completed: {error}"),
            }
            return format!("completing {name}");
        }
        match self.start() {
            Ok(tape) => {
                let note = format!("recording to {}", tape.name);
                *self.tape() = Some(tape);
                note
            }
            Err(error) => error.to_string(),
        }
    }

    fn finishing(&self) -> MutexGuard<'_, Vec<JoinHandle<String>>> {
        self.finishing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A video where there is an ffmpeg, else a GIF.
    fn start(&self) -> Result<Tape> {
        let named = |extension: &str| {
            let name = free(&format!("{}-recording", self.stem), extension);
            let sink = sink::create(&name, &self.info, &self.options)?;
            Ok(Tape { name, sink, last: None, pictures: 0 })
        };
        named("mp4").or_else(|_: Error| named("gif"))
    }

    /// Adds a picture, if there is a recording. One that fails ends the recording.
    pub(super) fn write(&self, picture: &Picture) {
        let mut slot = self.tape();
        let Some(tape) = slot.as_mut() else { return };
        let start = tape.last.map_or(Rational::ZERO, |(last, at)| at + step(&last, &picture.span));
        tape.last = Some((picture.span, start));
        tape.pictures += 1;
        let span = Span { start, ..picture.span };
        if let Err(error) = tape.sink.write(Picture { span, ..picture.clone() }, None) {
            crate::program::terminal::warn(format_args!("the recording ends: {error}"));
            *slot = None;
        }
    }

    /// The results of recordings that were completed.
    pub(super) fn finished(&self) -> Option<String> {
        let mut finishing = self.finishing();
        let done = finishing.iter().position(JoinHandle::is_finished)?;
        let thread = finishing.swap_remove(done);
        drop(finishing);
        Some(thread.join().unwrap_or_else(|_| "the recording could not be completed".to_owned()))
    }

    /// Completes all recordings, and returns the results.
    pub(super) fn close(&self) -> Vec<String> {
        let last = self.tape().take().map(finish);
        let threads = std::mem::take(&mut *self.finishing());
        threads.into_iter().filter_map(|thread| thread.join().ok()).chain(last).collect()
    }
}

fn finish(tape: Tape) -> String {
    let Tape { name, sink, pictures, .. } = tape;
    if pictures == 0 {
        return "nothing was recorded".to_owned();
    }
    match sink.finish() {
        Ok(()) if pictures == 1 => format!("{name}: 1 picture"),
        Ok(()) => format!("{name}: {pictures} pictures"),
        Err(error) => error.to_string(),
    }
}

/// From the picture of `last` to that of `next` in a recording: as far as they lie apart in the stream,
/// which may be more than a frame, where some were left out; where the stream has jumped or stood
/// still, one frame.
fn step(last: &Span, next: &Span) -> Rational {
    let apart = next.start - last.start;
    if apart > Rational::ZERO && apart < JUMP {
        return apart;
    }
    last.length.filter(|&length| length > Rational::ZERO).unwrap_or(UNKNOWN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_knows_no_jumps() {
        let span = |start: i64| Span {
            start: Rational::new(start, 24),
            length: Some(Rational::new(1, 24)),
        };
        let frame = Rational::new(1, 24);
        assert_eq!(step(&span(5), &span(6)), frame);
        assert_eq!(step(&span(5), &span(8)), Rational::new(3, 24), "two were left out");
        assert_eq!(step(&span(119), &span(0)), frame, "a new round");
        assert_eq!(step(&span(5), &span(5)), frame, "once more");
        assert_eq!(step(&span(5), &span(125)), frame, "a jump");
        let unknown = Span { start: Rational::ZERO, length: None };
        assert_eq!(step(&unknown, &unknown), UNKNOWN);
    }
}
