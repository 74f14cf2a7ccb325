//! A decoder that is started before the video is known: it takes ffmpeg as long to start as ffprobe, and
//! the two can start together.
//!
//! It is asked for the first video track as it is. That is what is wanted of most videos; of others it is
//! dropped, once the headers are known, and the right decoder is started.

use std::io::BufReader;
use std::path::Path;
use std::process::ChildStdout;

use crate::ffmpeg::Pipe;
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command;
use crate::ffmpeg::nut::NutReader;
use crate::frame::Rational;
use crate::geom::Size;
use crate::source::decode;

/// What comes out of ffmpeg.
pub(crate) type Frames = NutReader<BufReader<Pipe<ChildStdout>>>;

/// Bytes that are read at once where little is wanted.
pub(crate) const BUFFER: usize = 1 << 16;

/// Names of files that are likely to be videos.
const VIDEOS: [&str; 5] = ["mp4", "m4v", "mov", "webm", "mkv"];

/// A decoder that was started in the hope that it will do.
pub(crate) struct Early(Child);

impl Early {
    /// Starts the decoder of the file `path`, where it looks like a video and ffmpeg can be started.
    pub(crate) fn start(path: &Path, ffmpeg: Option<&Path>) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        if !VIDEOS.contains(&ending.as_str()) {
            return None;
        }
        let program = command::ffmpeg_program(ffmpeg);
        Child::spawn(&program, &decode::first_track(path)).ok().map(Self)
    }

    /// The decoder and its frames, if they turn out to be of `size`, of `bytes` bytes each, with times
    /// that tell units of `time_base` exactly.
    pub(crate) fn frames(
        mut self,
        size: Size,
        bytes: usize,
        time_base: Rational,
    ) -> Option<(Child, Frames)> {
        let stdout = BufReader::with_capacity(BUFFER, self.0.stdout()?);
        let frames = NutReader::new(stdout, bytes).ok()?;
        // NUT's own units are a fraction of those that it was given.
        let units = time_base * frames.time_base().recip()?;
        (frames.size() == size && units.den == 1).then_some((self.0, frames))
    }
}
