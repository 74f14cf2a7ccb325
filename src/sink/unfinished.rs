//! The list of outputs that are being written, so that a program that must end at once, without unwinding, can
//! remove them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// How often the removal of a folder is tried while another process still writes into it.
const ATTEMPTS: usize = 5;

/// The temporary files and folders of sinks that have not finished. Clones share one list. A program keeps one for
/// its Ctrl-C handler and gives it to its sinks ([`SinkOptions::unfinished`](super::SinkOptions::unfinished)). A
/// sink that is dropped removes its own files, so that other users need no list.
#[derive(Clone, Debug, Default)]
pub struct Unfinished(Arc<Mutex<Paths>>);

/// Absolute paths, and how each is removed. A folder sorts before what it holds.
type Paths = BTreeMap<PathBuf, Kind>;

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// A temporary file, or a temporary folder with all that is in it.
    Temporary,
    /// A folder that was made for the output: removed if it is empty.
    Folder,
}

/// An entry of the list: it is taken off when this is dropped. The owner of the file removes the file.
#[derive(Debug)]
pub(super) struct Entry {
    list: Unfinished,
    path: PathBuf,
}

impl Unfinished {
    /// Enters the temporary file or folder `path`.
    pub(super) fn add_temporary(&self, path: &Path) -> Entry {
        self.add(path, Kind::Temporary)
    }

    /// Enters the folder `path`, which was made for an output.
    pub(super) fn add_folder(&self, path: &Path) -> Entry {
        self.add(path, Kind::Folder)
    }

    fn add(&self, path: &Path, kind: Kind) -> Entry {
        // The working directory may be another one when the list is read.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.paths().insert(path.clone(), kind);
        Entry { list: self.clone(), path }
    }

    /// Removes all files and folders in the list. Only for a process that exits right after, and has ended the
    /// programs that write for it ([`Processes::end_all`](crate::ffmpeg::Processes::end_all)): the list stays
    /// locked, so that sinks on other threads wait rather than report that their files are gone.
    pub fn remove_all(&self) {
        let paths = self.paths();
        for (path, kind) in paths.iter().rev() {
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
        std::mem::forget(paths);
    }

    fn paths(&self) -> MutexGuard<'_, Paths> {
        // A panic elsewhere leaves the list in order.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        self.list.paths().remove(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_in_the_list_is_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let [done, begun, made, other] =
            ["done", "made/begun", "made", "other"].map(|name| folder.path().join(name));
        fs::create_dir(&made).expect("a folder");
        for file in [&done, &begun, &other] {
            fs::write(file, b"x").expect("a file");
        }
        let (list, another) = (Unfinished::default(), Unfinished::default());
        drop(list.add_temporary(&done));
        let entries = [list.add_folder(&made), list.add_temporary(&begun)];
        let _other = another.add_temporary(&other);
        list.remove_all();
        assert_eq!(
            [&done, &begun, &made, &other].map(|path| path.exists()),
            [true, false, false, true]
        );
        // The list is locked for good.
        std::mem::forget(entries);
    }
}
