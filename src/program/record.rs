//! Files that appear when they are complete: the one of `--report`, and others.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use polyreel::error::{Error, Result};
use polyreel::pipeline::Report;
use polyreel::sink::place::Place;
use polyreel::sink::{SinkOptions, Unfinished};

/// A report that will be written. Dropped before, it leaves no file behind.
#[derive(Debug)]
pub(crate) struct Record(Place);

impl Record {
    /// Checks, before any work is done, that a report can be written to `path` and is not one of the files in
    /// `taken`.
    pub(crate) fn create(path: &Path, taken: &[PathBuf], unfinished: Unfinished) -> Result<Self> {
        if taken.iter().any(|other| same_file(path, other)) {
            return Err(Error::usage(format!(
                "--report {} is an input or the output as well: name another file",
                path.display()
            )));
        }
        let options = SinkOptions { overwrite: true, unfinished, ..SinkOptions::default() };
        Place::reserve(path, &options).map(Self)
    }

    /// Writes `report` and gives it its final name.
    pub(crate) fn write(self, report: &Report) -> Result<()> {
        let mut out = BufWriter::new(self.0.file());
        let written = serde_json::to_writer(&mut out, report).map_err(std::io::Error::from);
        let written = written.and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
        // Buffered data is dropped after an error.
        drop(out.into_parts());
        written.map_err(|error| self.0.failed(&error))?;
        self.0.commit()
    }
}

/// Writes `bytes` to the file `path`, which appears when it is complete.
pub(crate) fn put(path: &Path, bytes: &[u8], overwrite: bool) -> Result<()> {
    write_all(Place::reserve(path, &SinkOptions { overwrite, ..SinkOptions::default() })?, bytes)
}

/// As [`put`]; the file replaces another, and is safe on its disk before it has its name.
pub(crate) fn put_durably(path: &Path, bytes: &[u8]) -> Result<()> {
    let options = SinkOptions { overwrite: true, durable: true, ..SinkOptions::default() };
    write_all(Place::reserve(path, &options)?, bytes)
}

fn write_all(place: Place, bytes: &[u8]) -> Result<()> {
    place.file().write_all(bytes).map_err(|error| place.failed(&error))?;
    place.commit()
}

/// Whether two names are of one file.
pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
