//! Expected times, from the last ones.

/// The share of the difference by which the mean follows a longer and a shorter time. It rises fast, to react to load
/// at the next frame, and falls slowly, since load may come back at once.
const RISE: f64 = 0.5;
const FALL: f64 = 0.125;

/// How fast the mean deviation follows.
const SPREAD: f64 = 0.125;

/// Mean deviations that are added to the mean for an expected time. The mean itself is nearer to the long times,
/// since it rises faster than it falls.
const CAUTION: f64 = 1.5;

/// The time of one kind of work, smoothed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    mean: f64,
    deviation: f64,
}

impl Pace {
    /// Whether a time is known.
    pub(super) fn is_known(&self) -> bool {
        self.mean > 0.0
    }

    /// Takes a `time` into the mean and the deviation.
    pub(super) fn learn(&mut self, time: f64) {
        if !self.is_known() {
            self.mean = time;
            return;
        }
        let off = time - self.mean;
        // An outlier counts as at most twice the mean.
        let distance = off.abs().min(self.mean);
        self.deviation += (distance - self.deviation) * SPREAD;
        self.mean += off.min(self.mean) * if off > 0.0 { RISE } else { FALL };
    }

    /// The mean; 0 before any time is known.
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }

    /// A bound that nearly all times stay below; 0 before any time is known.
    pub(super) fn careful(&self) -> f64 {
        self.mean + CAUTION * self.deviation
    }
}
