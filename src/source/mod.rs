//! Sources of frames. Each file has one format, which is detected by content.

mod animation;
mod apng;
mod broken;
mod canvas;
mod convert;
#[cfg(feature = "ffmpeg")]
pub(crate) mod decode;
mod deep;
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
mod recognise;
mod resize;
mod sequence;
mod still;
mod tiff;
mod tiff_samples;
mod trim;
mod warmup;
mod webp;
pub mod y4m;
mod y4m_samples;

use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use crate::error::{Error, Result};
use crate::ffmpeg::Ffmpeg;
#[cfg(feature = "ffmpeg")]
use crate::ffmpeg::probe::SoundTracks;
#[cfg(feature = "ffmpeg")]
use crate::ffmpeg::side::SoundPipe;
use crate::frame::{Frame, Rational};
use crate::memory;
use crate::stream::{Span, StreamInfo};

#[cfg(feature = "cli")]
pub(crate) use detect::is_called_picture;

use resize::Resize;
use trim::{Part, Trim};
use warmup::WarmedUp;

/// A decoded frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Decoded {
    /// The picture, upright, at the stream's size.
    pub frame: Frame,
    /// When it is shown.
    pub span: Span,
    /// Whether it is part of a warm-up pass: it goes through the whole chain, so that the mesh and its colours adapt
    /// to it, but is not written, reported or counted. Warm-up frames come before all others.
    pub is_warmup: bool,
}

impl Decoded {
    /// A frame that is shown in `span`.
    pub fn new(frame: Frame, span: Span) -> Self {
        Self { frame, span, is_warmup: false }
    }
}

/// A source that delivers frames in order. It stays on the thread that decodes, and need not be `Send`.
pub trait Source {
    /// The next frame, or `None` at the end of a complete input. It is not called again after an error or `None`.
    ///
    /// # Errors
    /// When the input is truncated or broken; the frames before were delivered.
    fn next(&mut self) -> Result<Option<Decoded>>;

    /// Allows the source to skip frames that start before `start`, in seconds, which is faster than delivering them.
    /// Called at most once, before the first [`Source::next`]. Default: they are delivered.
    fn skip_to(&mut self, _start: Rational) {}

    /// Takes the buffers of a frame that is no longer needed, for the next one. Default: they are dropped.
    fn recycle(&mut self, _frame: Frame) {}

    /// Waits until the next frame is due, if frames are played at a speed. Called before each [`Source::next`]; the
    /// time is not counted as work. Default: returns at once.
    fn wait(&mut self) {}
}

/// Which part of an input is read, and how. The default reads all of it unchanged.
#[derive(Clone, Debug, Default)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct SourceOptions {
    /// Start of the part, in seconds from the input's start: earlier frames are skipped, and times count from here.
    /// Default: the beginning.
    pub start: Option<Rational>,
    /// End of the part, in seconds from the input's start: frames that start then or later are skipped. Default:
    /// none.
    pub end: Option<Rational>,
    /// The most frames that are read. Default: all.
    pub frames: Option<u64>,
    /// Frames per second of a sequence of pictures. Default: [`SEQUENCE_RATE`].
    pub fps: Option<Rational>,
    /// The longest side in pixels; larger frames are scaled down to it. Default: no limit.
    pub max_size: Option<u32>,
    /// Whether the upper part of a truncated picture is delivered, before the error. Complete frames always are.
    /// Default: no.
    pub allow_truncated: bool,
    /// Whether it is played twice, the first time as a [warm-up](Decoded::is_warmup), so that its beginning continues
    /// its end. No effect on a still. Default: no.
    pub looped: bool,
    /// Bytes of memory that decoding may take: larger pictures are refused. Default: 1 GiB.
    pub max_memory: Option<u64>,
    /// The ffmpeg that reads video. Default: the one on the search path.
    pub ffmpeg: Ffmpeg,
    /// Whether HDR video is converted to SDR, for outputs without HDR. Default: no.
    pub to_sdr: bool,
    /// With [`SourceOptions::to_sdr`], whether colours of a wide gamut are converted to BT.709, for outputs without
    /// colour tags. Default: no.
    pub to_bt709: bool,
    /// Whether GIF delays of 0 and 1 hundredths of a second become ten hundredths, as in browsers. Default: no.
    pub browser_delays: bool,
}

/// The source of the sound.
#[derive(Clone, Debug, PartialEq)]
pub struct Sound {
    /// The video, or any file with sound.
    pub path: PathBuf,
    /// The time in it, in seconds from its start, at which the picture begins.
    pub start: Rational,
    /// Whether the picture ends before the source by request: then the sound ends with the picture. Otherwise the
    /// whole sound is kept, unless the picture is shorter than expected.
    pub cut: bool,
    /// Its tracks, if they are known already.
    #[cfg(feature = "ffmpeg")]
    pub(crate) tracks: Option<SoundTracks>,
    /// Where it comes from if its source can be read only once: from the process that decodes the picture.
    #[cfg(feature = "ffmpeg")]
    pub(crate) pipe: Option<SoundPipe>,
}

