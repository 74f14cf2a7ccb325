//! Numbered files that are written in a hidden folder and put in their places when all are complete.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::{Builder, TempDir};

use super::PREFIX;
use super::check::{
    check_folder, check_free, exists, folder_of, keep_permissions, misplaced, unwritable,
};
use crate::error::{Error, Result};
use crate::pattern::Pattern;
use crate::sink::SinkOptions;
use crate::sink::unfinished::{Entry, Unfinished};

/// Numbered output files, from 1. Until all are complete they are in a hidden folder inside the output folder,
/// which may hold other files.
#[derive(Debug)]
pub struct Series {
    pattern: Pattern,
    folder: PathBuf,
    overwrite: bool,
    written: u64,
    // Dropped in this order: the hidden folder goes before the one that it is in.
    waiting: TempDir,
    made: Option<Made>,
    _entry: Entry,
}

/// A folder that was made for an output. It is removed again when this is dropped, if it is empty then.
#[derive(Debug)]
pub struct Made {
    path: PathBuf,
    _entry: Entry,
}

impl Drop for Made {
    fn drop(&mut self) {
        // It stays if another program has put a file there.
        let _ = fs::remove_dir(&self.path);
    }
}

impl Made {
    /// Makes `folder`; `None` if another process has made it meanwhile.
    ///
    /// # Errors
    /// When its parent is missing or read-only.
    pub fn new(folder: &Path, unfinished: &Unfinished) -> Result<Option<Self>> {
        check_folder(folder, folder_of(folder))?;
        match fs::create_dir(folder) {
            Ok(()) => {
                Ok(Some(Self { path: folder.to_owned(), _entry: unfinished.add_folder(folder) }))
            }
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Ok(None),
            Err(e) => Err(unwritable(folder, folder_of(folder), e)),
        }
    }
}

/// Checks that no file of `pattern` in `folder` is one that must not be replaced.
///
/// # Errors
/// When one is, or the folder cannot be read.
fn check_all_free(pattern: &Pattern, folder: &Path, options: &SinkOptions) -> Result<()> {
    let first = pattern.name(1);
    let entries = fs::read_dir(folder).map_err(|e| unwritable(&first, folder, e))?;
    for entry in entries.flatten() {
        let path = if first.parent().is_some_and(|p| p.as_os_str().is_empty()) {
            PathBuf::from(entry.file_name())
        } else {
            folder.join(entry.file_name())
        };
        if pattern.number(&path).is_some_and(|n| n > 0) {
            check_free(&path, options)?;
        }
    }
    Ok(())
}

impl Series {
    /// Prepares the files of `pattern`. Their folder is made if `make` is true.
    ///
    /// # Errors
    /// When a file of that pattern exists (and may not be overwritten) or is an input, or when the folder is
    /// missing or read-only.
    pub fn reserve(pattern: Pattern, make: bool, options: &SinkOptions) -> Result<Self> {
        let first = pattern.name(1);
        let folder = folder_of(&first).to_owned();
        if folder_of(&pattern.name(2)) != folder {
            return Err(Error::usage(format!(
                "{}: the number must stand in the file's name, not in a folder's",
                first.display()
            )));
        }
        let made =
            if make && !folder.exists() { Made::new(&folder, &options.unfinished)? } else { None };
        check_folder(&first, &folder)?;
        check_all_free(&pattern, &folder, options)?;
        let waiting = Builder::new()
            .prefix(PREFIX)
            .tempdir_in(&folder)
            .map_err(|e| unwritable(&first, &folder, e))?;
        let overwrite = options.overwrite;
        let _entry = options.unfinished.add_temporary(waiting.path());
        Ok(Self { pattern, folder, overwrite, written: 0, waiting, made, _entry })
    }

    /// Whether no file was made yet.
    pub fn is_empty(&self) -> bool {
        self.written == 0
    }

    /// The name of the first file.
    pub fn first(&self) -> PathBuf {
        self.pattern.name(1)
    }

    /// A new file for the next number, and its final name for messages.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn file(&mut self) -> Result<(File, PathBuf)> {
        self.written += 1;
        let named = self.pattern.name(self.written);
        match File::create(self.waiting_path(&named)) {
            Ok(file) => Ok((file, named)),
            Err(e) => Err(Error::output(named, format!("cannot be written: {e}")).caused_by(e)),
        }
    }

    /// Moves all files to their final names.
    ///
    /// # Errors
    /// When one cannot be moved, or when a file of its name was made meanwhile and may not be overwritten. Files
    /// that were moved before it are removed again, unless they replaced others.
    pub fn commit(mut self) -> Result<()> {
        for number in 1..=self.written {
            if let Err(error) = self.place(number) {
                if !self.overwrite {
                    (1..number).for_each(|number| {
                        // The error that is returned already says what is wrong with the folder.
                        let _ = fs::remove_file(self.pattern.name(number));
                    });
                }
                return Err(error);
            }
        }
        if let Some(made) = self.made.take() {
            std::mem::forget(made);
        }
        Ok(())
    }

    /// Moves file `number` to its final name.
    fn place(&self, number: u64) -> Result<()> {
        let named = self.pattern.name(number);
        let target = self.folder.join(named.file_name().unwrap_or_default());
        let waiting = self.waiting_path(&named);
        if self.overwrite {
            keep_permissions(&target, &waiting);
        } else {
            // An empty file reserves the name, so that only one of two runs gets it.
            match File::create_new(&target) {
                Ok(_) => {}
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => return Err(exists(&named)),
                Err(e) => return Err(misplaced(&named, e)),
            }
        }
        fs::rename(waiting, &target).map_err(|e| {
            if !self.overwrite {
                // The empty one.
                let _ = fs::remove_file(&target);
            }
            misplaced(&named, e)
        })
    }

    fn waiting_path(&self, named: &Path) -> PathBuf {
        self.waiting.path().join(named.file_name().unwrap_or_default())
    }
}
