//! Mesh streams as an input: as meshes for who paints them anew, as pictures for everybody else.

use std::io::{self, BufRead, BufReader, IsTerminal, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use super::{Decoded, Input, Source, detect};
use crate::error::{Error, Result};
use crate::frame::{Colorimetry, Frame, Rational};
use crate::mesh_stream::{MAGIC, MeshFrame, MeshReader, ReadError};
use crate::options::Options;
use crate::rasterise::Painter;
use crate::stream::{Loops, Span, StreamInfo};

/// Meshes, one after another.
pub trait Meshes {
    /// The next frame's mesh; `None` at the end of a complete stream.
    ///
    /// # Errors
    /// When the stream is cut short or damaged; frames before have been delivered.
    fn next_mesh(&mut self) -> Result<Option<MeshFrame>>;
}

/// A mesh stream being read.
pub struct MeshSource {
    reader: MeshReader<Box<dyn Read + Send>>,
    path: PathBuf,
    info: StreamInfo,
    painter: Painter,
    count: u64,
}

impl MeshSource {
    /// Opens the stream in the file `path`.
    ///
    /// # Errors
    /// When it cannot be opened, or is no mesh stream.
    pub fn open(path: &Path) -> Result<Self> {
        let file = BufReader::with_capacity(1 << 16, detect::open(path)?);
        Self::new(Box::new(file), path)
    }

    /// Begins to read `input`, which is called `path` in messages.
    fn new(input: Box<dyn Read + Send>, path: &Path) -> Result<Self> {
        let reader = MeshReader::new(input).map_err(|error| failed(path, None, error))?;
        let info = info(&reader);
        let painter = Painter::new(&reader.header().look());
        Ok(Self { reader, path: path.to_owned(), info, painter, count: 0 })
    }

    /// How it was painted when it was written.
    pub fn look(&self) -> Options {
        self.reader.header().look()
    }

    /// The file or pipe that is read, `None` for standard input.
    pub fn path(&self) -> Option<&Path> {
        Some(&*self.path).filter(|path| *path != Path::new("-"))
    }

    /// The contents of its header.
    pub fn info(&self) -> &StreamInfo {
        &self.info
    }
}

impl Meshes for MeshSource {
    fn next_mesh(&mut self) -> Result<Option<MeshFrame>> {
        let frame = self.reader.next_frame();
        let frame = frame.map_err(|error| failed(&self.path, Some(self.count), error))?;
        self.count += u64::from(frame.is_some());
        Ok(frame)
    }
}

impl Source for MeshSource {
    fn next(&mut self) -> Result<Option<Decoded>> {
        let Some(MeshFrame { mesh, colours, time, .. }) = self.next_mesh()? else {
            return Ok(None);
        };
        let painting = self.painter.paint_known(&mesh, &colours);
        let span = Span { start: time.start, length: time.length };
        Ok(Some(Decoded::new(painting.frame, span)))
    }

    fn recycle(&mut self, frame: Frame) {
        self.painter.recycle(frame.into_buffers());
    }
}

fn failed(path: &Path, frame: Option<u64>, error: ReadError) -> Error {
    let what = error.to_string();
    let input = match frame {
        Some(frame) => Error::input_frame(path, frame, what),
        None => Error::input(path, what),
    };
    match error {
        ReadError::Truncated => input.truncated(),
        ReadError::Io(_) | ReadError::Magic | ReadError::Version(_) => input.caused_by(error),
        _ => input.caused_by(io::Error::new(io::ErrorKind::InvalidData, error)),
    }
}

fn info<R: Read>(reader: &MeshReader<R>) -> StreamInfo {
    let header = reader.header();
    let fraction = |name: &str| fraction(header.get(name)?);
    let flag = |name: &str| header.get(name) == Some("1");
    let plays = header.get("plays").and_then(|text| text.parse().ok());
    let tag = |name: &str| header.get(name).map(str::to_owned);
    StreamInfo {
        format: "polyreel".into(),
        size: reader.size(),
        frames: header.get("frames").and_then(|text| text.parse().ok()),
        rate: fraction("rate").filter(|rate| *rate > Rational::ZERO),
        duration: fraction("duration"),
        alpha: flag("alpha"),
        still: flag("still"),
        loops: match plays {
            Some(0) => Loops::Forever,
            None | Some(1) => Loops::Once,
            Some(n) => Loops::Times(n),
        },
        audio: None,
        live: false,
        colour: flag("tagged").then(|| Colorimetry {
            matrix: tag("matrix"),
            range: tag("range"),
            primaries: tag("primaries"),
            transfer: tag("transfer"),
        }),
    }
}

/// A number or a fraction of two.
fn fraction(text: &str) -> Option<Rational> {
    let (num, den) = text.split_once('/').unwrap_or((text, "1"));
    let (num, den) = (num.parse().ok()?, den.parse().ok()?);
    (den > 0 && num >= 0).then(|| Rational::new(num, den))
}

/// A stream that was opened, until somebody reads it: as pictures, or as meshes.
pub(super) type Opened = Arc<Mutex<Option<MeshSource>>>;

/// Takes what was opened; `None` the second time.
pub(super) fn take(opened: &Opened) -> Option<MeshSource> {
    // Nothing panics while it is locked.
    opened.lock().ok()?.take()
}

/// Opens the mesh stream at `path` as an input.
///
/// # Errors
/// As [`MeshSource::open`].
pub(crate) fn open(path: PathBuf) -> Result<Input> {
    let source = MeshSource::open(&path)?;
    let (info, paths) = (source.info.clone(), Arc::from([path.clone()]));
    let opened: Opened = Arc::new(Mutex::new(Some(source)));
    let first = opened.clone();
    let start = move || {
        Ok(Box::new(match take(&first) {
            Some(source) => source,
            None => MeshSource::open(&path)?,
        }) as Box<dyn Source>)
    };
    Ok(Input::new(paths, info, start).of_meshes(opened))
}

/// Opens the mesh stream on standard input; its header is read now.
///
/// # Errors
/// When it is no mesh stream.
pub(crate) fn open_standard() -> Result<Input> {
    let source = MeshSource::new(Box::new(io::stdin()), Path::new("-"))?;
    Ok(piped(source, Arc::from([])))
}

/// Opens the named pipe `path`: a mesh stream, or y4m. Its header is read now.
///
/// # Errors
/// When it is neither.
pub(crate) fn open_pipe(pipe: Box<dyn Read + Send>, path: PathBuf) -> Result<Input> {
    let input = Box::new(BufReader::with_capacity(1 << 16, pipe));
    Ok(piped(MeshSource::new(input, &path)?, Arc::from([path])))
}

fn piped(source: MeshSource, paths: Arc<[PathBuf]>) -> Input {
    let info = source.info.clone();
    let opened: Opened = Arc::new(Mutex::new(Some(source)));
    let first = opened.clone();
    let start = move || match take(&first) {
        Some(source) => Ok(Box::new(source) as Box<dyn Source>),
        None => Err(Error::usage("a pipe can be read only once")),
    };
    Input::new(paths, info, start).once().of_meshes(opened)
}

/// Whether a mesh stream waits on standard input. Nothing is taken from it.
pub(crate) fn waits_on_standard_input() -> bool {
    let input = io::stdin();
    if input.is_terminal() {
        return false;
    }
    input.lock().fill_buf().is_ok_and(|bytes| bytes.starts_with(MAGIC))
}
