//! Packets of NUT that are not frames: numbers, checksums, and the headers before the first frame.

use std::io::{self, Read};

use crate::geom::Size;

/// The first bytes of a NUT file.
pub(crate) const ID: &[u8] = b"nut/multimedia container\0";
/// Start codes of packets that are not frames. All begin with `N`; no frame does.
pub(crate) const MAIN: u64 = 0x4E4D_7A56_1F5F_04AD;
pub(crate) const STREAM: u64 = 0x4E53_1140_5BF2_F9DB;
pub(crate) const SYNCPOINT: u64 = 0x4E4B_E4AD_EECA_4569;
pub(crate) const INFO: u64 = 0x4E49_AB68_B596_BA78;
pub(crate) const INDEX: u64 = 0x4E58_DD67_2F23_E64E;

/// The frame flags that are used or must be understood.
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

/// The longest header that is accepted.
pub(super) const MAX_HEADER: u64 = 1 << 20;
/// Packets of this size and more have a checksum of the header, and no elision.
pub(super) const LONG: u64 = 4096;

/// CRC-32 with generator 0x04C11DB7, most significant bit first, not inverted. That of a block followed by its
/// checksum is 0.
pub(crate) fn crc(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |crc: u32, &byte| {
        (0..8).fold(crc ^ u32::from(byte) << 24, |crc, _| {
            (crc << 1) ^ if crc >> 31 == 1 { 0x04C1_1DB7 } else { 0 }
        })
    })
}

pub(super) fn broken(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("NUT: {what}"))
}

/// Reads numbers from a stream of bytes.
pub(super) trait Numbers {
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
        let value = self.number()?;
        // Odd numbers stand for positive ones.
        let half = (value / 2 + value % 2) as i64;
        Ok(if value & 1 == 0 { -half } else { half })
    }
}

impl<R: Read> Numbers for R {
    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.read_exact(&mut byte)?;
        Ok(byte[0])
    }
}

/// The meaning of a frame code.
#[derive(Clone, Copy, Default)]
pub(super) struct Code {
    pub(super) flags: u64,
    pub(super) stream: u64,
    pub(super) multiplier: u64,
    pub(super) size: u64,
    pub(super) delta: i64,
    pub(super) reserved: u64,
    pub(super) header: u64,
}

/// The main header.
pub(super) struct Main {
    pub(super) streams: u64,
    pub(super) time_bases: Vec<(u64, u64)>,
    pub(super) codes: Vec<Code>,
    /// Prefixes that frames may omit (elision); the first is empty.
    pub(super) headers: Vec<Vec<u8>>,
}

/// The stream header.
pub(super) struct Stream {
    pub(super) fourcc: [u8; 4],
    pub(super) time_base: usize,
    pub(super) shift: u32,
    pub(super) size: Size,
}

/// Reads a packet that is not a frame: its start code (whose first byte may have been read already)
/// and its contents without the checksum.
pub(super) fn read_packet(input: &mut impl Read, first: Option<u8>) -> io::Result<(u64, Vec<u8>)> {
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
        // The rest of the stream is not used.
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

pub(super) fn read_main(packet: &[u8]) -> io::Result<Main> {
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

/// The table of frame codes: runs of entries; a field keeps its value until it is set again.
pub(super) fn read_codes(input: &mut &[u8]) -> io::Result<Vec<Code>> {
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
            codes.push(Code { size: run.size.saturating_add(step), ..run });
        }
        if codes.len() == usize::from(b'N') {
            codes.push(Code { flags: flag::INVALID, ..Code::default() });
        }
    }
    Ok(codes)
}

pub(super) fn read_stream(packet: &[u8], main: &Main) -> io::Result<Stream> {
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
    let shift = input.number()?.min(64) as u32;
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

    /// Found by the fuzz target `nut`: it overflowed.
    #[test]
    fn the_largest_number_can_be_signed() {
        let largest = [0x81, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F];
        assert_eq!((&largest[..]).number().expect("ten bytes"), u64::MAX);
        assert!((&mut &largest[..]).signed().is_ok());
    }
}
