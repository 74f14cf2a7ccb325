//! Small pictures for pages.

use polyreel::error::{Error, Result};
use polyreel::frame::Frame;

/// Quality of the JPEGs, 1..100: no visible blocks on flat triangles.
const QUALITY: u8 = 88;

/// `frame`, which must be opaque, as a JPEG whose longest side has at most `longest` pixels.
///
/// # Errors
/// When the JPEG codec fails.
pub(crate) fn thumbnail(frame: &Frame, longest: u32) -> Result<Vec<u8>> {
    let image = frame.clone().into_image();
    let small = if image.width().max(image.height()) > longest {
        image::DynamicImage::from(image).thumbnail(longest, longest).to_rgba8()
    } else {
        image
    };
    super::disturb::jpeg(&Frame::from_image(small)?, QUALITY)
        .map_err(|error| Error::failed(format!("the JPEG codec failed: {error}")).caused_by(error))
}
