//! Times and counts of the last frame, for who wants to see them.

use std::time::Duration;

use polyreel::pipeline::FrameReport;
use polyreel::stage::Stage;

/// The state of the preview.
#[derive(Clone, Debug, Default)]
pub(super) struct Status {
    /// Pictures drawn a second.
    pub(super) rate: f64,
    /// Time for a frame, where one is set.
    pub(super) budget: Option<Duration>,
    pub(super) report: Option<FrameReport>,
    /// Time that reading a frame takes.
    pub(super) decode: Duration,
    /// Number of dropped frames.
    pub(super) dropped: u64,
    /// Number of pictures that were replaced before they were drawn.
    pub(super) missed: u64,
    /// Time of the picture in the stream, in seconds.
    pub(super) position: f64,
    /// Length of the stream in seconds, where it is known.
    pub(super) length: Option<f64>,
    pub(super) paused: bool,
    pub(super) recording: bool,
    /// Whether the input is one picture.
    pub(super) still: bool,
    /// The share of an export that is done, 0 to 1, while there is one.
    pub(super) exporting: Option<f64>,
}

/// The stages that share a time budget: those of one thread.
const THREADS: [&[Stage]; 3] =
    [&[Stage::Features], &[Stage::Sample, Stage::Triangulate, Stage::Refine], &[Stage::Rasterise]];

/// The figures, a line each. They have constant widths, so that they do not jitter.
pub(super) fn figures(status: &Status) -> Vec<String> {
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let report = status.report.as_ref();
    let time = |stage: Stage| report.map_or(Duration::ZERO, |report| report.timing.get(stage));
    let mut lines = vec![format!("{:4.1} pictures a second", status.rate)];
    if let Some(budget) = status.budget {
        // What shares a thread shares the time.
        let threads = THREADS.map(|stages| stages.iter().map(|&stage| time(stage)).sum());
        let slowest: Duration = threads.into_iter().max().unwrap_or_default();
        let (budget, left) = (ms(budget), ms(budget) - ms(slowest));
        lines.push(format!("budget {budget:.1} ms, headroom {left:.1} ms"));
    }
    if let Some(report) = report {
        let lived = report.seeds_kept + report.seeds_moved;
        let share = 100.0 * lived as f64 / report.seeds.max(1) as f64;
        lines.extend([
            format!("{} seeds, {share:.0} % kept", report.seeds),
            format!("{} triangles", report.triangles),
            format!("{} refinement steps, detail {:.2}", report.refine_steps, report.detail),
        ]);
    }
    lines.push(format!("dropped {}, not drawn {}", status.dropped, status.missed));
    lines.push(format!("decode {:.1} ms", ms(status.decode)));
    let stages = Stage::ALL.into_iter().skip(1);
    lines.extend(stages.map(|stage| format!("{stage} {:.1} ms", ms(time(stage)))));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_figures_are_there() {
        let status = Status {
            budget: Some(Duration::from_millis(33)),
            rate: 23.98,
            dropped: 7,
            ..Status::default()
        };
        let text = figures(&status).join(" ");
        for part in ["24.0 pictures", "budget 33.0", "headroom 33.0 ms", "dropped 7", "rasterise"] {
            assert!(text.contains(part), "{part} is missing in {text}");
        }
    }
}
