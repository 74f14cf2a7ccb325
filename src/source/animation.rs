//! Animated PNG and WebP, composed by the `image` crate. What is known before decoding is read from
//! their chunks: [`super::apng`], [`super::webp`].

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::codecs::{png::PngDecoder, webp::WebPDecoder};
use image::{AnimationDecoder, Frames, ImageDecoder, ImageResult};

use super::still::{broken, check_picture, cut_short, limits, title};
use super::{Decoded, Input, Source};
use crate::error::{Error, Result};
use crate::frame::{Frame, Rational};
use crate::geom::Size;
use crate::stream::{Loops, Span, StreamInfo};

/// What the chunks of an animation tell.
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

/// Opens an animation whose chunks told `facts`.
///
/// # Errors
/// When its frames are too large.
pub(crate) fn open(path: PathBuf, format: Format, facts: Facts) -> Result<Input> {
    check_picture(&path, facts.size)?;
    let Facts { size, alpha, loops, lengths, complete } = facts;
    let info = StreamInfo {
        format: format.word().into(),
        size,
        frames: Some(lengths.frames),
        rate: lengths.each.and_then(Rational::recip),
        duration: Some(lengths.total),
        alpha,
        still: false,
        loops,
        audio: None,
        live: false,
        colour: None,
    };
    Ok(Input::new(Arc::from([path.clone()]), info, move || {
        let frames =
            frames(&path, format).map_err(|e| Error::input(&path, broken(&e, format.word())))?;
        let path = path.clone();
        Ok(Box::new(Animation { frames, path, format, time: Rational::ZERO, number: 0, complete }))
    }))
}

fn frames(path: &Path, format: Format) -> ImageResult<Frames<'static>> {
    let file: BufReader<File> = BufReader::new(File::open(path)?);
    Ok(match format {
        Format::Apng => PngDecoder::with_limits(file, limits())?.apng()?.into_frames(),
        Format::WebP => {
            let mut decoder = WebPDecoder::new(file)?;
            decoder.set_limits(limits())?;
            // Browsers leave out the background colour that the file asks for.
            decoder.set_background_color(image::Rgba([0; 4]))?;
            decoder.into_frames()
        }
    })
}

struct Animation {
    frames: Frames<'static>,
    path: PathBuf,
    format: Format,
    time: Rational,
    number: u64,
    complete: bool,
}

impl Source for Animation {
    fn next(&mut self) -> Result<Option<Decoded>> {
        let what = match self.frames.next() {
            Some(Ok(frame)) => {
                let (num, den) = frame.delay().numer_denom_ms();
                let length = Rational::new(num.into(), i64::from(den.max(1)) * 1000);
                let start = self.time;
                self.time = start + length;
                self.number += 1;
                let frame = Frame::from_image(frame.into_buffer())?;
                return Ok(Some(Decoded::new(frame, Span { start, length: Some(length) })));
            }
            Some(Err(e)) if self.complete => broken(&e, self.format.word()),
            None if self.complete => return Ok(None),
            _ => cut_short(&title(self.format.word()), "frames are missing"),
        };
        Err(Error::input_frame(&self.path, self.number, what))
    }
}
