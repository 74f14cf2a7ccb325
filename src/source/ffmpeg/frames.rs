//! Reads the frames that ffmpeg decodes.

use std::io::{self, BufReader};
use std::process::ChildStdout;

use super::{Video, is_address};
use crate::colour::{Form, Planes, to_rgba};
use crate::error::{Error, Result};
use crate::ffmpeg::child::Child;
use crate::ffmpeg::nut::NutReader;
use crate::ffmpeg::probe::Pixels;
use crate::ffmpeg::{FfmpegError, Pipe};
use crate::frame::{Buffers, Frame, Rational};
use crate::source::{Decoded, Source};
use crate::stream::Span;

/// The output of ffmpeg.
type Frames = NutReader<BufReader<Pipe<ChildStdout>>>;

/// Bytes that are read at once where little is wanted.
const BUFFER: usize = 1 << 16;

/// A frame as it came through the pipe.
struct Raw {
    start: Rational,
    data: Vec<u8>,
}

/// A video being decoded. Dropping it ends ffmpeg.
pub struct VideoSource {
    video: Video,
    /// Where ffmpeg began, in seconds; 0 is the beginning.
    place: i64,
    /// The pipe until its headers are read.
    stdout: Option<BufReader<Pipe<ChildStdout>>>,
    reader: Option<Frames>,
    child: Child,
    /// The frame after the one last delivered: its time gives the duration of that one.
    ahead: Option<Raw>,
    spare: Vec<u8>,
    /// Buffers of a recycled frame.
    buffers: Buffers,
    /// The result when it has ended: the error, if any.
    outcome: Option<Result<(), FfmpegError>>,
    /// Frames before this time are skipped.
    from: Rational,
    delivered: u64,
    received: u64,
    last_start: Option<Rational>,
    /// The longest time between two frames.
    longest: Rational,
    /// Length of the frame before, at first of one at the nominal rate.
    length: Option<Rational>,
}

impl VideoSource {
    /// The frames that `child`, which decodes `video` from `place` on, writes to `stdout`.
    pub(super) fn new(video: Video, child: Child, stdout: Pipe<ChildStdout>, place: i64) -> Self {
        Self {
            length: video.probed.info.rate.and_then(Rational::recip),
            video,
            place,
            stdout: Some(BufReader::with_capacity(BUFFER, stdout)),
            reader: None,
            child,
            ahead: None,
            spare: Vec::new(),
            buffers: Buffers::default(),
            outcome: None,
            from: Rational::ZERO,
            delivered: 0,
            received: 0,
            last_start: None,
            longest: Rational::ZERO,
        }
    }

    /// Reads a frame off the pipe; at its end learns how ffmpeg fared.
    fn read(&mut self) -> Option<Raw> {
        if self.outcome.is_some() {
            return None;
        }
        let mut data = std::mem::take(&mut self.spare);
        let broken = match self.read_into(&mut data) {
            Ok(Some(start)) => {
                if let Some(before) = self.last_start.replace(start) {
                    self.longest = self.longest.max(start - before);
                }
                self.received += 1;
                return Some(Raw { start, data });
            }
            Ok(None) => None,
            Err(error) => Some(error),
        };
        // Only now that nothing is left in the pipe.
        (self.reader, self.stdout) = (None, None);
        self.outcome = Some(self.judge(broken));
        None
    }

    /// The first frame that is not skipped; skipped ones are not converted.
    fn wanted(&mut self) -> Option<Raw> {
        loop {
            let raw = self.read();
            let missed = match &raw {
                Some(raw) => self.received == 1 && raw.start > self.from,
                None => self.received == 0,
            };
            if self.place > 0 && missed {
                // There may have been one before, which is wanted.
                self.start_over();
                continue;
            }
            let raw = raw?;
            if raw.start >= self.from {
                return Some(raw);
            }
            self.spare = raw.data;
            // The number of frames that were not decoded is unknown.
            self.delivered += u64::from(self.place == 0);
        }
    }

    /// Restarts at the beginning.
    fn start_over(&mut self) {
        match self.video.start_at(0) {
            Ok(source) => *self = Self { from: self.from, ..source },
            Err(error) => (self.place, self.outcome) = (0, Some(Err(error))),
        }
    }

    fn read_into(&mut self, data: &mut Vec<u8>) -> io::Result<Option<Rational>> {
        if let Some(pipe) = self.stdout.take() {
            self.reader = Some(NutReader::new(
                pipe,
                self.video.probed.track.bytes(self.video.probed.info.size),
            )?);
        }
        let Some(reader) = &mut self.reader else { return Ok(None) };
        if reader.size() != self.video.probed.info.size {
            return Err(io::Error::other(format!("frames of {} arrived", reader.size())));
        }
        let pts = reader.next(data)?;
        Ok(pts.map(|pts| {
            let time = Rational::new(pts, 1) * reader.time_base();
            time - *self.video.probed.track.zero.get_or_insert(time)
        }))
    }

