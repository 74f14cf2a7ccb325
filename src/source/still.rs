//! Reads one picture from one file: PNG, JPEG, WebP, BMP, TIFF, PNM. Converts it to sRGB and turns it upright.

use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, RgbaImage};

use super::broken::{broken, check_picture, cut_short, found, is_cut_short, title, word};
use super::convert::{decode_image, decode_png, decoded, is_deep};
use super::jpeg::Jpeg;
use super::limit::{Limit, METADATA};
use super::profile::{ColourSpace, DeepToSrgb, ToSrgb};
use super::tiff::{Extra, Tags};
use super::tiff_samples::Samples;
use super::{SourceOptions, detect, fence, jpeg_fallback, png, tiff, webp};
use crate::error::{Error, Result};
use crate::frame::{Frame, Rgba};
use crate::geom::Size;

/// What a picture's header says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// Size of the upright picture.
    pub(crate) size: Size,
    /// Whether pixels may be transparent.
    pub(crate) alpha: bool,
    /// What of the file is left out.
    pub(crate) left_out: Option<&'static str>,
}

/// How pictures are decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Decoding {
    /// The most memory that decoding may take.
    pub(crate) limit: Limit,
    /// Whether the part of a truncated picture that is there is used.
    pub(crate) allow_truncated: bool,
}

impl Decoding {
    /// As `options` say.
    pub(crate) fn of(options: &SourceOptions) -> Self {
        Self { limit: Limit::of(options), allow_truncated: options.allow_truncated }
    }
}

/// Reads the header of the picture in `path`.
///
/// # Errors
/// When it is broken, or the picture is too large.
pub(crate) fn header(path: &Path, format: ImageFormat, how: Decoding) -> Result<Header> {
    let read = fence::run(word(format), || Opened::open(path, format, how.limit, true));
    let opened = read.map_err(|what| Error::input(path, what))??;
    let Size { width, height } = opened.facts.size;
    let size = match opened.facts.orientation {
        Orientation::Rotate90
        | Orientation::Rotate270
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => Size::new(height, width),
        _ => opened.facts.size,
    };
    Ok(Header { size, alpha: opened.facts.alpha, left_out: opened.left_out })
}

/// Decodes the picture in `path`.
///
/// # Errors
/// When it is broken or too large, or ends too early.
pub(crate) fn decode(path: &Path, format: ImageFormat, how: Decoding) -> Result<Frame> {
    let how = Decoding { allow_truncated: false, ..how };
    decode_part(path, format, how).map(|(frame, _)| frame)
}

/// Decodes the picture in `path`. A truncated one, if that is allowed, comes with the error.
///
/// # Errors
/// When it is broken or too large, or ends too early and that is not allowed.
pub(crate) fn decode_part(
    path: &Path,
    format: ImageFormat,
    how: Decoding,
) -> Result<(Frame, Option<Error>)> {
    let decode = || Opened::open(path, format, how.limit, false)?.decode(path, how.allow_truncated);
    fence::run(word(format), decode).map_err(|what| Error::input(path, what))?
}

/// The properties of a picture that are known before its pixels are decoded.
struct Facts {
    /// Size as stored, before the orientation is applied.
    size: Size,
    alpha: bool,
    orientation: Orientation,
    space: Option<ColourSpace>,
    gray: bool,
    extra: Extra,
}

/// A picture whose header has been read.
struct Opened<'a> {
    format: ImageFormat,
    facts: Facts,
    pixels: Pixels<'a>,
    /// Which part is missing at its end, if any.
    missing: Option<&'static str>,
    /// What of the file is left out.
    left_out: Option<&'static str>,
}

/// Where pixels come from.
enum Pixels<'a> {
    Png(Box<png::Png>),
    Image(Box<dyn ImageDecoder + 'a>),
    Jpeg(Vec<u8>),
    Samples(Samples),
}

