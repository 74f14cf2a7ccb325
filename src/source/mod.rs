//! Where frames come from. One format a file; formats are recognised by content.

pub(crate) mod child;
pub mod ffmpeg;
pub mod nut;
pub mod probe;
pub(crate) mod watch;
pub mod y4m;

use crate::error::Result;
use crate::frame::{Frame, Span};

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
