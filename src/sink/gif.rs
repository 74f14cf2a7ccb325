//! Writes GIF: of each picture only the changes.
//!
//! Compared with what the viewer shows already (the canvas), only the bounding rectangle of the changes is written,
//! and in it only the pixels that changed; the others are transparent. A pixel also stays if its old colour is as
//! near to the new one as the palette's best.
//!
//! Drawing cannot make a pixel transparent in a GIF, but the frame before can, by having its rectangle cleared. So a
//! frame is written when the next one is known.
//!
//! Viewers show at most fifty frames a second: of more, some are dropped, so that the duration stays.

mod clock;
mod draw;

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use gif::{DisposalMethod, EncodingError, Repeat};
use rayon::prelude::*;

use super::palette::{Lookup, MOST, Palette, Rgb, distinct};
use super::place::Place;
use super::still::nothing;
use super::{Needs, Origin, Picture, Sink, SinkOptions};
use crate::error::{Error, Result};
use crate::frame::{Buffers, Frame, Rgba};
use crate::geom::Size;
use crate::options::Edges;
use crate::stream::{Loops, Span, StreamInfo};
use clock::Clock;
use draw::draw_row;

/// Pixels with a smaller alpha become transparent.
const THRESHOLD: u8 = 128;

/// A GIF being written.
pub(crate) struct Gif {
    place: Place,
    loops: Loops,
    still: bool,
    clock: Clock,
    palette: Option<Palette>,
    /// What the viewer shows after the waiting frame; pixels have alpha 0 or 255.
    canvas: Vec<Rgba>,
    /// Indices of a whole frame, a buffer.
    indices: Vec<u8>,
    size: Size,
    out: Option<Out>,
    waiting: Option<Waiting>,
    warnings: Vec<String>,
}

/// The encoder, made with the first frame, and its palette.
struct Out {
    encoder: gif::Encoder<BufWriter<File>>,
    global: Vec<Rgb>,
}

/// A frame that is written when the next one is known.
struct Waiting {
    area: Area,
    /// The indices of `area`, row by row.
    indices: Vec<u8>,
    colours: Vec<Rgb>,
    span: Span,
}

impl Gif {
    /// A GIF at `output`.
    ///
    /// # Errors
    /// As [`Place::reserve`].
    pub(crate) fn create(output: &Path, info: &StreamInfo, options: &SinkOptions) -> Result<Self> {
        Ok(Self {
            place: Place::reserve(output, options)?,
            loops: if info.still { Loops::Once } else { options.loops.unwrap_or(info.loops) },
            still: info.still,
            clock: Clock::new(info.format == "gif"),
            palette: None,
            canvas: Vec::new(),
            indices: Vec::new(),
            size: info.size,
            out: None,
            waiting: None,
            warnings: clock::too_fast(info).into_iter().collect(),
        })
    }

    /// The encoder, made with the first frame's palette.
    fn begin(&mut self, colours: &[Rgb]) -> Result<(), EncodingError> {
        let side = |v: u32| u16::try_from(v).map_err(|_| too_large());
        let (width, height) = (side(self.size.width)?, side(self.size.height)?);
        let file = BufWriter::with_capacity(1 << 16, self.place.file().try_clone()?);
        let mut encoder = gif::Encoder::new(file, width, height, &table(colours))?;
        encoder.set_repeat(match self.loops {
            Loops::Forever => Repeat::Infinite,
            // The file holds the number of repetitions after the first time.
            Loops::Times(n) => {
                Repeat::Finite(u16::try_from(n.saturating_sub(1)).unwrap_or(u16::MAX))
            }
            Loops::Once => Repeat::Finite(0),
        })?;
        self.out = Some(Out { encoder, global: colours.to_vec() });
        Ok(())
    }

