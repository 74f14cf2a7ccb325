//! Outputs that are written to a temporary file in the same folder and renamed when they are complete.
//!
//! An output that is dropped before its `commit` leaves nothing behind.

mod check;
mod series;
#[cfg(test)]
mod tests;
#[cfg(target_os = "linux")]
mod unnamed;

#[cfg(unix)]
use std::fs;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::SinkOptions;
use super::unfinished::{Entry, Unfinished};
use crate::error::{Error, Result, copied};
use check::{exists, folder_of, keep_permissions, misplaced, target_of, unwritable};

pub use series::{Made, Series};

/// Checks that `output`, which other programs write to without a temporary file, may be written.
///
/// # Errors
/// As [`Place::reserve`].
#[cfg(feature = "ffmpeg")]
pub(crate) fn check_target(output: &Path, options: &SinkOptions) -> Result<()> {
    target_of(output, options).map(|_| ())
}

/// What temporary names begin with; the dot hides them.
const PREFIX: &str = ".polyreel-";

/// An output file that is being written.
#[derive(Debug)]
pub struct Place {
    named: PathBuf,
    target: PathBuf,
    overwrite: bool,
    durable: bool,
    unfinished: Unfinished,
    temporaries: Option<PathBuf>,
    file: Temporary,
}

/// The temporary file of an output.
#[derive(Debug)]
enum Temporary {
    /// A file without a name, and its path in `/proc`. The system removes it, however this process ends.
    #[cfg(target_os = "linux")]
    Unnamed(File, PathBuf),
    Named(NamedTempFile, Entry),
}

impl Place {
    /// An empty temporary file for `output`, in the same folder, where possible without a name.
    ///
    /// # Errors
    /// When `output` exists (and may not be overwritten), is an input or a folder, or when its folder is missing
    /// or read-only.
    pub fn reserve(output: &Path, options: &SinkOptions) -> Result<Self> {
        let target = target_of(output, options)?;
        #[cfg(target_os = "linux")]
        if let Some(file) = unnamed::create(folder_of(&target), &target) {
            let path = unnamed::path(&file);
            return Ok(Self {
                named: output.to_owned(),
                target,
                overwrite: options.overwrite,
                durable: options.durable,
                unfinished: options.unfinished.clone(),
                temporaries: options.temporaries.clone(),
                file: Temporary::Unnamed(file, path),
            });
        }
        Self::with_name(output.to_owned(), target, options)
    }

    /// As [`Place::reserve`], but the temporary file has a [name](Place::path), for other programs to write to. It
    /// ends in the extension of `output`.
    ///
    /// # Errors
    /// As [`Place::reserve`].
    pub fn reserve_named(output: &Path, options: &SinkOptions) -> Result<Self> {
        let target = target_of(output, options)?;
        Self::with_name(output.to_owned(), target, options)
    }

    /// Another temporary file with a name for the same output. Only one of the two can be committed.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn another(&self) -> Result<Self> {
        let options = SinkOptions {
            overwrite: self.overwrite,
            durable: self.durable,
            unfinished: self.unfinished.clone(),
            temporaries: self.temporaries.clone(),
            ..SinkOptions::default()
        };
        Self::with_name(self.named.clone(), self.target.clone(), &options)
    }

    fn with_name(named: PathBuf, target: PathBuf, options: &SinkOptions) -> Result<Self> {
        let folder = options.temporaries.as_deref().unwrap_or_else(|| folder_of(&target));
        let suffix =
            named.extension().map_or_else(String::new, |e| format!(".{}", e.to_string_lossy()));
        let mut builder = Builder::new();
        builder.prefix(PREFIX).suffix(&suffix);
        // The permissions of the file that is replaced, or of any new file, less the user's mask.
        #[cfg(unix)]
        builder.permissions(fs::metadata(&target).map_or_else(
            |_| std::os::unix::fs::PermissionsExt::from_mode(0o666),
            |there| there.permissions(),
        ));
        let file = builder.tempfile_in(folder).map_err(|e| unwritable(&named, folder, e))?;
        let SinkOptions { overwrite, durable, .. } = *options;
        let (unfinished, temporaries) = (options.unfinished.clone(), options.temporaries.clone());
        let entry = unfinished.add_temporary(file.path());
        let file = Temporary::Named(file, entry);
        Ok(Self { named, target, overwrite, durable, unfinished, temporaries, file })
    }

    /// The file to write to.
    pub fn file(&self) -> &File {
        match &self.file {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(file, _) => file,
            Temporary::Named(file, _) => file.as_file(),
        }
    }

    /// The path of the temporary file, for other programs to write to. It has the output's extension, and stays
    /// valid when this process ends, only after [`Place::reserve_named`].
    pub fn path(&self) -> &Path {
        match &self.file {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(_, path) => path,
            Temporary::Named(file, _) => file.path(),
        }
    }

    /// The output's name as it was given, for messages.
    pub fn named(&self) -> &Path {
        &self.named
    }

    /// The `error` of writing to it, with the output's name.
    pub fn failed(&self, error: &std::io::Error) -> Error {
        Error::output(&self.named, format!("cannot be written: {error}")).caused_by(copied(error))
    }

    /// Renames the temporary file to the output's name. The permissions of a file that it replaces stay.
    ///
    /// # Errors
    /// When that fails, or when a file of that name was made meanwhile and may not be overwritten.
    pub fn commit(self) -> Result<()> {
        if self.durable {
            self.file().sync_all().map_err(|error| self.failed(&error))?;
        }
        let Self { named, target, overwrite, durable, file, .. } = self;
        let done = match file {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(_file, path) => unnamed::put(&path, &target, overwrite),
            Temporary::Named(file, _entry) => put(file, &target, overwrite),
        };
        match done {
            Ok(()) => {
                if durable {
                    sync_folder(folder_of(&target));
                }
                Ok(())
            }
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(exists(&named)),
            Err(e) => Err(misplaced(&named, e)),
        }
    }
}

/// Makes the names in `folder` safe on its disk, where the system can do that with a folder.
fn sync_folder(folder: &Path) {
    // The file is whole whether its name lasts or not.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Gives `file` the name `target`.
fn put<F>(file: NamedTempFile<F>, target: &Path, overwrite: bool) -> io::Result<()> {
    if overwrite {
        keep_permissions(target, file.path());
        file.persist(target)?;
    } else {
        file.persist_noclobber(target)?;
    }
    Ok(())
}
