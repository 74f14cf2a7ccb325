//! From what the user names to a list of files: folders, globs, patterns.

use std::path::{Path, PathBuf};

use super::detect::{self, Kind, READABLE};
use crate::error::{Error, Result};
use crate::pattern::Pattern;

/// The files that `inputs` name, in the order in which they play: as given, and in natural order
/// (`2` before `10`) within a folder or a glob.
///
/// # Errors
/// When nothing is named, or a folder, glob or pattern holds no file.
pub(crate) fn expand(inputs: &[String]) -> Result<Vec<PathBuf>> {
    if inputs.is_empty() {
        return Err(Error::usage("no input is named; name a picture, a GIF or a video"));
    }
    let mut files = Vec::new();
    for input in inputs {
        let path = Path::new(input);
        if path.is_dir() {
            files.extend(folder(path)?);
        } else if path.exists() {
            // Before globs and patterns: `[1].png` and `100%d.png` are names, too.
            files.push(path.to_owned());
        } else if let Some(pattern) = Pattern::parse(input) {
            files.extend(numbered(input, &pattern)?);
        } else if input.contains(['*', '?', '[']) {
            files.extend(globbed(input)?);
        } else {
            files.push(path.to_owned());
        }
    }
    Ok(files)
}

fn natural(paths: &mut [PathBuf]) {
    paths.sort_by(|a, b| {
        natord::compare(&a.to_string_lossy(), &b.to_string_lossy()).then_with(|| a.cmp(b))
    });
}

/// The pictures in a folder: files that hold one, and files that are called one (so that a broken
/// one is noticed). Hidden files are passed over.
fn folder(path: &Path) -> Result<Vec<PathBuf>> {
    let unreadable =
        |e| Error::input(path, format!("the folder cannot be read: {e}; check its permissions"));
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let file = entry.path();
        let shown = !entry.file_name().to_string_lossy().starts_with('.') && file.is_file();
        let meant = || {
            detect::is_called_picture(&file)
                || matches!(detect::detect(&file), Ok(Kind::Picture(_) | Kind::Gif))
        };
        if shown && meant() {
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
    let mut files: Vec<PathBuf> =
        glob::glob(input).map_err(wrong)?.flatten().filter(|p| p.is_file()).collect();
    if files.is_empty() {
        return Err(Error::input(input, "no file matches this pattern; check the folder's name"));
    }
    natural(&mut files);
    Ok(files)
}

/// From 0, 1 or the lowest number that there is, up to the first gap.
fn numbered(input: &str, pattern: &Pattern) -> Result<Vec<PathBuf>> {
    let exists = |n: u64| Path::new(&pattern.name(n)).exists();
    let first = (0..=1).find(|&n| exists(n)).or_else(|| lowest(input, pattern));
    let Some(first) = first else {
        return Err(Error::input(
            input,
            format!("no file matches; expected {}, {} ...", pattern.name(0), pattern.name(1)),
        ));
    };
    Ok((first..).take_while(|&n| exists(n)).map(|n| PathBuf::from(pattern.name(n))).collect())
}

/// The lowest number in use. The number must stand in the file's name, not in a folder's.
fn lowest(input: &str, pattern: &Pattern) -> Option<u64> {
    let parent = Path::new(input).parent()?;
    let listed = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let entries = std::fs::read_dir(listed).ok()?;
    entries
        .flatten()
        .filter_map(|e| pattern.number(&parent.join(e.file_name()).to_string_lossy()))
        .min()
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
        expand(&[format!("{}/{name}", folder.path().display())]).map(|files| names(&files))
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
    fn patterns_start_at_the_lowest_and_stop_at_the_first_gap() {
        let folder = folder_of(&["a1.png", "a2.png", "a4.png", "b07.png", "b08.png", "c0.png"]);
        assert_eq!(expanded(&folder, "a%d.png").expect("from 1"), ["a1.png", "a2.png"]);
        assert_eq!(expanded(&folder, "b%02d.png").expect("from 7"), ["b07.png", "b08.png"]);
        assert_eq!(expanded(&folder, "c%d.png").expect("from 0"), ["c0.png"]);
        let error = expanded(&folder, "d%d.png").expect_err("nothing there").to_string();
        assert!(error.contains("d0.png"), "{error}");
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
