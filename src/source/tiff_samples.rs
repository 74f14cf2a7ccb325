//! Reads TIFFs that the `image` crate refuses or reads wrongly, chunk by chunk: gray with alpha or of few bits,
//! palettes, whole numbers of 32 bits, tiles of planes or of LZW, planes of CMYK, and JPEG's YCbCr.

use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

use image::error::{DecodingError, LimitError, LimitErrorKind};
use image::{ImageError, ImageFormat};
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use crate::frame::Rgba;
use crate::geom::Size;

/// What the samples of a pixel are.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Gray, then alpha.
    Gray {
        /// Whether 0 is white.
        is_inverted: bool,
    },
    /// Places in a palette, then alpha.
    Palette(Vec<[u8; 3]>),
    /// Red, green, blue, alpha.
    Colour,
    /// Luma and chroma of all codes, as in JPEG.
    YCbCr,
    /// Inks.
    Cmyk,
}

/// How the samples of a picture are stored.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stored {
    /// Width and height as stored.
    pub(super) size: Size,
    pub(super) meaning: Meaning,
    /// Samples of a pixel, of which four count.
    pub(super) channels: usize,
    /// Bits of a sample.
    pub(super) bits: u8,
    /// Whether each sample has a plane of its own.
    pub(super) planar: bool,
    /// The size of tiles, if there are some. The decoder is to read them whole, those at the border, too: of planes it
    /// cannot tell which are there, and of LZW it takes parts of rows for a broken end (image-tiff, issue 395).
    pub(super) tile: Option<Size>,
}

/// Reads the samples, four a pixel.
type Decode = dyn FnOnce(&Stored) -> Result<Vec<Rgba>, TiffError>;

/// A picture whose pixels are decoded here.
pub(super) struct Samples {
    decode: Box<Decode>,
    stored: Stored,
}

impl Samples {
    /// The picture in `file`, which is decoded within `limits`; `None` if it is broken.
    pub(super) fn new<R: Read + Seek + 'static>(
        file: R,
        stored: Stored,
        limits: Limits,
    ) -> Option<Self> {
        let mut values = Vec::new();
        // The decoder refuses palettes, and gray of several samples with white as 0.
        if matches!(stored.meaning, Meaning::Gray { .. } | Meaning::Palette(_)) {
            values.push((Tag::PhotometricInterpretation, 1));
        }
        if let Some(tile) = stored.tile {
            values.push((Tag::ImageWidth, stored.size.width.checked_next_multiple_of(tile.width)?));
            values.push((
                Tag::ImageLength,
                stored.size.height.checked_next_multiple_of(tile.height)?,
            ));
        }
        let decoder = Decoder::new(Replaced::new(file, &values).ok()?).ok()?.with_limits(limits);
        Some(Self { decode: Box::new(move |stored| samples(decoder, stored)), stored })
    }

    /// Width and height as stored.
    pub(super) fn size(&self) -> Size {
        self.stored.size
    }

    /// Whether pixels have a sample beyond their colours.
    pub(super) fn has_extra(&self) -> bool {
        self.stored.has_extra()
    }

    /// Bytes of memory for a pixel: all may be one chunk.
    pub(super) fn bytes_per_pixel(&self) -> u64 {
        let bytes = u64::from(self.stored.bits).div_ceil(8);
        if self.stored.planar { bytes } else { bytes * self.stored.channels as u64 }
    }

    /// Decodes the picture.
    ///
    /// # Errors
    /// When it is broken or ends too early.
    pub(super) fn decode(self) -> Result<Vec<Rgba>, ImageError> {
        let mut pixels = (self.decode)(&self.stored).map_err(fault)?;
        self.stored.colour(&mut pixels);
        Ok(pixels)
    }
}

impl Stored {
    fn has_extra(&self) -> bool {
        match self.meaning {
            Meaning::Gray { .. } | Meaning::Palette(_) => self.channels > 1,
            Meaning::Colour => self.channels > 3,
            Meaning::YCbCr | Meaning::Cmyk => false,
        }
    }

