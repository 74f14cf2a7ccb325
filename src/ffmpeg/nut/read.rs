//! Reads raw video from a NUT stream, by which ffmpeg passes frames with exact times.
//!
//! A damaged stream is an error: it comes through a pipe, which can only be cut short.

use std::io::{self, Read};

use crate::frame::Rational;
use crate::geom::Size;

use super::packet::{
    ID, LONG, MAIN, Main, Numbers, STREAM, SYNCPOINT, Stream, broken, flag, read_main, read_packet,
    read_stream,
};

/// A NUT stream with one raw video in it.
pub struct NutReader<R> {
    input: R,
    main: Main,
    stream: Stream,
    last_pts: i64,
    frame_bytes: usize,
}

impl<R: Read> NutReader<R> {
    /// Reads the headers of `input`. Every frame must have `frame_bytes` bytes, which bounds the memory.
    ///
    /// # Errors
    /// When the headers cannot be read (`UnexpectedEof` when the stream is empty) or do not hold one
    /// video stream.
    pub fn new(mut input: R, frame_bytes: usize) -> io::Result<Self> {
        let mut id = [0; ID.len()];
        input.read_exact(&mut id)?;
        if id != ID {
            return Err(broken("the stream does not begin as one"));
        }
        let (code, packet) = read_packet(&mut input, None)?;
        if code != MAIN {
            return Err(broken("no main header"));
        }
        let main = read_main(&packet)?;
        loop {
            let (code, packet) = read_packet(&mut input, None)?;
            if code == STREAM {
                let stream = read_stream(&packet, &main)?;
                return Ok(Self { input, main, stream, last_pts: 0, frame_bytes });
            }
        }
    }

    /// The size of the video.
    pub fn size(&self) -> Size {
        self.stream.size
    }

    /// The four-character code of its pixel format.
    pub fn fourcc(&self) -> [u8; 4] {
        self.stream.fourcc
    }

    /// The time unit, in seconds.
    pub fn time_base(&self) -> Rational {
        let (num, den) = self.main.time_bases[self.stream.time_base];
        Rational::new(num as i64, den as i64)
    }

    /// Reads the next frame into `out` and returns its time in units of the time base; `None` at the
    /// end.
    ///
    /// # Errors
    /// When the stream ends within a frame or is invalid.
    pub fn next(&mut self, out: &mut Vec<u8>) -> io::Result<Option<i64>> {
        loop {
            let mut first = [0];
            if read_some(&mut self.input, &mut first)? == 0 {
                return Ok(None);
            }
            if first[0] == b'N' {
                let (code, packet) = read_packet(&mut self.input, Some(b'N'))?;
                if code == SYNCPOINT {
                    self.synchronise(&packet)?;
                }
                continue;
            }
            return self.frame(first[0], out).map(Some);
        }
    }

    /// Reads the time of a syncpoint.
    fn synchronise(&mut self, mut packet: &[u8]) -> io::Result<()> {
        let bases = self.main.time_bases.len() as u64;
        let time = packet.number()?;
        let (num, den) = self.main.time_bases[(time % bases) as usize];
        let (own_num, own_den) = self.main.time_bases[self.stream.time_base];
        let scaled = u128::from(time / bases) * u128::from(num) * u128::from(own_den);
        self.last_pts = (scaled / (u128::from(den) * u128::from(own_num))) as i64;
        Ok(())
    }

