//! Reads pictures from files at a constant rate; a still is a sequence of one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::ImageFormat;

use super::broken::word;
use super::detect::{self, Kind};
use super::still::{self, Decoding, Header};
use super::{Decoded, Input, SEQUENCE_RATE, Source, SourceOptions};
use super::{apng, webp};
use crate::error::{Error, Result};
use crate::frame::Rational;
use crate::geom::Size;
use crate::stream::{Loops, Span, StreamInfo};

/// Opens one picture as a still.
///
/// # Errors
/// When its header is broken or its size too large.
pub(crate) fn open_still(
    path: PathBuf,
    format: ImageFormat,
    options: &SourceOptions,
) -> Result<Input> {
    let Header { size, alpha, left_out } = still::header(&path, format, Decoding::of(options))?;
    let warning = left_out.map(|what| left_out_warning(&path, what));
    let info = StreamInfo {
        format: word(format).into(),
        size,
        frames: Some(1),
        rate: None,
        duration: None,
        alpha,
        still: true,
        loops: Loops::Once,
        audio: None,
        live: false,
        colour: None,
    };
    Ok(input(Arc::from([path]), info, None, options).with_warning(warning))
}

fn left_out_warning(path: &Path, left_out: &str) -> String {
    format!("{}: {left_out}", path.display())
}

/// Opens several pictures as a sequence. All headers are read now, so that a picture of another size is found before
/// the work begins.
///
/// # Errors
/// When a file is missing, no picture, broken, or differs in size from the first.
pub(crate) fn open_sequence(paths: &[PathBuf], options: &SourceOptions) -> Result<Input> {
    let rate = options.fps.unwrap_or(SEQUENCE_RATE);
    let Some(length) = rate.recip().filter(|l| l.num > 0) else {
        return Err(Error::usage(format!("a rate of {rate} frames per second cannot be played")));
    };
    let mut first: Option<(&Path, Size, ImageFormat)> = None;
    let (mut alpha, mut warning) = (false, None);
    for (number, path) in paths.iter().enumerate() {
        let number = number as u64;
        let format = picture(path).map_err(|e| at_frame(e, number))?;
        let header =
            still::header(path, format, Decoding::of(options)).map_err(|e| at_frame(e, number))?;
        alpha |= header.alpha;
        warning = warning.or_else(|| Some(left_out_warning(path, header.left_out?)));
        match first {
            None => first = Some((path, header.size, format)),
            Some((other, size, _)) => same_size(path, number, header.size, other, size)?,
        }
    }
    let Some((_, size, format)) = first else {
        return Err(Error::usage("a sequence needs a picture"));
    };
    let info = StreamInfo {
        format: format!("{} sequence", word(format)),
        size,
        frames: Some(paths.len() as u64),
        rate: Some(rate),
        duration: Some(length * Rational::new(paths.len() as i64, 1)),
        alpha,
        still: false,
        loops: Loops::Forever,
        audio: None,
        live: false,
        colour: None,
    };
    Ok(input(Arc::from(paths), info, Some(length), options).with_warning(warning))
}

fn input(
    paths: Arc<[PathBuf]>,
    info: StreamInfo,
    length: Option<Rational>,
    options: &SourceOptions,
) -> Input {
    let (size, how) = (info.size, Decoding::of(options));
    let files = paths.clone();
    Input::new(files, info, move || {
        let paths = paths.clone();
        Ok(Box::new(Sequence { paths, next: 0, size, length, how, cut: None }))
    })
}

/// The format of a picture that is part of a sequence.
fn picture(path: &Path) -> Result<ImageFormat> {
    let refused = |what: &str| {
        Err(Error::input(
            path,
            format!("{what} cannot be one picture of a sequence; name it alone, or add --batch"),
        ))
    };
    match detect::detect(path)? {
        Kind::Picture(ImageFormat::Png) if apng::facts(path)?.is_some() => refused("an APNG"),
        Kind::Picture(ImageFormat::WebP) if webp::facts(path)?.is_some() => {
            refused("an animated WebP")
        }
        Kind::Picture(format) => Ok(format),
        Kind::Gif => refused("a GIF"),
        Kind::MeshStream => refused("a mesh stream"),
        Kind::Y4m | Kind::Stream => refused("a video"),
        Kind::Other => Err(detect::no_picture(path.to_owned())),
    }
}

fn same_size(path: &Path, number: u64, size: Size, first: &Path, expected: Size) -> Result<()> {
    if size == expected {
        return Ok(());
    }
    let first = first.display();
    Err(Error::input_frame(
        path,
        number,
        format!(
            "is {size} pixels, but the sequence began with {first} of {expected}; \
             all pictures of a sequence need one size; to a folder (-o out/) pictures of any size go one by one"
        ),
    ))
}

/// An error about a file with the frame's number.
fn at_frame(error: Error, number: u64) -> Error {
    match error {
        Error::Input { path, frame: None, what, cause } => {
            Error::Input { path, frame: Some(number), what, cause }
        }
        other => other,
    }
}

struct Sequence {
    paths: Arc<[PathBuf]>,
    next: usize,
    size: Size,
    /// `None` for a still.
    length: Option<Rational>,
    how: Decoding,
    /// The error of a truncated still that was delivered.
    cut: Option<Error>,
}

impl Source for Sequence {
    fn skip_to(&mut self, start: Rational) {
        let Some(rate) = self.length.and_then(Rational::recip) else { return };
        let place = start * rate;
        // The first that does not start earlier.
        let first = -(-place.num).div_euclid(place.den);
        self.next = usize::try_from(first).unwrap_or(0).min(self.paths.len());
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        if let Some(error) = self.cut.take() {
            return Err(error);
        }
        let Some(path) = self.paths.get(self.next) else { return Ok(None) };
        let number = self.next as u64;
        self.next += 1;
        let Some(length) = self.length else {
            let (frame, cut) = still::decode_part(path, picture(path)?, self.how)?;
            self.cut = cut;
            let span = Span { start: Rational::ZERO, length: None };
            return Ok(Some(Decoded::new(frame, span)));
        };
        let frame = picture(path)
            .and_then(|format| still::decode(path, format, self.how))
            .map_err(|e| at_frame(e, number))?;
        // The file may have changed since its header was read.
        same_size(path, number, frame.size(), &self.paths[0], self.size)?;
        let start = length * Rational::new(number as i64, 1);
        Ok(Some(Decoded::new(frame, Span { start, length: Some(length) })))
    }
}
