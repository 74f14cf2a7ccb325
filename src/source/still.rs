//! One picture from one file: PNG, JPEG, WebP, BMP, TIFF, PNM. Colours become sRGB, pictures stand upright.

use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

use image::metadata::Orientation;
use image::{
    ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, RgbaImage,
};

use super::jpeg::Jpeg;
use super::limit::{Limit, METADATA};
use super::png::Rows;
use super::profile::{ColourSpace, ToSrgb};
use super::tiff::{Extra, FewBits, Tags};
use super::{SourceOptions, detect, fence, jpeg_fallback, png, tiff, webp};
use crate::error::{Error, Result};
use crate::frame::{Frame, Rgba, check_size};
use crate::geom::{MAX_SIDE, Size};

/// What a picture's header says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// Size of the upright picture.
    pub(crate) size: Size,
    /// Whether pixels may be transparent.
    pub(crate) alpha: bool,
}

/// How pictures are decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Decoding {
    /// The memory that may be taken.
    pub(crate) limit: Limit,
    /// Whether what is there of a picture that ends too early is wanted.
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
    Ok(Header { size, alpha: opened.facts.alpha })
}

/// Decodes the picture in `path`.
///
/// # Errors
/// When it is broken or too large, or ends too early.
pub(crate) fn decode(path: &Path, format: ImageFormat, how: Decoding) -> Result<Frame> {
    let how = Decoding { allow_truncated: false, ..how };
    decode_part(path, format, how).map(|(frame, _)| frame)
}

/// Decodes what there is of the picture in `path`. If it ends too early and that is allowed, the error comes with
/// it.
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

/// What is known of a picture before its pixels are decoded.
struct Facts {
    /// As it lies in the file.
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
    /// What is known to be missing at its end.
    missing: Option<&'static str>,
}

/// Where pixels come from.
enum Pixels<'a> {
    Png(Box<png::Png>),
    Image(Box<dyn ImageDecoder + 'a>),
    Jpeg(Vec<u8>),
    FewBits(FewBits),
}

impl Opened<'_> {
    fn open(path: &Path, format: ImageFormat, limit: Limit, header: bool) -> Result<Self> {
        let mut opened = match format {
            ImageFormat::Png => open_png(path)?,
            ImageFormat::Jpeg => open_jpeg(path, limit, header)?,
            ImageFormat::Tiff => open_tiff(path, limit)?,
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
        Opened { format, facts, pixels: Pixels::Image(decoder), missing: None }
    }

    /// Bytes that a pixel takes while it is decoded: as the decoder has it (some keep a picture of their
    /// own), and as RGBA.
    fn bytes_per_pixel(&self) -> u64 {
        4 + match &self.pixels {
            Pixels::Png(decoder) => png::bytes_per_pixel(decoder),
            Pixels::Image(decoder) => {
                let bytes = u64::from(decoder.color_type().bytes_per_pixel());
                let copies = matches!(self.format, ImageFormat::Bmp | ImageFormat::Pnm);
                if copies { bytes } else { 2 * bytes }
            }
            Pixels::Jpeg(_) => 6,
            Pixels::FewBits(_) => 2,
        }
    }

    fn decode(self, path: &Path, allow_truncated: bool) -> Result<(Frame, Option<Error>)> {
        let Self { format, facts, pixels, missing } = self;
        let title = title(word(format));
        let missing = missing.map(|how| Error::input(path, cut_short(&title, how)).truncated());
        let (read, convert) = match pixels {
            Pixels::Png(decoder) => decode_png(*decoder, facts.size),
            Pixels::Image(decoder) => decode_image(path, decoder, format)?,
            Pixels::Jpeg(bytes) => decoded(jpeg_fallback::decode(&bytes)),
            Pixels::FewBits(few_bits) => decoded(few_bits.decode()),
        };
        let cut = match read {
            Ok(()) => None,
            // Of a WebP that ends too early, the decoder says only that it is broken.
            Err(e) if !is_cut_short(&e) => {
                let broken = Error::input(path, broken(&e, word(format)));
                return Err(missing.unwrap_or(broken));
            }
            Err(e) => Some(Error::input(path, broken(&e, word(format))).truncated()),
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
    /// The frame of `pixels`: in sRGB, upright, colours not premultiplied.
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
            ));
        };
        let mut image = DynamicImage::ImageRgba8(image);
        image.apply_orientation(self.orientation);
        Ok(Frame::from_image(image.into_rgba8())?)
    }
}

/// Makes pixels of what was read, once it is known that they are wanted.
type Convert<'a> = Box<dyn FnOnce() -> Result<Vec<Rgba>> + 'a>;

