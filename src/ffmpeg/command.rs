//! Words for ffmpeg's command line: the programs, the names of inputs and outputs.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The program to run as ffmpeg.
pub(crate) fn ffmpeg_program(ffmpeg: Option<&Path>) -> PathBuf {
    ffmpeg.unwrap_or(Path::new("ffmpeg")).to_path_buf()
}

/// ffprobe: beside the given ffmpeg if there is one, else the one on the search path.
pub(crate) fn ffprobe_program(ffmpeg: Option<&Path>) -> PathBuf {
    let beside = ffmpeg.and_then(|ffmpeg| {
        let name = ffmpeg.file_name()?.to_str()?;
        let name = if name.contains("ffmpeg") {
            name.replace("ffmpeg", "ffprobe")
        } else {
            "ffprobe".into()
        };
        Some(ffmpeg.with_file_name(name))
    });
    beside.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from("ffprobe"))
}

/// A local file or a URL as ffmpeg is to be given it: files with their protocol, so that neither a
/// leading dash nor a colon in a name means anything.
pub(crate) fn address(path: &Path) -> OsString {
    if is_url(path) || path.starts_with("/dev") {
        return path.into();
    }
    let mut name = OsString::from("file:");
    name.push(path);
    name
}

/// Whether `path` is the address of a stream rather than of a file.
pub(crate) fn is_url(path: &Path) -> bool {
    path.to_str().is_some_and(|text| {
        text.split_once("://").is_some_and(|(scheme, _)| {
            !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'+')
        })
    })
}

/// Options that say what kind of input `path` is, where ffmpeg cannot know.
pub(crate) fn input_format(path: &Path) -> Vec<OsString> {
    if is_camera(path) { arguments([&"-f", &"v4l2"]) } else { Vec::new() }
}

pub(crate) fn is_camera(path: &Path) -> bool {
    path.to_str().is_some_and(|text| text.starts_with("/dev/video"))
}

/// A command line in parts of any kind of text.
pub(crate) fn arguments<const N: usize>(parts: [&dyn AsRef<OsStr>; N]) -> Vec<OsString> {
    parts.iter().map(|part| OsStr::to_os_string((*part).as_ref())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_from_addresses() {
        assert_eq!(address(Path::new("-a:b.mp4")), "file:-a:b.mp4");
        assert_eq!(address(Path::new("rtsp://host/x")), "rtsp://host/x");
        assert!(!is_url(Path::new("a/b://c")) && !is_url(Path::new("C:\\x")));
    }
}
