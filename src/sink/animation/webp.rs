//! Lossless animated WebP: pictures of the crate `image`, in the chunks of an animation. Source: Google's "WebP
//! Container Specification".

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageError};

use super::{Encode, Header, Piece, rounded};

/// Flags of the header.
const ANIMATION: u8 = 0x02;
const ALPHA: u8 = 0x10;
/// Where they stand in the file.
const FLAGS_AT: u64 = 20;
/// A frame replaces what is under it, and stays.
const REPLACE: u8 = 0x02;
/// Bytes of a still before its only chunk.
const STILL_HEAD: usize = 12;

pub(super) struct WebP {
    out: BufWriter<File>,
    has_alpha: bool,
    still: Vec<u8>,
    rgb: Vec<u8>,
}

/// The three lower bytes of `value`.
fn le24(value: u32) -> [u8; 3] {
    let [a, b, c, _] = value.to_le_bytes();
    [a, b, c]
}

impl WebP {
    /// Begins a file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn begin(file: File, header: Header) -> io::Result<Self> {
        let mut out = BufWriter::with_capacity(1 << 16, file);
        // Length and flags are put in at the end.
        out.write_all(b"RIFF\0\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0")?;
        out.write_all(&le24(header.size.width - 1))?;
        out.write_all(&le24(header.size.height - 1))?;
        let plays = u16::try_from(header.loops.plays()).unwrap_or(u16::MAX);
        out.write_all(b"ANIM\x06\0\0\0\0\0\0\0")?;
        out.write_all(&plays.to_le_bytes())?;
        Ok(Self { out, has_alpha: false, still: Vec::new(), rgb: Vec::new() })
    }

    /// Encodes `piece` as a still picture.
    fn encode(&mut self, piece: &Piece<'_>) -> Result<(), ImageError> {
        self.still.clear();
        let size = piece.area.size();
        let encoder = WebPEncoder::new_lossless(&mut self.still);
        if !piece.is_opaque {
            let bytes = piece.pixels.as_flattened();
            return encoder.encode(bytes, size.width, size.height, ExtendedColorType::Rgba8);
        }
        self.rgb.clear();
        self.rgb.extend(piece.pixels.iter().flat_map(|[r, g, b, _]| [r, g, b]));
        encoder.encode(&self.rgb, size.width, size.height, ExtendedColorType::Rgb8)
    }
}

impl Encode for WebP {
    fn piece(&mut self, piece: &Piece<'_>) -> io::Result<()> {
        self.has_alpha |= !piece.is_opaque;
        self.encode(piece).map_err(|error| match error {
            ImageError::IoError(error) => error,
            error => io::Error::other(error),
        })?;
        let chunk = self.still.get(STILL_HEAD..).filter(|chunk| chunk.starts_with(b"VP8L"));
        let chunk =
            chunk.ok_or_else(|| io::Error::other("the encoder wrote no lossless picture"))?;
        let length = 16 + chunk.len() as u64;
        let length = u32::try_from(length).map_err(|_| too_long())?;
        let milliseconds = rounded(piece.start + piece.length, 1000) - rounded(piece.start, 1000);
        let delay = milliseconds.clamp(0, (1 << 24) - 1) as u32;
        let (area, size) = (piece.area, piece.area.size());
        let out = &mut self.out;
        out.write_all(b"ANMF")?;
        out.write_all(&length.to_le_bytes())?;
        for value in [area.x0 / 2, area.y0 / 2, size.width - 1, size.height - 1, delay] {
            out.write_all(&le24(value))?;
        }
        out.write_all(&[REPLACE])?;
        out.write_all(chunk)
    }

    fn end(mut self: Box<Self>) -> io::Result<()> {
        let length = self.out.stream_position()?;
        let length = u32::try_from(length - 8).map_err(|_| too_long())?;
        self.out.seek(SeekFrom::Start(4))?;
        self.out.write_all(&length.to_le_bytes())?;
        self.out.seek(SeekFrom::Start(FLAGS_AT))?;
        self.out.write_all(&[ANIMATION | if self.has_alpha { ALPHA } else { 0 }])?;
        self.out.flush()
    }
}

fn too_long() -> io::Error {
    io::Error::other("a WebP has at most 4 GiB")
}
