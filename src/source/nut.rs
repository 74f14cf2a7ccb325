//! Reads raw video out of a NUT stream, the container in which ffmpeg hands us frames with exact times.
//!
//! Follows the specification (<https://ffmpeg.org/~michael/nut.txt>, versions 3 and 4) for one stream
//! that is read from front to back: no index, no seeking, no resynchronisation. A damaged stream is
//! an error, as it comes through a pipe and cannot be damaged but by its end.

use std::io::{self, Read};

use crate::frame::Rational;
use crate::geom::Size;

/// What a NUT file begins with.
pub(crate) const ID: &[u8] = b"nut/multimedia container\0";
/// Start codes of packets that are not frames. All begin with `N`, which no frame does.
pub(crate) const MAIN: u64 = 0x4E4D_7A56_1F5F_04AD;
pub(crate) const STREAM: u64 = 0x4E53_1140_5BF2_F9DB;
pub(crate) const SYNCPOINT: u64 = 0x4E4B_E4AD_EECA_4569;
pub(crate) const INFO: u64 = 0x4E49_AB68_B596_BA78;
pub(crate) const INDEX: u64 = 0x4E58_DD67_2F23_E64E;

/// Flags of frames that we use or must understand.
pub(crate) mod flag {
    pub(crate) const KEY: u64 = 1;
    pub(crate) const CODED_PTS: u64 = 8;
    pub(crate) const STREAM_ID: u64 = 16;
    pub(crate) const SIZE_MSB: u64 = 32;
    pub(crate) const CHECKSUM: u64 = 64;
    pub(crate) const RESERVED: u64 = 128;
    pub(crate) const SIDE_DATA: u64 = 256;
    pub(crate) const HEADER_INDEX: u64 = 1024;
    pub(crate) const MATCH_TIME: u64 = 2048;
    pub(crate) const CODED: u64 = 4096;
    pub(crate) const INVALID: u64 = 8192;
}

/// Headers longer than this are none of ours.
const MAX_HEADER: u64 = 1 << 20;
/// From this size on a packet's header has a checksum of its own, and elision ends.
const LONG: u64 = 4096;

/// CRC-32 with generator 0x04C11DB7, most significant bit first, nothing inverted: over a block with
/// its checksum behind it, it is 0.
pub(crate) fn crc(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |crc: u32, &byte| {
        (0..8).fold(crc ^ u32::from(byte) << 24, |crc, _| {
            (crc << 1) ^ if crc >> 31 == 1 { 0x04C1_1DB7 } else { 0 }
        })
    })
}

fn broken(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("NUT: {what}"))
}

/// Reads numbers from a stream of bytes.
trait Numbers {
    fn byte(&mut self) -> io::Result<u8>;

    /// A number of any length (`v`): seven bits a byte, the most significant first.
    fn number(&mut self) -> io::Result<u64> {
        let mut value = 0u64;
        loop {
            let byte = self.byte()?;
            if value >> 57 != 0 {
                return Err(broken("a number is too large"));
            }
            value = value << 7 | u64::from(byte & 127);
            if byte & 128 == 0 {
                return Ok(value);
            }
        }
    }

    /// A signed number (`s`).
    fn signed(&mut self) -> io::Result<i64> {
        let value = (self.number()? + 1) as i64;
        Ok(if value & 1 == 1 { -(value >> 1) } else { value >> 1 })
    }
}

impl<R: Read> Numbers for R {
    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.read_exact(&mut byte)?;
        Ok(byte[0])
    }
}

/// What a frame code stands for.
#[derive(Clone, Copy, Default)]
struct Code {
    flags: u64,
    stream: u64,
    multiplier: u64,
    size: u64,
    delta: i64,
    reserved: u64,
    header: u64,
}

/// The main header.
struct Main {
    streams: u64,
    time_bases: Vec<(u64, u64)>,
    codes: Vec<Code>,
    /// Beginnings that frames may leave out; the first is empty.
    headers: Vec<Vec<u8>>,
}

/// The stream header.
struct Stream {
    fourcc: [u8; 4],
    time_base: usize,
    shift: u32,
    size: Size,
}

