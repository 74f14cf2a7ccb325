//! What the chunks of a WebP tell of its animation (WebP container specification).

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::animation::{Facts, Lengths};
use super::apng::fill;
use super::detect;
use crate::error::{Error, Result};
use crate::frame::Rational;
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

/// Whether the file in `path` is as long as its header says. The decoder takes a shorter one for a
/// broken one.
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

/// Where the file ends, by its header.
fn file_end(start: &[u8]) -> u64 {
    8 + u64::from(le32(start, 4))
}

fn chunks(file: &mut BufReader<File>, file_length: u64) -> std::io::Result<Option<Facts>> {
    let mut start = [0; 30];
    // The extended header comes first where there is one, and only it can announce an animation.
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

fn le24(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], 0])
}

fn le32(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
