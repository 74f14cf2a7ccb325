//! Decodes the pixels of a picture, and converts them to RGBA of 8 bits.

use std::path::Path;

use image::{ColorType, ImageDecoder, ImageError, ImageFormat};

use super::broken::{title, word};
use super::deep;
use super::png::{self, Rows};
use super::profile::DeepToSrgb;
use super::tiff::unpremultiply_deep;
use crate::error::{Error, Result};
use crate::frame::Rgba;
use crate::geom::Size;

/// Pixels of 16 bits that are converted at once.
const PIECE: usize = 1 << 14;

/// Converts what was read; called only if the pixels are used.
pub(super) type Convert<'a> = Box<dyn FnOnce() -> Result<Vec<Rgba>> + 'a>;

/// Reads the rows of a PNG, and returns how to convert them. After an error the rows before it can be converted.
pub(super) fn decode_png<'a>(
    mut decoder: png::Png,
    size: Size,
    to_srgb: Option<DeepToSrgb>,
) -> (Result<(), ImageError>, Convert<'a>) {
    let mut rows = Rows::default();
    let read = rows.read(&mut decoder);
    (read, Box::new(move || Ok(rows.pixels(&decoder, size, to_srgb.as_ref()))))
}

/// Reads a picture with a decoder of the crate `image`, and returns how to convert it. After an error the part before
/// it can be converted. Colours of 16 bits that are `premultiplied` are divided by alpha.
///
/// # Errors
/// When the picture does not fit into memory.
pub(super) fn decode_image<'a>(
    path: &'a Path,
    decoder: Box<dyn ImageDecoder + 'a>,
    format: ImageFormat,
    (premultiplied, to_srgb): (bool, Option<DeepToSrgb>),
) -> Result<(Result<(), ImageError>, Convert<'a>)> {
    let colour = decoder.color_type();
    let bytes = usize::try_from(decoder.total_bytes())
        .map_err(|_| Error::input(path, "the picture does not fit into memory"))?;
    if colour == ColorType::Rgba8 {
        let mut pixels = vec![[0; 4]; bytes / 4];
        let read = decoder.read_image_boxed(pixels.as_flattened_mut());
        return Ok((read, Box::new(move || Ok(pixels))));
    }
    let mut raw = vec![0; bytes];
    let read = decoder.read_image_boxed(&mut raw);
    if is_deep(colour) {
        let channels = colour.channel_count().into();
        let convert = move || Ok(from_deep(&raw, channels, premultiplied, to_srgb.as_ref()));
        return Ok((read, Box::new(convert)));
    }
    Ok((read, Box::new(move || to_rgba(path, colour, &raw, format))))
}

/// The result of a decoder that gives RGBA pixels.
pub(super) fn decoded<'a>(
    read: Result<Vec<Rgba>, ImageError>,
) -> (Result<(), ImageError>, Convert<'a>) {
    match read {
        Ok(pixels) => (Ok(()), Box::new(move || Ok(pixels))),
        Err(e) => (Err(e), Box::new(|| Ok(Vec::new()))),
    }
}

/// Whether samples have 16 bits.
pub(super) fn is_deep(colour: ColorType) -> bool {
    matches!(colour, ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16)
}

/// Pixels of 16 bits a channel as 8-bit RGBA.
fn from_deep(
    raw: &[u8],
    channels: usize,
    premultiplied: bool,
    to_srgb: Option<&DeepToSrgb>,
) -> Vec<Rgba> {
    let mut pixels = Vec::with_capacity(raw.len() / (2 * channels));
    for piece in raw.chunks(2 * channels * PIECE) {
        let values = piece.as_chunks().0.iter().map(|&bytes| u16::from_ne_bytes(bytes));
        let mut values: Vec<u16> = values.collect();
        if premultiplied {
            unpremultiply_deep(&mut values, channels);
        }
        deep::push(&mut pixels, &values, channels, to_srgb);
    }
    pixels
}

/// Pixels of any other layout as 8-bit RGBA.
fn to_rgba(path: &Path, colour: ColorType, raw: &[u8], format: ImageFormat) -> Result<Vec<Rgba>> {
    let float = |v: [u8; 4]| (f32::from_ne_bytes(v).clamp(0.0, 1.0) * 255.0).round() as u8;
    Ok(match colour {
        ColorType::L8 => raw.iter().map(|&v| [v, v, v, 255]).collect(),
        ColorType::La8 => raw.as_chunks().0.iter().map(|&[v, a]| [v, v, v, a]).collect(),
        ColorType::Rgb8 => raw.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
        ColorType::Rgba8 => raw.as_chunks().0.to_vec(),
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let values: Vec<u8> = raw.as_chunks().0.iter().map(|&v| float(v)).collect();
            let narrow =
                if colour == ColorType::Rgb32F { ColorType::Rgb8 } else { ColorType::Rgba8 };
            return to_rgba(path, narrow, &values, format);
        }
        other => {
            let name = title(word(format));
            let what = format!(
                "this kind of {name} is not supported (pixels of type {other:?}); save it as 8-bit PNG first"
            );
            return Err(Error::input(path, what));
        }
    })
}
