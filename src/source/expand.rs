//! Expands inputs to a list of files: folders, globs, patterns.

use std::cmp::Ordering;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::detect::{self, Kind, READABLE};
use crate::error::{Error, Result};
use crate::pattern::Pattern;

/// The files that `inputs` name, in order: inputs as given, and files of a folder or a glob in natural order (`2`
/// before `10`).
///
/// # Errors
/// When nothing is named, or a folder, glob or pattern holds no file.
pub(crate) fn expand(inputs: &[&OsStr]) -> Result<Vec<PathBuf>> {
    if inputs.is_empty() {
        return Err(Error::usage("no input is named; name a picture, a GIF or a video"));
    }
    let mut files = Vec::new();
    for input in inputs {
        let path = Path::new(input);
        if path.is_dir() {
            files.extend(folder(path)?);
        } else if path.exists() {
            // Existing files come before globs and patterns: `[1].png` and `100%d.png` are valid names.
            files.push(path.to_owned());
        } else if let Some(pattern) = Pattern::parse(input) {
            files.extend(numbered(path, &pattern)?);
        } else if let Some(glob) = input.to_str().filter(|name| name.contains(['*', '?', '['])) {
            files.extend(globbed(glob)?);
        } else {
            files.push(path.to_owned());
        }
    }
    Ok(files)
}

fn natural(paths: &mut [PathBuf]) {
    paths.sort_by(|a, b| natural_order(bytes(a), bytes(b)).then_with(|| a.cmp(b)));
}

fn bytes(path: &Path) -> &[u8] {
    path.as_os_str().as_encoded_bytes()
}

/// Compares names byte by byte, but numbers in them by value, as `ls -v`: 8, 9, 010, 011.
fn natural_order(mut a: &[u8], mut b: &[u8]) -> Ordering {
    loop {
        match (a.first(), b.first()) {
            (Some(x), Some(y)) if x.is_ascii_digit() && y.is_ascii_digit() => {
                let (one, other) = (number(&mut a), number(&mut b));
                // Without leading zeros the longer number is larger.
                match one.len().cmp(&other.len()).then_with(|| one.cmp(other)) {
                    Ordering::Equal => {}
                    unequal => return unequal,
                }
            }
            (Some(x), Some(y)) if x == y => (a, b) = (&a[1..], &b[1..]),
            (x, y) => return x.cmp(&y),
        }
    }
}

/// Removes the leading digits from `text` and returns them without leading zeros.
fn number<'a>(text: &mut &'a [u8]) -> &'a [u8] {
    let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
    let (number, after) = text.split_at(digits);
    *text = after;
    let zeros = number.iter().take_while(|&&b| b == b'0').count();
    &number[zeros..]
}

/// The pictures in a folder: files that hold a picture, and files with the extension of one, so that a broken one is
/// noticed. Hidden files are skipped.
fn folder(path: &Path) -> Result<Vec<PathBuf>> {
    let unreadable = |e| {
        Error::input(path, format!("the folder cannot be read: {e}; check its permissions"))
            .caused_by(e)
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let file = entry.path();
        let hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        let meant = || {
            // A broken link is kept: the error of opening it names it.
            detect::is_called_picture(&file) && !file.is_dir()
                || file.is_file()
                    && matches!(detect::detect(&file), Ok(Kind::Picture(_) | Kind::Gif))
        };
        if !hidden && meant() {
            files.push(file);
        }
    }
    if files.is_empty() {
        return Err(Error::input(
            path,
            format!("the folder holds no picture; expected {READABLE} files in it"),
        ));
    }
    natural(&mut files);
    Ok(files)
}

fn globbed(input: &str) -> Result<Vec<PathBuf>> {
    let wrong = |e: glob::PatternError| Error::input(input, format!("is no pattern: {e}"));
    let unreadable = |e: glob::GlobError| {
        Error::input(e.path(), format!("cannot be read: {}; check its permissions", e.error()))
    };
    let mut files = Vec::new();
    for file in glob::glob(input).map_err(wrong)? {
        files.push(file.map_err(unreadable)?);
    }
    files.retain(|file| !file.is_dir());
    if files.is_empty() {
        return Err(Error::input(input, "no file matches this pattern; check the folder's name"));
    }
    natural(&mut files);
    Ok(files)
}

