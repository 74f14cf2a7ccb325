//! WebP (WebP container specification): reads the chunks of an animation, decodes each of its frames as a still, and
//! composes them.

use std::fs::File;
use std::io::{BufReader, Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use image::codecs::webp::WebPDecoder;
use image::error::{DecodingError, LimitError, LimitErrorKind};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageResult};

use super::animation::{Facts, Lengths};
use super::apng::fill;
use super::canvas::{Area, Canvas, Disposal};
use super::detect;
use super::limit::{Limit, METADATA};
use super::profile::{ColourSpace, ToSrgb};
use crate::error::{Error, Result};
use crate::frame::{Rational, Rgba};
use crate::geom::Size;
use crate::stream::Loops;

/// Bits of the extended header's flags.
const ANIMATION: u8 = 0x02;
const ALPHA: u8 = 0x10;

/// Reads the chunks of the WebP in `path`; `None` if it is no animation.
///
/// # Errors
/// When it cannot be read.
pub(crate) fn facts(path: &Path) -> Result<Option<Facts>> {
    let file = detect::open(path)?;
    let unreadable = |e| Error::input(path, format!("cannot be read: {e}")).caused_by(e);
    let length = file.metadata().map_err(unreadable)?.len();
    chunks(&mut BufReader::new(file), length).map_err(unreadable)
}

/// Whether the file `path` is as long as its header says. The decoder reports a shorter one as broken.
///
/// # Errors
/// When it cannot be read.
pub(crate) fn is_complete(path: &Path) -> Result<bool> {
    let mut file = detect::open(path)?;
    let unreadable = |e| Error::input(path, format!("cannot be read: {e}")).caused_by(e);
    let length = file.metadata().map_err(unreadable)?.len();
    let mut start = [0; 8];
    Ok(fill(&mut file, &mut start).map_err(unreadable)? && length >= file_end(&start))
}

/// The end of the file, by its header.
fn file_end(start: &[u8]) -> u64 {
    8 + u64::from(le32(start, 4))
}

fn chunks(file: &mut BufReader<File>, file_length: u64) -> std::io::Result<Option<Facts>> {
    let mut start = [0; 30];
    // The extended header is the first chunk, if there is one, and only it can announce an animation.
    if !fill(file, &mut start)? || &start[12..16] != b"VP8X" || start[20] & ANIMATION == 0 {
        return Ok(None);
    }
    let mut facts = Facts {
        size: Size::new(le24(&start, 24) + 1, le24(&start, 27) + 1),
        alpha: start[20] & ALPHA != 0,
        loops: Loops::Forever,
        lengths: Lengths::NONE,
        complete: false,
    };
    let end = file_end(&start);
    facts.complete = file_length >= end;
    let mut at = start.len() as u64;
    let mut header = [0; 8];
    while at < end && fill(file, &mut header)? {
        let length = le32(&header, 4);
        let mut head = [0; 16];
        let known = head.len().min(length as usize);
        if !fill(file, &mut head[..known])? {
            break;
        }
        // Chunks are padded to an even length.
        let padded = u64::from(length) + u64::from(length % 2);
        at += 8 + padded;
        match &header[..4] {
            b"ANIM" => {
                facts.loops = match u16::from_le_bytes([head[4], head[5]]) {
                    0 => Loops::Forever,
                    1 => Loops::Once,
                    n => Loops::Times(n.into()),
                }
            }
            b"ANMF" if at <= file_length => {
                facts.lengths.add(Rational::new(le24(&head, 12).into(), 1000));
            }
            _ => {}
        }
        file.seek_relative(padded as i64 - known as i64)?;
    }
    Ok(Some(facts))
}

/// The frames of an animated WebP, composed one after the other.
pub(super) struct WebP {
    file: BufReader<File>,
    /// The start of the next chunk, and the end of the last one.
    at: u64,
    end: u64,
    canvas: Canvas,
    size: Size,
    limit: Limit,
    to_srgb: Option<ToSrgb>,
}

