//! Follows the number of points that the frames of a stream ask for, slowly.

use super::content;
use crate::frame::Frame;

/// Frames from one look to the next.
const EVERY: u32 = 4;

/// How far a look draws the smoothed number, on a scale of logarithms.
const SHARE: f64 = 0.12;

/// The farthest that a look can see, so that a flash of one colour draws no more than a change does.
const MOST: f64 = 1.0;

/// The number is changed when the smoothed one has left it by this factor: a change makes a mesh anew, which is seen.
const FACTOR: f64 = 1.3;

/// Frames between two changes at least.
const PATIENCE: u32 = 24;

/// The number of points of a shot. It begins with that of the first frame, follows a change of the content that stays,
/// and ignores one that does not.
#[derive(Clone, Debug, Default)]
pub(super) struct Abstraction {
    /// The number, and the logarithm of the smoothed one; `None` before the first frame.
    now: Option<(u32, f64)>,
    /// Frames since the shot began, and since the number last changed.
    frames: u32,
    since: u32,
}

impl Abstraction {
    /// The number for the next `frame`, if it is another one than before; `is_fresh` says that a shot begins.
    pub(super) fn next(&mut self, frame: &Frame, is_fresh: bool) -> Option<u32> {
        let Some((count, smoothed)) = self.now.filter(|_| !is_fresh) else {
            let count = content::points(frame);
            *self = Self { now: Some((count, f64::from(count).ln())), frames: 0, since: 0 };
            return Some(count);
        };
        self.frames = self.frames.wrapping_add(1);
        self.since = self.since.saturating_add(1);
        if !self.frames.is_multiple_of(EVERY) {
            return None;
        }
        self.follow(count, smoothed, content::points(frame))
    }

    /// Takes in that a frame asks for `wanted` points.
    fn follow(&mut self, count: u32, smoothed: f64, wanted: u32) -> Option<u32> {
        let far = (f64::from(wanted).ln() - smoothed).clamp(-MOST, MOST);
        let smoothed = smoothed + SHARE * far;
        let off = (smoothed - f64::from(count).ln()).abs();
        if off < FACTOR.ln() || self.since < PATIENCE {
            self.now = Some((count, smoothed));
            return None;
        }
        let count = smoothed.exp().round().max(1.0) as u32;
        self.now = Some((count, smoothed));
        self.since = 0;
        Some(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The changes of the number over looks at frames that ask for `wanted`.
    fn changes(wanted: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut abstraction = Abstraction::default();
        let mut found = Vec::new();
        for wanted in wanted {
            let Some((count, smoothed)) = abstraction.now else {
                abstraction.now = Some((wanted, f64::from(wanted).ln()));
                continue;
            };
            abstraction.since += EVERY;
            found.extend(abstraction.follow(count, smoothed, wanted));
        }
        found
    }

    #[test]
    fn what_comes_and_goes_changes_nothing() {
        // Up and down by a third, fast or slow, and a flash.
        assert!(changes((0..400).map(|i| 1000 + 300 * (i % 2))).is_empty());
        let wave = |i: u32| (1000.0 * (0.25 * f64::from(i) / 20.0).sin().mul_add(0.2, 1.0)) as u32;
        assert!(changes((0..400).map(wave)).is_empty());
        assert!(changes((0..100).map(|i| if i == 50 { 24 } else { 1000 })).is_empty());
    }

    #[test]
    fn what_stays_is_followed_in_few_steps_without_overshoot() {
        let found = changes((0..200).map(|i| if i < 20 { 800 } else { 2400 }));
        assert!((2..=5).contains(&found.len()), "{found:?}");
        assert!(found.is_sorted() && found.iter().all(|&n| n <= 2400), "{found:?}");
        assert!(found.last().is_some_and(|&n| n > 1800), "{found:?}");
    }
}
