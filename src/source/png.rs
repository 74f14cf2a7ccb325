//! PNG, still or animated, through the `png` crate: pictures, frames, and what chunks say of colours.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use image::error::{DecodingError, LimitError, LimitErrorKind};
use image::{ImageError, ImageFormat};
use png::{BitDepth, ColorType, Decoder, Limits, Reader, Transformations};

use super::apng::fill;
use super::broken::{broken, found};
use super::deep;
use super::detect;
use super::limit::METADATA;
use super::profile::{ColourSpace, DeepToSrgb, Primaries};
use crate::error::{Error, Result};
use crate::frame::Rgba;
use crate::geom::Size;

/// The decoder of one file.
pub(super) type Png = Reader<BufReader<Chunks>>;

/// What is said of a PNG whose metadata is left out.
const LIGHT: &str = "its metadata takes more than 8 MiB and is ignored: colours are taken for sRGB, and the picture \
    for upright";

/// What is said of a PNG whose cICP the decoder takes for an error of reading: that of Y'CbCr, for one.
const NO_CODE_POINTS: &str = "its code points of colours (cICP) are broken and are ignored";

/// Opens the PNG in `path`, whose animation has at most `frames` frames; all before its first picture is
/// read. Samples come as 8 or 16 bits, palettes as colours. Metadata that takes too much memory is left out, which is
/// said.
///
/// # Errors
/// When it cannot be read, or is broken.
pub(super) fn open(path: &Path, frames: u64) -> Result<(Png, Option<&'static str>)> {
    let failed = |e| {
        let e = fault(e);
        found(Error::input(path, broken(&e, "png")), &e)
    };
    let (without, what) = match opened(detect::open(path)?, frames, None) {
        Err(png::DecodingError::LimitsExceeded) => (b"eXIf", LIGHT),
        Err(png::DecodingError::IoError(e)) if e.kind() == ErrorKind::InvalidData => {
            (b"cICP", NO_CODE_POINTS)
        }
        read => return read.map(|png| (png, None)).map_err(failed),
    };
    let opened = opened(detect::open(path)?, frames, Some(without));
    opened.map(|png| (png, Some(what))).map_err(failed)
}

fn opened(
    file: File,
    frames: u64,
    without: Option<&'static [u8; 4]>,
) -> std::result::Result<Png, png::DecodingError> {
    let mut decoder = Decoder::new(BufReader::new(Chunks { file, without, state: State::Start }));
    decoder.set_ignore_iccp_chunk(without == Some(b"eXIf"));
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let width = decoder.read_header_info()?.width;
    // The decoder counts a row, of up to 8 bytes a pixel, for every frame, and metadata.
    let rows = (frames + 4) * 8 * u64::from(width);
    let bytes = usize::try_from(METADATA + rows).unwrap_or(usize::MAX);
    decoder.set_limits(Limits { bytes });
    decoder.read_info()
}

/// The EXIF data of the PNG in `path` that comes after its picture, as some programs write it; none if it takes too
/// much memory. Damage is left to the decoder.
///
/// # Errors
/// When the file cannot be opened.
pub(super) fn late_exif(path: &Path) -> Result<Option<Vec<u8>>> {
    let mut file = BufReader::new(detect::open(path)?);
    let mut find = || -> io::Result<Option<Vec<u8>>> {
        file.seek_relative(8)?;
        let mut header = [0; 8];
        while fill(&mut file, &mut header)? && &header[4..] != b"IEND" {
            if &header[4..] == b"eXIf" && u64::from(length(header)) <= METADATA {
                let mut exif = vec![0; length(header) as usize];
                return Ok(fill(&mut file, &mut exif)?.then_some(exif));
            }
            file.seek_relative(i64::from(length(header)) + 4)?;
        }
        Ok(None)
    };
    Ok(find().unwrap_or(None))
}

/// A PNG's bytes, without the chunks of a kind.
#[derive(Debug)]
pub(super) struct Chunks {
    file: File,
    without: Option<&'static [u8; 4]>,
    state: State,
}

/// What of a PNG comes next.
#[derive(Clone, Copy, Debug)]
enum State {
    /// The signature, which has as many bytes as a chunk's header.
    Start,
    /// The header of a chunk.
    Header,
    /// So much of a header that was read, from a place on.
    Given([u8; 8], usize),
    /// The next bytes of a chunk, this many.
    Data(u64),
}

impl Read for Chunks {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let Some(without) = self.without else { return self.file.read(buffer) };
        loop {
            match self.state {
                State::Given(header, from) => {
                    let count = (&header[from..]).read(buffer)?;
                    self.state = match from + count {
                        8 if header == SIGNATURE => State::Header,
                        8 => State::Data(u64::from(length(header)) + 4),
                        given => State::Given(header, given),
                    };
                    return Ok(count);
                }
                State::Data(0) => self.state = State::Header,
                State::Data(left) => {
                    let count = (&mut self.file).take(left).read(buffer)?;
                    self.state = State::Data(left - count as u64);
                    return Ok(count);
                }
                State::Start | State::Header => {
                    let mut header = [0; 8];
                    if !fill(&mut self.file, &mut header)? {
                        return Ok(0);
                    }
                    if matches!(self.state, State::Header) && header[4..] == *without {
                        self.file.seek(SeekFrom::Current(i64::from(length(header)) + 4))?;
                    } else {
                        self.state = State::Given(header, 0);
                    }
                }
            }
        }
    }
}

/// What every PNG begins with.
const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// The length of a chunk's data.
fn length(header: [u8; 8]) -> u32 {
    let [a, b, c, d, ..] = header;
    u32::from_be_bytes([a, b, c, d])
}

