//! What times are to be expected from those that were.

/// How much of a time above the mean is taken over at once, and of one below: load that comes is to be
/// answered at the next frame, load that goes may have gone for a moment only.
const RISE: f64 = 0.5;
const FALL: f64 = 0.125;

/// How fast the mean deviation follows.
const SPREAD: f64 = 0.125;

/// Mean deviations above the mean that are reckoned with. The mean itself leans towards the long times,
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

    /// Takes note of a time.
    pub(super) fn learn(&mut self, time: f64) {
        if !self.is_known() {
            self.mean = time;
            return;
        }
        let off = time - self.mean;
        // An outlier counts only as a long time.
        let distance = off.abs().min(self.mean);
        self.deviation += (distance - self.deviation) * SPREAD;
        self.mean += off.min(self.mean) * if off > 0.0 { RISE } else { FALL };
    }

    /// The mean; 0 before anything is known.
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }

    /// What nearly all times stay below; 0 before anything is known.
    pub(super) fn careful(&self) -> f64 {
        self.mean + CAUTION * self.deviation
    }
}
