//! Replaces the window in a build without one.

use std::ffi::OsString;

use polyreel::error::{Error, Result};
use polyreel::ffmpeg::Processes;
use polyreel::pipeline::{Controls, Observer, Stop, Summary};
use polyreel::sink::Sink;
use polyreel::stream::StreamInfo;

use crate::program::Outcome;
use crate::program::cli::PreviewArgs;

fn no_window() -> Error {
    Error::output("preview", "this polyreel was built without its window (feature 'preview')")
}

/// Reports that there is no window.
pub(crate) fn preview(_: &PreviewArgs) -> Result<Outcome> {
    Err(no_window())
}

/// The window of a render, which does not exist.
pub(crate) enum RenderWindow {}

impl RenderWindow {
    /// Reports that there is no window.
    pub(crate) fn open(_: &[OsString], _: &StreamInfo, _: Controls) -> Result<Self> {
        Err(no_window())
    }

    pub(crate) fn watch(&self, _: Box<dyn Sink>) -> Box<dyn Sink> {
        match *self {}
    }

    pub(crate) fn run(
        self,
        _: &Stop,
        _: &Processes,
        _: &mut (dyn Observer + Send),
        _: impl FnOnce(&mut dyn Observer) -> Result<Summary> + Send,
    ) -> Result<Summary> {
        match self {}
    }
}
