//! Files that have no name until they are complete (Linux, `O_TMPFILE`).

use std::fs::{self, File};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};

use tempfile::Builder;

use super::PREFIX;
use super::check::folder_of;

/// A file in `folder` without a name, with the permissions of the file `old` if it exists. `None` where the file
/// system has no such files, or cannot give them a name later.
pub(super) fn create(folder: &Path, old: &Path) -> Option<File> {
    let mode = fs::metadata(old).map_or(0o666, |there| there.permissions().mode() & 0o777);
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let file = File::from(open(folder, flags, Mode::from_raw_mode(mode)).ok()?);
    path(&file).exists().then_some(file)
}

/// Gives the open file at the path `file` the name `target`.
pub(super) fn put(file: &Path, target: &Path, overwrite: bool) -> io::Result<()> {
    let link =
        |to: &Path| -> io::Result<()> { Ok(linkat(CWD, file, CWD, to, AtFlags::SYMLINK_FOLLOW)?) };
    if !overwrite {
        return link(target);
    }
    // linkat does not replace files, but rename does.
    let mut builder = Builder::new();
    super::put(builder.prefix(PREFIX).make_in(folder_of(target), link)?, target, true)
}

/// The path of an open file without a name.
pub(super) fn path(file: &File) -> PathBuf {
    PathBuf::from(format!("/proc/{}/fd/{}", std::process::id(), file.as_raw_fd()))
}
