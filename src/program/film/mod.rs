//! Films in parts: `polyreel plan`, `polyreel render --plan`, `polyreel join`, and `polyreel render --resume`.

mod all;
mod bar;
mod chunk;
mod join;
mod plan;
mod resume;

use std::path::{Path, PathBuf};

use polyreel::error::{Error, Result};
use polyreel::ffmpeg::Ffmpeg;
use polyreel::film::plan::{Kind, Plan, Reading};
use polyreel::sink::Unfinished;
use polyreel::source::{self, Input, SourceOptions};

use crate::program::interrupt::Interrupt;

pub(crate) use chunk::render_parts;
pub(crate) use join::join;
pub(crate) use plan::plan;
pub(crate) use resume::resume;

/// A plan, and where it and what it needs are on this machine.
struct Work {
    plan: Plan,
    /// The plan's own name, for messages.
    path: PathBuf,
    /// Where the parts are.
    folder: PathBuf,
    /// Where the film is, if it is not where it was planned.
    film: Option<PathBuf>,
    ffmpeg: Ffmpeg,
    unfinished: Unfinished,
    quiet: bool,
}

impl Work {
    /// The plan at `path`, with its parts in `folder`, or else beside it. What is begun is entered in the lists of
    /// `interrupt`.
    fn open(
        path: &Path,
        folder: Option<PathBuf>,
        ffmpeg: Ffmpeg,
        interrupt: &Interrupt,
    ) -> Result<Self> {
        Ok(Self {
            plan: Plan::read(path)?,
            path: path.to_owned(),
            folder: folder.unwrap_or_else(|| path.with_file_name("parts")),
            film: None,
            ffmpeg,
            unfinished: interrupt.unfinished(),
            quiet: false,
        })
    }

    /// The names of the film on this machine.
    fn inputs(&self) -> Vec<PathBuf> {
        if let Some(film) = &self.film {
            return vec![film.clone()];
        }
        let planned: Vec<PathBuf> = self.plan.film.inputs.iter().map(PathBuf::from).collect();
        if let [one] = &planned[..]
            && !one.exists()
            && let Some(name) = one.file_name()
        {
            // Plan and film may have been moved together.
            let beside = self.path.with_file_name(name);
            if beside.exists() {
                return vec![beside];
            }
        }
        planned
    }

    /// The film, opened as it was planned.
    fn open_film(&self) -> Result<Input> {
        self.open_with(self.plan.read.frames)
    }

    /// The film, opened to read a chunk of it.
    fn open_for_chunk(&self) -> Result<Input> {
        // Where frames are to be counted nothing can be passed over. Of a sequence they say which files it is made of.
        let is_sequence = self.plan.film.format.ends_with(" sequence");
        self.open_with(self.plan.read.frames.filter(|_| is_sequence))
    }

    fn open_with(&self, frames: Option<u64>) -> Result<Input> {
        let options = source_options(&self.plan.read, self.ffmpeg.clone());
        let options = SourceOptions { frames, ..options };
        let inputs = self.inputs();
        let input = source::open(&inputs, &options).map_err(|error| match inputs.first() {
            Some(one) if source::files(&inputs).is_err() => Error::input(
                one,
                "the film that was planned is not there; tell where it is with --film FILE",
            ),
            _ => error,
        })?;
        let mut bytes = 0;
        for path in input.paths() {
            bytes += std::fs::metadata(path).map_or(0, |file| file.len());
        }
        if bytes != self.plan.film.bytes {
            return Err(self.other_film(input.paths()));
        }
        Ok(input)
    }

    fn other_film(&self, paths: &[PathBuf]) -> Error {
        let path = paths.first().cloned().unwrap_or_default();
        let plan = self.path.display();
        Error::input(
            path,
            format!("is not the film of {plan}: it has changed since; plan it again"),
        )
    }
}

/// How a film is opened that is read so.
fn source_options(read: &Reading, ffmpeg: Ffmpeg) -> SourceOptions {
    SourceOptions {
        start: read.start,
        end: read.end,
        frames: read.frames,
        fps: read.fps,
        max_size: read.max_size,
        max_memory: read.max_memory,
        allow_truncated: read.allow_truncated,
        looped: false,
        ffmpeg,
        to_sdr: !read.keep_hdr,
        to_bt709: read.kind != Kind::Video,
        browser_delays: read.kind != Kind::Gif,
    }
}