    fn frame(&mut self, code: u8, out: &mut Vec<u8>) -> io::Result<i64> {
        let code = self.main.codes[usize::from(code)];
        let mut flags = code.flags;
        if flags & flag::INVALID != 0 {
            return Err(broken("a frame has an invalid code"));
        }
        let input = &mut self.input;
        if flags & flag::CODED != 0 {
            flags ^= input.number()?;
        }
        if flags & flag::SIDE_DATA != 0 {
            return Err(broken("a frame has side data"));
        }
        let stream = if flags & flag::STREAM_ID != 0 { input.number()? } else { code.stream };
        if stream != 0 {
            return Err(broken("there is more than one stream"));
        }
        let pts = if flags & flag::CODED_PTS != 0 {
            full_pts(input.number()?, self.stream.shift, self.last_pts)
        } else {
            self.last_pts.checked_add(code.delta)
        };
        let pts = pts.ok_or_else(|| broken("a frame's time is out of range"))?;
        let mut size = code.size;
        if flags & flag::SIZE_MSB != 0 {
            size = size.saturating_add(code.multiplier.saturating_mul(input.number()?));
        }
        if flags & flag::MATCH_TIME != 0 {
            input.signed()?;
        }
        let header = if flags & flag::HEADER_INDEX != 0 { input.number()? } else { code.header };
        let reserved = if flags & flag::RESERVED != 0 { input.number()? } else { code.reserved };
        for _ in 0..reserved {
            input.number()?;
        }
        if flags & flag::CHECKSUM != 0 {
            input.read_exact(&mut [0; 4])?;
        }
        if size != self.frame_bytes as u64 {
            return Err(broken(&format!("a frame has {size} bytes, not {}", self.frame_bytes)));
        }
        let header = if size > LONG { 0 } else { header as usize };
        let header = self.main.headers.get(header).ok_or_else(|| broken("no such header"))?;
        out.resize(self.frame_bytes, 0);
        let (start, rest) = out
            .split_at_mut_checked(header.len())
            .ok_or_else(|| broken("a frame is shorter than its header"))?;
        start.copy_from_slice(header);
        input.read_exact(rest)?;
        self.last_pts = pts;
        Ok(pts)
    }
}

/// Decodes a time: complete, or its last `shift` bits near the last time. `None` if it is out of range.
fn full_pts(coded: u64, shift: u32, last: i64) -> Option<i64> {
    let range = 1i64 << shift;
    let coded = i64::try_from(coded).ok()?;
    if coded >= range {
        return Some(coded - range);
    }
    let delta = last.checked_sub((range - 1) / 2)?;
    (coded.wrapping_sub(delta) & (range - 1)).checked_add(delta)
}

/// Reads until `buffer` is full or the input ends; returns the number of bytes.
fn read_some(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match input.read(buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            other => return other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet::Code;
    use super::*;

    #[test]
    fn short_times_are_those_near_the_last() {
        assert_eq!(full_pts(5, 7, 128), Some(133));
        assert_eq!(full_pts(120, 7, 130), Some(120));
        assert_eq!(full_pts(128 + 77, 7, 1_000_000), Some(77));
    }

    /// Found by the fuzz target `nut`: such times overflowed.
    #[test]
    fn times_out_of_range_are_none() {
        assert_eq!(full_pts(5, 7, i64::MIN), None);
        assert_eq!(full_pts(5, 7, i64::MAX), None);
        assert_eq!(full_pts(u64::MAX, 7, 0), None);
    }

    /// A reader of `input` behind headers whose only frame code is `code`.
    fn reader(code: Code, input: &[u8]) -> NutReader<&[u8]> {
        let main = Main {
            streams: 1,
            time_bases: vec![(1, 25)],
            codes: vec![code],
            headers: vec![vec![]],
        };
        let size = Size::new(1, 1);
        let stream = Stream { fourcc: *b"RGBA", time_base: 0, shift: 7, size };
        NutReader { input, main, stream, last_pts: i64::MAX, frame_bytes: 4 }
    }

    /// Found by the fuzz target `nut`: both overflowed.
    #[test]
    fn sizes_and_times_of_frames_do_not_overflow() {
        let large =
            Code { flags: flag::SIZE_MSB, multiplier: 1, size: u64::MAX, ..Code::default() };
        let late = Code { delta: 1, ..Code::default() };
        for (code, word) in [(large, "bytes"), (late, "time")] {
            let error = reader(code, &[0, 5]).next(&mut Vec::new()).expect_err("a broken frame");
            assert!(error.to_string().contains(word), "{error}");
        }
    }

    #[test]
    fn rubbish_is_an_error_not_a_panic() {
        for length in 0..64 {
            let bytes: Vec<u8> =
                ID.iter().copied().chain((0..length).map(|i: u8| i.wrapping_mul(37))).collect();
            assert!(NutReader::new(&bytes[..], 6).is_err());
        }
    }
}