/// A NUT stream with one raw video in it.
pub struct NutReader<R> {
    input: R,
    main: Main,
    stream: Stream,
    last_pts: i64,
    frame_bytes: usize,
}

impl<R: Read> NutReader<R> {
    /// Reads the headers of `input`. Every frame must have `frame_bytes` bytes, which bounds what is
    /// taken into memory.
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

    /// The four letters that name its pixel format.
    pub fn fourcc(&self) -> [u8; 4] {
        self.stream.fourcc
    }

    /// Seconds of one unit of time.
    pub fn time_base(&self) -> Rational {
        let (num, den) = self.main.time_bases[self.stream.time_base];
        Rational::new(num as i64, den as i64)
    }

    /// Reads the next frame into `out` and returns its time in units of the time base; `None` at the
    /// end.
    ///
    /// # Errors
    /// When the stream ends within a frame or makes no sense.
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

    /// Takes over the time of a syncpoint.
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
            self.last_pts + code.delta
        };
        let mut size = code.size;
        if flags & flag::SIZE_MSB != 0 {
            size += code.multiplier.saturating_mul(input.number()?);
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

/// The time that `coded` stands for: whole, or its last `shift` bits near the time before.
fn full_pts(coded: u64, shift: u32, last: i64) -> i64 {
    let range = 1i64 << shift;
    let coded = coded as i64;
    if coded >= range {
        return coded - range;
    }
    let delta = last - (range - 1) / 2;
    (coded.wrapping_sub(delta) & (range - 1)) + delta
}

/// Reads until `buffer` is full or the input ends; returns how much there was.
fn read_some(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match input.read(buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            other => return other,
        }
    }
}

/// Reads a packet that is not a frame: its start code (whose first byte may have been read already)
/// and its contents without the checksum.
fn read_packet(input: &mut impl Read, first: Option<u8>) -> io::Result<(u64, Vec<u8>)> {
    let mut code = [0; 8];
    match first {
        Some(byte) => {
            code[0] = byte;
            input.read_exact(&mut code[1..])?;
        }
        None => input.read_exact(&mut code)?,
    }
    let code = u64::from_be_bytes(code);
    if ![MAIN, STREAM, SYNCPOINT, INFO, INDEX].contains(&code) {
        return Err(broken("an unknown packet"));
    }
    let length = input.number()?;
    if length > LONG {
        input.read_exact(&mut [0; 4])?;
    }
    if code == INDEX {
        // As long as the stream; of no use to us.
        io::copy(&mut input.take(length), &mut io::sink())?;
        return Ok((code, Vec::new()));
    }
    if !(4..=MAX_HEADER).contains(&length) {
        return Err(broken("a packet has an impossible length"));
    }
    let mut packet = vec![0; length as usize];
    input.read_exact(&mut packet)?;
    if crc(&packet) != 0 {
        return Err(broken("a packet's checksum is wrong"));
    }
    packet.truncate(packet.len() - 4);
    Ok((code, packet))
}

fn read_main(packet: &[u8]) -> io::Result<Main> {
    let mut input = packet;
    let version = input.number()?;
    if !(2..=4).contains(&version) {
        return Err(broken("an unknown version"));
    }
    if version > 3 {
        input.number()?;
    }
    let streams = input.number()?;
    let _distance = input.number()?;
    let count = input.number()?;
    if count == 0 || count > 256 {
        return Err(broken("an impossible number of time bases"));
    }
    let mut time_bases = Vec::new();
    for _ in 0..count {
        let base = (input.number()?, input.number()?);
        if !(1..1 << 31).contains(&base.0) || !(1..1 << 31).contains(&base.1) {
            return Err(broken("an impossible time base"));
        }
        time_bases.push(base);
    }
    let codes = read_codes(&mut input)?;
    let mut headers = vec![Vec::new()];
    if !input.is_empty() {
        for _ in 0..input.number()?.min(127) {
            let length = input.number()? as usize;
            let (header, rest) =
                input.split_at_checked(length).ok_or_else(|| broken("a header is cut short"))?;
            headers.push(header.to_vec());
            input = rest;
        }
    }
    Ok(Main { streams, time_bases, codes, headers })
}

