//! Writes animated pictures with all their colours and alpha: APNG and lossless WebP.
//!
//! Each frame replaces the rectangle of what has changed. A frame is written when the next one is known, by which its
//! length is known at the latest.

mod apng;
mod webp;

use std::fs::File;
use std::io;
use std::path::Path;

use super::place::Place;
use super::still::nothing;
use super::{Origin, Picture, Sink, SinkOptions};
use crate::error::{Error, Result};
use crate::frame::{Buffers, Rational, Rgba};
use crate::geom::Size;
use crate::stream::{Loops, Span, StreamInfo};

/// A format of animated pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Apng,
    WebP,
}

impl Format {
    /// The format of a lower-case extension.
    pub(crate) fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "apng" => Some(Self::Apng),
            "webp" => Some(Self::WebP),
            _ => None,
        }
    }

    /// The longest side of a picture.
    fn longest(self) -> u32 {
        match self {
            Self::Apng => i32::MAX as u32,
            Self::WebP => 1 << 14,
        }
    }
}

/// The properties of a file that are known before its frames.
#[derive(Clone, Copy, Debug)]
struct Header {
    size: Size,
    loops: Loops,
}

/// A rectangle of new pixels, and for how long it is shown.
struct Piece<'a> {
    area: Area,
    pixels: &'a [Rgba],
    is_opaque: bool,
    /// Start and length in seconds.
    start: Rational,
    length: Rational,
}

/// Writes the pieces of one format.
trait Encode: Send {
    /// Writes a piece.
    ///
    /// # Errors
    /// When it cannot be written.
    fn piece(&mut self, piece: &Piece<'_>) -> io::Result<()>;

    /// Completes the file.
    ///
    /// # Errors
    /// As [`Encode::piece`].
    fn end(self: Box<Self>) -> io::Result<()>;
}

/// A rectangle, `x0 <= x < x1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Area {
    x0: u32,
    y0: u32,
    x1: u32,
    y1: u32,
}

impl Area {
    fn size(self) -> Size {
        Size::new(self.x1 - self.x0, self.y1 - self.y0)
    }
}

/// An animation being written.
pub(crate) struct Animation {
    place: Place,
    size: Size,
    encoder: Box<dyn Encode>,
    /// What is shown after the waiting frame.
    shown: Vec<Rgba>,
    waiting: Option<Waiting>,
    /// The length of the frame before.
    usual: Rational,
}

/// A frame that is written when the next one is known.
struct Waiting {
    area: Area,
    pixels: Vec<Rgba>,
    is_opaque: bool,
    span: Span,
}

impl Animation {
    /// An animation of `format` at `output`.
    ///
    /// # Errors
    /// As [`Place::reserve`], and when pictures are too large for the format.
    pub(crate) fn create(
        output: &Path,
        format: Format,
        info: &StreamInfo,
        options: &SinkOptions,
    ) -> Result<Self> {
        let Size { width, height } = info.size;
        let longest = format.longest();
        if width.max(height) > longest {
            let what =
                format!("{} is too large: it has at most {longest} pixels a side", info.size);
            return Err(Error::output(output, what));
        }
        let place = Place::reserve(output, options)?;
        let header = Header { size: info.size, loops: loops(info, options) };
        let begin = |file: File| -> io::Result<Box<dyn Encode>> {
            Ok(match format {
                Format::Apng => Box::new(apng::Apng::begin(file, header)?),
                Format::WebP => Box::new(webp::WebP::begin(file, header)?),
            })
        };
        let encoder = place.file().try_clone().and_then(begin);
        let encoder = encoder.map_err(|error| place.failed(&error))?;
        let usual = info.rate.and_then(Rational::recip).unwrap_or(Rational::new(1, 10));
        Ok(Self { place, size: info.size, encoder, shown: Vec::new(), waiting: None, usual })
    }

