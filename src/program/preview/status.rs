//! The text of the status line.

use std::time::Duration;

use polyreel::options::Method;
use polyreel::pipeline::FrameReport;
use polyreel::stage::Stage;

/// The data of the status line.
#[derive(Clone, Debug, Default)]
pub(super) struct Status {
    pub(super) method: Method,
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
    /// The last note.
    pub(super) note: Option<String>,
}

/// The stages that share a time budget: those of one thread.
const THREADS: [&[Stage]; 3] =
    [&[Stage::Features], &[Stage::Sample, Stage::Triangulate, Stage::Refine], &[Stage::Rasterise]];

/// The words of the status line, each of which is kept on one line. They have constant widths, so that the line does
/// not jitter.
pub(super) fn words(status: &Status) -> Vec<String> {
    let mut words = vec![format!("{:4.1} fps", status.rate)];
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let report = status.report.as_ref();
    let time = |stage: Stage| report.map_or(Duration::ZERO, |report| report.timing.get(stage));
    if let Some(budget) = status.budget {
        // What shares a thread shares the time.
        let threads = THREADS.map(|stages| stages.iter().map(|&stage| time(stage)).sum());
        let slowest: Duration = threads.into_iter().max().unwrap_or_default();
        words.push(format!("budget {:4.1}", ms(budget)));
        words.push(format!("headroom {:5.1} ms", ms(budget) - ms(slowest)));
    }
    words.push(status.method.name().to_owned());
    if let Some(report) = report {
        let lived = report.seeds_kept + report.seeds_moved;
        let share = 100.0 * lived as f64 / report.seeds.max(1) as f64;
        words.extend([
            format!("{:5} seeds", report.seeds),
            format!("{:5} triangles", report.triangles),
            format!("kept {share:3.0}%"),
            format!("refined {:2}", report.refine_steps),
        ]);
        if report.detail < 1.0 {
            words.push(format!("detail {:.2}", report.detail));
        }
    }
    words.push(format!("dropped {}", status.dropped));
    words.extend((status.missed > 0).then(|| format!("not drawn {}", status.missed)));
    words.push(match status.length {
        Some(length) => format!("{} / {}", clock(status.position), clock(length)),
        None => clock(status.position),
    });
    words.extend(status.paused.then(|| "PAUSED".to_owned()));
    words.extend(status.recording.then(|| "RECORDING".to_owned()));
    words.push(format!("ms: decode {:4.1}", ms(status.decode)));
    let stages = Stage::ALL.into_iter().skip(1);
    words.extend(stages.map(|stage| format!("{stage} {:4.1}", ms(time(stage)))));
    words.push(status.note.clone().unwrap_or_else(|| "h: help".to_owned()));
    words
}

/// `0:03.2`.
fn clock(seconds: f64) -> String {
    let tenths = (seconds.max(0.0) * 10.0) as u64;
    format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10)
}

/// Between two words.
const GAP: &str = "  ";

/// `words` in lines of at most `columns` letters. A word longer than that is cut.
pub(super) fn lines(words: &[String], columns: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        let word: String = word.chars().take(columns).collect();
        match lines.last_mut() {
            Some(line) if line.chars().count() + GAP.len() + word.chars().count() <= columns => {
                line.push_str(GAP);
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status() -> Status {
        Status {
            budget: Some(Duration::from_millis(33)),
            length: Some(65.04),
            position: 3.25,
            rate: 23.98,
            dropped: 7,
            ..Status::default()
        }
    }

    #[test]
    fn lines_fit_whatever_the_width() {
        let note = Some("recording to a-file-of-a-rather-long-name.mp4".to_owned());
        let words = words(&Status { note, paused: true, recording: true, ..status() });
        for columns in 1..300 {
            let lines = lines(&words, columns);
            assert!(
                lines.iter().all(|line| line.chars().count() <= columns),
                "{columns}: {lines:?}"
            );
        }
        let all = words.join(GAP);
        assert_eq!(lines(&words, all.len()), [all]);
    }

    #[test]
    fn all_data_is_in_the_line() {
        let text = words(&status()).join(" ");
        for part in [
            "24.0 fps",
            "budget 33.0",
            "headroom  33.0 ms",
            "hrlp",
            "dropped 7",
            "0:03.2 / 1:05.0",
            "rasterise",
            "h: help",
        ] {
            assert!(text.contains(part), "{part} is missing in {text}");
        }
        assert!(!text.contains("PAUSED") && !text.contains("RECORDING"));
    }
}
