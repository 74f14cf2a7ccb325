//! What a render writes to standard error: its progress bar, warnings and the line at its end.

use std::fmt::Write;
use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use polyreel::pipeline::{FrameReport, OutputReport, Summary};
use polyreel::stream::StreamInfo;

use crate::program::cli::RunArgs;
use crate::program::embed::Watcher;
use crate::program::render::say_summary;
use crate::program::terminal;

/// How often the bar is drawn while no frame comes.
pub(crate) const TICK: Duration = Duration::from_millis(200);

/// Reports the progress of a run on the terminal.
#[derive(Debug)]
pub(crate) struct Progress<'a> {
    run: &'a RunArgs,
    bar: ProgressBar,
    /// What goes on until the first frame is done.
    first_step: &'static str,
    /// Until then, whether the number of frames is known.
    awaits: Option<bool>,
}

impl<'a> Progress<'a> {
    /// As `run` asks for. A bar is drawn only if standard error is a terminal.
    pub(crate) fn new(run: &'a RunArgs) -> Self {
        Self {
            run,
            bar: ProgressBar::hidden(),
            first_step: "rendering the first frame",
            awaits: None,
        }
    }

    /// The same, which says that `first_step` goes on until the first frame is done.
    pub(crate) fn waiting_for(self, first_step: &'static str) -> Self {
        Self { first_step, ..self }
    }
}

/// A bar for work that has nothing to count, on standard error where that is a terminal. Its message says what goes
/// on.
pub(crate) fn spinner() -> ProgressBar {
    if !stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    bar.set_style(waiting_style());
    bar.enable_steady_tick(TICK);
    bar
}

/// How the bar looks while it has nothing to count: what goes on, and for how long.
fn waiting_style() -> ProgressStyle {
    ProgressStyle::with_template("{spinner} {msg}, {elapsed}")
        .expect("the template is a fixed, sound one")
}

/// How a bar of frames looks.
pub(crate) fn style(length_known: bool) -> ProgressStyle {
    let template = if length_known {
        "{wide_bar} {pos}/{len} frames, {rate}, {eta} left"
    } else {
        "{spinner} {pos} frames, {rate}, {elapsed}"
    };
    let style = ProgressStyle::with_template(template).expect("the template is a fixed, sound one");
    style.with_key("rate", |state: &ProgressState, to: &mut dyn Write| {
        // A bar that cannot be drawn is no reason to stop.
        let _ = write!(to, "{:.1} fps", state.per_sec());
    })
}

impl Watcher for Progress<'_> {
    fn begins(&mut self, info: &StreamInfo) {
        let shown = !self.run.quiet && stderr().is_terminal();
        let target =
            if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        self.bar = ProgressBar::with_draw_target(info.frames, target);
        self.bar.set_style(waiting_style());
        self.bar.set_message(self.first_step);
        self.awaits = Some(info.frames.is_some());
        if shown {
            self.bar.enable_steady_tick(TICK);
        }
    }

    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        if let Some(length_known) = self.awaits.take() {
            self.bar.set_style(style(length_known));
        }
        self.bar.inc(1);
        if self.run.verbose {
            for change in &report.changes {
                self.bar
                    .suspend(|| terminal::say(format_args!("frame {}: {change}", report.index)));
            }
        }
        ControlFlow::Continue(())
    }

    fn frames_end(&mut self) {
        self.bar.finish_and_clear();
    }

    fn warns(&mut self, text: &str) {
        if !self.run.quiet {
            terminal::warn(text);
        }
    }

    fn ended(&mut self, info: &StreamInfo, written: &OutputReport, summary: &Summary) {
        say_summary(self.run, info, written, summary);
    }
}