    /// Writes the waiting frame, which ends where `next` begins unless it has a length.
    fn flush(&mut self, next: Option<Span>) -> io::Result<()> {
        let Some(waiting) = self.waiting.take() else { return Ok(()) };
        let span = waiting.span;
        let length = span.length.or_else(|| next.map(|next| next.start - span.start));
        let length = length.unwrap_or(self.usual).max(Rational::ZERO);
        self.usual = length;
        let Waiting { area, pixels, is_opaque, .. } = &waiting;
        let piece = Piece { area: *area, pixels, is_opaque: *is_opaque, start: span.start, length };
        self.encoder.piece(&piece)
    }

    /// The rectangle of what differs from what is shown, at least a pixel; it begins at even places, as WebP needs it.
    fn changed(&self, pixels: &[Rgba]) -> Area {
        let Size { width, height } = self.size;
        if self.shown.len() != pixels.len() {
            return Area { x0: 0, y0: 0, x1: width, y1: height };
        }
        let row = width as usize;
        let rows = pixels.chunks(row).zip(self.shown.chunks(row)).zip(0u32..);
        let mut area: Option<Area> = None;
        for ((new, old), y) in rows {
            let differs = |&x: &usize| new[x] != old[x];
            let (Some(first), Some(last)) = ((0..row).find(differs), (0..row).rev().find(differs))
            else {
                continue;
            };
            let (x0, x1) = (first as u32, last as u32 + 1);
            let own = Area { x0, y0: y, x1, y1: y + 1 };
            area = Some(area.map_or(own, |area| Area {
                x0: area.x0.min(x0),
                x1: area.x1.max(x1),
                y1: y + 1,
                ..area
            }));
        }
        let area = area.unwrap_or(Area { x0: 0, y0: 0, x1: 1, y1: 1 });
        Area { x0: area.x0 & !1, y0: area.y0 & !1, ..area }
    }

    /// The pixels of `area`.
    fn cut(&self, pixels: &[Rgba], area: Area) -> Vec<Rgba> {
        let row = self.size.width as usize;
        let rows = pixels.chunks(row).take(area.y1 as usize).skip(area.y0 as usize);
        rows.flat_map(|row| &row[area.x0 as usize..area.x1 as usize]).copied().collect()
    }
}

/// How often an animation plays: an animation as often as before, a film for ever.
pub(super) fn loops(info: &StreamInfo, options: &SinkOptions) -> Loops {
    let is_film = info.colour.is_some() && !info.still;
    let own = if is_film { Loops::Forever } else { info.loops };
    if info.still { Loops::Once } else { options.loops.unwrap_or(own) }
}

impl Sink for Animation {
    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        let Picture { frame, span, .. } = picture;
        if frame.size() != self.size {
            let what = format!("a picture of {} among those of {}", frame.size(), self.size);
            return Err(Error::output(self.place.named(), what));
        }
        self.flush(Some(span)).map_err(|error| self.place.failed(&error))?;
        let is_opaque = frame.is_opaque();
        let pixels = frame.into_pixels();
        let area = self.changed(&pixels);
        self.waiting = Some(Waiting { area, pixels: self.cut(&pixels, area), is_opaque, span });
        let pixels = std::mem::replace(&mut self.shown, pixels);
        Ok(Buffers { pixels, ..Buffers::default() })
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        if self.waiting.is_none() {
            return Err(nothing(self.place.named()));
        }
        self.flush(None).map_err(|error| self.place.failed(&error))?;
        let Self { place, encoder, .. } = *self;
        encoder.end().map_err(|error| place.failed(&error))?;
        place.commit()
    }
}

