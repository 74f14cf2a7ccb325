//! Sinks of frames. Each file has one format; an unfinished output never has its final name.

mod animation;
#[cfg(feature = "ffmpeg")]
mod codec;
#[cfg(feature = "ffmpeg")]
mod container;
#[cfg(feature = "ffmpeg")]
mod encoding;
mod facets;
#[cfg(feature = "ffmpeg")]
pub mod ffmpeg;
#[cfg(not(feature = "ffmpeg"))]
#[path = "no_ffmpeg.rs"]
pub mod ffmpeg;
mod gif;
mod html;
#[cfg(feature = "ffmpeg")]
mod live;
mod mesh_stream;
mod null;
mod one_mesh;
mod palette;
pub mod place;
mod planes;
#[cfg(feature = "ffmpeg")]
mod remux;
pub mod repainted;
#[cfg(feature = "ffmpeg")]
mod sound;
mod spec;
mod still;
#[cfg(feature = "ffmpeg")]
mod tags;
mod target;
mod unfinished;
mod usd;
mod video;
pub mod y4m;

pub use unfinished::Unfinished;
#[cfg(feature = "cli")]
pub use video::is_video;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::colour::Form;
use crate::error::{Error, Result};
use crate::frame::{Buffers, Fill, Frame, Rgba};
use crate::mesh::Mesh;
use crate::mesh_stream::Grid;
use crate::options::{Edges, Options};
use crate::pattern::Pattern;
use crate::stream::{Loops, Span, StreamInfo};
use crate::svg::Seams;

pub use crate::source::Sound;
use ffmpeg::VideoOptions;
use place::Series;
use still::Format;
use target::Target;
use video::{container_of, format_of, lossy_webp, passing, video_file};

/// A finished frame on its way to a sink.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Picture {
    /// The low-poly picture.
    pub frame: Frame,
    /// All colours of `frame`, if edges are hard: those of the triangles, and of outlines. A colour may occur several
    /// times; areas are weights (an outline hides parts of triangles).
    pub fills: Vec<Fill>,
    /// When it is shown.
    pub span: Span,
}

/// The frame and mesh of a picture, for sinks that show them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Origin {
    /// The source frame.
    pub frame: Frame,
    /// The mesh that was painted.
    pub mesh: Mesh,
}

/// The requirements of a [`Sink`] for its pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct Needs {
    /// Opaque pictures without outlines are painted as planes of this form, which must be
    /// [squared](crate::colour::Layout::is_squared); others come as pixels all the same. Default: none,
    /// all pictures come as pixels.
    pub form: Option<Form>,
    /// The edges that pictures must have, instead of those of the options. Default: those of the options.
    pub edges: Option<Edges>,
    /// Whether pictures are shown at once, by a window or a live stream: then frames of a live source are dropped
    /// when the pipeline is full. A file gets all frames. Default: no.
    pub live: bool,
    /// Whether [`Sink::write`] gets the [`Origin`]. If not, the source frame and the mesh are recycled as
    /// soon as the picture is painted. Default: no.
    pub origin: bool,
    /// Whether pictures come without grading and outlines: for formats that store triangles and apply these
    /// themselves. Default: no.
    pub plain: bool,
}

impl Needs {
    /// Whether the sink can show what `options` ask for.
    ///
    /// # Errors
    /// When pictures come [plain](Needs::plain), as facets of one colour each, and facets are to have gradients.
    pub fn check(&self, options: &Options) -> Result<()> {
        if self.plain && options.fill.is_gradient() {
            return Err(Error::usage(format!(
                "--fill {} gives a triangle more than one colour, and this output holds one a triangle: write a \
                 picture or a video, without --scale, or take another --fill",
                options.fill.name()
            )));
        }
        Ok(())
    }

    /// Changes `options` to the requirements.
    pub fn adapt(&self, options: &mut Options) {
        if let Some(edges) = self.edges {
            options.edges = edges;
        }
        if self.plain {
            *options = options.plain();
        }
    }
}

/// An output that is being written. If it is dropped before [`Sink::finish`], it leaves no file behind.
pub trait Sink: Send {
    /// The requirements for pictures. They are constant: callers may read them once, before the first picture.
    /// Default: RGBA pixels with the edges of the options, without their origin.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// Writes the next picture. All have the same size. `origin` is given if [`Needs::origin`] is set. Returns
    /// buffers that the sink no longer needs, perhaps empty, in which the next picture can be painted.
    ///
    /// # Errors
    /// When it cannot be written; [`crate::error::Error::Closed`] when the reader of a pipe has closed it.
    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers>;

