//! What is said of pictures that cannot be read, and the names of their formats.

use std::fmt::Display;
use std::path::Path;

use image::{ImageError, ImageFormat};

use crate::error::{Error, Result, copied};
use crate::frame::check_size;
use crate::geom::{MAX_SIDE, Size};

/// The message for an input that ends too early.
pub(crate) fn cut_short(format: &str, how: &str) -> String {
    format!(
        "the {format} ends too early ({how}); get a complete copy, or keep what is there with \
         --allow-truncated"
    )
}

/// Checks the size of a picture.
///
/// # Errors
/// When `size` has no pixel or is above the limits.
pub(crate) fn check_picture(path: &Path, size: Size) -> Result<()> {
    if size.width == 0 || size.height == 0 {
        return Err(Error::input(path, format!("the picture has no pixels ({size})")));
    }
    check_size(size).map_err(|_| {
        Error::input(
            path,
            format!(
                "the header claims {size} pixels, more than {MAX_SIDE} a side; make it smaller first"
            ),
        )
    })
}

/// The short name of a format.
pub(crate) fn word(format: ImageFormat) -> &'static str {
    match format {
        ImageFormat::Png => "png",
        ImageFormat::Jpeg => "jpeg",
        ImageFormat::WebP => "webp",
        ImageFormat::Bmp => "bmp",
        ImageFormat::Tiff => "tiff",
        ImageFormat::Pnm => "pnm",
        ImageFormat::Gif => "gif",
        _ => "picture",
    }
}

/// The short name of a format as it is written in a sentence.
pub(crate) fn title(word: &str) -> String {
    if word == "webp" { "WebP".into() } else { word.to_uppercase() }
}

/// The message for an `error` of a decoder. `name` is the format's short name.
pub(crate) fn broken(error: &ImageError, name: &str) -> String {
    let name = title(name);
    match error {
        _ if is_cut_short(error) => cut_short(&name, "the data is incomplete"),
        ImageError::IoError(e) => format!("cannot be read: {e}"),
        ImageError::Unsupported(e) => not_supported(&name, e),
        // Some decoders say so of what they do not know: arithmetic coding, three samples for one.
        ImageError::Decoding(e)
            if ["not supported", "cannot decode"].iter().any(|w| e.to_string().contains(w)) =>
        {
            not_supported(&name, e)
        }
        ImageError::Limits(_) => {
            format!("decoding this {name} would take too much memory; make it smaller first")
        }
        e => format!("the {name} is broken ({e}); get another copy"),
    }
}

fn not_supported(name: &str, what: &dyn Display) -> String {
    format!("this kind of {name} is not supported ({what}); save it as 8-bit PNG first")
}

/// The error `what` about an input, with its cause: the decoder found that its data ends too early or is broken,
/// or failed.
pub(crate) fn found(what: Error, error: &ImageError) -> Error {
    match error {
        _ if is_cut_short(error) => what.truncated(),
        ImageError::IoError(e) => what.caused_by(copied(e)),
        ImageError::Decoding(_) => what.corrupt(),
        _ => what,
    }
}

/// Whether the error is that the data ends too early.
pub(super) fn is_cut_short(error: &ImageError) -> bool {
    if let ImageError::IoError(e) = error {
        return e.kind() == std::io::ErrorKind::UnexpectedEof;
    }
    let mut cause = std::error::Error::source(error);
    while let Some(c) = cause {
        let eof = |e: &std::io::Error| e.kind() == std::io::ErrorKind::UnexpectedEof;
        if c.downcast_ref::<std::io::Error>().is_some_and(eof) {
            return true;
        }
        cause = c.source();
    }
    // Some decoders have no cause, but use these words.
    let text = error.to_string().to_lowercase();
    ["eof", "end of file", "exhausted", "truncated", "fill whole buffer", "no more data"]
        .iter()
        .any(|words| text.contains(words))
}