    /// Whether the end of the pipe was the end of the video. ffmpeg exits with 0 after most
    /// truncated and damaged inputs, but it complains.
    fn judge(&mut self, broken: Option<io::Error>) -> Result<(), FfmpegError> {
        let status = self
            .child
            .wait()
            .map_err(|error| FfmpegError::new(format!("ffmpeg: {error}")).caused_by(error))?;
        if !status.success() || self.child.complained() {
            return Err(self.child.failure(is_address(&self.video.path)));
        }
        match broken {
            Some(error) if self.received > 0 => {
                Err(FfmpegError::new(format!("its output cannot be read: {error}")))
            }
            // A stream without a header has no frame.
            Some(_) => Err(FfmpegError::new("not one frame could be decoded")
                .caused_by(io::ErrorKind::InvalidData)),
            None => self.check_promise(),
        }
    }

    /// Whether the frames reach the end that the container promises. ffmpeg takes some containers for
    /// complete wherever they end. A last frame that is held is no miss: only more than ten seconds,
    /// and more than twice any gap before, are missed, and only if frames are missing.
    fn check_promise(&self) -> Result<(), FfmpegError> {
        let (Some(end), Some(last)) = (self.video.probed.track.end, self.last_start) else {
            return Ok(());
        };
        // Where they were not counted from the first one it is left to ffmpeg to complain.
        let all = self
            .video
            .probed
            .info
            .frames
            .is_some_and(|frames| self.place > 0 || self.received >= frames);
        let slack = self.longest.max(Rational::new(5, 1)) * Rational::new(2, 1);
        if all || end - last <= slack {
            return Ok(());
        }
        let (last, end) = (last.to_f64(), end.to_f64());
        let words = format!("its last frame is at {last:.3} s of {end:.3} s");
        Err(FfmpegError::new(words).caused_by(io::ErrorKind::UnexpectedEof))
    }

    /// The error of a video that did not end well.
    fn failed(&self, error: FfmpegError) -> Error {
        let fault = if error.is_truncation() {
            "the video is cut short"
        } else if error.is_corruption() {
            "the video is damaged"
        } else {
            "ffmpeg failed"
        };
        let kept = self.delivered > 0 && (error.is_truncation() || error.is_corruption());
        let help = if kept { "; keep what can be read with --allow-truncated" } else { "" };
        let what = format!("{fault}: {error}{help}");
        Error::input_frame(&self.video.path, self.delivered, what).caused_by(error)
    }

    /// The frame in `data`, in the buffers of a recycled one.
    fn frame(&mut self, data: Vec<u8>) -> Result<Frame> {
        let Buffers { mut pixels, planes } = std::mem::take(&mut self.buffers);
        match self.video.probed.track.pixels {
            Pixels::Planar(layout, coding) if layout.is_squared() => {
                self.spare = planes;
                Ok(Frame::planar(Planes { form: Form { layout, coding }, data }, pixels)?)
            }
            Pixels::Planar(layout, coding) => {
                to_rgba(&layout, coding, &data, &mut pixels);
                self.spare = data;
                Ok(Frame::known(self.video.probed.info.size, pixels, !layout.alpha)?)
            }
            Pixels::Rgba => {
                pixels.clear();
                pixels.extend_from_slice(data.as_chunks::<4>().0);
                self.spare = data;
                Ok(Frame::new(self.video.probed.info.size, pixels)?)
            }
        }
    }

    /// How long the frame that starts at `start` is shown, and the last frame if there is no next.
    fn length(&self, start: Rational) -> Option<Rational> {
        if let Some(next) = &self.ahead {
            return Some(next.start - start);
        }
        match self.video.probed.track.end {
            Some(end) if end > start && matches!(self.outcome, Some(Ok(()))) => Some(end - start),
            _ => self.length,
        }
    }
}

impl Source for VideoSource {
    fn skip_to(&mut self, start: Rational) {
        self.from = start;
        let place = self.video.place(start);
        if self.received == 0
            && place != self.place
            && let Ok(source) = self.video.start_at(place)
        {
            *self = Self { from: start, ..source };
        }
    }

    fn recycle(&mut self, frame: Frame) {
        self.buffers = frame.into_buffers();
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        let Some(raw) = self.ahead.take().or_else(|| self.wanted()) else {
            return match self.outcome.take() {
                Some(Err(error)) => Err(self.failed(error)),
                _ => Ok(None),
            };
        };
        // A live input must not wait for the next frame.
        if !self.video.probed.info.live {
            self.ahead = self.read();
        }
        self.length = self.length(raw.start);
        let span = Span { start: raw.start, length: self.length };
        let frame = self.frame(raw.data)?;
        self.delivered += 1;
        Ok(Some(Decoded::new(frame, span)))
    }
}
