//! Where frames come from. One format a file; formats are recognised by content.

mod animation;
mod apng;
mod canvas;
#[cfg(feature = "ffmpeg")]
pub(crate) mod decode;
mod delays;
pub(crate) mod detect;
mod expand;
mod fence;
#[cfg(feature = "ffmpeg")]
pub mod ffmpeg;
#[cfg(not(feature = "ffmpeg"))]
#[path = "no_ffmpeg.rs"]
mod ffmpeg;
mod gif;
mod gif_blocks;
mod jpeg;
mod jpeg_fallback;
mod limit;
pub mod mesh_stream;
mod png;
mod profile;
mod resize;
mod sequence;
mod still;
mod tiff;
mod trim;
mod warmup;
mod webp;
pub mod y4m;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use image::ImageFormat;

use crate::error::{Error, Result};
use crate::ffmpeg::Ffmpeg;
#[cfg(feature = "ffmpeg")]
use crate::ffmpeg::probe::SoundTracks;
use crate::frame::{Frame, Rational};
use crate::memory;
use crate::stream::{Span, StreamInfo};

use detect::Kind;
use limit::Limit;
use resize::Resize;
use trim::{Part, Trim};
use warmup::WarmedUp;

/// A frame as it comes from a source.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Decoded {
    /// The picture, upright, at the stream's size.
    pub frame: Frame,
    /// When it is shown.
    pub span: Span,
    /// Whether it is part of a warm-up pass: it goes through the whole chain, so that the mesh and its
    /// colours adapt to it, but is neither written nor reported nor counted. Warm-up frames come before all
    /// others.
    pub is_warmup: bool,
}

impl Decoded {
    /// A frame that is shown in `span`.
    pub fn new(frame: Frame, span: Span) -> Self {
        Self { frame, span, is_warmup: false }
    }
}

/// A started source: frames in order. Lives on the thread that decodes, and need not be `Send`.
pub trait Source {
    /// The next frame, `None` at the end of a complete input. After an error or `None` it is not
    /// called again.
    ///
    /// # Errors
    /// When the input is truncated or broken; the frames before have been delivered.
    fn next(&mut self) -> Result<Option<Decoded>>;

    /// Nobody wants the frames that start before `start`: they may be left out, which is quicker
    /// than to deliver them. Called before the first [`Source::next`], if at all. Default: they
    /// are delivered all the same.
    fn skip_to(&mut self, _start: Rational) {}

    /// Takes back a frame of the stream that is no longer needed, so that the next one need not allocate.
    /// Default: it is dropped.
    fn recycle(&mut self, _frame: Frame) {}

    /// Called before each [`Source::next`]: waits until the next frame is due, where frames are played
    /// at a speed. Time spent here is not time at work. Default: it is due at once.
    fn wait(&mut self) {}
}

/// What of an input is read, and how. The default reads all of it as it is.
#[derive(Clone, Debug, Default)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct SourceOptions {
    /// Seconds from the input's start: frames that start earlier are left out, and times count from
    /// here. Default: the beginning.
    pub start: Option<Rational>,
    /// Seconds from the input's start: frames that start then or later are left out. Default: none.
    pub end: Option<Rational>,
    /// At most this many frames. Default: all.
    pub frames: Option<u64>,
    /// Frames per second of a sequence of pictures. Default: [`SEQUENCE_RATE`].
    pub fps: Option<Rational>,
    /// Frames whose longest side is above this many pixels are shrunk to it. Default: never.
    pub max_size: Option<u32>,
    /// Whether of a single picture that ends too early its upper part is delivered, before the error
    /// that says so. Whole frames always are. Default: no.
    pub allow_truncated: bool,
    /// Whether it is played twice, the first time as a [warm-up](Decoded::is_warmup): its beginning
    /// then goes on from its end. No effect on a still. Default: no.
    pub looped: bool,
    /// Bytes of memory that decoding may take: larger pictures are refused, and so are headers that claim
    /// more. Default: 1 GiB.
    pub max_memory: Option<u64>,
    /// The ffmpeg that reads video. Default: the one on the search path.
    pub ffmpeg: Ffmpeg,
    /// Whether HDR video is brought to SDR, for outputs that cannot say that they are HDR. Default: no.
    pub to_sdr: bool,
    /// Whether frames of a GIF with delays of 0 and 1 hundredths are shown for ten, as browsers do. Default:
    /// they keep their delays.
    pub browser_delays: bool,
}

