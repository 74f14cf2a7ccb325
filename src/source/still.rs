//! One picture from one file: PNG, JPEG, WebP, BMP, TIFF, PNM.

use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;

use image::metadata::Orientation;
use image::{
    ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, RgbaImage,
};

use super::{detect, jpeg, webp};
use crate::error::{Error, Result};
use crate::frame::{Frame, MAX_PIXELS, Rgba, check_size};
use crate::geom::{MAX_SIDE, Size};

/// What a picture's header tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// Size of the upright picture.
    pub(crate) size: Size,
    /// Whether pixels may be transparent.
    pub(crate) alpha: bool,
}

/// How much of a JPEG is read for its header at first: camera files keep a preview and maker's notes
/// of some 100 KiB before it.
const JPEG_HEADER: u64 = 256 << 10;

/// Reads the header of the picture in `path`.
///
/// # Errors
/// When it is broken, or the picture is too large.
pub(crate) fn header(path: &Path, format: ImageFormat) -> Result<Header> {
    if format != ImageFormat::Jpeg {
        let file = BufReader::new(detect::open(path)?);
        return header_of(path, &mut decoder(path, file, format)?);
    }
    let mut start = Vec::new();
    let file = detect::open(path)?;
    let unreadable = |e| Error::input(path, format!("cannot be read: {e}")).caused_by(e);
    (&file).take(JPEG_HEADER).read_to_end(&mut start).map_err(unreadable)?;
    if let Ok(mut decoder) = decoder(path, Cursor::new(&start), format) {
        return header_of(path, &mut decoder);
    }
    (&file).read_to_end(&mut start).map_err(unreadable)?;
    header_of(path, &mut decoder(path, Cursor::new(&start), format)?)
}

/// Decodes the picture in `path`.
///
/// # Errors
/// When it is broken or too large, or ends too early.
pub(crate) fn decode(path: &Path, format: ImageFormat) -> Result<Frame> {
    let (frame, cut) = decode_part(path, format)?;
    cut.map_or(Ok(frame), Err)
}

/// Decodes what there is of the picture in `path`. If it ends too early, that is told beside it.
///
/// # Errors
/// When it is broken or too large.
pub(crate) fn decode_part(path: &Path, format: ImageFormat) -> Result<(Frame, Option<Error>)> {
    let mut file = BufReader::new(detect::open(path)?);
    let cut = |how| Some(Error::input(path, cut_short(&title(word(format)), how)));
    if format != ImageFormat::Jpeg {
        let missing = format == ImageFormat::WebP && !webp::is_complete(path)?;
        let end = || if missing { cut("data is missing at its end") } else { None };
        let part = decoder(path, file, format).and_then(|d| decoded(path, d, format));
        // Of a WebP that ends too early, the decoder says only that it is broken.
        let (frame, error) = part.map_err(|error| end().unwrap_or(error))?;
        return Ok((frame, error.or_else(end)));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)
        .map_err(|e| Error::input(path, format!("cannot be read: {e}")).caused_by(e))?;
    let (frame, error) = decoded(path, decoder(path, Cursor::new(&bytes), format)?, format)?;
    // The decoder fills up what is missing with gray and says nothing.
    let missing = error.is_none() && !jpeg::is_complete(&bytes);
    Ok((frame, if missing { cut("its end marker is missing") } else { error }))
}

/// Words for an input that ends too early.
pub(crate) fn cut_short(format: &str, how: &str) -> String {
    format!(
        "the {format} ends too early ({how}); get a complete copy, or keep what is there with \
         --allow-truncated"
    )
}

/// Words for a picture that is too large.
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

/// The `image` crate's word for a format.
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

/// A format's word as one writes it in a sentence.
pub(crate) fn title(word: &str) -> String {
    if word == "webp" { "WebP".into() } else { word.to_uppercase() }
}

/// Words for what a decoder found wrong. `name` is the format's.
pub(crate) fn broken(error: &ImageError, name: &str) -> String {
    let name = title(name);
    match error {
        _ if is_cut_short(error) => cut_short(&name, "the data is incomplete"),
        ImageError::IoError(e) => format!("cannot be read: {e}"),
        ImageError::Unsupported(e) => {
            format!("this kind of {name} is not supported ({e}); save it as 8-bit PNG first")
        }
        ImageError::Limits(_) => {
            format!("decoding this {name} would take too much memory; make it smaller first")
        }
        e => format!("the {name} is broken ({e}); get another copy"),
    }
}

/// Whether the error is that the data ends too early.
fn is_cut_short(error: &ImageError) -> bool {
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
    // Not every decoder carries the cause; those that do not say it in these words.
    let text = error.to_string().to_lowercase();
    ["eof", "end of file", "exhausted", "truncated", "fill whole buffer", "no more data"]
        .iter()
        .any(|words| text.contains(words))
}

