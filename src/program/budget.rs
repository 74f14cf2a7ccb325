//! `--budget`: the time for a frame.

use std::time::Duration;

use polyreel::error::{Error, Result};
use polyreel::frame::Rational;
use polyreel::stream::StreamInfo;

use crate::program::amount;

/// The requested time for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Budget {
    /// This many seconds.
    Time(Rational),
    /// As long as a frame of the source is shown.
    Auto,
}

/// `16ms`, `0.5s` or `auto`. A bare number is refused: 33 might mean either.
pub(crate) fn budget(text: &str) -> Result<Budget, String> {
    if text == "auto" {
        return Ok(Budget::Auto);
    }
    let unit = text.ends_with('s') && !text.contains(':');
    let time = if unit { amount::time(text).ok() } else { None };
    match time.filter(|time| *time > Rational::ZERO && *time <= Rational::new(3600, 1)) {
        Some(time) => Ok(Budget::Time(time)),
        None => Err(format!("'{text}' is not a budget: write 33ms, 0.5s or auto")),
    }
}

impl Budget {
    /// The time for a frame of the input `info`.
    ///
    /// # Errors
    /// When the duration of its frames is unknown.
    pub(crate) fn time(self, info: &StreamInfo) -> Result<Duration> {
        let seconds = match self {
            Budget::Time(time) => Some(time.to_f64()),
            Budget::Auto => frame_time(info),
        };
        let sound = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        sound.filter(|time| !time.is_zero()).ok_or_else(|| {
            Error::usage(
                "the input does not tell how long its frames are shown: write --budget 33ms in place \
                 of auto",
            )
        })
    }
}

/// Seconds for which a frame is shown: by the rate, or on average.
fn frame_time(info: &StreamInfo) -> Option<f64> {
    if info.still {
        return None;
    }
    let by_rate = info.rate.and_then(Rational::recip).map(Rational::to_f64);
    by_rate.or_else(|| {
        let (duration, frames) = info.duration.zip(info.frames)?;
        (frames > 0).then(|| duration.to_f64() / frames as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_have_a_unit() {
        for (text, time) in [
            ("16ms", Rational::new(16, 1000)),
            ("0.5s", Rational::new(1, 2)),
            ("33.3ms", Rational::new(333, 10_000)),
        ] {
            assert_eq!(budget(text), Ok(Budget::Time(time)));
        }
        assert_eq!(budget("auto"), Ok(Budget::Auto));
        for wrong in ["", "33", "0ms", "-1ms", "1:30", "1:30s", "9999s", "soon", "ms"] {
            assert!(budget(wrong).is_err(), "{wrong}");
        }
    }
}