/// Where sound comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Sound {
    /// The video (or any file with sound).
    pub path: PathBuf,
    /// The moment of it, in seconds from its start, at which the picture begins.
    pub start: Rational,
    /// Whether the picture was asked to end before the source does: then the sound ends with the
    /// picture. Else it is kept whole, unless the picture turns out shorter than expected.
    pub cut: bool,
    /// Its tracks, where they were looked at already.
    #[cfg(feature = "ffmpeg")]
    pub(crate) tracks: Option<SoundTracks>,
}

impl Sound {
    /// The sound of `path` from the moment `start` on, see the fields.
    pub fn new(path: impl Into<PathBuf>, start: Rational, cut: bool) -> Self {
        Self {
            path: path.into(),
            start,
            cut,
            #[cfg(feature = "ffmpeg")]
            tracks: None,
        }
    }
}

/// Frames per second of a sequence of pictures that nobody gave a rate.
pub const SEQUENCE_RATE: Rational = Rational { num: 25, den: 1 };

type Starter = Box<dyn FnMut() -> Result<Box<dyn Source>> + Send>;

/// An input that has been recognised and whose header has been read, not yet started. It is small
/// and can go to the thread that decodes.
pub struct Input {
    paths: Arc<[PathBuf]>,
    info: StreamInfo,
    sound: Option<Sound>,
    repeats: bool,
    start: Starter,
}

impl std::fmt::Debug for Input {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Input").field("info", &self.info).finish_non_exhaustive()
    }
}

impl Input {
    /// An input that reads `paths` once `start` has built its decoder.
    pub(crate) fn new(
        paths: Arc<[PathBuf]>,
        info: StreamInfo,
        start: impl FnMut() -> Result<Box<dyn Source>> + Send + 'static,
    ) -> Self {
        let repeats = !info.live;
        Self { paths, info, sound: None, repeats, start: Box::new(start) }
    }

    /// The same, of what can be read only once: a pipe.
    pub(crate) fn once(self) -> Self {
        Self { repeats: false, ..self }
    }

    /// The same with sound.
    #[cfg(feature = "ffmpeg")]
    pub(crate) fn with_sound(self, sound: Option<Sound>) -> Self {
        Self { sound, ..self }
    }

    /// The files that are read, none for standard input.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// What the headers say, with `start`, `end`, `frames` and `max_size` taken into account.
    pub fn info(&self) -> &StreamInfo {
        &self.info
    }

    /// The sound of the part that is read, if there is any that can be read alongside the frames.
    pub fn sound(&self) -> Option<&Sound> {
        self.sound.as_ref()
    }

    /// Builds the decoder. Call it on the thread that will ask for frames.
    ///
    /// # Errors
    /// When the input cannot be opened (any more).
    pub fn start(mut self) -> Result<Box<dyn Source>> {
        self.restart()
    }

    /// Whether it can be read again from its beginning: not a pipe, not a camera.
    pub fn repeats(&self) -> bool {
        self.repeats
    }

    /// As [`Input::start`], to be called any number of times if the input [repeats](Self::repeats),
    /// else once.
    ///
    /// # Errors
    /// When the input cannot be opened (any more).
    pub fn restart(&mut self) -> Result<Box<dyn Source>> {
        (self.start)()
    }
}

/// Opens what `inputs` name: a file; several pictures, a folder of them, a glob, or a printf pattern
/// (`frame_%04d.png`), each of which makes a sequence; or `-` for y4m on standard input. Only
/// headers are read.
///
/// # Errors
/// When nothing is named, a file is missing, unreadable or not a picture, frames differ in size, or what
/// is to be looped can be read only once; [`Error::Memory`] when there is not enough for frames of that size.
pub fn open(inputs: &[impl AsRef<OsStr>], options: &SourceOptions) -> Result<Input> {
    let part = Part::of(options)?;
    if options.max_size == Some(0) {
        return Err(Error::usage("a longest side of 0 pixels leaves nothing; ask for at least 1"));
    }
    let inputs: Vec<&OsStr> = inputs.iter().map(AsRef::as_ref).collect();
    let input = recognised(&inputs, part, options)?;
    let input = if options.browser_delays { delays::as_shown(input) } else { input };
    let decoded = input.info.size;
    let input = resized(trimmed(input, part), options);
    memory::check(decoded, input.info.size, input.info.still)?;
    if options.looped { warmed_up(input, options.allow_truncated) } else { Ok(input) }
}

