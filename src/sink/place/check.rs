//! Whether an output may be written where it is asked for, and the errors if not.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::sink::SinkOptions;

/// The folder that holds `path`.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// The file to write for `output`: what it links to, if it is a link.
///
/// # Errors
/// When it must not be replaced, or its folder is missing.
pub(super) fn target_of(output: &Path, options: &SinkOptions) -> Result<PathBuf> {
    check_free(output, options)?;
    let target = follow_links(output)?;
    check_folder(output, folder_of(&target))?;
    Ok(target)
}

/// The error of an output that may not be overwritten.
pub(super) fn exists(output: &Path) -> Error {
    Error::output(output, "exists already; give another name, or replace it with -y")
}

/// Checks that `output` does not exist or may be replaced.
pub(super) fn check_free(output: &Path, options: &SinkOptions) -> Result<()> {
    let Ok(there) = fs::metadata(output) else { return Ok(()) };
    if options.inputs.iter().any(|input| same_file(input, output)) {
        return Err(Error::output(output, "is the input, too; give another name"));
    }
    if there.is_dir() {
        return Err(Error::output(output, "is a folder; give the name of a file"));
    }
    if !there.is_file() {
        return Err(Error::output(output, "is no regular file and cannot be replaced by one"));
    }
    if !options.overwrite {
        return Err(exists(output));
    }
    Ok(())
}

/// Whether two names are the same file, through hard or symbolic links.
fn same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt;
        return (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// Checks that `folder`, where `output` is to be, is a folder.
pub(super) fn check_folder(output: &Path, folder: &Path) -> Result<()> {
    match fs::metadata(folder) {
        Ok(there) if there.is_dir() => Ok(()),
        Ok(_) => Err(Error::output(output, format!("{} is not a folder", folder.display()))),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let what = format!("there is no folder {}; make it first", folder.display());
            Err(Error::output(output, what).caused_by(e))
        }
        Err(e) => Err(unwritable(output, folder, e)),
    }
}

/// The file that `output` links to, which need not exist yet.
///
/// # Errors
/// When links form a circle.
fn follow_links(output: &Path) -> Result<PathBuf> {
    if let Ok(path) = fs::canonicalize(output) {
        return Ok(path);
    }
    let mut path = output.to_owned();
    // The limit of Linux.
    for _ in 0..40 {
        let Ok(next) = fs::read_link(&path) else { return Ok(path) };
        // A relative link starts from its own folder.
        path = folder_of(&path).join(next);
    }
    Err(Error::output(output, "is a link that leads round in a circle"))
}

/// Gives the file `new` the permissions of the file `old`, which it will replace.
pub(super) fn keep_permissions(old: &Path, new: &Path) {
    if let Ok(there) = fs::metadata(old) {
        // Some file systems have no permissions: a failure does not matter.
        let _ = fs::set_permissions(new, there.permissions());
    }
}

/// The `error` of moving an output to its final name.
pub(super) fn misplaced(named: &Path, error: io::Error) -> Error {
    Error::output(named, format!("cannot be put in its place: {error}")).caused_by(error)
}

/// The `error` of making a file for `output` in `folder`.
pub(super) fn unwritable(output: &Path, folder: &Path, error: io::Error) -> Error {
    // The error of the crate tempfile names the temporary file, which means nothing to the user: take its cause.
    let why = error.get_ref().and_then(|e| e.source()).map_or(error.to_string(), |e| e.to_string());
    let folder = folder.display();
    Error::output(output, format!("the folder {folder} cannot be written to: {why}"))
        .caused_by(error)
}
