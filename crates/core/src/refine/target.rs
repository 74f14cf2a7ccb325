//! The pixels that a mesh is fitted to.

use std::ops::Range;

use crate::frame::{Buffers, Frame};
use crate::geom::Size;
use crate::residual::Residual;

/// The pixels that a mesh is fitted to: the frame's own, or a picture derived from them.
#[derive(Debug)]
pub(super) enum Target<'a> {
    /// The frame itself.
    Frame(&'a Frame),
    /// The frame with the residual of the frame before it added.
    Corrected(Frame),
    /// The frame, only some rows of which have pixels; others must not be read.
    Rows(Frame),
}

impl<'a> Target<'a> {
    /// `frame` with the `residual` of the last frame added, if there is one of its size.
    pub(super) fn with_residual(frame: &'a Frame, residual: Option<Residual>) -> Self {
        let corrected = residual.and_then(|residual| residual.target_for(frame));
        corrected.map_or(Self::Frame(frame), Self::Corrected)
    }

    /// `frame`, of which only `rows` will be read: only these are converted from planes, in `buffers`.
    pub(super) fn with_rows(
        frame: &'a Frame,
        rows: impl IntoIterator<Item = Range<u32>>,
        buffers: &mut Buffers,
    ) -> Self {
        let partial = frame.with_rows(rows, &mut buffers.pixels);
        partial.map_or(Self::Frame(frame), Self::Rows)
    }

    /// The picture that holds the pixels.
    #[inline]
    pub(super) fn picture(&self) -> &Frame {
        match self {
            Self::Frame(frame) => frame,
            Self::Corrected(picture) | Self::Rows(picture) => picture,
        }
    }

    /// Width and height.
    #[inline]
    pub(super) fn size(&self) -> Size {
        self.picture().size()
    }

    /// Whether all pixels are opaque.
    #[inline]
    pub(super) fn is_opaque(&self) -> bool {
        self.picture().is_opaque()
    }

    /// Returns the buffers of a derived picture to `buffers`.
    pub(super) fn recycle(self, buffers: &mut Buffers) {
        match self {
            Self::Frame(_) => {}
            Self::Corrected(picture) => *buffers = picture.into_buffers(),
            Self::Rows(picture) => buffers.pixels = picture.into_pixels(),
        }
    }
}
