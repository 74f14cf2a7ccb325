//! Outputs that are written beside their place and put into it when they are complete.
//!
//! Whatever is dropped before its `commit` leaves nothing behind.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

use super::SinkOptions;
use super::unfinished::Unfinished;
use crate::error::{Error, Result, copied};
use crate::pattern::Pattern;

/// What temporary names begin with; the point hides them.
const PREFIX: &str = ".polyreel-";

/// A file on its way to its place.
#[derive(Debug)]
pub struct Place {
    named: PathBuf,
    target: PathBuf,
    overwrite: bool,
    file: Temporary,
}

/// A file that is not complete yet.
#[derive(Debug)]
enum Temporary {
    /// One without a name: the system removes it, however this process ends.
    #[cfg(target_os = "linux")]
    Unnamed(File, PathBuf),
    Named(NamedTempFile, Unfinished),
}

impl Place {
    /// A place for `output`: an empty file in its folder, where possible without a name.
    ///
    /// # Errors
    /// When `output` exists (and may not be overwritten), is an input or a folder, its folder is
    /// missing, or cannot be written to.
    pub fn reserve(output: &Path, options: &SinkOptions) -> Result<Self> {
        let target = target_of(output, options)?;
        #[cfg(target_os = "linux")]
        if let Some(file) = unnamed::create(folder_of(&target), &target) {
            let (named, overwrite) = (output.to_owned(), options.overwrite);
            let path = unnamed::path(&file);
            return Ok(Self { named, target, overwrite, file: Temporary::Unnamed(file, path) });
        }
        Self::beside(output.to_owned(), target, options.overwrite)
    }

    /// As [`Place::reserve`], of a file with a [name](Place::path) of its own, for other programs to write.
    /// It has the extension of `output`.
    ///
    /// # Errors
    /// As [`Place::reserve`].
    pub fn reserve_named(output: &Path, options: &SinkOptions) -> Result<Self> {
        let target = target_of(output, options)?;
        Self::beside(output.to_owned(), target, options.overwrite)
    }

    /// Another file, with a name, for the same output; only one of the two can be put into its place.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn another(&self) -> Result<Self> {
        Self::beside(self.named.clone(), self.target.clone(), self.overwrite)
    }

    fn beside(named: PathBuf, target: PathBuf, overwrite: bool) -> Result<Self> {
        let folder = folder_of(&target);
        let suffix =
            named.extension().map_or_else(String::new, |e| format!(".{}", e.to_string_lossy()));
        let mut builder = Builder::new();
        builder.prefix(PREFIX).suffix(&suffix);
        // Those of the file that is replaced, or those of any new file; the user's mask is taken off.
        #[cfg(unix)]
        builder.permissions(fs::metadata(&target).map_or_else(
            |_| std::os::unix::fs::PermissionsExt::from_mode(0o666),
            |there| there.permissions(),
        ));
        let file = builder.tempfile_in(folder).map_err(|e| unwritable(&named, folder, e))?;
        let note = Unfinished::temporary(file.path());
        Ok(Self { named, target, overwrite, file: Temporary::Named(file, note) })
    }

    /// The file to write to.
    pub fn file(&self) -> &File {
        match &self.file {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(file, _) => file,
            Temporary::Named(file, _) => file.as_file(),
        }
    }

    /// Where the file stands until it is complete, for programs that write it by its name. That has the
    /// output's extension, and lasts longer than this process, only if it was
    /// [asked for](Place::reserve_named).
    pub fn path(&self) -> &Path {
        match &self.file {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(_, path) => path,
            Temporary::Named(file, _) => file.path(),
        }
    }

    /// The output as it was named, for messages.
    pub fn named(&self) -> &Path {
        &self.named
    }

    /// An error of writing to it.
    pub fn failed(&self, error: &std::io::Error) -> Error {
        Error::output(&self.named, format!("cannot be written: {error}")).caused_by(copied(error))
    }

    /// Puts the file in its place. One that it replaces hands its permissions on.
    ///
    /// # Errors
    /// When that fails, or something has come to stand there meanwhile and may not be overwritten.
    pub fn commit(self) -> Result<()> {
        let Self { named, target, overwrite, file } = self;
        let done = match file {
            #[cfg(target_os = "linux")]
            Temporary::Unnamed(_file, path) => unnamed::put(&path, &target, overwrite),
            Temporary::Named(file, _note) => put(file, &target, overwrite),
        };
        match done {
            Ok(()) => Ok(()),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(exists(&named)),
            Err(e) => Err(misplaced(&named, e)),
        }
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

/// Files that have no name until they are complete.
#[cfg(target_os = "linux")]
mod unnamed {
    use std::os::fd::AsRawFd;

    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};

    use super::*;

    /// A file in `folder` without a name, with the permissions of `old` if that is there. `None` where the
    /// file system has no such files, or could not give them a name.
    pub(super) fn create(folder: &Path, old: &Path) -> Option<File> {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(old).map_or(0o666, |there| there.permissions().mode() & 0o777);
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        let file = File::from(open(folder, flags, Mode::from_raw_mode(mode)).ok()?);
        path(&file).exists().then_some(file)
    }

    /// Gives the open file at the path `file` the name `target`.
    pub(super) fn put(file: &Path, target: &Path, overwrite: bool) -> io::Result<()> {
        let link = |to: &Path| -> io::Result<()> {
            Ok(linkat(CWD, file, CWD, to, AtFlags::SYMLINK_FOLLOW)?)
        };
        if !overwrite {
            return link(target);
        }
        // A link cannot take the place of a file, but a file with a name can.
        let mut builder = Builder::new();
        super::put(builder.prefix(PREFIX).make_in(folder_of(target), link)?, target, true)
    }

    /// Where an open file without a name is found.
    pub(super) fn path(file: &File) -> PathBuf {
        PathBuf::from(format!("/proc/{}/fd/{}", std::process::id(), file.as_raw_fd()))
    }
}

