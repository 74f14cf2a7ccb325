//! Animated PNG (PNG specification, third edition, 11.3.6): reads its chunks, and composes its frames.

use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;

use image::{ImageResult, Pixel};
use png::{BlendOp, DisposeOp};

use super::animation::{Facts, Lengths};
use super::canvas::{Area, Canvas, Disposal};
use super::detect;
use super::png::{self as decoder, Png, Rows};
use super::profile::{DeepToSrgb, ToSrgb};
use crate::error::{Error, Result};
use crate::frame::{Rational, Rgba};
use crate::geom::Size;
use crate::stream::Loops;

/// Reads the chunks of the PNG in `path`; `None` if it is not an animation, or if its only frame is the default
/// image. A default image that is not part of the animation is for readers without support for APNG.
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
    let mut hidden = false;
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
            // Only animations are read to the end.
            b"IDAT" if claimed.is_none() => return Ok(None),
            b"IDAT" => hidden |= facts.lengths.frames == 0,
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
            b"fcTL" => {
                let first = facts.lengths.frames == 0;
                let size = Size::new(be32(&head, 4), be32(&head, 8));
                // Cleared areas, and those outside the first frame, are transparent.
                facts.alpha |= match head[24] {
                    1 => true,
                    2 => first,
                    _ => first && size != facts.size,
                };
                facts.lengths.add(delay(&head));
            }
            _ => {}
        }
        // And the checksum. Seeking beyond the end succeeds; reading the next header then fails.
        file.seek_relative(i64::from(length) - used as i64 + 4)?;
    }
    Ok(claimed.filter(|&frames| frames > 1 || frames == 1 && hidden).map(|_| facts))
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

/// The frames of an APNG, composed one after the other.
pub(super) struct Apng {
    png: Png,
    rows: Rows,
    canvas: Canvas,
    size: Size,
    frames: u64,
    to_srgb: Option<ToSrgb>,
    deep_to_srgb: Option<DeepToSrgb>,
}

impl Apng {
    /// The frames of the APNG in `path`, of which there are `frames`.
    ///
    /// # Errors
    /// When it cannot be read, or is broken.
    pub(super) fn open(path: &Path, size: Size, frames: u64) -> Result<Self> {
        let (png, _) = decoder::open(path, frames)?;
        if decoder::size(&png) != size {
            return Err(Error::input(path, "has changed since its header was read; start again"));
        }
        let gray = !decoder::is_colour(&png);
        let space = decoder::colour_space(&png);
        // Frames are laid over each other as they are in the file, but of those of 16 bits that would lose levels.
        let (space, deep) = if decoder::is_deep(&png) { (None, space) } else { (space, None) };
        let to_srgb = space.and_then(|space| ToSrgb::new(&space, gray));
        let deep_to_srgb = deep.and_then(|space| DeepToSrgb::new(&space, gray));
        let (rows, canvas) = (Rows::default(), Canvas::new(size));
        Ok(Self { png, rows, canvas, size, frames, to_srgb, deep_to_srgb })
    }

    /// The next frame and its duration; `None` after the last one.
    pub(super) fn next(&mut self) -> ImageResult<Option<(Vec<Rgba>, Rational)>> {
        if self.frames == 0 {
            return Ok(None);
        }
        self.frames -= 1;
        if self.png.info().frame_control.is_none() {
            self.rows.read(&mut self.png)?;
        }
        self.rows.read(&mut self.png)?;
        let Some(frame) = self.png.info().frame_control else { return Ok(None) };
        let size = Size::new(frame.width, frame.height);
        let area = Area::at(frame.x_offset, frame.y_offset, size).clipped(self.size);
        // The first frame has no frame to restore, but the canvas is transparent then, too.
        let disposal = match frame.dispose_op {
            DisposeOp::None => Disposal::Keep,
            DisposeOp::Background => Disposal::Background,
            DisposeOp::Previous => Disposal::Previous,
        };
        self.canvas.begin(area, disposal);
        let drawn = self.rows.pixels(&self.png, size, self.deep_to_srgb.as_ref());
        match frame.blend_op {
            BlendOp::Source => self.canvas.draw(area, &drawn, |new, _| new),
            BlendOp::Over => self.canvas.draw(area, &drawn, over),
        }
        let mut pixels = self.canvas.pixels().to_vec();
        if let Some(to_srgb) = &self.to_srgb {
            to_srgb.apply(&mut pixels);
        }
        // A denominator of 0 stands for 100.
        let den = if frame.delay_den == 0 { 100 } else { frame.delay_den };
        Ok(Some((pixels, Rational::new(frame.delay_num.into(), den.into()))))
    }
}

/// `new` composed over `old` (PNG specification, 13.16).
fn over(new: Rgba, old: Rgba) -> Rgba {
    match (new[3], old[3]) {
        (255, _) => new,
        (0, _) => old,
        _ => {
            let mut below = image::Rgba(old);
            below.blend(&image::Rgba(new));
            below.0
        }
    }
}
