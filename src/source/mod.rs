//! Where frames come from. One format a file; formats are recognised by content.

use std::path::PathBuf;

use crate::error::Result;
use crate::frame::{Frame, Rational, Span, StreamInfo};

/// A frame as it comes from a source.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    /// The picture, upright, at the stream's size.
    pub frame: Frame,
    /// When it is shown.
    pub span: Span,
}

/// A started source: frames in order. Lives on the thread that decodes, and need not be `Send`.
pub trait Source {
    /// The next frame, `None` at the end of a complete input. After an error or `None` it is not
    /// called again.
    ///
    /// # Errors
    /// When the input is truncated or broken; the frames before have been delivered.
    fn next(&mut self) -> Result<Option<Decoded>>;
}

/// What of an input is read, and how. The default reads all of it as it is.
#[derive(Clone, Debug, Default)]
pub struct SourceOptions {
    /// Seconds from the input's start: frames that start earlier are left out, and times count from
    /// here. Default: the beginning.
    pub start: Option<Rational>,
    /// Seconds from the input's start: frames that start then or later are left out. Default: none.
    pub end: Option<Rational>,
    /// At most this many frames. Default: all.
    pub frames: Option<u64>,
    /// Frames per second of a sequence of pictures. Default: [`SEQUENCE_RATE`].
    pub fps: Option<Rational>,
    /// Frames whose longest side is above this many pixels are shrunk to it. Default: never.
    pub max_size: Option<u32>,
    /// Whether an input that ends too early is taken as if it ended there. Default: it is an error,
    /// after the frames that could be read.
    pub allow_truncated: bool,
    /// The ffmpeg program that reads video. Default: the one that the system finds.
    pub ffmpeg: Option<PathBuf>,
}

/// Frames per second of a sequence of pictures that nobody gave a rate.
pub const SEQUENCE_RATE: Rational = Rational { num: 25, den: 1 };

/// Starts the decoder, on the thread that will use it.
pub(crate) type Starter = Box<dyn FnOnce() -> Result<Box<dyn Source>> + Send>;

/// An input that has been recognised and whose header has been read, not yet started. It is small
/// and can go to the thread that decodes.
pub struct Input {
    info: StreamInfo,
    start: Starter,
}

impl std::fmt::Debug for Input {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Input").field("info", &self.info).finish_non_exhaustive()
    }
}

impl Input {
    /// What the headers tell, with `start`, `end`, `frames` and `max_size` taken into account.
    pub fn info(&self) -> &StreamInfo {
        &self.info
    }

    /// Builds the decoder. Call it on the thread that will ask for frames.
    ///
    /// # Errors
    /// When the input cannot be opened (any more).
    pub fn start(self) -> Result<Box<dyn Source>> {
        (self.start)()
    }
}

/// Opens what `inputs` name: a file; several pictures, a folder of them, a glob, or a printf pattern
/// (`frame_%04d.png`), each of which makes a sequence; or `-` for y4m on standard input. Only
/// headers are read.
///
/// # Errors
/// When nothing is named, a file is missing, unreadable or not a picture, or frames differ in size.
pub fn open(inputs: &[String], options: &SourceOptions) -> Result<Input> {
    let _ = (inputs, options);
    Err(crate::error::Error::usage("not yet"))
}
