//! The distance of a rendering from its source: structural similarity, squared error, flicker.

pub mod flicker;
pub mod mse;
pub mod ssim;
pub mod warp;

use crate::error::{Error, Result};
use crate::frame::{Frame, Rgba, over};
use crate::geom::Size;

/// Checks that two pictures can be compared pixel by pixel.
fn same_size(a: Size, b: Size) -> Result<()> {
    if a == b {
        return Ok(());
    }
    Err(Error::SizeMismatch(a, b))
}

const WHITE: Rgba = [255; 4];

/// `frame` composed over white, for comparisons: invisible colours do not count.
pub fn over_white(frame: &Frame) -> Frame {
    if frame.is_opaque() {
        return frame.clone();
    }
    let pixels = frame.pixels().iter().map(|&pixel| over(pixel, WHITE));
    Frame::new(frame.size(), pixels.collect()).expect("as many pixels as before")
}
