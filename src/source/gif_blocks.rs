//! Rewrites the blocks of a GIF in the order of the specification before they are decoded (GIF89a, appendix A).
//!
//! Many files hold unknown extensions, bytes between blocks or loop extensions with other names than Netscape's, or
//! lack the end of their last image or their trailer. Other readers accept these; the `gif` crate gets a file without
//! them.

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::rc::Rc;

const EXTENSION: u8 = 0x21;
const IMAGE: u8 = 0x2c;
const TRAILER: u8 = 0x3b;
const CONTROL: u8 = 0xf9;
const APPLICATION: u8 = 0xff;

/// Names of the extension with the number of repetitions.
const LOOPS: [&[u8]; 2] = [b"NETSCAPE2.0", b"ANIMEXTS1.0"];

/// What was found in the blocks so far.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// Whether the file ends inside an image's data; then an end was added.
    pub(super) cut: Cell<bool>,
    /// Number of repetitions after the first time, 0 for ever.
    pub(super) loops: Cell<Option<u16>>,
}

/// Approximate number of bytes that are passed on at once.
const PIECE: usize = 1 << 14;

/// The next part to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Header,
    Blocks,
    /// The sub-blocks of an image's data.
    Data,
    End,
}

/// The bytes of a GIF, with blocks in order.
pub(super) struct Blocks<R> {
    input: BufReader<R>,
    state: State,
    out: Vec<u8>,
    given: usize,
    seen: Rc<Seen>,
}

impl<R: Read> Blocks<R> {
    /// The blocks of `input`, and what is found in them, complete when all are read.
    pub(super) fn new(input: R) -> (Self, Rc<Seen>) {
        let seen = Rc::<Seen>::default();
        let (input, out) = (BufReader::with_capacity(1 << 16, input), Vec::new());
        (Self { input, state: State::Header, out, given: 0, seen: seen.clone() }, seen)
    }

    /// Reads the next part into `out`; leaves it empty at the end.
    fn fill(&mut self) -> io::Result<()> {
        self.out.clear();
        self.given = 0;
        while self.out.len() < PIECE && self.state != State::End {
            match self.state {
                State::Header => self.header()?,
                State::Blocks => self.block()?,
                State::Data => self.data()?,
                State::End => {}
            }
        }
        Ok(())
    }

    /// Appends `length` bytes of the file; fewer at its end.
    fn take(&mut self, length: usize) -> io::Result<bool> {
        let had = (&mut self.input).take(length as u64).read_to_end(&mut self.out)?;
        Ok(had == length)
    }

    /// The header, the screen, and its palette. A file that ends in one of them ends here.
    fn header(&mut self) -> io::Result<()> {
        let start = self.out.len();
        let whole = self.take(13)? && self.palette(start + 10)?;
        self.state = if whole { State::Blocks } else { State::End };
        Ok(())
    }

    /// A palette, if the flags at `at` in `out` announce one.
    fn palette(&mut self, at: usize) -> io::Result<bool> {
        let flags = self.out[at];
        if flags & 0x80 == 0 { Ok(true) } else { self.take(3 << ((flags & 7) + 1)) }
    }

    fn byte(&mut self) -> io::Result<Option<u8>> {
        let byte = self.input.fill_buf()?.first().copied();
        self.input.consume(1.min(self.input.buffer().len()));
        Ok(byte)
    }

    fn block(&mut self) -> io::Result<()> {
        match self.byte()? {
            Some(EXTENSION) => self.extension(),
            Some(IMAGE) => {
                let start = self.out.len();
                self.out.push(IMAGE);
                // The descriptor, its palette, and the size of the first codes.
                let whole = self.take(9)? && self.palette(start + 9)? && self.take(1)?;
                self.state = if whole { State::Data } else { State::End };
                Ok(())
            }
            // If only the trailer is missing, no pixel is.
            Some(TRAILER) | None => {
                self.out.push(TRAILER);
                self.state = State::End;
                Ok(())
            }
            Some(_) => Ok(()),
        }
    }

    /// A sub-block of an image's data.
    fn data(&mut self) -> io::Result<()> {
        let length = self.byte()?;
        let start = self.out.len();
        if let Some(length) = length {
            self.out.push(length);
            if self.take(length.into())? {
                self.state = if length == 0 { State::Blocks } else { State::Data };
                return Ok(());
            }
        }
        // All pixels may be there: the decoder finds out.
        self.seen.cut.set(true);
        if let Some(length) = self.out.len().checked_sub(start + 1).filter(|&length| length > 0) {
            self.out[start] = length as u8;
        } else {
            self.out.truncate(start);
        }
        self.out.extend([0, TRAILER]);
        self.state = State::End;
        Ok(())
    }