impl Opened<'_> {
    fn open(path: &Path, format: ImageFormat, limit: Limit, header: bool) -> Result<Self> {
        let mut opened = match format {
            ImageFormat::Png => open_png(path)?,
            ImageFormat::Jpeg => open_jpeg(path, limit, header)?,
            ImageFormat::Tiff => open_tiff(path, limit, header)?,
            _ => Self::new(
                decoder(path, BufReader::new(detect::open(path)?), format, limit)?,
                format,
            ),
        };
        check_picture(path, opened.facts.size)?;
        if format == ImageFormat::WebP && !header && !webp::is_complete(path)? {
            opened.missing = Some("data is missing at its end");
        }
        limit.check(path, opened.facts.size, opened.bytes_per_pixel())?;
        Ok(opened)
    }

    fn new<'a>(mut decoder: Box<dyn ImageDecoder + 'a>, format: ImageFormat) -> Opened<'a> {
        let (width, height) = decoder.dimensions();
        let colour = decoder.color_type();
        let icc = decoder.icc_profile().ok().flatten();
        let facts = Facts {
            size: Size::new(width, height),
            alpha: colour.has_alpha(),
            // Broken EXIF data is ignored.
            orientation: decoder.orientation().unwrap_or(Orientation::NoTransforms),
            space: icc.filter(|icc| icc.len() as u64 <= METADATA).map(ColourSpace::Icc),
            gray: !colour.has_color(),
            extra: Extra::Alpha,
        };
        Opened { format, facts, pixels: Pixels::Image(decoder), missing: None, left_out: None }
    }

    /// Bytes of memory for a pixel while it is decoded: in the decoder's format, twice if the decoder buffers the
    /// picture, and as RGBA.
    fn bytes_per_pixel(&self) -> u64 {
        4 + match &self.pixels {
            Pixels::Png(decoder) => png::bytes_per_pixel(decoder),
            Pixels::Image(decoder) => {
                let bytes = u64::from(decoder.color_type().bytes_per_pixel());
                let copies = matches!(self.format, ImageFormat::Bmp | ImageFormat::Pnm);
                if copies { bytes } else { 2 * bytes }
            }
            Pixels::Jpeg(_) => 6,
            Pixels::Samples(samples) => samples.bytes_per_pixel(),
        }
    }

    fn decode(self, path: &Path, allow_truncated: bool) -> Result<(Frame, Option<Error>)> {
        let Self { format, mut facts, pixels, missing, .. } = self;
        let title = title(word(format));
        let missing = missing.map(|how| Error::input(path, cut_short(&title, how)).truncated());
        let (read, convert) = match pixels {
            Pixels::Png(decoder) => {
                let to_srgb = facts.deep(png::is_deep(&decoder));
                decode_png(*decoder, facts.size, to_srgb)
            }
            Pixels::Image(decoder) => {
                let deep = is_deep(decoder.color_type());
                let premultiplied = deep && facts.extra == Extra::Premultiplied;
                if premultiplied {
                    facts.extra = Extra::Alpha;
                }
                decode_image(path, decoder, format, (premultiplied, facts.deep(deep)))?
            }
            Pixels::Jpeg(bytes) => decoded(jpeg_fallback::decode(&bytes)),
            Pixels::Samples(samples) => decoded(samples.decode()),
        };
        let cut = match read {
            Ok(()) => None,
            // For a truncated WebP the decoder reports only that it is broken.
            Err(e) if !is_cut_short(&e) => {
                return Err(missing.unwrap_or_else(|| failed(path, &e, format)));
            }
            Err(e) => Some(failed(path, &e, format)),
        };
        let cut = cut.or(missing);
        if let Some(error) = cut {
            if !allow_truncated {
                return Err(error);
            }
            return Ok((facts.finished(path, convert()?)?, Some(error)));
        }
        Ok((facts.finished(path, convert()?)?, None))
    }
}

impl Facts {
    /// The conversion to sRGB of samples of 16 bits, if these are `deep`. [`Self::finished`] then does none.
    fn deep(&mut self, deep: bool) -> Option<DeepToSrgb> {
        if !deep {
            return None;
        }
        DeepToSrgb::new(&self.space.take()?, self.gray)
    }

    /// The frame of `pixels`: converted to sRGB, upright, with straight alpha.
    fn finished(self, path: &Path, mut pixels: Vec<Rgba>) -> Result<Frame> {
        let mut opaque = !self.alpha;
        match self.extra {
            Extra::Alpha => {}
            Extra::Premultiplied => tiff::unpremultiply(&mut pixels),
            Extra::Other => {
                pixels.iter_mut().for_each(|pixel| pixel[3] = 255);
                opaque = true;
            }
        }
        if let Some(to_srgb) = self.space.and_then(|space| ToSrgb::new(&space, self.gray)) {
            to_srgb.apply(&mut pixels);
        }
        if self.orientation == Orientation::NoTransforms {
            return Ok(Frame::known(self.size, pixels, opaque)?);
        }
        let Size { width, height } = self.size;
        let Some(image) = RgbaImage::from_raw(width, height, pixels.into_flattened()) else {
            return Err(Error::input(
                path,
                "has fewer pixels than its header says; get another copy",
            )
            .corrupt());
        };
        let mut image = DynamicImage::ImageRgba8(image);
        image.apply_orientation(self.orientation);
        Ok(Frame::from_image(image.into_rgba8())?)
    }
}

