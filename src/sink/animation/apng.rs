//! APNG, by the crate `png`. The number of frames stands before the first one, and is put in at the end.

use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};

use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, Encoder, EncodingError, Filter};

use super::{Encode, Header, Piece, rounded};
use crate::frame::Rational;

/// A number of frames that is never reached: the encoder needs one.
const MANY: u32 = i32::MAX as u32;

/// Bytes at the start of the file in which the number of frames is: the header, and what the encoder puts after it.
const HEAD: u64 = 1 << 10;

pub(super) struct Apng {
    writer: png::Writer<BufWriter<File>>,
    file: File,
    frames: u32,
}

impl Apng {
    /// Begins a file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn begin(file: File, header: Header) -> io::Result<Self> {
        let out = BufWriter::with_capacity(1 << 16, file.try_clone()?);
        let mut encoder = Encoder::new(out, header.size.width, header.size.height);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        // As for stills.
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Paeth);
        encoder.set_animated(MANY, header.loops.plays()).map_err(failed)?;
        encoder.set_blend_op(BlendOp::Source).map_err(failed)?;
        encoder.set_dispose_op(DisposeOp::None).map_err(failed)?;
        let writer = encoder.write_header().map_err(failed)?;
        Ok(Self { writer, file, frames: 0 })
    }
}

impl Encode for Apng {
    fn piece(&mut self, piece: &Piece<'_>) -> io::Result<()> {
        let (num, den) = delay(piece.start, piece.length);
        let (area, size) = (piece.area, piece.area.size());
        let writer = &mut self.writer;
        writer.set_frame_delay(num, den).map_err(failed)?;
        if self.frames > 0 {
            // The position first goes where any size fits.
            writer.reset_frame_position().map_err(failed)?;
            writer.set_frame_dimension(size.width, size.height).map_err(failed)?;
            writer.set_frame_position(area.x0, area.y0).map_err(failed)?;
        }
        self.frames += 1;
        writer.write_image_data(piece.pixels.as_flattened()).map_err(failed)
    }

    fn end(self: Box<Self>) -> io::Result<()> {
        let Self { writer, mut file, frames } = *self;
        writer.finish().map_err(failed)?;
        file.seek(SeekFrom::Start(0))?;
        let mut head = Vec::new();
        Read::by_ref(&mut file).take(HEAD).read_to_end(&mut head)?;
        let at = head.windows(4).position(|name| name == b"acTL");
        let chunk = at.and_then(|at| Some((at, head.get_mut(at..at + 12)?)));
        let (at, chunk) =
            chunk.ok_or_else(|| io::Error::other("the animation has no control chunk"))?;
        chunk[4..8].copy_from_slice(&frames.to_be_bytes());
        let checksum = crc32fast::hash(chunk).to_be_bytes();
        file.seek(SeekFrom::Start(at as u64))?;
        file.write_all(&[&*chunk, &checksum].concat())
    }
}

fn failed(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        error => io::Error::other(error),
    }
}

/// The delay as a fraction: exact if it fits, else of whole milliseconds, or of what else fits.
fn delay(start: Rational, length: Rational) -> (u16, u16) {
    let exact = (u16::try_from(length.num), u16::try_from(length.den));
    if let (Ok(num), Ok(den)) = exact {
        return (num, den);
    }
    let units = [1000, 100, 10, 1];
    let fitting = units.into_iter().find_map(|units| {
        let delay = rounded(start + length, units.into()) - rounded(start, units.into());
        Some((u16::try_from(delay).ok()?, units))
    });
    fitting.unwrap_or((u16::MAX, 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_exact_or_add_up() {
        let at = |num, den| Rational::new(num, den);
        assert_eq!(delay(at(0, 1), at(1001, 30000)), (1001, 30000));
        assert_eq!(delay(at(5, 1), at(100, 1)), (100, 1));
        let third = at(33_333, 100_000);
        let (mut start, mut sum) = (Rational::ZERO, 0);
        for _ in 0..300 {
            let (num, den) = delay(start, third);
            assert_eq!(den, 1000);
            (start, sum) = (start + third, sum + u32::from(num));
        }
        assert_eq!(sum, 100_000 - 1);
    }
}