/// The files from number 0, 1 or the lowest one up to the first gap.
fn numbered(input: &Path, pattern: &Pattern) -> Result<Vec<PathBuf>> {
    // A broken link is not a gap: the error of opening it names it.
    let exists = |n: u64| pattern.name(n).symlink_metadata().is_ok();
    let first = (0..=1).find(|&n| exists(n)).or_else(|| lowest(input, pattern));
    let Some(first) = first else {
        let (zero, one) = (pattern.name(0), pattern.name(1));
        return Err(Error::input(
            input,
            format!("no file matches; expected {}, {} ...", zero.display(), one.display()),
        ));
    };
    Ok((first..).take_while(|&n| exists(n)).map(|n| pattern.name(n)).collect())
}

/// The lowest number in use. The number must be in the file's name, not in a folder's.
fn lowest(input: &Path, pattern: &Pattern) -> Option<u64> {
    let parent = input.parent()?;
    let listed = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let entries = std::fs::read_dir(listed).ok()?;
    entries.flatten().filter_map(|e| pattern.number(&parent.join(e.file_name()))).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(files: &[PathBuf]) -> Vec<String> {
        files
            .iter()
            .map(|f| f.file_name().expect("a name").to_string_lossy().into_owned())
            .collect()
    }

    fn folder_of(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for file in files {
            std::fs::write(folder.path().join(file), b"x").expect("a file");
        }
        folder
    }

    fn expanded(folder: &tempfile::TempDir, name: &str) -> Result<Vec<String>> {
        expand(&[folder.path().join(name).as_os_str()]).map(|files| names(&files))
    }

    #[test]
    fn folders_and_globs_are_in_natural_order() {
        let folder =
            folder_of(&["f10.png", "f9.png", "F1.PNG", "notes.txt", ".hidden.png", "f2.jpg"]);
        std::fs::write(folder.path().join("gif-without-name"), b"GIF89a").expect("a file");
        let all = expanded(&folder, "").expect("pictures");
        assert_eq!(all, ["F1.PNG", "f2.jpg", "f9.png", "f10.png", "gif-without-name"]);
        assert_eq!(expanded(&folder, "f*.png").expect("a glob"), ["f9.png", "f10.png"]);
    }

    #[test]
    fn numbers_with_leading_zeros_are_in_natural_order() {
        let folder = folder_of(&["f_010.png", "f_8.png", "f_011.png", "f_9.png", "f_08.png"]);
        let all = expanded(&folder, "f_*.png").expect("a glob");
        assert_eq!(all, ["f_08.png", "f_8.png", "f_9.png", "f_010.png", "f_011.png"]);
    }

    #[test]
    fn patterns_start_at_the_lowest_and_stop_at_the_first_gap() {
        let folder = folder_of(&["a1.png", "a2.png", "a4.png", "b07.png", "b08.png", "c0.png"]);
        assert_eq!(expanded(&folder, "a%d.png").expect("from 1"), ["a1.png", "a2.png"]);
        assert_eq!(expanded(&folder, "b%02d.png").expect("from 7"), ["b07.png", "b08.png"]);
        assert_eq!(expanded(&folder, "c%d.png").expect("from 0"), ["c0.png"]);
        let error = expanded(&folder, "d%d.png").expect_err("nothing there").to_string();
        assert!(error.contains("d0.png"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_nowhere_is_part_of_the_sequence() {
        let folder = folder_of(&["a1.png", "a3.png"]);
        std::os::unix::fs::symlink("gone.png", folder.path().join("a2.png")).expect("a link");
        for name in ["", "a*.png", "a%d.png"] {
            let files = expanded(&folder, name).expect("three names");
            assert_eq!(files, ["a1.png", "a2.png", "a3.png"], "{name:?}");
        }
    }

    #[test]
    fn names_that_look_like_globs_are_names_when_they_exist() {
        let folder = folder_of(&["[1].png", "1.png"]);
        assert_eq!(expanded(&folder, "[1].png").expect("a name"), ["[1].png"]);
    }

    #[test]
    fn nothing_to_read_is_an_error_that_says_what_was_expected() {
        let folder = folder_of(&["notes.txt"]);
        let error = expanded(&folder, "").expect_err("no picture").to_string();
        assert!(error.contains("no picture") && error.contains("PNG"), "{error}");
        assert!(expanded(&folder, "*.png").is_err());
        assert!(expand(&[]).is_err());
    }
}
