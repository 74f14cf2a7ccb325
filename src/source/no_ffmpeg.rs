//! In place of video where polyreel is built without ffmpeg.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

use std::io::Read;

use super::{Input, SourceOptions};

/// Whether `path` is for ffmpeg to open: nothing is.
pub(crate) fn is_address(path: &Path) -> bool {
    path.to_str().is_some_and(|text| text.contains("://"))
}

/// Refuses the video `path`.
///
/// # Errors
/// Always.
pub(crate) fn open(path: PathBuf, _options: &SourceOptions) -> Result<Input> {
    Err(Error::input(
        path,
        "is no picture that is read without ffmpeg, and this polyreel was built without it: build it with \
         --features ffmpeg",
    ))
}

/// Refuses what comes out of the pipe `path`.
///
/// # Errors
/// Always.
pub(crate) fn open_pipe(
    path: &Path,
    _pipe: Box<dyn Read + Send>,
    options: &SourceOptions,
) -> Result<Input> {
    open(path.to_owned(), options)
}