/// Numbered files, from 1, on their way to a folder, which may hold others already. They wait in a
/// hidden folder inside it.
#[derive(Debug)]
pub struct Series {
    pattern: Pattern,
    folder: PathBuf,
    overwrite: bool,
    written: u64,
    // Dropped in this order: what waits goes before the folder that was made for it.
    waiting: TempDir,
    made: Option<Made>,
    _note: Unfinished,
}

/// A folder that was made for the output, removed again unless the output is complete.
#[derive(Debug)]
struct Made {
    path: PathBuf,
    _note: Unfinished,
}

impl Drop for Made {
    fn drop(&mut self) {
        // Someone may have put a file there meanwhile: then it stays.
        let _ = fs::remove_dir(&self.path);
    }
}

impl Series {
    /// A place for the files of `pattern`. Its folder is made if `make` says so.
    ///
    /// # Errors
    /// When a file of that pattern exists (and may not be overwritten) or is an input, the folder is
    /// missing, or cannot be written to.
    pub fn reserve(pattern: Pattern, make: bool, options: &SinkOptions) -> Result<Self> {
        let first = pattern.name(1);
        let folder = folder_of(&first).to_owned();
        if folder_of(&pattern.name(2)) != folder {
            return Err(Error::usage(format!(
                "{}: the number must stand in the file's name, not in a folder's",
                first.display()
            )));
        }
        let mut made = None;
        if make && !folder.exists() {
            check_folder(&folder, folder_of(&folder))?;
            match fs::create_dir(&folder) {
                Ok(()) => {
                    made = Some(Made { path: folder.clone(), _note: Unfinished::folder(&folder) });
                }
                // Another run was faster.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(unwritable(&folder, folder_of(&folder), e)),
            }
        }
        check_folder(&first, &folder)?;
        let entries = fs::read_dir(&folder).map_err(|e| unwritable(&first, &folder, e))?;
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
        let waiting = Builder::new()
            .prefix(PREFIX)
            .tempdir_in(&folder)
            .map_err(|e| unwritable(&first, &folder, e))?;
        let overwrite = options.overwrite;
        let _note = Unfinished::temporary(waiting.path());
        Ok(Self { pattern, folder, overwrite, written: 0, waiting, made, _note })
    }

    /// Whether no file was asked for yet.
    pub fn is_empty(&self) -> bool {
        self.written == 0
    }

    /// The first file's name.
    pub fn first(&self) -> PathBuf {
        self.pattern.name(1)
    }

    /// A new file for the next number, and its later name for messages.
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

