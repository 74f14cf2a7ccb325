//! Where frames go. One format a file; unfinished outputs never stand under their final name.

pub mod codec;
pub mod ffmpeg;
pub mod nut;
pub(crate) mod remux;
pub mod sound;
pub mod y4m;

use crate::error::Result;
use crate::frame::{Fill, Frame, Span};

/// A finished frame on its way to a sink.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The low-poly picture.
    pub frame: Frame,
    /// Every colour that `frame` holds: those of the triangles, and of outlines. One colour may stand
    /// several times; the areas add up to the frame's.
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
