//! What kind of place the name of an output means.

use std::ffi::OsStr;
use std::path::Path;

use crate::ffmpeg::{is_camera, is_url};
use crate::source::detect::is_pipe;

/// A place that is written to as frames come, and cannot be replaced when it is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// A pipe: standard output, a named one.
    Pipe,
    /// An address on a network.
    Network,
    /// A playlist of HLS, with its segments in the same folder.
    Playlist,
    /// A video device (v4l2loopback).
    Device,
}

impl Target {
    /// That of `output`; `None` for files and folders.
    pub(crate) fn of(output: &OsStr) -> Option<Self> {
        let path = Path::new(output);
        let is_playlist = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("m3u8"));
        match () {
            () if output == "-" || output == "/dev/stdout" || is_pipe(path) => Some(Self::Pipe),
            () if is_camera(path) => Some(Self::Device),
            () if is_playlist => Some(Self::Playlist),
            () if is_url(path) => Some(Self::Network),
            () => None,
        }
    }

    /// Whether it is watched while it is written, so that frames of a live source must not come late.
    #[cfg(feature = "ffmpeg")]
    pub(crate) fn is_live(self) -> bool {
        self != Self::Pipe
    }

    /// Whether its readers expect frames at the speed at which they are shown.
    #[cfg(feature = "ffmpeg")]
    pub(crate) fn is_paced(self) -> bool {
        matches!(self, Self::Network | Self::Device)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_told_by_their_names() {
        let of = |name: &str| Target::of(OsStr::new(name));
        assert_eq!(of("-"), Some(Target::Pipe));
        assert_eq!(of("rtmp://host/app/key"), Some(Target::Network));
        assert_eq!(of("live/x.M3U8"), Some(Target::Playlist));
        assert_eq!(of("http://host/x.m3u8"), Some(Target::Playlist));
        assert_eq!(of("/dev/video10"), Some(Target::Device));
        assert_eq!(of("a.mp4"), None);
    }
}