/// The table of frame codes: runs of entries whose fields stay as they are until told otherwise.
fn read_codes(input: &mut &[u8]) -> io::Result<Vec<Code>> {
    let mut codes = Vec::with_capacity(256);
    let mut run = Code { multiplier: 1, ..Code::default() };
    while codes.len() < 256 {
        run.flags = input.number()?;
        let fields = input.number()?;
        if fields > 0 {
            run.delta = input.signed()?;
        }
        if fields > 1 {
            run.multiplier = input.number()?;
        }
        if fields > 2 {
            run.stream = input.number()?;
        }
        run.size = if fields > 3 { input.number()? } else { 0 };
        run.reserved = if fields > 4 { input.number()? } else { 0 };
        let count =
            if fields > 5 { input.number()? } else { run.multiplier.saturating_sub(run.size) };
        if fields > 6 {
            input.signed()?;
        }
        if fields > 7 {
            run.header = input.number()?;
        }
        for _ in 8..fields {
            input.number()?;
        }
        let left = 256 - codes.len() as u64 - u64::from(codes.len() <= usize::from(b'N'));
        if count == 0 || count > left {
            return Err(broken("an impossible run of frame codes"));
        }
        for step in 0..count {
            if codes.len() == usize::from(b'N') {
                codes.push(Code { flags: flag::INVALID, ..Code::default() });
            }
            codes.push(Code { size: run.size + step, ..run });
        }
        if codes.len() == usize::from(b'N') {
            codes.push(Code { flags: flag::INVALID, ..Code::default() });
        }
    }
    Ok(codes)
}

fn read_stream(packet: &[u8], main: &Main) -> io::Result<Stream> {
    let mut input = packet;
    let (id, class) = (input.number()?, input.number()?);
    if main.streams != 1 || id != 0 || class != 0 {
        return Err(broken("there is not exactly one video stream"));
    }
    let mut fourcc = [0; 4];
    if input.number()? != 4 {
        return Err(broken("a codec's name has not four letters"));
    }
    input.read_exact(&mut fourcc)?;
    let time_base = input.number()? as usize;
    let shift = input.number()? as u32;
    if time_base >= main.time_bases.len() || shift > 15 {
        return Err(broken("a stream header makes no sense"));
    }
    let (_max_distance, _delay, _flags) = (input.number()?, input.number()?, input.number()?);
    let extra = input.number()? as usize;
    input = input.get(extra..).ok_or_else(|| broken("a stream header is cut short"))?;
    let side = |value: u64| u32::try_from(value).map_err(|_| broken("an impossible size"));
    let size = Size::new(side(input.number()?)?, side(input.number()?)?);
    Ok(Stream { fourcc, time_base, shift, size })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_vanish_over_their_block() {
        // CRC-32/MPEG-2 starts with ones; ours with zeros. Value from a bitwise division by hand.
        assert_eq!(crc(&[1]), 0x04C1_1DB7);
        let mut block = b"nut".to_vec();
        block.extend(crc(b"nut").to_be_bytes());
        assert_eq!(crc(&block), 0);
    }

    #[test]
    fn numbers_of_any_length() {
        let read = |mut bytes: &[u8]| bytes.number();
        assert_eq!(read(&[0x7F]).expect("one byte"), 127);
        assert_eq!(read(&[0x83, 0xD4, 0x60]).expect("three bytes"), 60000);
        assert!(read(&[0xFF; 10]).is_err(), "too large");
        assert!(read(&[0x80]).is_err(), "cut short");
        let signed = [0, 1, 2, 3].map(|byte| (&mut &[byte][..]).signed().expect("one byte"));
        assert_eq!(signed, [0, 1, -1, 2]);
    }

    #[test]
    fn short_times_are_those_near_the_last() {
        assert_eq!(full_pts(5, 7, 128), 133);
        assert_eq!(full_pts(120, 7, 130), 120);
        assert_eq!(full_pts(128 + 77, 7, 1_000_000), 77);
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