/// The nearest whole number of `units` a second at `time`.
fn rounded(time: Rational, units: i64) -> i64 {
    let (num, den) = (2 * i128::from(time.num) * i128::from(units), i128::from(time.den));
    i64::try_from((num + den).div_euclid(2 * den)).unwrap_or(i64::MAX >> 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::source::{self, SourceOptions};

    const SIZE: Size = Size::new(9, 7);

    fn frames() -> Vec<(Frame, Rational)> {
        let lengths = [(1001, 30000), (1, 25), (2, 1), (0, 1), (1, 3), (70, 1)];
        let frame = |i: usize| {
            let pixel = |at: usize| match at % 9 {
                x if x == i => [250, 10, 30, 255],
                x if x == i + 2 => [10, 200, 30, 128],
                x if x > 6 && i < 3 => [0, 0, 0, 0],
                _ => [90, 90, 200, 255],
            };
            Frame::new(SIZE, (0..63).map(pixel).collect()).expect("a size")
        };
        let length = |(num, den)| Rational::new(num, den);
        lengths.into_iter().enumerate().map(|(i, l)| (frame(i), length(l))).collect()
    }

    /// What is written as `name` and read again.
    fn read_again(name: &str, loops: Loops) -> (Vec<(Frame, Rational)>, StreamInfo) {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join(name);
        let info = StreamInfo { alpha: true, loops, ..StreamInfo::of(SIZE) };
        let mut sink = super::super::create(&path, &info, &SinkOptions::default()).expect("a sink");
        let mut start = Rational::ZERO;
        for (frame, length) in frames() {
            let span = Span { start, length: Some(length) };
            start = start + length;
            sink.write(Picture { frame, fills: Vec::new(), span }, None).expect("written");
        }
        sink.finish().expect("complete");
        let input = source::open(&[&path], &SourceOptions::default()).expect("readable");
        let info = input.info().clone();
        let mut source = input.start().expect("it starts");
        let mut read = Vec::new();
        while let Some(decoded) = source.next().expect("whole") {
            read.push((decoded.frame, decoded.span.length.expect("a length")));
        }
        (read, info)
    }

    #[test]
    fn pictures_and_lengths_come_back() {
        for name in ["x.apng", "x.webp"] {
            for loops in [Loops::Once, Loops::Times(3), Loops::Forever] {
                let (read, info) = read_again(name, loops);
                assert_eq!((info.size, info.loops, info.alpha), (SIZE, loops, true), "{name}");
                assert_eq!(read.len(), 6, "{name}");
                for (i, ((frame, length), (own, exact))) in read.iter().zip(frames()).enumerate() {
                    let clear = |pixel: &Rgba| if pixel[3] == 0 { [0; 4] } else { *pixel };
                    let seen =
                        |frame: &Frame| -> Vec<Rgba> { frame.pixels().iter().map(clear).collect() };
                    assert_eq!(seen(frame), seen(&own), "{name}: frame {i}");
                    let off = (length.to_f64() - exact.to_f64()).abs();
                    assert!(off <= 0.001, "{name}: {length} for {exact}");
                }
            }
        }
    }

    #[test]
    fn what_does_not_change_is_not_written_again() {
        let dir = tempfile::tempdir().expect("a folder");
        let size = Size::new(200, 150);
        let frame = |x: usize| {
            let mut frame = Frame::filled(size, [9, 8, 7, 255]).expect("a size").into_pixels();
            frame.iter_mut().enumerate().for_each(|(i, pixel)| pixel[0] = (i * i % 251) as u8);
            frame[150 * 100 + x] = [255, 0, 0, 255];
            Frame::new(size, frame).expect("a size")
        };
        for name in ["x.apng", "x.webp"] {
            let bytes = [1, 20].map(|count| {
                let path = dir.path().join(format!("{count}-{name}"));
                let info = StreamInfo::of(size);
                let options = SinkOptions::default();
                let mut sink = super::super::create(&path, &info, &options).expect("a sink");
                for i in 0..count {
                    let span = Span { start: Rational::new(i, 10), length: None };
                    let picture = Picture { frame: frame(i as usize), fills: Vec::new(), span };
                    sink.write(picture, None).expect("written");
                }
                sink.finish().expect("complete");
                std::fs::metadata(&path).expect("a file").len()
            });
            assert!(bytes[1] < bytes[0] + 20 * 300, "{name}: {bytes:?}");
        }
    }
}
