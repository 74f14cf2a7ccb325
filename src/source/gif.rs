//! GIF: partial frames composed to whole ones (GIF89a specification; where it is silent, as browsers
//! do: cleared areas are transparent, areas outside the screen are cut off).
//!
//! Delays come through exactly as they stand in the file, 0 and 1 hundredths included, which
//! browsers show for ten; so a GIF out gets the same delays, and is shown in the same way.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gif::{DecodeOptions, Decoder, DecodingError, DisposalMethod, MemoryLimit, Repeat};

use super::still::{check_picture, cut_short};
use super::{Decoded, Input, Source, SourceOptions, detect};
use crate::error::{Error, Result};
use crate::frame::{Frame, Rational, Rgba};
use crate::geom::{MAX_SIDE, Size};
use crate::stream::{Loops, Span, StreamInfo};

/// Opens the GIF in `path`. All of its frames are counted, without decoding them.
///
/// # Errors
/// When it holds no picture, or one that is too large.
pub(crate) fn open(path: PathBuf, options: &SourceOptions) -> Result<Input> {
    let facts = scan(&path)?;
    let still = facts.frames_begun == 1;
    if facts.frames == 0 && !options.allow_truncated {
        return Err(Error::input(path, broken(&DecodingError::UnexpectedEof)));
    }
    // Most encoders declare a transparent colour, whether it occurs or not.
    let alpha = match facts.alpha {
        Alpha::Yes => true,
        Alpha::No => false,
        Alpha::IfDrawn => {
            let first = Gif::new(path.clone(), facts.size, still, true)?.next()?;
            first.is_some_and(|d| !d.frame.is_opaque())
        }
    };
    let duration = (!still).then(|| Rational::new(facts.hundredths, 100));
    let info = StreamInfo {
        format: "gif".into(),
        size: facts.size,
        frames: Some(if still { 1 } else { facts.frames }),
        rate: facts.delay.filter(|&d| d > 0 && !still).map(|d| Rational::new(100, d.into())),
        duration,
        alpha,
        still,
        loops: if still { Loops::Once } else { facts.loops },
        audio: None,
        live: false,
        colour: None,
    };
    let allow_truncated = options.allow_truncated;
    Ok(Input::new(Arc::from([path.clone()]), info, move || {
        Ok(Box::new(Gif::new(path.clone(), facts.size, still, allow_truncated)?))
    }))
}

/// What the block structure tells.
struct Facts {
    size: Size,
    /// Frames that are all there, and those whose header is.
    frames: u64,
    frames_begun: u64,
    hundredths: i64,
    /// The delay, if all frames have one.
    delay: Option<u16>,
    loops: Loops,
    alpha: Alpha,
}

/// Whether frames have transparent pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Alpha {
    No,
    /// If the first frame has; the others are drawn on it.
    IfDrawn,
    Yes,
}

fn decoder(path: &Path, skip: bool) -> Result<Decoder<File>> {
    let mut options = DecodeOptions::new();
    options.skip_frame_decoding(skip);
    // Sizes are checked before memory is taken for them.
    options.set_memory_limit(MemoryLimit::Unlimited);
    options.read_info(detect::open(path)?).map_err(|e| Error::input(path, broken(&e)))
}

fn scan(path: &Path) -> Result<Facts> {
    let mut decoder = decoder(path, true)?;
    let mut size = Size::new(decoder.width().into(), decoder.height().into());
    let (mut begun, mut hundredths) = (0u64, 0i64);
    let (mut delay, mut alpha) = (None, Alpha::No);
    let mut before = DisposalMethod::Keep;
    let frames = loop {
        let frame = match decoder.next_frame_info() {
            Ok(Some(frame)) => frame,
            Ok(None) => break begun,
            // Decoding will meet the same error, after the frames before it.
            Err(_) if begun > 0 => break begun - 1,
            Err(e) => return Err(Error::input(path, broken(&e))),
        };
        let area = Area::of(frame);
        if begun == 0 {
            if size.width == 0 || size.height == 0 {
                size = area.far();
            }
            check_picture(path, size)?;
            alpha = match frame.transparent {
                _ if area.clipped(size) != Area::whole(size) => Alpha::Yes,
                Some(_) => Alpha::IfDrawn,
                None => Alpha::No,
            };
            delay = Some(frame.delay);
        }
        // What is cleared, or was there before the first frame, is transparent.
        let cleared = before == DisposalMethod::Background
            || (begun == 1 && before == DisposalMethod::Previous);
        alpha = if cleared { Alpha::Yes } else { alpha };
        before = frame.dispose;
        delay = delay.filter(|&d| d == frame.delay);
        hundredths += i64::from(frame.delay);
        begun += 1;
    };
    if begun == 0 {
        return Err(Error::input(path, "the GIF holds no picture; get another copy"));
    }
    let loops = match decoder.repeat() {
        Repeat::Infinite => Loops::Forever,
        Repeat::Finite(0) => Loops::Once,
        // The file says how often it is repeated after the first time.
        Repeat::Finite(n) => Loops::Times(u32::from(n) + 1),
    };
    Ok(Facts { size, frames, frames_begun: begun, hundredths, delay, loops, alpha })
}

