//! In place of video files where polyreel is built without ffmpeg.

use std::convert::Infallible;
use std::path::Path;

use super::target::Target;
use super::{Origin, Picture, Sink, SinkOptions};
use crate::error::{Error, Result};
use crate::frame::Buffers;

pub use crate::sink::spec::{VideoOptions, VideoSpec};

/// A container of video, none of which can be written.
pub struct Container;

impl Container {
    /// That of lossy WebP.
    pub(crate) fn webp() -> Self {
        Self
    }

    /// Whether the extension of `path` is that of a video.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let known = ["mp4", "m4v", "mov", "mkv", "webm", "ts", "m2ts", "mts", "avi", "flv", "ogv"];
        known.contains(&extension.as_str()).then_some(Self)
    }

    /// A container by its name.
    pub fn named(_name: &str) -> Self {
        Self
    }
}

/// A video file: there is none without ffmpeg.
pub struct VideoSink(Infallible);

impl VideoSink {
    /// Refuses the video `path`.
    ///
    /// # Errors
    /// Always.
    pub fn create(path: &Path, _spec: VideoSpec, _with: &SinkOptions) -> Result<Self> {
        Err(Error::output(
            path,
            "video is written by ffmpeg, and this polyreel was built without it: build it with --features ffmpeg",
        ))
    }

    /// Refuses it in any container.
    ///
    /// # Errors
    /// Always.
    pub(crate) fn create_in(
        _container: Container,
        path: &Path,
        spec: VideoSpec,
        with: &SinkOptions,
    ) -> Result<Self> {
        Self::create(path, spec, with)
    }
}

/// A video on its way: there is none without ffmpeg either.
pub(crate) struct LiveSink;

impl LiveSink {
    /// Refuses it, as [`VideoSink::create`].
    ///
    /// # Errors
    /// Always.
    pub(crate) fn create(
        path: &Path,
        _target: Target,
        _live: bool,
        spec: VideoSpec,
        with: &SinkOptions,
    ) -> Result<VideoSink> {
        VideoSink::create(path, spec, with)
    }
}

impl Sink for VideoSink {
    fn write(&mut self, _picture: Picture, _origin: Option<Origin>) -> Result<Buffers> {
        match self.0 {}
    }

    fn finish(self: Box<Self>) -> Result<()> {
        match self.0 {}
    }
}