impl Sound {
    /// The sound of `path` from `start` on, see the fields.
    pub fn new(path: impl Into<PathBuf>, start: Rational, cut: bool) -> Self {
        Self {
            path: path.into(),
            start,
            cut,
            #[cfg(feature = "ffmpeg")]
            tracks: None,
            #[cfg(feature = "ffmpeg")]
            pipe: None,
        }
    }
}

/// Default frames per second of a sequence of pictures.
pub const SEQUENCE_RATE: Rational = Rational { num: 25, den: 1 };

type Starter = Box<dyn FnMut() -> Result<Box<dyn Source>> + Send>;

/// An input whose format and header are known, not yet started. It is small and can be sent to the thread that
/// decodes.
pub struct Input {
    paths: Arc<[PathBuf]>,
    info: StreamInfo,
    sound: Option<Sound>,
    repeats: bool,
    warnings: Vec<String>,
    notes: Vec<String>,
    /// The meshes behind its pictures, where it is a mesh stream.
    meshes: Option<mesh_stream::Opened>,
    start: Starter,
}

impl std::fmt::Debug for Input {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Input").field("info", &self.info).finish_non_exhaustive()
    }
}

impl Input {
    /// An input that reads `paths`; `start` makes its decoder.
    pub(crate) fn new(
        paths: Arc<[PathBuf]>,
        info: StreamInfo,
        start: impl FnMut() -> Result<Box<dyn Source>> + Send + 'static,
    ) -> Self {
        let repeats = !info.live;
        Self {
            paths,
            info,
            sound: None,
            repeats,
            warnings: Vec::new(),
            notes: Vec::new(),
            meshes: None,
            start: Box::new(start),
        }
    }

    /// The same for inputs that can be read only once: a pipe.
    pub(crate) fn once(self) -> Self {
        Self { repeats: false, ..self }
    }

    /// The same with what the user should know about it.
    pub(crate) fn with_warning(mut self, warning: Option<String>) -> Self {
        self.warnings.extend(warning);
        self
    }

    /// The same, of a mesh stream.
    fn of_meshes(self, opened: mesh_stream::Opened) -> Self {
        Self { meshes: Some(opened), ..self }
    }

    /// The meshes of a mesh stream, whole, to be read in place of its pictures. `None` of other inputs, and once
    /// somebody has begun to read it.
    pub fn take_meshes(&self) -> Option<mesh_stream::MeshSource> {
        self.meshes.as_ref().and_then(mesh_stream::take)
    }

    /// The same with sound.
    #[cfg(feature = "ffmpeg")]
    pub(crate) fn with_sound(self, sound: Option<Sound>) -> Self {
        Self { sound, ..self }
    }

    /// The files that it reads, none for standard input.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// The properties of the stream, with `start`, `end`, `frames` and `max_size` taken into account.
    pub fn info(&self) -> &StreamInfo {
        &self.info
    }

    /// The sound of the part that is read, if it can be read alongside the frames.
    pub fn sound(&self) -> Option<&Sound> {
        self.sound.as_ref()
    }

    /// The same with what was found in it.
    #[cfg(feature = "ffmpeg")]
    pub(crate) fn with_notes(self, notes: Vec<String>) -> Self {
        Self { notes, ..self }
    }

    /// What was found in the input besides frames, and what is done with it, in words.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// What of the input is left out, in sentences.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Makes the decoder. Call it on the thread that will decode.
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

    /// As [`Input::start`], but it can be called any number of times if the input [repeats](Self::repeats), else
    /// once.
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
/// When nothing is named, a file is missing, unreadable or not a picture, frames differ in size, or an input to be
/// looped can be read only once; [`Error::Memory`] when there is not enough memory for frames of that size.
pub fn open(inputs: &[impl AsRef<OsStr>], options: &SourceOptions) -> Result<Input> {
    let part = Part::of(options)?;
    if options.max_size == Some(0) {
        return Err(Error::usage("a longest side of 0 pixels leaves nothing; ask for at least 1"));
    }
    let inputs: Vec<&OsStr> = inputs.iter().map(AsRef::as_ref).collect();
    let input = recognise::recognised(&inputs, part, options)?;
    let input = if options.browser_delays { delays::as_shown(input) } else { input };
    let decoded = input.info.size;
    let input = resized(trimmed(input, part), options);
    memory::check(decoded, input.info.size, input.info.still)?;
    if options.looped { warmed_up(input, options.allow_truncated) } else { Ok(input) }
}

/// The files that `inputs` name, as [`open`] finds them, to be opened one by one.
///
/// # Errors
/// When nothing is named, or a folder, glob or pattern holds no file.
pub fn files(inputs: &[impl AsRef<OsStr>]) -> Result<Vec<PathBuf>> {
    let inputs: Vec<&OsStr> = inputs.iter().map(AsRef::as_ref).collect();
    expand::expand(&inputs)
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