fn open_png<'a>(path: &Path) -> Result<Opened<'a>> {
    let (decoder, left_out) = png::open(path, 1)?;
    let early = decoder.info().exif_metadata.as_deref().map(<[u8]>::to_vec);
    let exif = match early {
        Some(exif) => Some(exif),
        None if left_out.is_some() => None,
        None => png::late_exif(path)?,
    };
    let exif = exif.as_deref().and_then(Orientation::from_exif_chunk);
    let facts = Facts {
        size: png::size(&decoder),
        alpha: png::has_alpha(&decoder),
        orientation: exif.unwrap_or(Orientation::NoTransforms),
        space: png::colour_space(&decoder),
        gray: !png::is_colour(&decoder),
        extra: Extra::Alpha,
    };
    let pixels = Pixels::Png(Box::new(decoder));
    Ok(Opened { format: ImageFormat::Png, facts, pixels, missing: None, left_out })
}

fn open_jpeg<'a>(path: &Path, limit: Limit, header: bool) -> Result<Opened<'a>> {
    let Jpeg { bytes, complete, split_scans, is_luma_coarser, .. } =
        Jpeg::read(path, header, limit)?;
    let is_decoded_here = split_scans || is_luma_coarser;
    let copy = if is_decoded_here { bytes.clone() } else { Vec::new() };
    let decoder = decoder(path, Cursor::new(bytes), ImageFormat::Jpeg, limit)?;
    let mut opened = Opened::new(decoder, ImageFormat::Jpeg);
    // The decoder fills missing parts with gray, without an error.
    opened.missing = (!complete).then_some("its end marker is missing");
    if is_decoded_here && !opened.facts.gray {
        opened.pixels = Pixels::Jpeg(copy);
    }
    Ok(opened)
}

fn open_tiff<'a>(path: &Path, limit: Limit, header: bool) -> Result<Opened<'a>> {
    let file = || detect::open(path).map(BufReader::new);
    let Tags { extra, space, gray, orientation, samples } =
        tiff::read(file()?, file()?, limit).map_err(|what| Error::input(path, what))?;
    let left_out = (header && tiff::has_pages(file()?))
        .then_some("it has several pages, of which the first is read");
    if let Some(samples) = samples {
        let orientation = Orientation::from_exif(orientation).unwrap_or(Orientation::NoTransforms);
        let has_extra = samples.has_extra();
        let facts = Facts {
            size: samples.size(),
            alpha: has_extra && extra != Extra::Other,
            orientation,
            space,
            gray,
            extra: if has_extra { extra } else { Extra::Alpha },
        };
        let pixels = Pixels::Samples(samples);
        return Ok(Opened { format: ImageFormat::Tiff, facts, pixels, missing: None, left_out });
    }
    let mut opened =
        Opened::new(decoder(path, file()?, ImageFormat::Tiff, limit)?, ImageFormat::Tiff);
    let has_alpha = opened.facts.alpha;
    opened.facts.extra = if has_alpha { extra } else { Extra::Alpha };
    opened.facts.alpha = has_alpha && extra != Extra::Other;
    opened.facts.space = space;
    opened.left_out = left_out;
    Ok(opened)
}

fn decoder<'a, R: BufRead + Seek + 'a>(
    path: &Path,
    reader: R,
    format: ImageFormat,
    limit: Limit,
) -> Result<Box<dyn ImageDecoder + 'a>> {
    let mut reader = ImageReader::with_format(reader, format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(limit.0);
    reader.limits(limits);
    match reader.into_decoder() {
        Ok(decoder) => Ok(Box::new(decoder)),
        Err(e) => Err(failed(path, &e, format)),
    }
}

fn failed(path: &Path, error: &ImageError, format: ImageFormat) -> Error {
    found(Error::input(path, broken(error, word(format))), error)
}