    /// Puts the files in their places.
    ///
    /// # Errors
    /// When one cannot be put there, or something has come to stand there meanwhile and may not be
    /// overwritten; those that were put in their places are removed again unless they replaced others.
    pub fn commit(mut self) -> Result<()> {
        for number in 1..=self.written {
            if let Err(error) = self.place(number) {
                if !self.overwrite {
                    (1..number).for_each(|number| {
                        // What cannot be removed has been complained about: the folder is at fault.
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

    /// Puts file `number` in its place.
    fn place(&self, number: u64) -> Result<()> {
        let named = self.pattern.name(number);
        let target = self.folder.join(named.file_name().unwrap_or_default());
        let waiting = self.waiting_path(&named);
        if self.overwrite {
            keep_permissions(&target, &waiting);
        } else {
            // An empty file takes the place: of two runs only one gets it.
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

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Where the file `output` is to stand.
fn target_of(output: &Path, options: &SinkOptions) -> Result<PathBuf> {
    check_free(output, options)?;
    // A link stays a link; what it points to is written, whether it is there or not.
    let target = follow_links(output)?;
    check_folder(output, folder_of(&target))?;
    Ok(target)
}

fn exists(output: &Path) -> Error {
    Error::output(output, "exists already; give another name, or replace it with -y")
}

/// Checks that nothing stands at `output` that must not be replaced.
fn check_free(output: &Path, options: &SinkOptions) -> Result<()> {
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

/// Whether two names lead to one file, through links of either sort.
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

fn check_folder(output: &Path, folder: &Path) -> Result<()> {
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

/// What `output` leads to through links, the last of which may lead to nothing yet.
fn follow_links(output: &Path) -> Result<PathBuf> {
    if let Ok(path) = fs::canonicalize(output) {
        return Ok(path);
    }
    let mut path = output.to_owned();
    // As many as Linux follows.
    for _ in 0..40 {
        let Ok(next) = fs::read_link(&path) else { return Ok(path) };
        // Of a relative link, the folder that it stands in counts.
        path = folder_of(&path).join(next);
    }
    Err(Error::output(output, "is a link that leads round in a circle"))
}

/// Gives the file `new` the permissions of the file `old`, which it is about to replace.
fn keep_permissions(old: &Path, new: &Path) {
    if let Ok(there) = fs::metadata(old) {
        // Some file systems have none. The file is written all the same.
        let _ = fs::set_permissions(new, there.permissions());
    }
}

fn misplaced(named: &Path, error: io::Error) -> Error {
    Error::output(named, format!("cannot be put in its place: {error}")).caused_by(error)
}

fn unwritable(output: &Path, folder: &Path, error: io::Error) -> Error {
    // The error of a temporary file names that file, which nobody has asked for.
    let why = error.get_ref().and_then(|e| e.source()).map_or(error.to_string(), |e| e.to_string());
    let folder = folder.display();
    Error::output(output, format!("the folder {folder} cannot be written to: {why}"))
        .caused_by(error)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn listed(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn numbered(folder: &Path) -> Pattern {
        Pattern::in_folder(folder, "png")
    }

    #[test]
    fn a_file_appears_when_it_is_complete_and_not_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("a.gif");
        let place = Place::reserve(&output, &SinkOptions::default()).expect("a place");
        place.file().write_all(b"x").expect("written");
        assert!(!output.exists());
        place.commit().expect("in its place");
        assert_eq!(listed(folder.path()), ["a.gif"]);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let usual = folder.path().join("usual");
            File::create(&usual).expect("a file");
            let mode = |p: &Path| fs::metadata(p).expect("a file").permissions().mode();
            assert_eq!(mode(&output), mode(&usual), "rights as of any new file");
        }
    }

    #[test]
    fn what_is_dropped_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let options = SinkOptions::default();
        let place = Place::reserve(&folder.path().join("a.gif"), &options).expect("a place");
        let mut there = Series::reserve(numbered(folder.path()), false, &options).expect("a place");
        there.file().expect("a file");
        let new = folder.path().join("new");
        let mut made = Series::reserve(numbered(&new), true, &options).expect("a place");
        made.file().expect("a file");
        drop((place, there, made));
        assert_eq!(listed(folder.path()), [""; 0]);
    }

    #[test]
    fn a_series_goes_beside_what_is_there() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("notes.txt"), b"x").expect("a file");
        let options = SinkOptions::default();
        let mut series =
            Series::reserve(numbered(folder.path()), false, &options).expect("a place");
        for _ in 0..2 {
            series.file().expect("a file");
        }
        series.commit().expect("in their places");
        assert_eq!(listed(folder.path()), ["0001.png", "0002.png", "notes.txt"]);
        let error = Series::reserve(numbered(folder.path()), false, &options)
            .expect_err("they exist")
            .to_string();
        assert!(error.contains("exists") && error.contains("-y"), "{error}");
    }

    #[test]
    fn nothing_is_replaced_unasked() {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("a.png");
        let place = Place::reserve(&output, &SinkOptions::default()).expect("a place");
        fs::write(&output, b"came meanwhile").expect("a file");
        assert!(place.commit().is_err());
        assert_eq!(fs::read(&output).expect("still there"), b"came meanwhile");
        let error = Place::reserve(&output, &SinkOptions::default()).expect_err("it exists");
        assert!(error.to_string().contains("-y"), "{error}");
        let options = SinkOptions { overwrite: true, ..SinkOptions::default() };
        Place::reserve(&output, &options).expect("a place").commit().expect("replaced");
        assert_eq!(fs::read(&output).expect("replaced"), b"");
    }

    #[test]
    #[cfg(unix)]
    fn a_link_to_nothing_is_written_through() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("link.png");
        symlink("there.png", &link).expect("a link");
        for overwrite in [false, true] {
            let options = SinkOptions { overwrite, ..SinkOptions::default() };
            Place::reserve(&link, &options).expect("a place").commit().expect("written");
            assert!(fs::symlink_metadata(&link).expect("a link").is_symlink());
        }
        assert_eq!(listed(folder.path()), ["link.png", "there.png"]);
        symlink("round", folder.path().join("round")).expect("a link");
        let error = Place::reserve(&folder.path().join("round"), &SinkOptions::default());
        assert!(error.expect_err("no file").to_string().contains("circle"));
    }

    #[test]
    #[cfg(unix)]
    fn a_file_that_is_replaced_hands_its_mode_on() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let options = SinkOptions { overwrite: true, ..SinkOptions::default() };
        for (name, mode) in [("a.gif", 0o600), ("b.gif", 0o444), ("c.gif", 0o777)] {
            let output = folder.path().join(name);
            fs::write(&output, b"x").expect("a file");
            fs::set_permissions(&output, PermissionsExt::from_mode(mode)).expect("its mode");
            Place::reserve(&output, &options).expect("a place").commit().expect("replaced");
            let now = fs::metadata(&output).expect("a file").permissions().mode();
            assert_eq!(now & 0o777, mode, "{name}");
        }
        let first = folder.path().join("0001.png");
        fs::write(&first, b"x").expect("a file");
        fs::set_permissions(&first, PermissionsExt::from_mode(0o640)).expect("its mode");
        let mut series = Series::reserve(numbered(folder.path()), false, &options).expect("places");
        series.file().expect("a file");
        series.commit().expect("replaced");
        assert_eq!(fs::metadata(&first).expect("a file").permissions().mode() & 0o777, 0o640);
    }

    #[test]
    fn of_two_series_for_one_place_one_is_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let new = folder.path().join("new");
        let options = SinkOptions::default();
        let [mut one, mut other] =
            [(); 2].map(|()| Series::reserve(numbered(&new), true, &options).expect("a place"));
        for _ in 0..2 {
            one.file().expect("a file");
        }
        for _ in 0..3 {
            other.file().expect("a file");
        }
        // What came meanwhile is in the way of the third.
        fs::write(new.join("0003.png"), b"x").expect("a file");
        other.commit().expect_err("the third is there");
        assert_eq!(listed(&new).iter().filter(|name| name.ends_with("png")).count(), 1);
        one.commit().expect("in its place");
        assert_eq!(listed(&new), ["0001.png", "0002.png", "0003.png"]);
    }

    #[test]
    fn an_input_is_never_the_output() {
        let folder = tempfile::tempdir().expect("a folder");
        let input = folder.path().join("0001.png");
        let link = folder.path().join("link.png");
        fs::write(&input, b"x").expect("a file");
        fs::hard_link(&input, &link).expect("a link");
        let round = folder.path().join("..").join(folder.path().file_name().expect("a name"));
        let inputs = vec![input];
        let options = SinkOptions { overwrite: true, inputs, ..SinkOptions::default() };
        for output in [round.join("0001.png"), link] {
            let error = Place::reserve(&output, &options).expect_err("the input").to_string();
            assert!(error.contains("is the input"), "{error}");
        }
        assert!(Series::reserve(numbered(&round), false, &options).is_err());
    }

    #[test]
    fn missing_folders_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("no/a.png");
        let error = Place::reserve(&output, &SinkOptions::default()).expect_err("no folder");
        assert!(error.to_string().contains("there is no folder"), "{error}");
        let error = Place::reserve(folder.path(), &SinkOptions::default()).expect_err("a folder");
        assert!(error.to_string().contains("is a folder"), "{error}");
    }
}