/// The header of a frame.
struct Head {
    area: Area,
    size: Size,
    length: Rational,
    disposal: Disposal,
    blend: bool,
}

/// Bytes of the file's header, and of the extended one.
const START: u64 = 30;

impl WebP {
    /// The frames of the WebP in `path`, of a canvas of `size`.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(super) fn open(path: &Path, size: Size, limit: Limit) -> Result<Self> {
        let mut file = BufReader::new(detect::open(path)?);
        let mut start = [0; START as usize];
        let read = fill(&mut file, &mut start);
        let canvas = Size::new(le24(&start, 24) + 1, le24(&start, 27) + 1);
        if !read.is_ok_and(|whole| whole && canvas == size) {
            return Err(Error::input(path, "has changed since its header was read; start again"));
        }
        let (at, end, canvas) = (START, file_end(&start), Canvas::new(size));
        Ok(Self { file, at, end, canvas, size, limit, to_srgb: None })
    }

    /// The next frame and its duration; `None` after the last one.
    pub(super) fn next(&mut self) -> ImageResult<Option<(Vec<Rgba>, Rational)>> {
        while let Some((kind, length)) = self.header()? {
            match &kind {
                b"ICCP" if u64::from(length) <= METADATA => {
                    let space = ColourSpace::Icc(self.data(length)?);
                    self.to_srgb = ToSrgb::new(&space, false);
                }
                b"ANMF" => {
                    let data = self.data(length)?;
                    let head = head(&data, self.size)?;
                    let drawn = self.decoded(&data[16..], head.size)?;
                    return Ok(Some((self.composed(&head, &drawn), head.length)));
                }
                _ => {}
            }
        }
        Ok(None)
    }

    /// The kind and length of the next chunk; moves on to the one after it.
    fn header(&mut self) -> ImageResult<Option<([u8; 4], u32)>> {
        let mut header = [0; 8];
        self.file.seek(SeekFrom::Start(self.at))?;
        if self.at >= self.end || !fill(&mut self.file, &mut header)? {
            return Ok(None);
        }
        let length = le32(&header, 4);
        self.at += 8 + u64::from(length) + u64::from(length % 2);
        Ok(Some(([header[0], header[1], header[2], header[3]], length)))
    }

    /// The data of the chunk whose header was read last.
    fn data(&mut self, length: u32) -> ImageResult<Vec<u8>> {
        if u64::from(length) > self.limit.0 {
            let kind = LimitErrorKind::InsufficientMemory;
            return Err(ImageError::Limits(LimitError::from_kind(kind)));
        }
        let mut data = Vec::new();
        (&mut self.file).take(length.into()).read_to_end(&mut data)?;
        if data.len() < length as usize {
            return Err(ImageError::IoError(ErrorKind::UnexpectedEof.into()));
        }
        Ok(data)
    }

    /// Decodes the picture in `chunks`, of a frame of `size`, as a still.
    fn decoded(&self, chunks: &[u8], size: Size) -> ImageResult<Vec<Rgba>> {
        let still = still(chunks, size)?;
        let mut decoder = WebPDecoder::new(Cursor::new(still))?;
        if decoder.dimensions() != (size.width, size.height) {
            return Err(broken("a frame's picture has another size than the frame"));
        }
        let mut limits = image::Limits::no_limits();
        limits.max_alloc = Some(self.limit.0);
        decoder.set_limits(limits)?;
        if decoder.color_type() == ColorType::Rgba8 {
            let mut pixels = vec![[0; 4]; size.pixels()];
            decoder.read_image(pixels.as_flattened_mut())?;
            return Ok(pixels);
        }
        let mut bytes = vec![0; 3 * size.pixels()];
        decoder.read_image(&mut bytes)?;
        Ok(bytes.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect())
    }

    fn composed(&mut self, head: &Head, drawn: &[Rgba]) -> Vec<Rgba> {
        self.canvas.begin(head.area, head.disposal);
        if head.blend {
            self.canvas.draw(head.area, drawn, over);
        } else {
            self.canvas.draw(head.area, drawn, |new, _| new);
        }
        let mut pixels = self.canvas.pixels().to_vec();
        if let Some(to_srgb) = &self.to_srgb {
            to_srgb.apply(&mut pixels);
        }
        pixels
    }
}