fn decoder<'a, R: BufRead + Seek + 'a>(
    path: &Path,
    reader: R,
    format: ImageFormat,
) -> Result<impl ImageDecoder + 'a> {
    let mut reader = ImageReader::with_format(reader, format);
    reader.limits(limits());
    reader.into_decoder().map_err(|e| Error::input(path, broken(&e, word(format))))
}

/// Sizes are checked by [`check_picture`], which names them; 16 bytes a pixel is the most that a
/// pixel takes (four floats).
pub(crate) fn limits() -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(16 * MAX_PIXELS);
    limits
}

fn header_of(path: &Path, decoder: &mut impl ImageDecoder) -> Result<Header> {
    let (width, height) = decoder.dimensions();
    let size = Size::new(width, height);
    check_picture(path, size)?;
    let size = match orientation(decoder) {
        Orientation::Rotate90
        | Orientation::Rotate270
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => Size::new(height, width),
        _ => size,
    };
    Ok(Header { size, alpha: decoder.color_type().has_alpha() })
}

/// How the picture must be turned to stand upright. Broken EXIF data is as good as none.
fn orientation(decoder: &mut impl ImageDecoder) -> Orientation {
    decoder.orientation().unwrap_or(Orientation::NoTransforms)
}

fn decoded(
    path: &Path,
    mut decoder: impl ImageDecoder,
    format: ImageFormat,
) -> Result<(Frame, Option<Error>)> {
    let (width, height) = decoder.dimensions();
    let size = Size::new(width, height);
    check_picture(path, size)?;
    let orientation = orientation(&mut decoder);
    let colour = decoder.color_type();
    let (read, pixels) = if colour == ColorType::Rgba8 {
        let mut pixels = vec![[0; 4]; size.pixels()];
        (decoder.read_image(pixels.as_flattened_mut()), pixels)
    } else {
        let bytes = usize::try_from(decoder.total_bytes())
            .map_err(|_| Error::input(path, "the picture does not fit into memory"))?;
        let mut raw = vec![0; bytes];
        (decoder.read_image(&mut raw), to_rgba(path, colour, &raw)?)
    };
    let cut = match read {
        Ok(()) => None,
        Err(e) => {
            let error = Error::input(path, broken(&e, word(format)));
            if !is_cut_short(&e) {
                return Err(error);
            }
            Some(error)
        }
    };
    if orientation == Orientation::NoTransforms {
        return Ok((Frame::known(size, pixels, !colour.has_alpha())?, cut));
    }
    let image = RgbaImage::from_raw(width, height, pixels.into_flattened())
        .expect("the pixels were made for this size");
    let mut image = DynamicImage::ImageRgba8(image);
    image.apply_orientation(orientation);
    Ok((Frame::from_image(image.into_rgba8())?, cut))
}

/// Pixels of any layout as 8-bit RGBA. 16-bit values are rounded to the nearest of 255.
fn to_rgba(path: &Path, colour: ColorType, raw: &[u8]) -> Result<Vec<Rgba>> {
    let word = |v: [u8; 2]| ((u32::from(u16::from_ne_bytes(v)) + 128) / 257) as u8;
    let float = |v: [u8; 4]| (f32::from_ne_bytes(v).clamp(0.0, 1.0) * 255.0).round() as u8;
    Ok(match colour {
        ColorType::L8 => raw.iter().map(|&v| [v, v, v, 255]).collect(),
        ColorType::La8 => raw.as_chunks().0.iter().map(|&[v, a]| [v, v, v, a]).collect(),
        ColorType::Rgb8 => raw.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
        ColorType::Rgba8 => raw.as_chunks().0.to_vec(),
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let values: Vec<u8> = raw.as_chunks().0.iter().map(|&v| word(v)).collect();
            let narrow = match colour {
                ColorType::L16 => ColorType::L8,
                ColorType::La16 => ColorType::La8,
                ColorType::Rgb16 => ColorType::Rgb8,
                _ => ColorType::Rgba8,
            };
            return to_rgba(path, narrow, &values);
        }
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let values: Vec<u8> = raw.as_chunks().0.iter().map(|&v| float(v)).collect();
            let narrow =
                if colour == ColorType::Rgb32F { ColorType::Rgb8 } else { ColorType::Rgba8 };
            return to_rgba(path, narrow, &values);
        }
        other => {
            let what = format!("pixels of type {other:?} are not supported; save it as 8-bit PNG");
            return Err(Error::input(path, what));
        }
    })
}
