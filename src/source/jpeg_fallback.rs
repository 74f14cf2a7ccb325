//! JPEGs that zune-jpeg decodes wrongly, by the `jpeg-decoder` crate: one scan a component, or luma of fewer samples
//! than chroma.

use std::io::ErrorKind;

use image::error::{
    DecodingError, LimitError, LimitErrorKind, UnsupportedError, UnsupportedErrorKind,
};
use image::{ImageError, ImageFormat};
use jpeg_decoder::{Decoder, PixelFormat};

use crate::frame::Rgba;

/// Decodes a whole JPEG of three components.
///
/// # Errors
/// When it is broken.
pub(super) fn decode(jpeg: &[u8]) -> Result<Vec<Rgba>, ImageError> {
    let mut decoder = Decoder::new(jpeg);
    let bytes = decoder.decode().map_err(fault)?;
    match decoder.info().map(|info| info.pixel_format) {
        Some(PixelFormat::RGB24) => {
            Ok(bytes.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect())
        }
        _ => Err(unsupported("such scans or samples, and not three components")),
    }
}

/// A fault of the decoder as one of the `image` crate, for its words.
fn fault(error: jpeg_decoder::Error) -> ImageError {
    match error {
        jpeg_decoder::Error::Io(e) if e.kind() == ErrorKind::UnexpectedEof => {
            ImageError::IoError(e)
        }
        jpeg_decoder::Error::Unsupported(what) => unsupported(&format!("{what:?}")),
        e if e.to_string().contains("memory") => {
            ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory))
        }
        e => ImageError::Decoding(DecodingError::new(ImageFormat::Jpeg.into(), e)),
    }
}

fn unsupported(what: &str) -> ImageError {
    let kind = UnsupportedErrorKind::GenericFeature(what.to_owned());
    let format = ImageFormat::Jpeg.into();
    ImageError::Unsupported(UnsupportedError::from_format_and_kind(format, kind))
}