    /// Completes the output and gives it its final name.
    ///
    /// # Errors
    /// When the last bytes cannot be written.
    fn finish(self: Box<Self>) -> Result<()>;

    /// Warnings for the user, in sentences. Default: none.
    fn warnings(&self) -> &[String] {
        &[]
    }
}

/// How an output is written.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct SinkOptions {
    /// Whether existing outputs may be replaced. Default: no.
    pub overwrite: bool,
    /// The colour behind transparent pixels in formats without alpha. Default: white.
    pub background: Rgba,
    /// How often an animation plays. Default: as the input does.
    pub loops: Option<Loops>,
    /// The files that are being read; none of them may be the output. Default: none.
    pub inputs: Vec<PathBuf>,
    /// Quality of JPEG and of lossy WebP, 1 to 100. Default: JPEG of 90, lossless WebP.
    pub quality: Option<u8>,
    /// How video is encoded.
    pub video: VideoOptions,
    /// The sound that goes into a video. Default: none.
    pub sound: Option<Sound>,
    /// The edges, outlines and grading for formats that store triangles. Default: those of `Options::default()`.
    pub look: Options,
    /// How gaps between the triangles of an SVG are avoided. Default: underlap.
    pub seams: Seams,
    /// Where vertices of a mesh stream stand. Default: where they are, nothing is lost.
    pub grid: Grid,
    /// By how much its colours may be off, of 255. Default: 0.
    pub colour_error: u8,
    /// The format, by its extension or by the name of ffmpeg's muxer. Default: as the output's name says, in a
    /// folder `png`.
    pub format: Option<String>,
    /// The list that temporary files are entered in until they are complete. Default: a list of its own.
    pub unfinished: Unfinished,
    /// The folder of temporary files that have names, on the output's file system. Default: the output's own.
    pub temporaries: Option<PathBuf>,
    /// Whether a file is safe on its disk before it has its name. Default: no.
    pub durable: bool,
}

impl Default for SinkOptions {
    fn default() -> Self {
        Self {
            overwrite: false,
            background: [255; 4],
            loops: None,
            inputs: Vec::new(),
            quality: None,
            video: VideoOptions::default(),
            sound: None,
            look: Options::default(),
            seams: Seams::default(),
            grid: Grid::default(),
            colour_error: 0,
            format: None,
            unfinished: Unfinished::default(),
            temporaries: None,
            durable: false,
        }
    }
}

