//! Outputs that are written beside their place and put into it when they are complete.
//!
//! Whatever is dropped before its `commit` leaves nothing behind.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

use super::SinkOptions;
use super::unfinished::Unfinished;
use crate::error::{Error, Result};
use crate::pattern::Pattern;

/// What temporary names begin with; the point hides them.
const PREFIX: &str = ".polyreel-";

/// A file on its way to its place.
#[derive(Debug)]
pub struct Place {
    named: PathBuf,
    target: PathBuf,
    overwrite: bool,
    file: NamedTempFile,
    _note: Unfinished,
}

impl Place {
    /// A place for `output`: an empty file beside it, with its extension.
    ///
    /// # Errors
    /// When `output` exists (and may not be overwritten), is an input or a folder, its folder is
    /// missing, or cannot be written to.
    pub fn reserve(output: &Path, options: &SinkOptions) -> Result<Self> {
        check_free(output, options)?;
        // A link stays a link; what it points to is replaced.
        let target = fs::canonicalize(output).unwrap_or_else(|_| output.to_owned());
        check_folder(output, folder_of(&target))?;
        Self::beside(output.to_owned(), target, options.overwrite)
    }

    /// Another file for the same output; only one of the two can be put into its place.
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
        // The usual rights of a new file, less what the user's mask takes away.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(folder).map_err(|e| unwritable(&named, folder, &e))?;
        let _note = Unfinished::temporary(file.path());
        Ok(Self { named, target, overwrite, file, _note })
    }

    /// The file to write to.
    pub fn file(&self) -> &File {
        self.file.as_file()
    }

    /// Where the file stands until it is complete, for programs that write it by its name.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The output as it was named, for messages.
    pub fn named(&self) -> &Path {
        &self.named
    }

    /// An error of writing to it.
    pub fn failed(&self, error: &std::io::Error) -> Error {
        Error::output(&self.named, format!("cannot be written: {error}"))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// When that fails, or something has come to stand there meanwhile and may not be overwritten.
    pub fn commit(self) -> Result<()> {
        let Self { named, target, overwrite, file, _note } = self;
        let done = if overwrite { file.persist(target) } else { file.persist_noclobber(target) };
        match done {
            Ok(_) => Ok(()),
            Err(e) if e.error.kind() == std::io::ErrorKind::AlreadyExists => Err(exists(&named)),
            Err(e) => Err(Error::output(named, format!("cannot be put in its place: {}", e.error))),
        }
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
            fs::create_dir(&folder).map_err(|e| unwritable(&folder, folder_of(&folder), &e))?;
            made = Some(Made { path: folder.clone(), _note: Unfinished::folder(&folder) });
        }
        check_folder(&first, &folder)?;
        let entries = fs::read_dir(&folder).map_err(|e| unwritable(&first, &folder, &e))?;
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
            .map_err(|e| unwritable(&first, &folder, &e))?;
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
            Err(e) => Err(Error::output(named, format!("cannot be written: {e}"))),
        }
    }

    /// Puts the files in their places.
    ///
    /// # Errors
    /// When one cannot be put there, or something has come to stand there meanwhile and may not be
    /// overwritten; the files before it are there.
    pub fn commit(mut self) -> Result<()> {
        for number in 1..=self.written {
            let named = self.pattern.name(number);
            let name = named.file_name().unwrap_or_default();
            let target = self.folder.join(name);
            if !self.overwrite && target.exists() {
                return Err(exists(&named));
            }
            fs::rename(self.waiting_path(&named), target)
                .map_err(|e| Error::output(&named, format!("cannot be put in its place: {e}")))?;
            if let Some(made) = self.made.take() {
                std::mem::forget(made);
            }
        }
        Ok(())
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
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Err(Error::output(
            output,
            format!("there is no folder {}; make it first", folder.display()),
        )),
        Err(e) => Err(unwritable(output, folder, &e)),
    }
}

fn unwritable(output: &Path, folder: &Path, error: &std::io::Error) -> Error {
    // The error of a temporary file names that file, which nobody has asked for.
    let why = error.get_ref().and_then(|e| e.source()).map_or(error.to_string(), |e| e.to_string());
    let folder = folder.display();
    Error::output(output, format!("the folder {folder} cannot be written to: {why}"))
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
