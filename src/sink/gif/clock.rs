//! Rounds the times of frames to hundredths of a second.

use crate::frame::Rational;
use crate::stream::{Span, StreamInfo};

/// The shortest delay that browsers use; they replace shorter ones by ten hundredths.
const SHORTEST: i64 = 2;

/// The warning for a stream with more frames a second than a GIF can have.
pub(super) fn too_fast(info: &StreamInfo) -> Option<String> {
    let mean = || Some(Rational::new(info.frames?.try_into().ok()?, 1) * info.duration?.recip()?);
    let rate = info.rate.or_else(mean)?;
    let most = Rational::new(100 / SHORTEST, 1);
    (rate > most && info.format != "gif" && !info.still).then(|| {
        format!(
            "viewers show at most {most} frames a second of a GIF, and these are {:.4}: some frames are \
             left out, so that it keeps its length",
            rate.to_f64()
        )
        .replace(".0000", "")
    })
}

/// Rounds durations to hundredths, and carries the difference over to the next frame. Of more frames than a GIF can
/// show, some are dropped evenly: those that remain all have the [`SHORTEST`] delay.
#[derive(Debug)]
pub(super) struct Clock {
    /// Whether whole hundredths are not changed, 0 and 1 included: those of a GIF were chosen by its author.
    exact: bool,
    /// The exact and the rounded start of the next frame, in hundredths.
    due: Rational,
    written: i64,
    last: Rational,
}

impl Clock {
    /// A clock for a stream that was a GIF or not.
    pub(super) fn new(exact: bool) -> Self {
        // Browsers use a tenth of a second for frames without a duration.
        Self { exact, due: Rational::ZERO, written: 0, last: Rational::new(10, 1) }
    }

    /// Whether the frame of span `next` must be dropped, because it would start too late by more than half of
    /// [`SHORTEST`], if the one before it were shown for that long; then that is shown for as long as both.
    pub(super) fn merge(&self, waiting: &mut Span, next: Span) -> bool {
        let length = waiting.length.unwrap_or(next.start - waiting.start) * Rational::new(100, 1);
        let whole = length.den == 1 && (self.exact || length.num == 0);
        let long = length >= Rational::new(SHORTEST, 1);
        let late = Rational::new(self.written + SHORTEST, 1) - (self.due + length);
        if whole || long || late <= Rational::new(SHORTEST, 2) {
            return false;
        }
        waiting.length = waiting.length.and_then(|length| Some(length + next.length?));
        true
    }

    /// The delay of a frame before that of span `next`.
    pub(super) fn delay(&mut self, span: Span, next: Option<Span>) -> u16 {
        let length = span.length.or_else(|| next.map(|n| n.start - span.start));
        let length = length.map_or(self.last, |l| (l * Rational::new(100, 1)).max(Rational::ZERO));
        self.last = length;
        self.due = self.due + length;
        let whole = length.den == 1 && (self.exact || length.num == 0 || length.num >= SHORTEST);
        let delay =
            if whole { length.num } else { (rounded(self.due) - self.written).max(SHORTEST) };
        let delay = delay.min(u16::MAX.into());
        self.written += delay;
        delay as u16
    }
}

/// The nearest whole number.
fn rounded(value: Rational) -> i64 {
    (2 * value.num + value.den).div_euclid(2 * value.den)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The delays of frames of these lengths, of a stream that came from a GIF or not.
    fn delays_of(lengths: &[Rational], exact: bool) -> Vec<u16> {
        let mut clock = Clock::new(exact);
        let mut start = Rational::ZERO;
        let (mut delays, mut waiting) = (Vec::new(), None::<Span>);
        for &length in lengths {
            let span = Span { start, length: Some(length) };
            start = start + length;
            if waiting.as_mut().is_some_and(|waiting| clock.merge(waiting, span)) {
                continue;
            }
            delays.extend(waiting.map(|waiting| clock.delay(waiting, Some(span))));
            waiting = Some(span);
        }
        delays.extend(waiting.map(|waiting| clock.delay(waiting, None)));
        delays
    }

    fn delays(lengths: &[Rational]) -> Vec<u16> {
        delays_of(lengths, false)
    }

    fn sum(delays: &[u16]) -> u32 {
        delays.iter().map(|&d| u32::from(d)).sum()
    }

    #[test]
    fn whole_hundredths_of_a_gif_come_out_exactly() {
        let lengths = [0, 1, 2, 7, 500, 0].map(|d| Rational::new(d, 100));
        assert_eq!(delays_of(&lengths, true), [0, 1, 2, 7, 500, 0]);
    }

    #[test]
    fn rounding_is_carried_so_that_the_total_is_right() {
        assert_eq!(delays(&[Rational::new(1, 30); 6]), [3, 4, 3, 3, 4, 3]);
        assert_eq!(sum(&delays(&vec![Rational::new(1001, 24000); 2400])), 10010);
    }

    #[test]
    fn above_fifty_frames_a_second_some_are_left_out_and_the_length_stays() {
        for (rate, seconds) in [(60, 3), (100, 1), (120, 3), (144, 2), (75, 1), (1000, 1)] {
            let delays = delays(&vec![Rational::new(1, rate); (rate * seconds) as usize]);
            // One delay for all: fifty frames a second.
            assert!(delays.iter().all(|&d| d == 2), "{rate}: {delays:?}");
            // The last one is shown for the shortest time at least.
            assert!(sum(&delays).abs_diff(100 * seconds as u32) <= 2, "{rate}: {}", sum(&delays));
            assert!(delays.len() as i64 >= 50 * seconds - 1, "{rate}: {} frames", delays.len());
        }
        assert_eq!(delays(&[Rational::new(1, 60); 6]), [2; 5]);
    }

    #[test]
    fn up_to_fifty_frames_a_second_none_is_left_out() {
        for rate in [Rational::new(50, 1), Rational::new(48, 1), Rational::new(30000, 1001)] {
            let length = rate.recip().expect("not 0");
            assert_eq!(delays(&vec![length; 500]).len(), 500, "{rate}");
        }
    }

    #[test]
    fn frames_without_length_last_until_the_next_one() {
        let mut clock = Clock::new(false);
        let span = |s| Span { start: Rational::new(s, 100), length: None };
        assert_eq!(clock.delay(span(0), Some(span(12))), 12);
        assert_eq!(clock.delay(span(12), None), 12, "the last one as long as the one before");
    }

    #[test]
    fn the_user_is_told_of_frames_that_are_left_out() {
        let mut info = StreamInfo::of(crate::geom::Size::new(8, 8));
        assert_eq!(too_fast(&info), None);
        info.rate = Some(Rational::new(60, 1));
        assert!(too_fast(&info).is_some_and(|text| text.contains("these are 60:")));
        info.format = "gif".into();
        assert_eq!(too_fast(&info), None);
    }
}
