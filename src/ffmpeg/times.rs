//! When a file and its streams begin and end, from ffprobe's fields.

use std::path::Path;

use serde_json::Value;

use super::command::{is_camera, is_url};
use super::fields::{clock, decimal, fraction, text};
use super::formats::is_list;
use super::tracks::tag;
use crate::frame::Rational;

/// Start time of a stream in seconds, by the container's clock.
pub(super) fn begin(stream: &Value) -> Option<Rational> {
    let start = stream["start_pts"].as_i64()?;
    Some(Rational::new(start, 1) * text(stream, "time_base").and_then(fraction)?)
}

/// Start time of the first stream in seconds, by the container's clock.
pub(super) fn origin(answer: &Value) -> Rational {
    text(&answer["format"], "start_time").and_then(decimal).unwrap_or(Rational::ZERO)
}

/// The container's time that becomes time 0. The container's clock is kept if it starts within a second of 0: a small
/// offset is an encoder's delay, and is intended. A clock that starts anywhere, as in MPEG-TS, is shifted to 0.
pub(super) fn zero(answer: &Value) -> Rational {
    let origin = origin(answer);
    let one = Rational::new(1, 1);
    if origin > -one && origin < one { Rational::ZERO } else { origin }
}

/// End of the video stream in seconds after time 0, if the container has it for this stream.
pub(super) fn promised_end(
    answer: &Value,
    stream: &Value,
    time_base: Rational,
) -> Option<Rational> {
    let zero = zero(answer);
    let scale = |ticks: i64| Rational::new(ticks, 1) * time_base;
    if let Some(duration) = stream["duration_ts"].as_i64().filter(|d| *d > 0) {
        let start = scale(stream["start_pts"].as_i64().unwrap_or(0));
        return Some(start + scale(duration) - zero);
    }
    tag(stream, "DURATION").and_then(clock).map(|end| end - zero)
}

/// Whether the input is live: a camera, or a network stream without an end. A network file of known size is not
/// live, even without a duration.
pub(super) fn is_live(path: &Path, answer: &Value) -> bool {
    let format = &answer["format"];
    let sized = text(format, "size").and_then(|size| size.parse::<u64>().ok()).unwrap_or(0) > 0;
    let container = text(format, "format_name").unwrap_or("unknown");
    let finished = text(format, "duration").is_some() || sized && !is_list(container);
    is_camera(path) || is_url(path) && !finished
}