fn decode_png<'a>(mut decoder: png::Png, size: Size) -> (Result<(), ImageError>, Convert<'a>) {
    let mut rows = Rows::default();
    let read = rows.read(&mut decoder);
    (read, Box::new(move || Ok(rows.pixels(&decoder, size))))
}

fn decode_image<'a>(
    path: &'a Path,
    decoder: Box<dyn ImageDecoder + 'a>,
    format: ImageFormat,
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
    Ok((read, Box::new(move || to_rgba(path, colour, &raw, format))))
}

/// What a decoder that answers with pixels gives.
fn decoded<'a>(read: Result<Vec<Rgba>, ImageError>) -> (Result<(), ImageError>, Convert<'a>) {
    match read {
        Ok(pixels) => (Ok(()), Box::new(move || Ok(pixels))),
        Err(e) => (Err(e), Box::new(|| Ok(Vec::new()))),
    }
}

fn open_png<'a>(path: &Path) -> Result<Opened<'a>> {
    let decoder = png::open(path, 1)?;
    let exif = decoder.info().exif_metadata.as_deref().and_then(Orientation::from_exif_chunk);
    let facts = Facts {
        size: png::size(&decoder),
        alpha: png::has_alpha(&decoder),
        orientation: exif.unwrap_or(Orientation::NoTransforms),
        space: png::colour_space(&decoder),
        gray: !png::is_colour(&decoder),
        extra: Extra::Alpha,
    };
    let pixels = Pixels::Png(Box::new(decoder));
    Ok(Opened { format: ImageFormat::Png, facts, pixels, missing: None })
}

fn open_jpeg<'a>(path: &Path, limit: Limit, header: bool) -> Result<Opened<'a>> {
    let Jpeg { bytes, complete, split_scans, .. } = Jpeg::read(path, header, limit)?;
    let copy = if split_scans { bytes.clone() } else { Vec::new() };
    let decoder = decoder(path, Cursor::new(bytes), ImageFormat::Jpeg, limit)?;
    let mut opened = Opened::new(decoder, ImageFormat::Jpeg);
    // The decoder fills up what is missing with gray and says nothing.
    opened.missing = (!complete).then_some("its end marker is missing");
    if split_scans && !opened.facts.gray {
        opened.pixels = Pixels::Jpeg(copy);
    }
    Ok(opened)
}

fn open_tiff<'a>(path: &Path, limit: Limit) -> Result<Opened<'a>> {
    let file = || detect::open(path).map(BufReader::new);
    let Tags { extra, space, gray, orientation, few_bits } =
        tiff::read(file()?, limit).map_err(|what| Error::input(path, what))?;
    if let Some(few_bits) = few_bits {
        let orientation = Orientation::from_exif(orientation).unwrap_or(Orientation::NoTransforms);
        let facts = Facts { size: few_bits.size(), alpha: false, orientation, space, gray, extra };
        let pixels = Pixels::FewBits(few_bits);
        return Ok(Opened { format: ImageFormat::Tiff, facts, pixels, missing: None });
    }
    let mut opened =
        Opened::new(decoder(path, file()?, ImageFormat::Tiff, limit)?, ImageFormat::Tiff);
    let has_alpha = opened.facts.alpha;
    opened.facts.extra = if has_alpha { extra } else { Extra::Alpha };
    opened.facts.alpha = has_alpha && extra != Extra::Other;
    opened.facts.space = space;
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
        Err(e) => Err(Error::input(path, broken(&e, word(format)))),
    }
}

/// Pixels of any layout as 8-bit RGBA. 16-bit values are rounded to the nearest of 255.
fn to_rgba(path: &Path, colour: ColorType, raw: &[u8], format: ImageFormat) -> Result<Vec<Rgba>> {
    let narrow = |v: [u8; 2]| ((u32::from(u16::from_ne_bytes(v)) + 128) / 257) as u8;
    let float = |v: [u8; 4]| (f32::from_ne_bytes(v).clamp(0.0, 1.0) * 255.0).round() as u8;
    Ok(match colour {
        ColorType::L8 => raw.iter().map(|&v| [v, v, v, 255]).collect(),
        ColorType::La8 => raw.as_chunks().0.iter().map(|&[v, a]| [v, v, v, a]).collect(),
        ColorType::Rgb8 => raw.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
        ColorType::Rgba8 => raw.as_chunks().0.to_vec(),
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let values: Vec<u8> = raw.as_chunks().0.iter().map(|&v| narrow(v)).collect();
            let narrow = match colour {
                ColorType::L16 => ColorType::L8,
                ColorType::La16 => ColorType::La8,
                ColorType::Rgb16 => ColorType::Rgb8,
                _ => ColorType::Rgba8,
            };
            return to_rgba(path, narrow, &values, format);
        }
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
