//! Files that are there when they are complete, or not at all: the one of `--report`, and others.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use polyreel::error::{Error, Result};
use polyreel::pipeline::Report;
use tempfile::NamedTempFile;

/// A report to be: a file beside its place, put there when it is complete. Dropped before, it leaves
/// nothing behind.
#[derive(Debug)]
pub(crate) struct Record {
    path: PathBuf,
    file: NamedTempFile,
}

impl Record {
    /// Makes sure, before any work is done, that a report can be written to `path` and is none of the
    /// files in `taken`.
    pub(crate) fn create(path: &Path, taken: &[PathBuf]) -> Result<Self> {
        if taken.iter().any(|other| same_file(path, other)) {
            return Err(Error::usage(format!(
                "--report {} is an input or the output as well: name another file",
                path.display()
            )));
        }
        if path.is_dir() {
            return Err(Error::output(path, "is a folder: name a file for the report"));
        }
        Ok(Self { path: path.to_owned(), file: beside(path)? })
    }

    /// Writes `report` and puts it in its place.
    pub(crate) fn write(self, report: &Report) -> Result<()> {
        let mut json = serde_json::to_vec(report).expect("plain data becomes JSON");
        json.push(b'\n');
        complete(self.file, &self.path, &json, true)
    }
}

/// Writes `bytes` beside `path` and puts them there when all are written.
pub(crate) fn put(path: &Path, bytes: &[u8], overwrite: bool) -> Result<()> {
    if path.exists() && !overwrite {
        return Err(there(path));
    }
    complete(beside(path)?, path, bytes, overwrite)
}

/// An unfinished file in the folder of `path`.
fn beside(path: &Path) -> Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let file = builder().tempfile_in(folder.unwrap_or(Path::new(".")));
    file.map_err(|error| unwritable(path, &error))
}

/// Fills the unfinished `file` with `bytes` and puts it in its place.
fn complete(mut file: NamedTempFile, path: &Path, bytes: &[u8], overwrite: bool) -> Result<()> {
    let written = file.write_all(bytes).and_then(|()| file.flush());
    written.map_err(|error| unwritable(path, &error))?;
    let placed = if overwrite { file.persist(path) } else { file.persist_noclobber(path) };
    match placed {
        Ok(_) => Ok(()),
        Err(failure) if failure.error.kind() == ErrorKind::AlreadyExists => Err(there(path)),
        Err(failure) => Err(unwritable(path, &failure.error)),
    }
}

fn there(path: &Path) -> Error {
    Error::output(path, "is there already; -y replaces it")
}

fn unwritable(path: &Path, error: &std::io::Error) -> Error {
    Error::output(path, format!("cannot be written: {error}"))
}

/// Readable by whom new files are readable by, where temporary files are the owner's alone.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".polyreel-report-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder
}

fn same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