/// The files that `inputs` name, as [`open`] finds them, each to be opened by itself.
///
/// # Errors
/// When nothing is named, or a folder, glob or pattern holds no file.
pub fn files(inputs: &[impl AsRef<OsStr>]) -> Result<Vec<PathBuf>> {
    let inputs: Vec<&OsStr> = inputs.iter().map(AsRef::as_ref).collect();
    expand::expand(&inputs)
}

fn recognised(inputs: &[&OsStr], part: Option<Part>, options: &SourceOptions) -> Result<Input> {
    if inputs == ["-"] {
        let path = Path::new("-");
        return if mesh_stream::waits_on_standard_input() {
            within_memory(mesh_stream::open_standard()?, path, options)
        } else {
            within_memory(y4m::open_standard()?, path, options)
        };
    }
    if let [one] = inputs
        && ffmpeg::is_address(Path::new(one))
    {
        return within_memory(ffmpeg::open(one.into(), options)?, Path::new(one), options);
    }
    let mut paths = expand::expand(inputs)?;
    if paths.len() > 1 {
        if let Some(part) = part {
            let needed = part.needed(options.fps.unwrap_or(SEQUENCE_RATE));
            paths.truncate(usize::try_from(needed).unwrap_or(usize::MAX).max(1));
        }
        return sequence::open_sequence(&paths, options);
    }
    let Some(path) = paths.pop() else { return Err(Error::usage("no input is named")) };
    match detect::detect(&path)? {
        Kind::Gif => gif::open(path, options),
        Kind::Picture(ImageFormat::Png) => match apng::facts(&path)? {
            Some(facts) => animation::open(path, animation::Format::Apng, facts, options),
            None => sequence::open_still(path, ImageFormat::Png, options),
        },
        Kind::Picture(ImageFormat::WebP) => match webp::facts(&path)? {
            Some(facts) => animation::open(path, animation::Format::WebP, facts, options),
            None => sequence::open_still(path, ImageFormat::WebP, options),
        },
        Kind::Picture(format) => sequence::open_still(path, format, options),
        Kind::MeshStream => within_memory(mesh_stream::open(path.clone())?, &path, options),
        Kind::Y4m | Kind::Stream => within_memory(y4m::open(path.clone())?, &path, options),
        Kind::Other => {
            let picture = detect::is_called_picture(&path);
            let video = ffmpeg::open(path.clone(), options)
                .map_err(|error| if picture { detect::no_picture(path.clone()) } else { error })?;
            within_memory(video, &path, options)
        }
    }
}

/// Checks that frames of a video can be had: as they come, and as RGBA.
fn within_memory(input: Input, path: &Path, options: &SourceOptions) -> Result<Input> {
    Limit::of(options).check(path, input.info.size, 8)?;
    Ok(input)
}

fn trimmed(input: Input, part: Option<Part>) -> Input {
    let Some(part) = part else { return input };
    let Input { info, mut start, .. } = input;
    let start = Box::new(move || Ok(Box::new(Trim::new(start()?, part)) as Box<dyn Source>));
    Input { info: part.info(info), start, ..input }
}

fn resized(input: Input, options: &SourceOptions) -> Input {
    let from = input.info.size;
    let to = options.max_size.map_or(from, |longest| resize::fitted(from, longest));
    if to == from {
        return input;
    }
    let Input { mut info, mut start, .. } = input;
    info.size = to;
    let start = Box::new(move || Ok(Box::new(Resize::new(start()?, from, to)) as Box<dyn Source>));
    Input { info, start, ..input }
}

fn warmed_up(input: Input, allow_truncated: bool) -> Result<Input> {
    if input.info.still {
        return Ok(input);
    }
    if !input.repeats {
        return Err(Error::usage(
            "to loop is to read the input twice, and pipes, streams and cameras can be read only once: \
             name a file",
        ));
    }
    let Input { start, .. } = input;
    let starter = Arc::new(Mutex::new(start));
    let start = Box::new(move || {
        Ok(Box::new(WarmedUp::new(starter.clone(), allow_truncated)?) as Box<dyn Source>)
    });
    Ok(Input { start, ..input })
}