    /// Turns samples into colours.
    fn colour(&self, pixels: &mut [Rgba]) {
        let extra = self.has_extra();
        let alpha = |a: u8| if extra { a } else { 255 };
        for pixel in pixels {
            let [a, b, c, d] = *pixel;
            *pixel = match &self.meaning {
                Meaning::Gray { is_inverted } => {
                    let gray = if *is_inverted { 255 - a } else { a };
                    [gray, gray, gray, alpha(b)]
                }
                Meaning::Palette(colours) => {
                    let [red, green, blue] = colours.get(usize::from(a)).copied().unwrap_or([0; 3]);
                    [red, green, blue, alpha(b)]
                }
                Meaning::Colour => [a, b, c, alpha(d)],
                Meaning::YCbCr => from_ycbcr([a, b, c]),
                Meaning::Cmyk => {
                    let light = |ink: u8| {
                        (u32::from(255 - ink) * u32::from(255 - d) + 127).div_euclid(255) as u8
                    };
                    [light(a), light(b), light(c), 255]
                }
            };
        }
    }

    /// The first sample of 8 bits, scaled to 255 if it is no place in a palette.
    fn scaled(&self, value: u64) -> u8 {
        if matches!(self.meaning, Meaning::Palette(_)) {
            return value as u8;
        }
        let most = u128::from(u64::MAX >> (64 - self.bits.min(64)));
        ((u128::from(value) * 255 + most / 2) / most) as u8
    }
}

/// ITU-R BT.601 of all codes.
fn from_ycbcr([y, cb, cr]: [u8; 3]) -> Rgba {
    let (y, cb, cr) = (f32::from(y), f32::from(cb) - 128.0, f32::from(cr) - 128.0);
    let code = |v: f32| v.round().clamp(0.0, 255.0) as u8;
    [code(y + 1.402 * cr), code(y - 0.344_136 * cb - 0.714_136 * cr), code(y + 1.772 * cb), 255]
}

/// The samples of all chunks, four a pixel.
fn samples<R: Read + Seek>(
    mut decoder: Decoder<R>,
    stored: &Stored,
) -> Result<Vec<Rgba>, TiffError> {
    let (width, height) = (stored.size.width as usize, stored.size.height as usize);
    let (wide, high) = decoder.chunk_dimensions();
    let (wide, high) = (wide as usize, high as usize);
    if wide == 0 || high == 0 {
        return Err(TiffError::IntSizeError);
    }
    let (across, down) = (width.div_ceil(wide), height.div_ceil(high));
    let planes = if stored.planar { stored.channels.min(4) } else { 1 };
    let mut pixels = vec![[0; 4]; stored.size.pixels()];
    for chunk in 0..across * down * planes {
        let (plane, place) = (chunk / (across * down), chunk % (across * down));
        let (x, y) = (place % across * wide, place / across * high);
        let values = decoder.read_chunk(u32::try_from(chunk)?)?;
        let count = wide.min(width - x);
        let read = if stored.tile.is_some() { wide } else { count };
        for (i, row) in values_of(&values, stored, read).enumerate().take(height - y) {
            let from = (y + i) * width + x;
            put(&mut pixels[from..from + count], row, stored, plane);
        }
    }
    Ok(pixels)
}

/// Puts a row of samples into pixels.
fn put(pixels: &mut [Rgba], row: Vec<u8>, stored: &Stored, plane: usize) {
    if stored.planar {
        pixels.iter_mut().zip(row).for_each(|(pixel, value)| pixel[plane] = value);
        return;
    }
    let used = stored.channels.min(4);
    for (pixel, values) in pixels.iter_mut().zip(row.chunks_exact(stored.channels)) {
        pixel[..used].copy_from_slice(&values[..used]);
    }
}

/// The rows of a chunk that is `width` wide, of 8 bits a sample.
fn values_of<'a>(
    chunk: &'a DecodingResult,
    stored: &'a Stored,
    width: usize,
) -> Box<dyn Iterator<Item = Vec<u8>> + 'a> {
    let count = if stored.planar { width } else { width * stored.channels };
    match chunk {
        DecodingResult::U8(bytes) if stored.bits < 8 => {
            let rows = bytes.chunks((count * usize::from(stored.bits)).div_ceil(8));
            Box::new(rows.map(move |row| unpacked(row, stored, count)))
        }
        DecodingResult::U8(values) => scaled_rows(values, count, stored),
        DecodingResult::U16(values) => scaled_rows(values, count, stored),
        DecodingResult::U32(values) => scaled_rows(values, count, stored),
        DecodingResult::F32(values) => {
            let code = |&v: &f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
            Box::new(values.chunks(count).map(move |row| row.iter().map(code).collect()))
        }
        _ => Box::new(std::iter::empty()),
    }
}