/// Makes the sink for `output`, by its name: a still (`.png`, `.jpg`, `.webp` ...), a numbered sequence
/// (`frame_%04d.png`, or a folder), a `.svg`, a `.gif`, a video (`.mp4`, `.webm`, `.mkv`, `.mov`, `.ts` ...), a `.y4m`,
/// a named pipe, `-` for y4m or the format of the options on standard output, an address (`rtmp://`, `srt://`, `udp://`),
/// a playlist (`.m3u8`), a device (`/dev/video0`), or `null:`, which discards. `info` is the stream that will be
/// written.
///
/// # Errors
/// When the name's format is unknown or does not suit the stream, the output exists, is an input, or
/// cannot be written.
pub fn create(
    output: impl AsRef<OsStr>,
    info: &StreamInfo,
    options: &SinkOptions,
) -> Result<Box<dyn Sink>> {
    let output = output.as_ref();
    if output == "null:" {
        return Ok(Box::new(null::Null::of(info)));
    }
    let path = Path::new(output);
    if let Some(target) = Target::of(output) {
        return passing(path, target, info, options);
    }
    if ends_in_separator(output) || path.is_dir() {
        let extension = options.format.as_deref().unwrap_or("png");
        let pattern = Pattern::in_folder(path, extension);
        return numbered(path, pattern, extension, true, options);
    }
    let extension = format_of(path, options);
    let extension = extension.as_str();
    if let Some(pattern) = Pattern::parse(output) {
        return numbered(path, pattern, extension, false, options);
    }
    let is_one = info.still || info.frames == Some(1);
    if extension == "webp"
        && let Some(quality) = options.quality
    {
        return lossy_webp(path, quality, info, options);
    }
    if let Some(format) = animation::Format::of_extension(extension)
        && (!is_one || format == animation::Format::Apng)
    {
        return Ok(Box::new(animation::Animation::create(path, format, info, options)?));
    }
    if let Some(format) = Format::of_extension(extension) {
        if !is_one {
            return Err(one_picture_for_many(path, info));
        }
        return Ok(Box::new(still::Still::create(path, format, options)?));
    }
    if let Some(format) = one_mesh::Format::of_extension(extension)
        && (is_one || format != one_mesh::Format::Svg)
    {
        if !is_one {
            return Err(one_picture_for_many(path, info));
        }
        return Ok(Box::new(one_mesh::MeshStill::create(path, format, options)?));
    }
    match extension {
        "polyreel" => Ok(Box::new(mesh_stream::MeshSink::create(path, info, options)?)),
        "html" | "htm" => Ok(Box::new(mesh_stream::MeshSink::page(path, info, options)?)),
        "usda" => Ok(Box::new(usd::UsdSink::create(path, info, options)?)),
        "svg" => Ok(Box::new(one_mesh::SvgAnimation::create(path, info, options)?)),
        "gif" => Ok(Box::new(gif::Gif::create(path, info, options)?)),
        "y4m" => Ok(Box::new(y4m::Y4mFile::create(path, info, options)?)),
        _ if container_of(path, options).is_some() => {
            if info.still {
                return Err(no_video_of_a_still(path));
            }
            video_file(path, info, options)
        }
        "" => Err(Error::usage(format!(
            "{}: the name has no ending that says what to write; for pictures in a folder write {0}/, for one file \
             {0}.png, {0}.gif or {0}.mp4",
            path.display()
        ))),
        _ => Err(Error::usage(format!(
            "{}: the name must end in what to write: {STILLS}, .gif, {VIDEOS}, .apng, .y4m, .html, \
             .polyreel, .usda; or name a folder (frames/), a pattern (frame_%04d.png), - for y4m on standard output, or \
             null: to write nothing",
            path.display()
        ))),
    }
}

/// Whether pictures of pixels with the lower-case `extension` can be written.
#[cfg(feature = "cli")]
pub(crate) fn is_still(extension: &str) -> bool {
    Format::of_extension(extension).is_some()
}

fn ends_in_separator(name: &OsStr) -> bool {
    name.as_encoded_bytes().last().is_some_and(|&b| std::path::is_separator(char::from(b)))
}

/// The sink of files that are numbered by `pattern`, in a folder that is made if `make` is true.
fn numbered(
    output: &Path,
    pattern: Pattern,
    extension: &str,
    make: bool,
    options: &SinkOptions,
) -> Result<Box<dyn Sink>> {
    if let Some(format) = one_mesh::Format::of_extension(extension) {
        let series = Series::reserve(pattern, make, options)?;
        return Ok(Box::new(one_mesh::MeshSeries::create(series, format, options)));
    }
    let Some(format) = Format::of_extension(extension) else {
        return Err(Error::usage(format!(
            "{}: numbered files are pictures; write {STILLS} after the pattern",
            output.display()
        )));
    };
    let series = Series::reserve(pattern, make, options)?;
    Ok(Box::new(still::Numbered::create(series, format, options)?))
}

/// The containers of video, in words.
const VIDEOS: &str = ".mp4, .webm, .mkv, .mov, .ts, .avi, .flv, .ogv";

fn no_video_of_a_still(path: &Path) -> Error {
    Error::usage(format!(
        "{} is a video, but the input is one still picture: write {}, or name several pictures",
        path.display(),
        path.with_extension("png").display()
    ))
}

/// The formats of stills, in words.
const STILLS: &str = ".png, .jpg, .webp, .bmp, .tiff, .svg, .obj, .ply";

fn one_picture_for_many(path: &Path, info: &StreamInfo) -> Error {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    let sibling = |name: String| path.with_file_name(name).display().to_string();
    let frames = info.frames.map_or("several".into(), |n| n.to_string());
    Error::usage(format!(
        "{} is one picture, but the input has {frames} frames: write {}, or {}",
        path.display(),
        sibling(format!("{stem}_%04d.{extension}")),
        sibling(format!("{stem}.gif")),
    ))
}
