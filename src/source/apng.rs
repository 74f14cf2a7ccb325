//! What the chunks of a PNG tell of its animation (PNG specification, third edition, 11.3.6).

use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;

use super::animation::{Facts, Lengths};
use super::detect;
use crate::error::{Error, Result};
use crate::frame::Rational;
use crate::geom::Size;
use crate::stream::Loops;

/// Reads the chunks of the PNG in `path`; `None` if it is no animation, or one of a single frame.
///
/// # Errors
/// When it cannot be read.
pub(crate) fn facts(path: &Path) -> Result<Option<Facts>> {
    let mut file = BufReader::new(detect::open(path)?);
    match chunks(&mut file) {
        Ok(facts) => Ok(facts),
        Err(e) => Err(Error::input(path, format!("cannot be read: {e}")).caused_by(e)),
    }
}

fn chunks(file: &mut BufReader<std::fs::File>) -> std::io::Result<Option<Facts>> {
    let mut facts = Facts {
        size: Size::new(0, 0),
        alpha: false,
        loops: Loops::Forever,
        lengths: Lengths::NONE,
        complete: false,
    };
    let mut claimed = None;
    file.seek_relative(8)?;
    while let Some((length, kind)) = header(file)? {
        let mut head = [0; 26];
        let known = head.len().min(length as usize);
        let mut used = 0;
        match &kind {
            b"IHDR" | b"acTL" | b"fcTL" => {
                if !fill(file, &mut head[..known])? {
                    break;
                }
                used = known;
            }
            // Only an animation is read to its end.
            b"IDAT" if claimed.is_none() => return Ok(None),
            b"tRNS" => facts.alpha = true,
            b"IEND" => {
                facts.complete = facts.lengths.frames == claimed.unwrap_or(0);
                break;
            }
            _ => {}
        }
        match &kind {
            b"IHDR" => {
                facts.size = Size::new(be32(&head, 0), be32(&head, 4));
                facts.alpha = head[9] & 4 != 0;
            }
            b"acTL" => {
                claimed = Some(u64::from(be32(&head, 0)));
                facts.loops = match be32(&head, 4) {
                    0 => Loops::Forever,
                    1 => Loops::Once,
                    n => Loops::Times(n),
                };
            }
            b"fcTL" => facts.lengths.add(delay(&head)),
            _ => {}
        }
        // And the checksum. Beyond the end this succeeds; the next header then is not there.
        file.seek_relative(i64::from(length) - used as i64 + 4)?;
    }
    Ok(claimed.filter(|&frames| frames > 1).map(|_| facts))
}

fn delay(control: &[u8; 26]) -> Rational {
    let word = |at: usize| i64::from(u16::from_be_bytes([control[at], control[at + 1]]));
    // A denominator of 0 stands for 100.
    let den = if word(22) == 0 { 100 } else { word(22) };
    Rational::new(word(20), den)
}

fn header(file: &mut impl Read) -> std::io::Result<Option<(u32, [u8; 4])>> {
    let mut header = [0; 8];
    if !fill(file, &mut header)? {
        return Ok(None);
    }
    let [a, b, c, d, kind @ ..] = header;
    Ok(Some((u32::from_be_bytes([a, b, c, d]), kind)))
}

fn be32(bytes: &[u8], at: usize) -> u32 {
    u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// Fills `bytes`; `false` at the end of the file.
pub(super) fn fill(file: &mut impl Read, bytes: &mut [u8]) -> std::io::Result<bool> {
    match file.read_exact(bytes) {
        Ok(()) => Ok(true),
        Err(e) if e.kind() == ErrorKind::UnexpectedEof => Ok(false),
        Err(e) => Err(e),
    }
}