// The decoder asks for it and makes no use of it.
impl Seek for Chunks {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// A fault of the decoder as one of the `image` crate, for its words.
pub(super) fn fault(error: png::DecodingError) -> ImageError {
    match error {
        png::DecodingError::IoError(e) => ImageError::IoError(e),
        png::DecodingError::LimitsExceeded => {
            ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory))
        }
        e => ImageError::Decoding(DecodingError::new(ImageFormat::Png.into(), e)),
    }
}

/// The size of the picture, or of the canvas.
pub(super) fn size(png: &Png) -> Size {
    Size::new(png.info().width, png.info().height)
}

/// Bytes of a pixel as it is decoded.
pub(super) fn bytes_per_pixel(png: &Png) -> u64 {
    let (colour, depth) = png.output_color_type();
    colour.samples() as u64 * if depth == BitDepth::Sixteen { 2 } else { 1 }
}

/// Whether the picture has colours, not only grays.
pub(super) fn is_colour(png: &Png) -> bool {
    !matches!(png.output_color_type().0, ColorType::Grayscale | ColorType::GrayscaleAlpha)
}

/// Whether samples have 16 bits.
pub(super) fn is_deep(png: &Png) -> bool {
    png.output_color_type().1 == BitDepth::Sixteen
}

/// Whether pixels may be transparent.
pub(super) fn has_alpha(png: &Png) -> bool {
    matches!(png.output_color_type().0, ColorType::Rgba | ColorType::GrayscaleAlpha)
}

/// The bytes of the next picture or frame, in rows of `stride` pixels. Four bytes an item, as RGBA needs them.
#[derive(Debug, Default)]
pub(super) struct Rows {
    bytes: Vec<Rgba>,
    stride: usize,
}

impl Rows {
    /// Reads the next picture of `png`. What is there of a picture that ends too early comes with the error.
    pub(super) fn read(&mut self, png: &mut Png) -> std::result::Result<(), ImageError> {
        let length = png.output_buffer_size().unwrap_or(0).div_ceil(4);
        if self.bytes.len() < length {
            // New memory that the system has zeroed takes no room before it is written.
            self.bytes = vec![[0; 4]; length];
        }
        let read = png.next_frame(self.bytes.as_flattened_mut());
        let frame = png.info().frame_control.map_or(png.info().width, |frame| frame.width);
        // Interlaced frames come in rows of the canvas's width, others in their own.
        self.stride = if png.info().interlaced { png.info().width } else { frame } as usize;
        read.map(|_| ()).map_err(fault)
    }

    /// The upper left `size` of what was read, as RGBA. Samples of 16 bits are converted by `to_srgb`, if there is
    /// one, before they are rounded.
    pub(super) fn pixels(
        &mut self,
        png: &Png,
        size: Size,
        to_srgb: Option<&DeepToSrgb>,
    ) -> Vec<Rgba> {
        let layout = png.output_color_type();
        let whole = self.stride == size.width as usize && self.bytes.len() == size.pixels();
        if whole && layout == (ColorType::Rgba, BitDepth::Eight) {
            return std::mem::take(&mut self.bytes);
        }
        let line = self.stride * bytes_per_pixel(png) as usize;
        let rows = self.bytes.as_flattened().chunks_exact(line.max(1)).take(size.height as usize);
        let mut pixels = Vec::with_capacity(size.pixels());
        for row in rows {
            if layout.1 == BitDepth::Sixteen {
                let channels = layout.0.samples();
                let values = row.as_chunks().0.iter().take(channels * size.width as usize);
                let values: Vec<u16> = values.map(|&bytes| u16::from_be_bytes(bytes)).collect();
                deep::push(&mut pixels, &values, channels, to_srgb);
            } else {
                push_row(&mut pixels, row, layout.0, size.width as usize);
            }
        }
        pixels
    }
}

/// Appends the first `width` pixels of `row`, of 8 bits a sample.
fn push_row(pixels: &mut Vec<Rgba>, row: &[u8], colour: ColorType, width: usize) {
    match colour {
        ColorType::Grayscale => pixels.extend(row.iter().take(width).map(|&v| [v, v, v, 255])),
        ColorType::GrayscaleAlpha => {
            pixels.extend(row.as_chunks().0.iter().take(width).map(|&[v, a]| [v, v, v, a]));
        }
        ColorType::Rgb => {
            pixels.extend(row.as_chunks().0.iter().take(width).map(|&[r, g, b]| [r, g, b, 255]));
        }
        // Palettes come as colours.
        ColorType::Rgba | ColorType::Indexed => {
            pixels.extend(row.as_chunks::<4>().0.iter().take(width));
        }
    }
}

/// The colour space that the chunks name; cICP wins over iCCP, that over sRGB, that over gAMA and cHRM
/// (PNG specification, third edition, 4.3). `None` if they name none, or sRGB.
pub(super) fn colour_space(png: &Png) -> Option<ColourSpace> {
    let info = png.info();
    if let Some(cicp) = info.coding_independent_code_points {
        return Some(ColourSpace::Cicp {
            primaries: cicp.color_primaries,
            transfer: cicp.transfer_function,
        });
    }
    if let Some(icc) = &info.icc_profile {
        return Some(ColourSpace::Icc(icc.to_vec()));
    }
    if info.srgb.is_some() || (info.gama_chunk.is_none() && info.chrm_chunk.is_none()) {
        return None;
    }
    let gamma = info.gama_chunk.map(|gamma| f64::from(gamma.into_value()));
    let primaries = info.chrm_chunk.map(|chrm| {
        let point = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x.into_value(), y.into_value()];
        Primaries {
            white: point(chrm.white),
            red: point(chrm.red),
            green: point(chrm.green),
            blue: point(chrm.blue),
        }
    });
    Some(ColourSpace::Gamma { gamma, primaries })
}
