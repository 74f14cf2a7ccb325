//! Animated PNG and WebP: what is common to both. Their chunks are read and their frames composed in
//! [`super::apng`] and [`super::webp`].

use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::ImageResult;

use super::apng::Apng;
use super::broken::{broken, check_picture, cut_short, found, title};
use super::limit::Limit;
use super::webp::WebP;
use super::{Decoded, Input, Source, SourceOptions, fence};
use crate::error::{Error, Result};
use crate::frame::{Frame, Rational, Rgba};
use crate::geom::Size;
use crate::stream::{Loops, Span, StreamInfo};

/// What the chunks of an animation say.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Facts {
    pub(crate) size: Size,
    pub(crate) alpha: bool,
    pub(crate) loops: Loops,
    /// How long each frame is shown, in seconds, for the frames that are there.
    pub(crate) lengths: Lengths,
    /// Whether the file reaches its end.
    pub(crate) complete: bool,
}

/// Lengths of frames, summed up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lengths {
    /// Number of frames.
    pub(crate) frames: u64,
    /// Their sum.
    pub(crate) total: Rational,
    /// The length, if all have one.
    pub(crate) each: Option<Rational>,
}

impl Lengths {
    /// Of no frame.
    pub(crate) const NONE: Self = Self { frames: 0, total: Rational::ZERO, each: None };

    /// Adds a frame.
    pub(crate) fn add(&mut self, length: Rational) {
        self.each =
            if self.frames == 0 { Some(length) } else { self.each.filter(|&e| e == length) };
        self.frames += 1;
        self.total = self.total + length;
    }
}

/// Which of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Apng,
    WebP,
}

impl Format {
    fn word(self) -> &'static str {
        match self {
            Self::Apng => "apng",
            Self::WebP => "webp",
        }
    }
}

/// Bytes of a pixel that an animation takes: the canvas, what a frame covers, the frame as it is decoded and as
/// it is handed on.
const PIXEL: u64 = 16;

/// Opens an animation whose chunks say `facts`.
///
/// # Errors
/// When its frames are too large.
pub(crate) fn open(
    path: PathBuf,
    format: Format,
    facts: Facts,
    options: &SourceOptions,
) -> Result<Input> {
    check_picture(&path, facts.size)?;
    let limit = Limit::of(options);
    limit.check(&path, facts.size, PIXEL)?;
    let Facts { size, alpha, loops, lengths, complete } = facts;
    // A default image that is not part of the animation leaves one frame: a picture.
    let still = format == Format::Apng && lengths.frames == 1 && complete;
    let info = StreamInfo {
        format: format.word().into(),
        size,
        frames: Some(lengths.frames),
        rate: lengths.each.and_then(Rational::recip).filter(|_| !still),
        duration: Some(lengths.total).filter(|_| !still),
        alpha,
        still,
        loops: if still { Loops::Once } else { loops },
        audio: None,
        live: false,
        colour: None,
    };
    Ok(Input::new(Arc::from([path.clone()]), info, move || {
        let frames = Frames::open(&path, format, size, lengths.frames, limit)?;
        let path = path.clone();
        let time = Rational::ZERO;
        Ok(Box::new(Animation { frames, path, format, size, time, number: 0, complete, still }))
    }))
}

enum Frames {
    Apng(Box<Apng>),
    WebP(WebP),
}

impl Frames {
    fn open(path: &Path, format: Format, size: Size, frames: u64, limit: Limit) -> Result<Self> {
        let opened = fence::run(format.word(), || match format {
            Format::Apng => Apng::open(path, size, frames).map(|apng| Self::Apng(Box::new(apng))),
            Format::WebP => WebP::open(path, size, limit).map(Self::WebP),
        });
        opened.map_err(|what| Error::input(path, what))?
    }

    fn next(&mut self) -> ImageResult<Option<(Vec<Rgba>, Rational)>> {
        match self {
            Self::Apng(frames) => frames.next(),
            Self::WebP(frames) => frames.next(),
        }
    }
}

struct Animation {
    frames: Frames,
    path: PathBuf,
    format: Format,
    size: Size,
    time: Rational,
    number: u64,
    complete: bool,
    still: bool,
}

impl Source for Animation {
    fn next(&mut self) -> Result<Option<Decoded>> {
        let next = fence::run(self.format.word(), || self.frames.next());
        let failed = |what: String| Error::input_frame(&self.path, self.number, what);
        Err(match next {
            Ok(Ok(Some((pixels, length)))) => {
                let start = self.time;
                self.time = start + length;
                self.number += 1;
                let length = Some(length).filter(|_| !self.still);
                let frame = Frame::new(self.size, pixels)?;
                return Ok(Some(Decoded::new(frame, Span { start, length })));
            }
            Ok(Ok(None)) if self.complete => return Ok(None),
            Ok(Err(e)) if self.complete => found(failed(broken(&e, self.format.word())), &e),
            // The decoder is at fault as well as the file: what it delivered before is not to be trusted.
            Err(what) => failed(what),
            _ => failed(cut_short(&title(self.format.word()), "frames are missing")).truncated(),
        })
    }
}