fn broken(error: &DecodingError) -> String {
    match error {
        DecodingError::UnexpectedEof => cut_short("GIF", "its end marker is missing"),
        DecodingError::Io(e) if e.kind() == ErrorKind::UnexpectedEof => {
            cut_short("GIF", "its end marker is missing")
        }
        DecodingError::Io(e) => format!("cannot be read: {e}"),
        e => format!("the GIF is broken ({e}); get another copy"),
    }
}

/// A rectangle of pixels, `x0 <= x < x1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Area {
    x0: u32,
    y0: u32,
    x1: u32,
    y1: u32,
}

impl Area {
    fn of(frame: &gif::Frame<'_>) -> Self {
        let (x0, y0) = (u32::from(frame.left), u32::from(frame.top));
        Self { x0, y0, x1: x0 + u32::from(frame.width), y1: y0 + u32::from(frame.height) }
    }

    fn whole(size: Size) -> Self {
        Self { x0: 0, y0: 0, x1: size.width, y1: size.height }
    }

    fn far(self) -> Size {
        Size::new(self.x1, self.y1)
    }

    fn clipped(self, size: Size) -> Self {
        Self {
            x0: self.x0.min(size.width),
            y0: self.y0.min(size.height),
            x1: self.x1.min(size.width),
            y1: self.y1.min(size.height),
        }
    }

    /// The ranges of its rows in a frame `width` wide.
    fn rows(self, width: u32) -> impl Iterator<Item = std::ops::Range<usize>> {
        let width = width as usize;
        (self.y0 as usize..self.y1 as usize)
            .map(move |y| y * width + self.x0 as usize..y * width + self.x1 as usize)
    }
}

/// What happens to the canvas before the next frame is drawn.
enum Undo {
    Nothing,
    Clear(Area),
    Restore(Area, Vec<Rgba>),
}

struct Gif {
    decoder: Decoder<File>,
    path: PathBuf,
    canvas: Vec<Rgba>,
    size: Size,
    /// Of the frame being read, as they stand in the file.
    indices: Vec<u8>,
    undo: Undo,
    number: u64,
    hundredths: i64,
    still: bool,
    allow_truncated: bool,
    /// What was wrong with the first frame, which was delivered all the same.
    spoilt: Option<Failure>,
}

impl Source for Gif {
    fn next(&mut self) -> Result<Option<Decoded>> {
        match self.read() {
            Ok(Some(delay)) => {
                let start = Rational::new(self.hundredths, 100);
                self.hundredths += i64::from(delay);
                self.number += 1;
                let length = (!self.still || delay > 0).then(|| Rational::new(delay.into(), 100));
                let frame = Frame::new(self.size, self.canvas.clone())?;
                Ok(Some(Decoded::new(frame, Span { start, length })))
            }
            Ok(None) => Ok(None),
            Err(Failure::Decoder(e)) => {
                Err(Error::input_frame(&self.path, self.number, broken(&e)))
            }
            Err(Failure::Short) => {
                let what = cut_short("GIF", "this frame has less data than pixels");
                Err(Error::input_frame(&self.path, self.number, what))
            }
            Err(Failure::Size(size)) => {
                let what = format!("claims {size} pixels, more than {MAX_SIDE} a side");
                Err(Error::input_frame(&self.path, self.number, what))
            }
        }
    }
}

enum Failure {
    Decoder(DecodingError),
    /// The data ends before the picture does.
    Short,
    Size(Size),
}

impl From<DecodingError> for Failure {
    fn from(error: DecodingError) -> Self {
        Self::Decoder(error)
    }
}

