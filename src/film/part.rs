//! A part on disk: its meshes, and a report that says what they are.
//!
//! The report is written last. A part without it, or that is not what it says, is not there.

use std::fmt;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::hash;
use super::plan::{Chunk, Plan, VERSION};
use crate::error::{Error, Result};
use crate::frame::Buffers;
use crate::sink::place::Place;
use crate::sink::{self, Needs, Origin, Picture, Sink, SinkOptions, Unfinished};
use crate::stream::StreamInfo;

/// What a part is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Report {
    /// The version of the program that rendered it.
    pub polyreel: String,
    /// The hash of the film.
    pub film: String,
    /// The hash of the options, and of how the film was read.
    pub look: String,
    /// The number of its first frame.
    pub first: u64,
    /// How many frames it has.
    pub frames: u64,
    /// Frames that were rendered before.
    pub warm_up: u64,
    /// The hash of its frames as they were decoded, with their times.
    pub decoded: String,
    /// The bytes of its file.
    pub bytes: u64,
    /// The hash of its file.
    pub hash: String,
}

/// Why a part does not count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stale {
    /// It is not there.
    Missing,
    /// It is something else, in words.
    Other(String),
}

impl fmt::Display for Stale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("is missing"),
            Self::Other(what) => f.write_str(what),
        }
    }
}

/// Where the meshes of chunk `number` are in `folder`.
pub fn meshes(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("{number:04}.polyreel"))
}

/// Where its report is.
pub fn report(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("{number:04}.json"))
}

fn decoded(plan: &Plan, chunk: &Chunk) -> String {
    hash::of_text(&plan.shots_of(chunk).iter().map(|shot| shot.hash.as_str()).collect::<String>())
}

/// Checks that `chunk` is in `folder`, whole, and what `plan` asks for.
///
/// # Errors
/// Why it does not count.
pub fn check(plan: &Plan, chunk: &Chunk, folder: &Path) -> Result<(), Stale> {
    let other = |what: String| Err(Stale::Other(what));
    let (meshes, report) = (meshes(folder, chunk.chunk), report(folder, chunk.chunk));
    let Ok(length) = fs::metadata(&meshes).map(|file| file.len()) else {
        return Err(Stale::Missing);
    };
    let Ok(text) = fs::read_to_string(&report) else {
        return other("has no report: its render did not end".into());
    };
    let Ok(known) = serde_json::from_str::<Report>(&text) else {
        return other(format!("its report {} cannot be understood", report.display()));
    };
    if known.polyreel != VERSION {
        return other(format!(
            "was rendered by polyreel {}, and this is {VERSION}",
            known.polyreel
        ));
    }
    if known.film != plan.film.hash {
        return other("was rendered from another film".into());
    }
    if known.look != plan.look() {
        return other("was rendered with other options".into());
    }
    let bounds = (known.first, known.frames, known.warm_up);
    if bounds != (chunk.first, chunk.frames, chunk.warm_up) || known.decoded != decoded(plan, chunk)
    {
        return other(format!(
            "holds other frames: {} from number {} on, not {} from {}",
            known.frames, known.first, chunk.frames, chunk.first
        ));
    }
    if length != known.bytes {
        return other(format!(
            "has {length} bytes, and its report says {}: it is cut short or not its own",
            known.bytes
        ));
    }
    match hash::of_file(&meshes) {
        Ok(found) if found == known.hash => Ok(()),
        Ok(_) => other("is damaged: its bytes are not those that were written".into()),
        Err(error) => other(format!("cannot be read: {error}")),
    }
}

/// The sink of `chunk` in `folder`. What stands there is replaced.
///
/// # Errors
/// When it cannot be made.
pub fn create(
    plan: &Plan,
    chunk: &Chunk,
    folder: &Path,
    info: &StreamInfo,
    unfinished: &Unfinished,
) -> Result<Box<dyn Sink>> {
    let info = StreamInfo { frames: Some(chunk.frames), duration: None, ..info.clone() };
    let options = options(plan, unfinished);
    let inner = sink::create(meshes(folder, chunk.chunk), &info, &options)?;
    Ok(Box::new(PartSink { inner, expected: chunk.frames, written: 0 }))
}

fn options(plan: &Plan, unfinished: &Unfinished) -> SinkOptions {
    SinkOptions {
        overwrite: true,
        durable: true,
        look: plan.options.clone(),
        unfinished: unfinished.clone(),
        ..SinkOptions::default()
    }
}

/// Removes the report of `chunk`, so that its part does not count as complete while it is replaced.
pub fn forget(chunk: &Chunk, folder: &Path) {
    // There may be none.
    let _ = fs::remove_file(report(folder, chunk.chunk));
}

/// Writes the report of `chunk`, whose meshes are complete in `folder`.
///
/// # Errors
/// When it cannot be written.
pub fn complete(plan: &Plan, chunk: &Chunk, folder: &Path, unfinished: &Unfinished) -> Result<()> {
    let meshes = meshes(folder, chunk.chunk);
    let unread = |error: std::io::Error| {
        Error::output(&meshes, format!("cannot be read again: {error}")).caused_by(error)
    };
    let known = Report {
        polyreel: VERSION.to_owned(),
        film: plan.film.hash.clone(),
        look: plan.look(),
        first: chunk.first,
        frames: chunk.frames,
        warm_up: chunk.warm_up,
        decoded: decoded(plan, chunk),
        bytes: fs::metadata(&meshes).map_err(unread)?.len(),
        hash: hash::of_file(&meshes).map_err(unread)?,
    };
    let text = serde_json::to_string_pretty(&known).expect("a report is plain data");
    let place = Place::reserve(&report(folder, chunk.chunk), &options(plan, unfinished))?;
    place.file().write_all(format!("{text}\n").as_bytes()).map_err(|error| place.failed(&error))?;
    place.commit()
}

/// Meshes that are put in their place only if none is missing.
struct PartSink {
    inner: Box<dyn Sink>,
    expected: u64,
    written: u64,
}

impl Sink for PartSink {
    fn needs(&self) -> Needs {
        self.inner.needs()
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        self.written += 1;
        self.inner.write(picture, origin)
    }

    fn finish(self: Box<Self>) -> Result<()> {
        if self.written != self.expected {
            let (written, expected) = (self.written, self.expected);
            return Err(Error::failed(format!("{written} of {expected} frames were rendered")));
        }
        self.inner.finish()
    }
}
