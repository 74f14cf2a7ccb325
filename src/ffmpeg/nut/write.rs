//! Writes raw video as a NUT stream, by which ffmpeg gets frames with exact times.
//!
//! Every frame is independent: before it is a syncpoint, and its header has its complete time, its size and a
//! checksum.

use std::io::{self, Write};

use super::packet::{ID, INFO, MAIN, STREAM, SYNCPOINT, crc, flag};
use crate::frame::Rational;
use crate::geom::Size;

/// Bits of a time that may be omitted. They never are, but a complete time is written as itself plus 2^bits.
const SHIFT: u32 = 14;
/// The only frame code that is used.
const CODE: u8 = 1;

/// Writes a NUT stream with one raw video.
pub struct NutWriter<W> {
    output: W,
}

fn number(out: &mut Vec<u8>, value: u64) {
    let bytes = (64 - (value | 1).leading_zeros()).div_ceil(7);
    for i in (0..bytes).rev() {
        let more = if i > 0 { 128 } else { 0 };
        out.push((value >> (7 * i)) as u8 & 127 | more);
    }
}

fn signed(out: &mut Vec<u8>, value: i64) {
    number(out, 2 * value.unsigned_abs() - u64::from(value > 0));
}

fn text(out: &mut Vec<u8>, text: &str) {
    number(out, text.len() as u64);
    out.extend_from_slice(text.as_bytes());
}

/// `contents` as a packet: start code, length, contents, checksum. All are short.
fn packet(out: &mut Vec<u8>, code: u64, contents: &[u8]) {
    out.extend(code.to_be_bytes());
    number(out, contents.len() as u64 + 4);
    out.extend_from_slice(contents);
    out.extend(crc(contents).to_be_bytes());
}

fn main_header(time_base: Rational) -> Vec<u8> {
    let mut out = Vec::new();
    // Version, number of streams, distance of syncpoints, time bases.
    for value in [3, 1, 65536, 1, time_base.num as u64, time_base.den as u64] {
        number(&mut out, value);
    }
    let used = flag::KEY | flag::CODED_PTS | flag::SIZE_MSB | flag::CHECKSUM;
    // 256 codes: 0, the one in use, and all others except `N`, which is not counted.
    for (flags, count) in [(flag::INVALID, 1), (used, 1), (flag::INVALID, 253)] {
        number(&mut out, flags);
        // Six fields follow: time delta, multiplier, stream, size, reserved, count.
        number(&mut out, 6);
        signed(&mut out, 0);
        for value in [1, 0, 0, 0, count] {
            number(&mut out, value);
        }
    }
    // No elision headers; ffmpeg needs the count.
    number(&mut out, 0);
    out
}

fn stream_header(size: Size, fourcc: [u8; 4]) -> Vec<u8> {
    let mut out = vec![0, 0, 4];
    out.extend(fourcc);
    // Time base 0, SHIFT, largest step in time without a checksum, no delay, flags or extra data, size, square
    // pixels, no colour space.
    let (width, height) = (u64::from(size.width), u64::from(size.height));
    for value in [0, u64::from(SHIFT), 1 << 20, 0, 0, 0, width, height, 1, 1, 0] {
        number(&mut out, value);
    }
    out
}

/// Writes the nominal rate, which the demuxer would otherwise guess from the first frames.
fn rate_info(rate: Rational) -> Vec<u8> {
    // Stream 0 (plus one), no chapter, start, length; one entry, of text (-1).
    let mut out = vec![1, 0, 0, 0, 1];
    text(&mut out, "r_frame_rate");
    signed(&mut out, -1);
    text(&mut out, &format!("{}/{}", rate.num, rate.den));
    out
}

impl<W: Write> NutWriter<W> {
    /// Starts a stream of frames of `size` in the pixel format `fourcc`, with times in units of `time_base`
    /// (positive, both parts below 2^31).
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(
        mut output: W,
        size: Size,
        fourcc: [u8; 4],
        time_base: Rational,
        rate: Option<Rational>,
    ) -> io::Result<Self> {
        let mut out = ID.to_vec();
        packet(&mut out, MAIN, &main_header(time_base));
        packet(&mut out, STREAM, &stream_header(size, fourcc));
        if let Some(rate) = rate {
            packet(&mut out, INFO, &rate_info(rate));
        }
        output.write_all(&out)?;
        Ok(Self { output })
    }

    /// Writes a frame that is shown from `pts` on (at least 0, in units of the time base).
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&mut self, pts: u64, data: &[u8]) -> io::Result<()> {
        let mut sync = Vec::new();
        number(&mut sync, pts);
        number(&mut sync, 0);
        let mut out = Vec::new();
        packet(&mut out, SYNCPOINT, &sync);
        let start = out.len();
        out.push(CODE);
        number(&mut out, pts + (1 << SHIFT));
        number(&mut out, data.len() as u64);
        let checksum = crc(&out[start..]);
        out.extend(checksum.to_be_bytes());
        self.output.write_all(&out)?;
        self.output.write_all(data)?;
        self.output.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ffmpeg::nut::NutReader;

    const SIZE: Size = Size::new(3, 2);

    fn stream(times: &[u64], time_base: Rational) -> Vec<u8> {
        let mut bytes = Vec::new();
        let rate = Some(Rational::new(30000, 1001));
        let mut writer =
            NutWriter::new(&mut bytes, SIZE, *b"444P", time_base, rate).expect("memory");
        for (i, &time) in times.iter().enumerate() {
            writer.write(time, &[i as u8; 18]).expect("memory");
        }
        bytes
    }

    #[test]
    fn what_is_written_is_read() {
        let times = [0, 1, 128, 129, 1 << 20, 1 << 40];
        let time_base = Rational::new(1001, 30000);
        let bytes = stream(&times, time_base);
        let mut reader = NutReader::new(&bytes[..], 18).expect("own stream");
        assert_eq!((reader.size(), reader.fourcc()), (SIZE, *b"444P"));
        assert_eq!(reader.time_base(), time_base);
        let mut frame = Vec::new();
        for (i, &time) in times.iter().enumerate() {
            assert_eq!(reader.next(&mut frame).expect("a frame"), Some(time as i64));
            assert_eq!(frame, [i as u8; 18]);
        }
        assert_eq!(reader.next(&mut frame).expect("the end"), None);
    }

    #[test]
    fn a_stream_that_ends_in_a_frame_is_an_error() {
        let bytes = stream(&[0, 1], Rational::new(1, 25));
        let mut reader = NutReader::new(&bytes[..bytes.len() - 1], 18).expect("own stream");
        let mut frame = Vec::new();
        reader.next(&mut frame).expect("the first is whole");
        let error = reader.next(&mut frame).expect_err("the second is not");
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }

    #[test]
    fn frames_of_another_size_are_refused() {
        let bytes = stream(&[0], Rational::new(1, 25));
        let mut reader = NutReader::new(&bytes[..], 17).expect("own stream");
        assert!(reader.next(&mut Vec::new()).is_err());
    }
}