    /// Draws `frame` on the canvas, and returns the part of it that has to be written.
    fn draw(&mut self, frame: &Frame, palette: &Palette, lookup: &Lookup, span: Span) -> Waiting {
        let width = self.size.width as usize;
        let first = self.canvas.is_empty();
        self.canvas.resize(self.size.pixels(), [0; 4]);
        self.indices.resize(self.size.pixels(), 0);
        let rows = self.canvas.par_chunks_mut(width).zip(self.indices.par_chunks_mut(width));
        let changed: Area = rows
            .zip(frame.pixels().par_chunks(width))
            .enumerate()
            .with_min_len(64)
            .map(|(y, ((canvas, indices), pixels))| {
                draw_row(pixels, canvas, indices, palette, lookup)
                    .map_or(Area::NONE, |(x0, x1)| Area { x0, y0: y, x1, y1: y + 1 })
            })
            .reduce(|| Area::NONE, Area::union);
        let area = match changed {
            // Readers expect the first frame to cover the screen.
            _ if first => Area { x0: 0, y0: 0, x1: width, y1: self.size.height as usize },
            // A frame must have at least one pixel; this one does not change.
            Area::NONE => Area { x0: 0, y0: 0, x1: 1, y1: 1 },
            area => area,
        };
        let rows: Vec<_> = area.rows(width).map(|row| &self.indices[row]).collect();
        let indices = rows.concat();
        Waiting { area, indices, colours: palette.colours().to_vec(), span }
    }

    /// Writes the waiting frame. `next` is the start of the next one; `clear` is the area that is to be transparent
    /// then.
    fn flush(&mut self, next: Option<Span>, clear: Area) -> Result<(), EncodingError> {
        let Some(mut waiting) = self.waiting.take() else { return Ok(()) };
        let delay = if self.still && waiting.span.length.is_none() {
            0
        } else {
            self.clock.delay(waiting.span, next)
        };
        let transparent = waiting.colours.len() as u8;
        let mut dispose = DisposalMethod::Keep;
        if clear != Area::NONE {
            dispose = DisposalMethod::Background;
            waiting.grow(waiting.area.union(clear), transparent);
            for row in waiting.area.rows(self.size.width as usize) {
                self.canvas[row].fill([0; 4]);
            }
        }
        if self.out.is_none() {
            self.begin(&waiting.colours)?;
        }
        let Some(out) = &mut self.out else { return Ok(()) };
        let area = waiting.area;
        let palette = (waiting.colours != out.global).then(|| table(&waiting.colours));
        out.encoder.write_frame(&gif::Frame {
            delay,
            dispose,
            transparent: Some(transparent),
            left: area.x0 as u16,
            top: area.y0 as u16,
            width: (area.x1 - area.x0) as u16,
            height: (area.y1 - area.y0) as u16,
            palette,
            buffer: Cow::Owned(waiting.indices),
            ..gif::Frame::default()
        })
    }

    /// The bounding rectangle of pixels that the viewer shows and that are transparent in `frame`.
    fn vanished(&self, frame: &Frame) -> Area {
        if frame.is_opaque() || self.canvas.is_empty() {
            return Area::NONE;
        }
        let width = self.size.width as usize;
        let rows = self.canvas.chunks(width).zip(frame.pixels().chunks(width)).enumerate();
        rows.map(|(y, (canvas, pixels))| {
            let gone = |x: &usize| canvas[*x][3] != 0 && pixels[*x][3] < THRESHOLD;
            match ((0..width).find(gone), (0..width).rev().find(gone)) {
                (Some(x0), Some(x1)) => Area { x0, y0: y, x1: x1 + 1, y1: y + 1 },
                _ => Area::NONE,
            }
        })
        .fold(Area::NONE, Area::union)
    }

    fn failed(&self, error: EncodingError) -> Error {
        match error {
            EncodingError::Io(e) => self.place.failed(&e),
            e => self.place.failed(&io::Error::other(e)),
        }
    }
}