fn broken(what: &str) -> ImageError {
    ImageError::Decoding(DecodingError::new(ImageFormat::WebP.into(), what))
}

/// Reads the header of a frame before its chunks.
fn head(data: &[u8], canvas: Size) -> ImageResult<Head> {
    if data.len() < 16 {
        return Err(broken("a frame without a header"));
    }
    let (x, y) = (2 * le24(data, 0), 2 * le24(data, 3));
    let size = Size::new(le24(data, 6) + 1, le24(data, 9) + 1);
    let area = Area::at(x, y, size);
    if area.clipped(canvas) != area {
        return Err(broken("a frame outside of the canvas"));
    }
    Ok(Head {
        area,
        size,
        length: Rational::new(le24(data, 12).into(), 1000),
        disposal: if data[15] & 1 == 0 { Disposal::Keep } else { Disposal::Background },
        blend: data[15] & 2 == 0,
    })
}

/// A still WebP from the `chunks` of a frame: the lossless picture, or the lossy one and its alpha.
fn still(chunks: &[u8], size: Size) -> ImageResult<Vec<u8>> {
    let mut body = b"WEBP".to_vec();
    let mut alpha: &[u8] = &[];
    let mut rest = chunks;
    while rest.len() >= 8 {
        let length = le32(rest, 4) as usize;
        let end = (8 + length).min(rest.len());
        let (chunk, after) = rest.split_at(end);
        rest = after.get(length % 2..).unwrap_or_default();
        match &chunk[..4] {
            b"ALPH" => alpha = chunk,
            b"VP8L" => {
                push(&mut body, chunk);
                // Alpha is used whatever the header says, as by libwebp.
                if let Some(flags) = body.get_mut(4 + 8 + 4) {
                    *flags |= 1 << 4;
                }
                return Ok(riff(&body));
            }
            b"VP8 " => {
                if !alpha.is_empty() {
                    let side = |v: u32| (v - 1).to_le_bytes();
                    let (w, h) = (side(size.width), side(size.height));
                    let extended = [ALPHA, 0, 0, 0, w[0], w[1], w[2], h[0], h[1], h[2]];
                    push(&mut body, &[&b"VP8X\x0a\0\0\0"[..], &extended].concat());
                    push(&mut body, alpha);
                }
                push(&mut body, chunk);
                return Ok(riff(&body));
            }
            _ => {}
        }
    }
    Err(broken("a frame without a picture"))
}

/// Appends a chunk, padded to an even length.
fn push(body: &mut Vec<u8>, chunk: &[u8]) {
    body.extend_from_slice(chunk);
    body.resize(body.len().next_multiple_of(2), 0);
}

fn riff(body: &[u8]) -> Vec<u8> {
    [b"RIFF", &(body.len() as u32).to_le_bytes()[..], body].concat()
}

/// `new` composed over `old` with straight alpha, in integers as in libwebp's animation decoder (except that the
/// remaining old alpha is rounded to the nearest).
fn over(new: Rgba, old: Rgba) -> Rgba {
    if new[3] == 0 {
        return old;
    }
    let alpha = u32::from(new[3]);
    let product = u32::from(old[3]) * (255 - alpha) + 128;
    let left = (product + (product >> 8)) >> 8;
    let scale = (1 << 24) / (alpha + left);
    let mix = |c: usize| ((u32::from(new[c]) * alpha + u32::from(old[c]) * left) * scale) >> 24;
    [mix(0) as u8, mix(1) as u8, mix(2) as u8, (alpha + left) as u8]
}

fn le24(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], 0])
}

fn le32(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
