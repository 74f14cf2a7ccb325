//! How far a rendering is from its source: structural similarity, squared error, flicker.

pub mod flicker;
pub mod mse;
pub mod ssim;
pub mod warp;

use crate::error::{Error, Result};
use crate::geom::Size;

/// Checks that two pictures can be compared pixel by pixel.
fn same_size(a: Size, b: Size) -> Result<()> {
    if a == b {
        return Ok(());
    }
    Err(Error::usage(format!("a picture of {a} cannot be compared with one of {b}")))
}
