//! Builds command lines of ffmpeg: names of inputs and outputs, times.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use crate::frame::Rational;

pub(crate) use super::address::{is_camera, is_url};

/// The name of standard input.
pub(crate) const STANDARD: &str = "-";

/// A local file, standard input or a URL for ffmpeg: files get their protocol, so that a leading dash or a colon in a name has no
/// meaning.
pub(crate) fn address(path: &Path) -> OsString {
    if is_url(path) || path.starts_with("/dev") {
        return path.into();
    }
    if path == Path::new(STANDARD) {
        return "pipe:0".into();
    }
    let mut name = OsString::from("file:");
    name.push(path);
    name
}

/// A command line in parts of any kind of text.
pub(crate) fn arguments<const N: usize>(parts: [&dyn AsRef<OsStr>; N]) -> Vec<OsString> {
    parts.iter().map(|part| OsStr::to_os_string((*part).as_ref())).collect()
}

/// A time in ffmpeg's unit: whole microseconds.
pub(crate) fn seconds(time: Rational) -> String {
    let (num, den) = (i128::from(time.num), i128::from(time.den));
    format!("{}us", (2_000_000 * num + den).div_euclid(2 * den))
}

/// Options that move an input's times, from 0 at its first stream, by `offset` seconds, never by 0: ffmpeg changes an
/// offset of 0 where (in MPEG-TS) unused streams begin before the used ones.
pub(crate) fn moved(offset: Rational) -> Vec<OsString> {
    let offset = seconds(offset);
    arguments([&"-itsoffset", &if offset == "0us" { "1us" } else { offset.as_str() }])
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

    #[test]
    fn seconds_are_whole_microseconds() {
        assert_eq!(seconds(Rational::new(1001, 30000)), "33367us");
        assert_eq!(seconds(Rational::ZERO), "0us");
        assert_eq!(seconds(Rational::new(1, 3)), "333333us");
        assert_eq!(seconds(Rational::new(-7, 1000)), "-7000us");
    }
}
