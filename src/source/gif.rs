//! GIF: partial frames composed to whole ones (GIF89a specification; where it is silent, as browsers
//! do: cleared areas are transparent, areas outside the screen are cut off).
//!
//! Delays come through exactly as they stand in the file, 0 and 1 hundredths included, which
//! browsers show for ten; so a GIF out gets the same delays, and is shown in the same way.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use gif::{DecodeOptions, DecodingError, DisposalMethod, MemoryLimit};

use super::broken::{check_picture, cut_short};
use super::canvas::{Area, Canvas, Disposal};
use super::gif_blocks::{Blocks, Seen};
use super::limit::Limit;
use super::{Decoded, Input, Source, SourceOptions, detect, fence};
use crate::error::{Error, Result, copied};
use crate::frame::{Frame, Rational, Rgba};
use crate::geom::{MAX_SIDE, Size};
use crate::stream::{Loops, Span, StreamInfo};

type Decoder = gif::Decoder<Blocks<File>>;

/// Bytes of a pixel that a GIF takes: the canvas, what a frame covers, its indices, and the frame that is
/// handed on.
const PIXEL: u64 = 13;

/// Opens the GIF in `path`. All of its frames are counted, without decoding them.
///
/// # Errors
/// When it holds no picture, or one that is too large.
pub(crate) fn open(path: PathBuf, options: &SourceOptions) -> Result<Input> {
    fence::run("gif", || opened(&path, options)).map_err(|what| Error::input(&path, what))?
}