impl Gif {
    fn new(path: PathBuf, size: Size, still: bool, allow_truncated: bool) -> Result<Self> {
        Ok(Self {
            decoder: decoder(&path, false)?,
            path,
            canvas: vec![[0; 4]; size.pixels()],
            size,
            indices: Vec::new(),
            undo: Undo::Nothing,
            number: 0,
            hundredths: 0,
            still,
            allow_truncated,
            spoilt: None,
        })
    }

    /// Reads the next frame onto the canvas and returns its delay in hundredths of a second.
    fn read(&mut self) -> Result<Option<u16>, Failure> {
        if let Some(failure) = self.spoilt.take() {
            return Err(failure);
        }
        let Some(frame) = self.decoder.next_frame_info()? else { return Ok(None) };
        let (area, dispose, delay) = (Area::of(frame), frame.dispose, frame.delay);
        let (transparent, interlaced) = (frame.transparent, frame.interlaced);
        let size = Size::new(frame.width.into(), frame.height.into());
        if size.width > MAX_SIDE || size.height > MAX_SIDE {
            return Err(Failure::Size(size));
        }
        self.indices.clear();
        self.indices.resize(size.pixels(), transparent.unwrap_or(0));
        // The rows that are there are better than nothing, if that is all there is.
        let forgiving = self.allow_truncated && self.number == 0;
        if !self.indices.is_empty() {
            // All rows at once: the crate's own way with interlaced frames loses the last pixels of
            // narrow ones.
            let failure = match self.decoder.fill_buffer(&mut self.indices) {
                Ok(true) => None,
                Ok(false) => Some(Failure::Short),
                Err(e) => Some(e.into()),
            };
            match failure {
                Some(failure) if !forgiving => return Err(failure),
                spoilt => self.spoilt = spoilt,
            }
        }
        self.dispose();
        let visible = area.clipped(self.size);
        self.undo = match dispose {
            DisposalMethod::Any | DisposalMethod::Keep => Undo::Nothing,
            DisposalMethod::Background => Undo::Clear(visible),
            DisposalMethod::Previous => {
                let rows = visible.rows(self.size.width);
                Undo::Restore(visible, rows.flat_map(|r| self.canvas[r].iter().copied()).collect())
            }
        };
        let colours = colours(self.decoder.palette()?, transparent);
        self.draw(visible, size, interlaced, &colours);
        Ok(Some(delay))
    }

    /// Does what the frame before asked for.
    fn dispose(&mut self) {
        match std::mem::replace(&mut self.undo, Undo::Nothing) {
            Undo::Nothing => {}
            Undo::Clear(area) => {
                area.rows(self.size.width).for_each(|row| self.canvas[row].fill([0; 4]));
            }
            Undo::Restore(area, saved) => {
                let mut saved = saved.as_slice();
                for row in area.rows(self.size.width) {
                    let (now, later) = saved.split_at(row.len());
                    self.canvas[row].copy_from_slice(now);
                    saved = later;
                }
            }
        }
    }

    fn draw(&mut self, visible: Area, size: Size, interlaced: bool, colours: &[Rgba; 256]) {
        let (width, line) = (self.size.width as usize, size.width.max(1) as usize);
        let stored = self.indices.chunks(line).zip(row_order(size.height, interlaced));
        for (line, y) in stored {
            if visible.y0 + y >= visible.y1 {
                continue;
            }
            let start = (visible.y0 + y) as usize * width;
            let row = start + visible.x0 as usize..start + visible.x1 as usize;
            for (pixel, &index) in self.canvas[row].iter_mut().zip(line) {
                let colour = colours[index as usize];
                if colour[3] != 0 {
                    *pixel = colour;
                }
            }
        }
    }
}

/// Where the rows of a frame belong, in the order in which they are stored (GIF89a, appendix E).
fn row_order(height: u32, interlaced: bool) -> impl Iterator<Item = u32> {
    let passes: &[(u32, usize)] =
        if interlaced { &[(0, 8), (4, 8), (2, 4), (1, 2)] } else { &[(0, 1)] };
    passes.iter().flat_map(move |&(first, step)| (first..height).step_by(step))
}

/// The colour of every index; transparent for the transparent one and those beyond the palette.
fn colours(palette: &[u8], transparent: Option<u8>) -> [Rgba; 256] {
    let mut colours = [[0; 4]; 256];
    for (colour, &[r, g, b]) in colours.iter_mut().zip(palette.as_chunks().0) {
        *colour = [r, g, b, 255];
    }
    if let Some(index) = transparent {
        colours[index as usize] = [0; 4];
    }
    colours
}
