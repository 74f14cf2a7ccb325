//! What there is to say after a run.

use std::fmt::Write as _;

use indicatif::HumanBytes;
use polyreel::options::Target;
use polyreel::pipeline::{Ending, OutputReport, Summary};
use polyreel::stage::Stage;
use polyreel::stream::StreamInfo;

use crate::program::cli::RunArgs;
use crate::program::terminal;

/// What to say where `short` frames stay below the `target` of `--error`, the `least` like at that.
pub(crate) fn fell_short(target: Target, short: u64, least: f64) -> Option<String> {
    let frames = match short {
        0 => return None,
        1 => "1 frame stays".to_owned(),
        n => format!("{n} frames stay"),
    };
    let (wanted, least) = (target.describe(target.value()), target.describe(least));
    Some(format!("{frames} below {wanted}, the least at {least}; more --points, or auto, reach it"))
}

/// What to say where `--focus faces` found none in `faceless` of `frames`.
pub(super) fn faceless(faceless: u64, frames: u64) -> Option<String> {
    let what = match (faceless, frames) {
        (0, _) => return None,
        (_, 1) => "no face was found".to_owned(),
        (faceless, frames) => format!("no face was found in {faceless} of {frames} frames"),
    };
    Some(format!("{what}: more points are where it stands out, as with --focus saliency"))
}

/// What there is to say on standard error after a run that did not fail.
pub(crate) fn say_summary(
    run: &RunArgs,
    info: &StreamInfo,
    written: &OutputReport,
    summary: &Summary,
) {
    if let Ending::Truncated(error) = &summary.ending {
        terminal::warn(format_args!("{error}; the output holds what came before"));
    }
    // A reader who has gone had enough.
    if run.quiet || matches!(summary.ending, Ending::Closed) {
        return;
    }
    if run.verbose {
        terminal::say_lines(&stage_table(summary));
    }
    let frames = match summary.frames {
        1 => "1 frame".to_owned(),
        n => format!("{n} frames"),
    };
    let mut line = format!(
        "{}: {frames} of {} in {:.2} s ({:.1} fps)",
        written.path,
        info.size,
        summary.wall.as_secs_f64(),
        summary.fps()
    );
    // Writing to a string cannot fail.
    if let Some(bytes) = written.bytes {
        let _ = write!(line, ", {}", HumanBytes(bytes));
    }
    if let Some(ms) = summary.budget.ms {
        let _ = write!(line, ", {} over {ms} ms", summary.budget.missed);
    }
    if summary.dropped > 0 {
        let _ = write!(line, ", {} dropped", summary.dropped);
    }
    if let Some(delay) = summary.delay {
        let _ = write!(line, ", delay {:.0} ms (95 %: {:.0} ms)", delay.p50_ms, delay.p95_ms);
    }
    if matches!(summary.ending, Ending::Stopped) {
        line += ", stopped early";
    }
    terminal::say(line);
}

fn stage_table(summary: &Summary) -> String {
    let head = format!("{:<12} {:>9} {:>9} {:>9}\n", "stage", "p50 ms", "p95 ms", "p99 ms");
    Stage::ALL.iter().fold(head, |mut table, &stage| {
        let times = summary.stages.get(stage);
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "{:<12} {:>9.2} {:>9.2} {:>9.2}",
            stage.name(),
            times.p50_ms,
            times.p95_ms,
            times.p99_ms
        );
        table
    })
}
