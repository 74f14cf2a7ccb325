//! The plan of a film in parts, as JSON.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::hash;
use crate::error::{Error, Result};
use crate::frame::Rational;
use crate::mesh_stream::Grid;
use crate::options::Options;
use crate::sink::ffmpeg::Container;
use crate::stream::StreamInfo;

/// The version of this program, which made the plan or a part.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The largest plan that is read: some two million shots.
const MOST_BYTES: u64 = 512 << 20;

/// Which parts a film is rendered in, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Plan {
    /// The version of the program that made it.
    pub polyreel: String,
    /// What is rendered.
    pub film: Film,
    /// How it is read.
    pub read: Reading,
    /// How it is rendered. The number of points is fixed: that of `auto` was found.
    pub options: Options,
    /// How the joined film is written.
    pub write: Writing,
    /// A hash of what was asked for, before anything was found.
    pub asked: String,
    /// The number of frames.
    pub frames: u64,
    /// Where the mesh begins anew, in order.
    pub shots: Vec<Shot>,
    /// The parts, in order; each is rendered by itself.
    pub chunks: Vec<Chunk>,
}

/// What is rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Film {
    /// The inputs, as absolute names.
    pub inputs: Vec<String>,
    /// Their bytes in all.
    pub bytes: u64,
    /// The hash of these.
    pub hash: String,
    /// Format as recognised by content.
    pub format: String,
    /// Whether it is HDR.
    pub hdr: bool,
}

/// How the film is read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", default)]
pub struct Reading {
    /// Frames that start earlier are left out.
    pub start: Option<Rational>,
    /// Frames that start then or later are left out.
    pub end: Option<Rational>,
    /// At most this many.
    pub frames: Option<u64>,
    /// Frames a second of a sequence of pictures.
    pub fps: Option<Rational>,
    /// The longest side.
    pub max_size: Option<u32>,
    /// Bytes of memory that decoding may take.
    pub max_memory: Option<u64>,
    /// Whether what can be read of a film that breaks off is kept.
    pub allow_truncated: bool,
    /// Whether HDR stays HDR; else its tones become SDR.
    pub keep_hdr: bool,
    /// What it is read for.
    #[serde(rename = "for")]
    pub kind: Kind,
}

/// Kinds of outputs for which a film is read in different ways: HDR and the delays of GIFs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Video, which can say that it is HDR.
    #[default]
    Video,
    /// GIF, which keeps the delays of a GIF, and has hard edges.
    Gif,
    /// All others.
    Other,
}

impl Kind {
    /// That of `output`, by its name.
    pub fn of(output: &OsStr) -> Self {
        let path = Path::new(output);
        if output == "null:" || Container::of(path).is_some() {
            Self::Video
        } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gif")) {
            Self::Gif
        } else {
            Self::Other
        }
    }

    /// That of an `ending` of names, with or without its dot.
    pub fn of_ending(ending: &str) -> Self {
        Self::of(OsStr::new(&format!("x.{}", ending.rsplit('.').next().unwrap_or(ending))))
    }

    /// Its name in messages: an output that is of this kind.
    pub fn example(self) -> &'static str {
        match self {
            Self::Video => ".mp4",
            Self::Gif => ".gif",
            Self::Other => ".y4m",
        }
    }
}

/// How the joined film is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", default)]
pub struct Writing {
    /// As [`crate::sink::ffmpeg::VideoOptions::codec`].
    pub codec: Option<String>,
    /// As [`crate::sink::ffmpeg::VideoOptions::crf`].
    pub crf: Option<u32>,
    /// As [`crate::sink::ffmpeg::VideoOptions::encoder_preset`].
    pub encoder_preset: Option<String>,
    /// Whether the sound is kept.
    pub audio: bool,
    /// Whether title, date, chapters, timecode, languages and titles of tracks are kept.
    pub metadata: bool,
    /// More options for ffmpeg.
    pub ffmpeg_args: Vec<String>,
    /// A file with the sound, in place of the film.
    pub sound: Option<PathBuf>,
    /// What shows through transparent pixels where a format has none.
    pub background: [u8; 4],
    /// How much larger the output is than the film.
    pub scale: f64,
    /// The extension of pictures that go to a folder.
    pub format: Option<String>,
    /// What keeps the ground from showing between the facets of an SVG, by its name.
    pub svg_seams: Option<String>,
    /// As [`crate::sink::SinkOptions::quality`].
    pub lossy: Option<u8>,
    /// Lines a pixel on which vertices of mesh streams stand.
    pub vertex_grid: u32,
    /// As [`crate::sink::SinkOptions::colour_error`].
    pub colour_error: u8,
}

impl Default for Writing {
    fn default() -> Self {
        Self {
            codec: None,
            crf: None,
            encoder_preset: None,
            audio: true,
            metadata: true,
            ffmpeg_args: Vec::new(),
            sound: None,
            background: [255; 4],
            scale: 1.0,
            format: None,
            svg_seams: None,
            lossy: None,
            vertex_grid: Grid::default().parts(),
            colour_error: 0,
        }
    }
}

