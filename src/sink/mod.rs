//! Where frames go. One format a file; unfinished outputs never stand under their final name.

use std::path::PathBuf;

use crate::error::Result;
use crate::frame::{Fill, Frame, Loops, Rgba, Span, StreamInfo};

/// A finished frame on its way to a sink.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The low-poly picture.
    pub frame: Frame,
    /// Every colour that `frame` holds: those of the triangles, and of outlines. One colour may stand
    /// several times; areas are weights (an outline hides parts of triangles).
    pub fills: Vec<Fill>,
    /// When it is shown.
    pub span: Span,
}

/// An output being written. Dropped before [`Sink::finish`], it leaves nothing behind.
pub trait Sink: Send {
    /// Takes the next picture. All have one size.
    ///
    /// # Errors
    /// When it cannot be written; [`crate::error::Error::Closed`] when the reader has gone.
    fn write(&mut self, picture: Picture) -> Result<()>;

    /// Completes the output and puts it in its place.
    ///
    /// # Errors
    /// When the last bytes cannot be written.
    fn finish(self: Box<Self>) -> Result<()>;
}

/// How an output is written.
#[derive(Clone, Debug)]
pub struct SinkOptions {
    /// Whether existing outputs may be replaced. Default: no.
    pub overwrite: bool,
    /// What shows through transparent pixels where a format has none. Default: white.
    pub background: Rgba,
    /// How often an animation plays. Default: as the input does.
    pub loops: Option<Loops>,
    /// The files that are being read; none of them may be the output. Default: none.
    pub inputs: Vec<PathBuf>,
    /// Quality of JPEG, 1 to 100. Default: 90.
    pub quality: Option<u8>,
}

impl Default for SinkOptions {
    fn default() -> Self {
        Self {
            overwrite: false,
            background: [255; 4],
            loops: None,
            inputs: Vec::new(),
            quality: None,
        }
    }
}

/// Makes the sink that `output` asks for by its name: a still (`.png`, `.jpg`, `.webp` ...), a
/// numbered sequence (`frame_%04d.png`, or a folder), a `.gif`, or `null:`, which discards.
/// `info` is the stream that will be written.
///
/// # Errors
/// When the name's format is unknown or does not suit the stream, the output exists, is an input, or
/// cannot be written.
pub fn create(output: &str, info: &StreamInfo, options: &SinkOptions) -> Result<Box<dyn Sink>> {
    let _ = (output, info, options);
    Err(crate::error::Error::usage("not yet"))
}
