//! The bar of frames that are done.

use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;

use indicatif::{ProgressBar, ProgressDrawTarget};
use polyreel::pipeline::{FrameReport, Observer};

use crate::program::progress::style;

/// A bar on standard error, where that is a terminal.
pub(super) struct Bar(ProgressBar);

impl Bar {
    /// A bar for `frames` frames, where their number is known; hidden if `quiet`.
    pub(super) fn new(frames: Option<u64>, quiet: bool) -> Self {
        let shown = !quiet && stderr().is_terminal();
        let target =
            if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(frames, target);
        bar.set_style(style(frames.is_some()));
        Self(bar)
    }

    /// Counts `frames` frames that are done.
    pub(super) fn add(&self, frames: u64) {
        self.0.inc(frames);
    }

    /// Takes the bar away.
    pub(super) fn finish(self) {
        self.0.finish_and_clear();
    }
}

impl Observer for Bar {
    fn frame_done(&mut self, _: &FrameReport) -> ControlFlow<()> {
        self.add(1);
        ControlFlow::Continue(())
    }
}