/// Frames whose mesh lives on from the first to the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Shot {
    /// The number of its first frame, from 0.
    pub first: u64,
    /// How many frames it has.
    pub frames: u64,
    /// When its first frame is shown, in seconds.
    pub start: Rational,
    /// When its last frame ends, where that is known.
    pub end: Option<Rational>,
    /// Why it begins.
    pub begins: Begins,
    /// The hash of its frames and their times.
    pub hash: String,
}

/// Why a shot begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Begins {
    /// With the film, or where it is cut.
    Cut,
    /// With the first picture of a film that fades in from nothing.
    FadeIn,
    /// Nowhere in particular: without coherence every frame is rendered alone.
    Alone,
    /// Within a shot that was too long.
    Split,
}

/// A part: shots that are rendered together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Chunk {
    /// Its number, from 0.
    pub chunk: usize,
    /// The number of its first frame.
    pub first: u64,
    /// How many frames it has.
    pub frames: u64,
    /// The first of its shots, and how many there are.
    pub shots: (usize, usize),
    /// How many frames before it are rendered too, and not kept.
    pub warm_up: u64,
    /// Whether its frames are those of a render of the whole film; else they are only close to them.
    pub exact: bool,
}

impl Plan {
    /// The shots of `chunk`.
    pub fn shots_of(&self, chunk: &Chunk) -> &[Shot] {
        let (first, count) = chunk.shots;
        self.shots.get(first..first.saturating_add(count)).unwrap_or_default()
    }

    /// What decides the meshes of any part, as a hash: options, and how the film is read.
    pub fn look(&self) -> String {
        let read = Reading { max_memory: None, allow_truncated: false, ..self.read.clone() };
        hash::of_text(&format!("{}{}", json(&self.options), json(&read)))
    }

    /// Reads the plan at `path`.
    ///
    /// # Errors
    /// When it cannot be read, is no plan, is one of another version, or contradicts itself.
    pub fn read(path: &Path) -> Result<Self> {
        let wrong = |what: String| Error::input(path, what);
        let unread = |error| wrong(format!("cannot be read: {error}")).caused_by(error);
        let mut text = String::new();
        let file = File::open(path).map_err(unread)?;
        file.take(MOST_BYTES).read_to_string(&mut text).map_err(unread)?;
        let none = |error| wrong(format!("is no plan of a film: {error}"));
        let value: Value = serde_json::from_str(&text).map_err(none)?;
        let version = value.get("polyreel").and_then(Value::as_str).unwrap_or("unknown");
        if version != VERSION {
            return Err(wrong(format!(
                "was made by polyreel {version}, and this is {VERSION}: plan the film again, \
                 or render it with that version"
            )));
        }
        let plan: Self = serde_json::from_value(value).map_err(none)?;
        plan.options.validate()?;
        if !plan.is_whole() {
            return Err(wrong("its shots and chunks do not make one film: plan it again".into()));
        }
        Ok(plan)
    }

    /// Whether shots and chunks follow each other without a gap.
    fn is_whole(&self) -> bool {
        let shots = self.shots.iter().try_fold(0u64, |first, shot| {
            (shot.first == first && shot.frames > 0).then(|| first.checked_add(shot.frames))?
        });
        if shots != Some(self.frames) {
            return false;
        }
        let (mut frames, mut next) = (0, 0);
        let chunks = self.chunks.iter().enumerate().all(|(number, chunk)| {
            let sum: u64 = self.shots_of(chunk).iter().map(|shot| shot.frames).sum();
            let follows = chunk.chunk == number && chunk.shots.0 == next && chunk.first == frames;
            next = next.saturating_add(chunk.shots.1);
            frames = frames.saturating_add(chunk.frames);
            follows && sum == chunk.frames && sum > 0 && chunk.warm_up <= chunk.first
        });
        chunks && frames == self.frames && frames > 0
    }

    /// The plan as JSON: a line a shot, a line a chunk.
    pub fn to_text(&self) -> String {
        let fields = [
            ("polyreel", json(&self.polyreel)),
            ("film", json(&self.film)),
            ("read", json(&self.read)),
            ("options", json(&self.options)),
            ("write", json(&self.write)),
            ("asked", json(&self.asked)),
            ("frames", json(&self.frames)),
            ("shots", lines(&self.shots)),
            ("chunks", lines(&self.chunks)),
        ];
        let mut text = String::from("{");
        for (i, (name, value)) in fields.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            // Writing to a string cannot fail.
            let _ = write!(text, "{comma}\n\"{name}\": {value}");
        }
        text + "\n}\n"
    }
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("a plan is plain data")
}

fn lines(values: &[impl Serialize]) -> String {
    format!("[\n{}\n]", values.iter().map(json).collect::<Vec<_>>().join(",\n"))
}

/// What a plan records of `info`.
pub fn film_of(info: &StreamInfo, inputs: Vec<String>, content: (String, u64), hdr: bool) -> Film {
    Film { inputs, bytes: content.1, hash: content.0, format: info.format.clone(), hdr }
}
