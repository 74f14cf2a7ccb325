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
    /// Takes note of a time.
    pub(super) fn learn(&mut self, time: f64) {
        if self.mean == 0.0 {
            self.mean = time;
            return;
        }
        let off = time - self.mean;
        // One time far out tells no more than that it was long.
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

/// Share of what was known that is left after a frame: some thirty frames count.
const KEPT: f64 = 0.97;

/// What is taken for the time before the first step, in steps, until times at different numbers of
/// steps tell. Measured at 0.8 % seeds.
const SETUP_STEPS: f64 = 1.5;

/// The weight of that in frames.
const PRIOR: f64 = 0.5;

/// The setup, in steps, that is believed.
const SETUPS: (f64, f64) = (0.25, 8.0);

/// A time that is so many times as long as expected counts as no longer than this for the line's shape.
const FAR_OUT: f64 = 2.0;

/// Time as a line over the number of refinement steps: its shape from the last thirty frames by least
/// squares, its level from the last few.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    /// Decaying sums of 1, n, n^2, time, n time.
    sums: [f64; 5],
    setup: f64,
    step: f64,
    /// Times as shares of what the line says.
    level: Pace,
}

impl Line {
    /// Takes note of a frame with `steps`.
    pub(super) fn learn(&mut self, steps: f64, time: f64) {
        let first = !self.is_known();
        let told = self.setup + self.step * steps;
        // The line's shape is not to be bent by one time far out.
        let taken = if first { time } else { time.min(FAR_OUT * told * self.pace()) };
        let terms = [1.0, steps, steps * steps, taken, steps * taken];
        for (sum, term) in self.sums.iter_mut().zip(terms) {
            *sum = *sum * KEPT + term;
        }
        if !first {
            self.level.learn(time / told);
        }
        self.fit();
        if first {
            self.level.learn(1.0);
        }
    }

    /// Least squares, drawn towards a setup of [`SETUP_STEPS`]: adds their difference squared.
    fn fit(&mut self) {
        let [n, sum, squares, time, product] = self.sums;
        let a = n + PRIOR;
        let b = sum - PRIOR * SETUP_STEPS;
        let c = squares + PRIOR * SETUP_STEPS * SETUP_STEPS;
        let determinant = a * c - b * b;
        let (mut setup, mut step) =
            ((c * time - b * product) / determinant, (a * product - b * time) / determinant);
        // Noise can turn the line: then only its height at the mean number of steps is believed.
        let (least, most) = SETUPS;
        if !(step > 0.0 && (least..=most).contains(&(setup / step))) {
            let ratio = if step > 0.0 { (setup / step).clamp(least, most) } else { most };
            step = time / (n * ratio + sum);
            setup = step * ratio;
        }
        (self.setup, self.step) = (setup.max(1e-9), step.max(1e-9));
    }

    /// The work of a step has become `by` times what it was. The setup has more to do with pixels.
    pub(super) fn scale(&mut self, by: f64) {
        let squares = self.sums[2];
        let [n, sum, _, time, product] = &mut self.sums;
        // As if all steps had been so from the beginning, and half of the setup.
        let (setup, step) = (self.setup * (1.0 + by) / 2.0, self.step * by);
        *time = setup * *n + step * *sum;
        *product = setup * *sum + step * squares;
        (self.setup, self.step) = (setup, step);
    }

    pub(super) fn is_known(&self) -> bool {
        self.step > 0.0
    }

    /// Seconds of a step at a pace of 1.
    pub(super) fn step(&self) -> f64 {
        self.step
    }

    /// Times as they are, for the line's.
    pub(super) fn pace(&self) -> f64 {
        self.level.mean()
    }

    /// What nearly all frames stay below, for the line's times.
    pub(super) fn careful_pace(&self) -> f64 {
        self.level.careful()
    }

    /// What nearly all frames with `steps` stay below; 0 before anything is known.
    pub(super) fn careful(&self, steps: f64) -> f64 {
        (self.setup + self.step * steps) * self.level.careful()
    }
}
