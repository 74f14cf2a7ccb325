//! Frames from and to bytes.

use polyreel_core::{Frame, Size};

use crate::error::{Error, Result};

/// A frame of `width` x `height` of these bytes, four a pixel.
///
/// # Errors
/// When the number of bytes or the size is wrong.
pub(crate) fn frame(rgba: &[u8], width: u32, height: u32) -> Result<Frame> {
    let (pixels, rest) = rgba.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(Error::file("a frame's bytes are not four a pixel"));
    }
    Ok(Frame::new(Size::new(width, height), pixels.to_vec())?)
}

/// The bytes of a frame, four a pixel.
pub(crate) fn bytes(frame: Frame) -> Vec<u8> {
    frame.into_pixels().into_flattened()
}