    /// An extension; kept if it concerns pixels or times.
    fn extension(&mut self) -> io::Result<()> {
        let Some(label) = self.byte()? else {
            self.state = State::End;
            return Ok(());
        };
        let mut first = None;
        let mut loops = None;
        loop {
            let Some(length) = self.byte()? else {
                // The file ends inside an extension, before an image.
                self.state = State::End;
                return Ok(());
            };
            if length == 0 {
                break;
            }
            let mut block = Vec::new();
            (&mut self.input).take(length.into()).read_to_end(&mut block)?;
            match (&first, block.as_slice()) {
                (None, _) => first = Some(block),
                (Some(_), &[1, low, high, ..]) => loops = loops.or(Some([low, high])),
                _ => {}
            }
        }
        let first = first.unwrap_or_default();
        match label {
            CONTROL if first.len() >= 4 => {
                self.out.extend([EXTENSION, CONTROL, 4]);
                self.out.extend_from_slice(&first[..4]);
                self.out.push(0);
            }
            // Not passed on here: the decoder accepts it only in front of the images.
            APPLICATION if LOOPS.contains(&first.as_slice()) && loops.is_some() => {
                self.seen.loops.set(loops.map(u16::from_le_bytes));
            }
            _ => {}
        }
        Ok(())
    }
}

impl<R: Read> Read for Blocks<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given == self.out.len() {
            self.fill()?;
        }
        let length = buffer.len().min(self.out.len() - self.given);
        buffer[..length].copy_from_slice(&self.out[self.given..self.given + length]);
        self.given += length;
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &[u8] = b"GIF89a\x02\0\x01\0\x80\0\0\0\0\0\xff\xff\xff";
    const FRAME: &[u8] = b",\0\0\0\0\x02\0\x01\0\0\x02\x02\x44\x0a\0";

    fn through(bytes: &[u8]) -> (Vec<u8>, bool) {
        let (mut blocks, seen) = Blocks::new(bytes);
        let mut out = Vec::new();
        blocks.read_to_end(&mut out).expect("memory does not fail");
        (out, seen.cut.get())
    }

    #[test]
    fn what_is_in_order_stays_as_it_is() {
        let control = b"!\xf9\x04\x01\x0a\0\0\0";
        let whole = [HEAD, control, FRAME, control, FRAME, b";"].concat();
        assert_eq!(through(&whole), (whole.clone(), false));
    }

    #[test]
    fn what_is_not_known_is_left_out() {
        let whole = [HEAD, FRAME, FRAME, b";"].concat();
        let unknown = b"!\x42\x03abc\x01d\0";
        let comment = b"!\xfe\x03abc\0";
        let odd = [HEAD, unknown, FRAME, b"\0\0x", comment, FRAME, b"\0;more"].concat();
        assert_eq!(through(&odd), (whole, false));
    }

    #[test]
    fn loops_are_seen_under_every_name_and_in_every_place() {
        for name in LOOPS {
            let loops = [b"!\xff\x0b", name, b"\x03\x01\x05\x01\0"].concat();
            for whole in
                [[HEAD, &loops, FRAME, b";"].concat(), [HEAD, FRAME, &loops, b";"].concat()]
            {
                let (mut blocks, seen) = Blocks::new(whole.as_slice());
                blocks.read_to_end(&mut Vec::new()).expect("memory does not fail");
                assert_eq!(seen.loops.get(), Some(0x105));
            }
        }
    }

    #[test]
    fn a_missing_end_is_made_up_where_no_pixel_need_be_missing() {
        let whole = [HEAD, FRAME, b";"].concat();
        assert_eq!(through(&whole[..whole.len() - 1]), (whole.clone(), false));
        assert_eq!(through(&whole[..whole.len() - 2]), (whole.clone(), true));
        let (out, cut) = through(&whole[..whole.len() - 3]);
        assert!(cut && out.ends_with(b"\x02\x01\x44\0;"), "{out:x?}");
        for length in 0..HEAD.len() + 11 {
            assert!(
                length == HEAD.len() || !through(&whole[..length]).0.ends_with(b";"),
                "{length}"
            );
        }
    }
}
