//! The progress bar, on standard error, and the collection of frame reports.

use std::fmt::Write;
use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use polyreel::pipeline::{FrameReport, Observer};

use crate::terminal;

/// How often the bar is drawn while no frame comes.
const TICK: Duration = Duration::from_millis(200);

/// Shows how far a run is, and keeps the frames' reports if they are wanted.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    reports: Option<Vec<FrameReport>>,
    tell_changes: bool,
}

impl Progress {
    /// A bar for `frames` frames, where their number is known; drawn only if standard error is a
    /// terminal and `quiet` is not asked for. With `keep_reports`, about 200 bytes a frame are kept.
    pub(crate) fn new(frames: Option<u64>, quiet: bool, keep_reports: bool) -> Self {
        let shown = !quiet && stderr().is_terminal();
        let target =
            if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(frames, target);
        bar.set_style(style(frames.is_some()));
        if shown {
            bar.enable_steady_tick(TICK);
        }
        Self { bar, reports: keep_reports.then(Vec::new), tell_changes: false }
    }

    /// Tells every change of detail as well, and its reason.
    pub(crate) fn telling_changes(self, tell_changes: bool) -> Self {
        Self { tell_changes, ..self }
    }

    /// Takes the bar away; the reports that were kept.
    pub(crate) fn finish(self) -> Vec<FrameReport> {
        self.bar.finish_and_clear();
        self.reports.unwrap_or_default()
    }
}

fn style(length_known: bool) -> ProgressStyle {
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

impl Observer for Progress {
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        self.bar.inc(1);
        if self.tell_changes {
            for change in &report.changes {
                self.bar
                    .suspend(|| terminal::say(format_args!("frame {}: {change}", report.index)));
            }
        }
        if let Some(reports) = &mut self.reports {
            reports.push(report.clone());
        }
        ControlFlow::Continue(())
    }
}