impl Sink for Gif {
    fn needs(&self) -> Needs {
        // The palette is made from the fills: pictures must have no other colours.
        Needs { edges: Some(Edges::Hard), ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        let Picture { frame, fills, span } = picture;
        if frame.size() != self.size {
            let what = format!("a frame of {} cannot go into a GIF of {}", frame.size(), self.size);
            return Err(Error::output(self.place.named(), what));
        }
        if self.waiting.as_mut().is_some_and(|waiting| self.clock.merge(&mut waiting.span, span)) {
            return Ok(frame.into_buffers());
        }
        let gone = self.vanished(&frame);
        self.flush(Some(span), gone).map_err(|e| self.failed(e))?;
        let colours = distinct(&fills, THRESHOLD);
        let (palette, lookup) = Palette::next(&colours, self.palette.as_ref());
        self.waiting = Some(self.draw(&frame, &palette, &lookup, span));
        self.palette = Some(palette);
        Ok(frame.into_buffers())
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        self.flush(None, Area::NONE).map_err(|e| self.failed(e))?;
        let Some(out) = self.out.take() else { return Err(nothing(self.place.named())) };
        // The encoder's own `Drop` would hide an error of writing the trailer.
        let mut file = out.encoder.into_inner().map_err(|e| self.failed(e))?;
        file.flush().map_err(|e| self.place.failed(&e))?;
        drop(file);
        self.place.commit()
    }
}

impl Waiting {
    /// Grows the rectangle; pixels of the new part do not change.
    fn grow(&mut self, to: Area, transparent: u8) {
        if to == self.area {
            return;
        }
        let width = to.x1 - to.x0;
        let mut grown = vec![transparent; width * (to.y1 - to.y0)];
        let (dx, dy) = (self.area.x0 - to.x0, self.area.y0 - to.y0);
        let inner = self.area.x1 - self.area.x0;
        for (row, old) in grown.chunks_mut(width).skip(dy).zip(self.indices.chunks(inner)) {
            row[dx..dx + inner].copy_from_slice(old);
        }
        (self.area, self.indices) = (to, grown);
    }
}

/// A colour table in the format of the file, with an entry for the transparent index.
fn table(colours: &[Rgb]) -> Vec<u8> {
    debug_assert!(colours.len() <= MOST, "one index is for transparent pixels");
    [colours.as_flattened(), &[0; 3]].concat()
}

fn too_large() -> EncodingError {
    EncodingError::Io(io::Error::other("a GIF has at most 65535 pixels a side"))
}

/// A rectangle of pixels, `x0 <= x < x1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Area {
    x0: usize,
    y0: usize,
    x1: usize,
    y1: usize,
}

impl Area {
    /// The empty rectangle; its union with another is the other.
    const NONE: Self = Self { x0: usize::MAX, y0: usize::MAX, x1: 0, y1: 0 };

    fn union(self, o: Self) -> Self {
        Self {
            x0: self.x0.min(o.x0),
            y0: self.y0.min(o.y0),
            x1: self.x1.max(o.x1),
            y1: self.y1.max(o.y1),
        }
    }

    /// The index ranges of its rows in a frame of this `width`.
    fn rows(self, width: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
        (self.y0..self.y1).map(move |y| y * width + self.x0..y * width + self.x1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Rational;

    #[test]
    fn the_memory_of_a_picture_is_given_back() {
        let size = Size::new(6, 4);
        let info = StreamInfo::of(size);
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("film.gif");
        let mut sink = Gif::create(&path, &info, &SinkOptions::default()).expect("a place");
        let frame = Frame::filled(size, [9, 8, 7, 255]).expect("a sound size");
        let memory = frame.pixels().as_ptr();
        let fills = vec![crate::frame::Fill { colour: [9, 8, 7, 255], area: 24 }];
        let span = Span { start: Rational::ZERO, length: None };
        let buffers = sink.write(Picture { frame, fills, span }, None).expect("written");
        assert_eq!(buffers.pixels.as_ptr(), memory);
    }
}