fn scaled_rows<'a, T: Copy + Into<u64>>(
    values: &'a [T],
    count: usize,
    stored: &'a Stored,
) -> Box<dyn Iterator<Item = Vec<u8>> + 'a> {
    let scaled = |row: &[T]| row.iter().map(|&v| stored.scaled(v.into())).collect();
    Box::new(values.chunks(count).map(scaled))
}

/// The samples of a row that are packed from the highest bit.
fn unpacked(row: &[u8], stored: &Stored, count: usize) -> Vec<u8> {
    let bits = usize::from(stored.bits);
    let value = |i: usize| {
        let byte = u64::from(row.get(i * bits / 8).copied().unwrap_or(0));
        byte >> (8 - bits - i * bits % 8) & ((1 << bits) - 1)
    };
    (0..count).map(|i| stored.scaled(value(i))).collect()
}

/// A fault of the decoder as one of the `image` crate, for its words.
fn fault(error: TiffError) -> ImageError {
    match error {
        TiffError::IoError(e) => ImageError::IoError(e),
        TiffError::LimitsExceeded => {
            ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory))
        }
        e => ImageError::Decoding(DecodingError::new(ImageFormat::Tiff.into(), e)),
    }
}

/// A file in which some numbers read as others, for a decoder that does not read what they say.
pub(super) struct Replaced<R> {
    file: R,
    place: u64,
    /// Where bytes are replaced, and by what.
    bytes: Vec<(u64, u8)>,
}

impl<R: Read + Seek> Replaced<R> {
    /// The TIFF in `file`, in whose first directory some tags have other values: `values` are pairs of a tag and its
    /// value.
    ///
    /// # Errors
    /// When it cannot be read, or a value has no room.
    pub(super) fn new(mut file: R, values: &[(Tag, u32)]) -> io::Result<Self> {
        file.rewind()?;
        let mut bytes = Vec::new();
        for entry in directory(&mut file)? {
            let Some(value) = values.iter().find(|(tag, _)| tag.to_u16() == entry.tag) else {
                continue;
            };
            let size = match entry.kind {
                3 => 2,
                4 => 4,
                _ => return Err(ErrorKind::InvalidData.into()),
            };
            let value = value.1.to_le_bytes();
            if value[size..].iter().any(|&byte| byte != 0) {
                return Err(ErrorKind::InvalidData.into());
            }
            let place = |i: usize| if entry.is_little { i } else { size - 1 - i };
            bytes.extend((0..size).map(|i| (entry.value + place(i) as u64, value[i])));
        }
        file.rewind()?;
        Ok(Self { file, place: 0, bytes })
    }
}

/// An entry of a directory.
struct Entry {
    tag: u16,
    kind: u16,
    /// Where its value is, if that is one number.
    value: u64,
    is_little: bool,
}

/// The entries of the first directory.
fn directory<R: Read + Seek>(file: &mut R) -> io::Result<Vec<Entry>> {
    let mut head = [0; 16];
    file.read_exact(&mut head[..8])?;
    let is_little = head[0] == b'I';
    let number = |bytes: &[u8]| {
        let digit = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        if is_little { bytes.iter().rev().fold(0, digit) } else { bytes.iter().fold(0, digit) }
    };
    let big = number(&head[2..4]) == 43;
    if big {
        file.read_exact(&mut head[8..])?;
    }
    let (at, count_size, entry_size, value) =
        if big { (number(&head[8..]), 8, 20, 12) } else { (number(&head[4..8]), 2, 12, 8) };
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = [0; 20];
    file.read_exact(&mut bytes[..count_size])?;
    let mut entries = Vec::new();
    for i in 0..number(&bytes[..count_size]).min(1 << 16) {
        file.read_exact(&mut bytes[..entry_size])?;
        entries.push(Entry {
            tag: number(&bytes[..2]) as u16,
            kind: number(&bytes[2..4]) as u16,
            value: at + count_size as u64 + i * entry_size as u64 + value,
            is_little,
        });
    }
    Ok(entries)
}

impl<R: Read> Read for Replaced<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        for &(at, byte) in &self.bytes {
            let there = at.checked_sub(self.place).and_then(|i| usize::try_from(i).ok());
            if let Some(there) = there.and_then(|i| buffer[..count].get_mut(i)) {
                *there = byte;
            }
        }
        self.place += count as u64;
        Ok(count)
    }
}

impl<R: Seek> Seek for Replaced<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.place = self.file.seek(to)?;
        Ok(self.place)
    }
}