fn opened(path: &Path, options: &SourceOptions) -> Result<Input> {
    let limit = Limit::of(options);
    let facts = scan(path, limit)?;
    let still = facts.frames_begun == 1;
    if facts.frames == 0 && !options.allow_truncated {
        let cut = DecodingError::UnexpectedEof;
        return Err(found(Error::input(path, broken(&cut)), &cut));
    }
    // Most encoders declare a transparent colour, whether it occurs or not.
    let alpha = match facts.alpha {
        Alpha::Yes => true,
        Alpha::No => false,
        Alpha::IfDrawn => {
            let first = Gif::new(path.to_owned(), facts.size, still, true, limit)?.next()?;
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
    let path = path.to_owned();
    Ok(Input::new(Arc::from([path.clone()]), info, move || {
        Ok(Box::new(Gif::new(path.clone(), facts.size, still, allow_truncated, limit)?))
    }))
}

/// What the block structure says.
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

fn decoder(path: &Path, skip: bool) -> Result<(Decoder, Rc<Seen>)> {
    let mut options = DecodeOptions::new();
    options.skip_frame_decoding(skip);
    // Sizes are checked before memory is taken for them.
    options.set_memory_limit(MemoryLimit::Unlimited);
    let (blocks, seen) = Blocks::new(detect::open(path)?);
    let decoder =
        options.read_info(blocks).map_err(|e| found(Error::input(path, broken(&e)), &e))?;
    Ok((decoder, seen))
}

fn scan(path: &Path, limit: Limit) -> Result<Facts> {
    let (mut decoder, seen) = decoder(path, true)?;
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
            Err(e) => return Err(found(Error::input(path, broken(&e)), &e)),
        };
        let area = area_of(frame);
        if begun == 0 {
            if size.width == 0 || size.height == 0 {
                size = area.far();
            }
            check_picture(path, size)?;
            limit.check(path, size, PIXEL)?;
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
    let loops = match seen.loops.get() {
        None => Loops::Once,
        Some(0) => Loops::Forever,
        // The file says how often it is repeated after the first time.
        Some(n) => Loops::Times(u32::from(n) + 1),
    };
    // Of a file that ends inside its last image, the pixels may be all there.
    let frames =
        if seen.cut.get() && frames == begun { whole_frames(path, size, limit)? } else { frames };
    Ok(Facts { size, frames, frames_begun: begun, hundredths, delay, loops, alpha })
}

/// What a frame covers.
fn area_of(frame: &gif::Frame<'_>) -> Area {
    let size = Size::new(frame.width.into(), frame.height.into());
    Area::at(frame.left.into(), frame.top.into(), size)
}

/// Counts the frames whose pixels are all there.
fn whole_frames(path: &Path, size: Size, limit: Limit) -> Result<u64> {
    let mut gif = Gif::new(path.to_owned(), size, false, false, limit)?;
    while let Ok(Some(_)) = gif.read() {
        gif.number += 1;
    }
    Ok(gif.number)
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

/// The error `what` about an input, with its cause.
fn found(what: Error, error: &DecodingError) -> Error {
    match error {
        DecodingError::UnexpectedEof => what.truncated(),
        DecodingError::Io(e) => what.caused_by(copied(e)),
        DecodingError::Format(_) | DecodingError::LzwError(_) => what.corrupt(),
        DecodingError::EndCodeNotFound | DecodingError::DecoderNotFound => what.corrupt(),
        _ => what,
    }
}

struct Gif {
    decoder: Decoder,
    path: PathBuf,
    canvas: Canvas,
    size: Size,
    limit: Limit,
    /// Of the frame being read, as they stand in the file.
    indices: Vec<u8>,
    number: u64,
    hundredths: i64,
    still: bool,
    allow_truncated: bool,
    /// What was wrong with the first frame, which was delivered all the same.
    damage: Option<Failure>,
}

impl Source for Gif {
    fn next(&mut self) -> Result<Option<Decoded>> {
        let read =
            fence::run("gif", || self.read()).unwrap_or_else(|what| Err(Failure::Panic(what)));
        match read {
            Ok(Some(delay)) => {
                let start = Rational::new(self.hundredths, 100);
                self.hundredths += i64::from(delay);
                self.number += 1;
                let length = (!self.still || delay > 0).then(|| Rational::new(delay.into(), 100));
                let frame = Frame::new(self.size, self.canvas.pixels().to_vec())?;
                Ok(Some(Decoded::new(frame, Span { start, length })))
            }
            Ok(None) => Ok(None),
            Err(Failure::Decoder(e)) => {
                Err(found(Error::input_frame(&self.path, self.number, broken(&e)), &e))
            }
            Err(Failure::Short) => {
                let what = cut_short("GIF", "this frame has less data than pixels");
                Err(Error::input_frame(&self.path, self.number, what).truncated())
            }
            Err(Failure::Size(size)) => {
                let what = format!("claims {size} pixels, more than {MAX_SIDE} a side");
                Err(Error::input_frame(&self.path, self.number, what).corrupt())
            }
            Err(Failure::Memory(error)) => Err(error),
            Err(Failure::Panic(what)) => Err(Error::input_frame(&self.path, self.number, what)),
        }
    }
}

/// Indices that are read at once.
const PIECE: usize = 1 << 20;

enum Failure {
    Decoder(DecodingError),
    /// The data ends before the picture does.
    Short,
    Size(Size),
    Memory(Error),
    /// The decoder panicked.
    Panic(String),
}

impl From<DecodingError> for Failure {
    fn from(error: DecodingError) -> Self {
        Self::Decoder(error)
    }
}

impl Gif {
    fn new(
        path: PathBuf,
        size: Size,
        still: bool,
        allow_truncated: bool,
        limit: Limit,
    ) -> Result<Self> {
        Ok(Self {
            decoder: decoder(&path, false)?.0,
            path,
            canvas: Canvas::new(size),
            size,
            limit,
            indices: Vec::new(),
            number: 0,
            hundredths: 0,
            still,
            allow_truncated,
            damage: None,
        })
    }

    /// Reads the next frame onto the canvas and returns its delay in hundredths of a second.
    fn read(&mut self) -> Result<Option<u16>, Failure> {
        if let Some(failure) = self.damage.take() {
            return Err(failure);
        }
        let Some(frame) = self.decoder.next_frame_info()? else { return Ok(None) };
        let (area, dispose, delay) = (area_of(frame), frame.dispose, frame.delay);
        let (transparent, interlaced) = (frame.transparent, frame.interlaced);
        let size = Size::new(frame.width.into(), frame.height.into());
        if size.width > MAX_SIDE || size.height > MAX_SIDE {
            return Err(Failure::Size(size));
        }
        self.limit.check(&self.path, size, 1).map_err(Failure::Memory)?;
        // The rows that are there are better than nothing, if that is all there is.
        let forgiving = self.allow_truncated && self.number == 0;
        // All rows at once: the crate's own way with interlaced frames loses the last pixels of narrow ones.
        match self.read_indices(size.pixels(), transparent.unwrap_or(0)) {
            Some(failure) if !forgiving => return Err(failure),
            damage => self.damage = damage,
        }
        let visible = area.clipped(self.size);
        self.canvas.begin(
            visible,
            match dispose {
                DisposalMethod::Any | DisposalMethod::Keep => Disposal::Keep,
                DisposalMethod::Background => Disposal::Background,
                DisposalMethod::Previous => Disposal::Previous,
            },
        );
        let colours = colours(self.decoder.palette()?, transparent);
        self.draw(visible, size, interlaced, &colours);
        Ok(Some(delay))
    }

    /// Reads `count` indices, in memory that grows with the data; those that are missing become `filler`.
    fn read_indices(&mut self, count: usize, filler: u8) -> Option<Failure> {
        self.indices.clear();
        while self.indices.len() < count {
            let start = self.indices.len();
            self.indices.resize(count.min(start + PIECE), filler);
            let failure = match self.decoder.fill_buffer(&mut self.indices[start..]) {
                Ok(true) => continue,
                Ok(false) => Failure::Short,
                Err(e) => e.into(),
            };
            if self.allow_truncated {
                self.indices.resize(count, filler);
            }
            return Some(failure);
        }
        None
    }

    fn draw(&mut self, visible: Area, size: Size, interlaced: bool, colours: &[Rgba; 256]) {
        let line = size.width.max(1) as usize;
        let stored = self.indices.chunks(line).zip(row_order(size.height, interlaced));
        for (line, y) in stored {
            if visible.y0 + y >= visible.y1 {
                continue;
            }
            let row = self.canvas.row_mut(visible.y0 + y, visible.x0, visible.x1);
            for (pixel, &index) in row.iter_mut().zip(line) {
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
