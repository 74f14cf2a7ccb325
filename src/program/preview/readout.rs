//! The words of the bar: the look, and the state of playback.

use polyreel::geom::Size;
use polyreel::options::{Edges, FillMode, Method, Options, Points, Shape};
use polyreel::pipeline::FrameReport;

use super::status::Status;

/// The share of the points below which a picture is said to be reduced.
const REDUCED: f64 = 0.97;

/// The look in words, the most important first. `name` is that of its preset.
pub(super) fn look(name: Option<String>, options: &Options, status: &Status) -> Vec<String> {
    let mut words = vec![name.unwrap_or_else(|| "my look".to_owned())];
    let seeds = status.report.as_ref().map(|report| report.seeds);
    words.extend(seeds.map(|seeds| format!("{seeds} points")));
    words.push(match (options.error, options.refine) {
        (Some(error), _) => format!("until {error}"),
        (None, Some(steps)) => format!("{steps} steps"),
        (None, None) => format!("quality {}", options.quality.name()),
    });
    words.extend((!status.still).then(|| format!("coherence {}", options.coherence)));
    words.push(format!("regularity {}", options.regularity));
    words.extend(
        options.outline.map(|colour| format!("outline {} {colour}", options.outline_width)),
    );
    let default = Options::default();
    let mut add = |differs: bool, word: String| words.extend(differs.then_some(word));
    add(options.shape != Shape::default(), options.shape.name().to_owned());
    add(options.fill != FillMode::default(), format!("fill {}", options.fill.name()));
    add(options.edges == Edges::Hard, "hard edges".to_owned());
    add(options.chroma != default.chroma, format!("chroma {}", options.chroma));
    add(options.saturation != default.saturation, format!("saturation {}", options.saturation));
    add(options.method != Method::default(), options.method.name().to_owned());
    add(options.seed != default.seed, format!("seed {}", options.seed));
    words
}

/// What the time budget has reduced, if anything.
pub(super) fn reduced(report: &FrameReport, options: &Options, size: Size) -> Option<String> {
    if report.detail >= 1.0 || options.points == Points::Auto || options.hex_density.is_some() {
        return None;
    }
    let wanted = options.points.target(size);
    if (report.seeds as f64) < REDUCED * wanted as f64 {
        return Some(format!("{} of {wanted} points (budget)", report.seeds));
    }
    Some(format!("detail {:.0} % (budget)", 100.0 * report.detail))
}

/// What goes on, left of the timeline.
pub(super) fn state(status: &Status) -> String {
    if let Some(share) = status.exporting {
        return format!("exporting {:.0} %", 100.0 * share);
    }
    let state = if status.recording { "recording" } else { "playing" };
    if status.paused { "paused".to_owned() } else { state.to_owned() }
}

/// The time, right of the timeline.
pub(super) fn clock(status: &Status) -> String {
    match status.length {
        Some(length) => format!("{} / {}", time(status.position), time(length)),
        None => time(status.position),
    }
}

/// `0:03.2`.
fn time(seconds: f64) -> String {
    let tenths = (seconds.max(0.0) * 10.0) as u64;
    format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10)
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::options::{Colour, Length};

    #[test]
    fn the_look_is_in_the_bar() {
        let options = Options {
            outline: Some(Colour([255, 0, 0, 255])),
            outline_width: Length::Pixels(2.0),
            seed: 5,
            ..Options::default()
        };
        let text = |still| {
            let status = Status { still, ..Status::default() };
            look(Some("bold *".to_owned()), &options, &status).join(" ")
        };
        for part in ["bold *", "quality", "coherence 0.4", "outline 2 #ff0000", "seed 5"] {
            assert!(text(false).contains(part), "{part} is missing in {}", text(false));
        }
        assert!(!text(true).contains("coherence"), "on a still it means nothing");
        assert!(look(None, &options, &Status::default())[0].contains("my look"));
    }

    #[test]
    fn state_and_time_are_said() {
        let status = Status { length: Some(65.04), position: 3.25, ..Status::default() };
        assert_eq!(clock(&status), "0:03.2 / 1:05.0");
        assert_eq!(state(&status), "playing");
        assert_eq!(state(&Status { paused: true, ..status.clone() }), "paused");
        assert_eq!(state(&Status { exporting: Some(0.5), ..status }), "exporting 50 %");
    }
}
