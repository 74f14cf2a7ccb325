//! When a frame of a file is due: arithmetic on given times, without a clock.

use std::time::Duration;

use polyreel::stream::Span;

/// The longest delay of a frame that playback catches up with; after a longer stall it goes on from there.
const SLIP: Duration = Duration::from_secs(1);

/// Duration of a frame of unknown duration.
const UNKNOWN: f64 = 1.0 / 25.0;

/// The longest duration of a frame.
const LONGEST: f64 = 3600.0;

/// Keeps the distance between frames by their timestamps.
#[derive(Clone, Debug, Default)]
pub(super) struct Pace {
    /// When the last frame was due, and its time in the stream.
    last: Option<(Duration, Span)>,
}

impl Pace {
    /// When the frame of `span` is due: at once, if it is the first; else as long after the last one as its timestamp
    /// says. `now` is the current time.
    pub(super) fn due(&self, span: &Span, now: Duration) -> Duration {
        let Some((at, last)) = &self.last else { return now };
        let due = *at + step(last, span);
        if now.saturating_sub(due) > SLIP { now } else { due }
    }

    /// The frame of `span` was due at `due`, shown or not.
    pub(super) fn mark(&mut self, due: Duration, span: Span) {
        self.last = Some((due, span));
    }

    /// The next frame is due at once: after a pause, a jump, a step.
    pub(super) fn forget(&mut self) {
        self.last = None;
    }
}

/// The time from the frame of `last` to that of `next`. Where the stream has begun again it is the
/// length of `last`.
pub(super) fn step(last: &Span, next: &Span) -> Duration {
    let apart = (next.start - last.start).to_f64();
    let length = last.length.map_or(0.0, |length| length.to_f64());
    let seconds = [apart, length].into_iter().find(|&s| s > 0.0).unwrap_or(UNKNOWN);
    Duration::from_secs_f64(seconds.min(LONGEST))
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::frame::Rational;

    fn span(frame: i64) -> Span {
        let length = Rational::new(1, 24);
        Span { start: Rational::new(frame, 24), length: Some(length) }
    }

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn frames_keep_their_distance_however_late_one_was() {
        let mut pace = Pace::default();
        assert_eq!(pace.due(&span(7), ms(500)), ms(500), "the first one is due at once");
        pace.mark(ms(500), span(7));
        // Asked 20 ms before and 30 ms after, the answer is the same.
        for now in [520, 570] {
            assert_eq!(pace.due(&span(8), ms(now)).as_micros(), 541_666);
        }
        // A frame that was left out counts.
        assert_eq!(pace.due(&span(10), ms(600)), ms(625));
    }

    #[test]
    fn a_minute_of_film_takes_a_minute() {
        let mut pace = Pace::default();
        let mut due = ms(0);
        for frame in 0..=24 * 60 {
            due = pace.due(&span(frame), due);
            pace.mark(due, span(frame));
        }
        assert!(due.abs_diff(ms(60_000)) < ms(1), "{due:?}");
    }

    #[test]
    fn the_next_round_follows_the_last_frame() {
        let mut pace = Pace::default();
        pace.mark(ms(1000), span(23));
        assert_eq!(pace.due(&span(0), ms(1000)).as_micros(), 1_041_666);
        let unknown = Span { start: Rational::ZERO, length: None };
        pace.mark(ms(1000), unknown);
        assert_eq!(pace.due(&unknown, ms(1000)), ms(1040));
    }

    #[test]
    fn after_a_stall_time_slips() {
        let mut pace = Pace::default();
        pace.mark(ms(0), span(0));
        assert_eq!(pace.due(&span(1), ms(900)).as_micros(), 41_666);
        assert_eq!(pace.due(&span(1), ms(9000)), ms(9000));
        pace.forget();
        assert_eq!(pace.due(&span(1), ms(50)), ms(50));
    }
}
