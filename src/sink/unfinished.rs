//! Outputs that have been begun and not finished, so that a program that must end at once, without
//! unwinding, can still remove them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What is unfinished, and how it is removed. A folder sorts before what it holds.
static BEGUN: Mutex<BTreeMap<PathBuf, Kind>> = Mutex::new(BTreeMap::new());

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// A temporary file, or a temporary folder with all that is in it.
    Temporary,
    /// A folder that was made for the output: removed if it is empty.
    Folder,
}

/// How often a folder is emptied again into which somebody still writes.
const ATTEMPTS: usize = 5;

/// A file or folder that stands beside its place. It is removed by whoever owns it; this only notes
/// that it exists.
#[derive(Debug)]
pub(super) struct Unfinished(PathBuf);

impl Unfinished {
    /// Notes that the temporary file or folder `path` exists, until the note is dropped.
    pub(super) fn temporary(path: &Path) -> Self {
        Self::note(path, Kind::Temporary)
    }

    /// Notes that the folder `path` was made for an output, until the note is dropped.
    pub(super) fn folder(path: &Path) -> Self {
        Self::note(path, Kind::Folder)
    }

    fn note(path: &Path, kind: Kind) -> Self {
        // Whoever looks at the list later may stand elsewhere.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        begun().insert(path.clone(), kind);
        Self(path)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        begun().remove(&self.0);
    }
}

/// Removes all unfinished outputs of this process. Only for a process that ends right after, and has ended the
/// programs that write for it ([`Processes::end_all`](crate::ffmpeg::Processes::end_all)): no output can be begun any more.
pub fn remove_unfinished() {
    let begun = begun();
    for (path, kind) in begun.iter().rev() {
        for _ in 0..ATTEMPTS {
            let removed = match kind {
                Kind::Temporary if path.is_dir() => fs::remove_dir_all(path),
                Kind::Temporary => fs::remove_file(path),
                Kind::Folder => fs::remove_dir(path),
            };
            if removed.is_ok() || !path.exists() {
                break;
            }
        }
    }
    // Kept locked: nothing can be begun from here on.
    std::mem::forget(begun);
}

fn begun() -> MutexGuard<'static, BTreeMap<PathBuf, Kind>> {
    // A list of names is sound whoever panicked with it in his hands.
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}
