//! Chooses how much detail a frame gets within a time budget, from the times of the frames before it.
//!
//! Pure arithmetic: nothing here reads a clock. Three threads are governed: level one; the mesh (sample,
//! triangulate, refine); the rasteriser. Each asks for its detail just before it starts a frame, and reports the time
//! afterwards, so that frames that wait in channels get a detail by the newest times.
//!
//! The ladder, from the top down:
//! 1. refinement, from more steps than were requested down to an eighth of a step. Part of a step visits that share
//!    of the vertices, so that some refinement nearly always fits, and its time is known for the next frame;
//! 2. work without visible effect: mean colours from every second, then every fourth row; the feature map of a fresh
//!    mesh at half the size; motion found in every second frame only;
//! 3. seeds, from 100 to 25 per cent, while an eighth of a step or the painting does not fit;
//! 4. the last eighth of a step; then as many seeds as fit, since without steps many are better than few.
//!
//! The number of steps falls at once when they are expected to take more than [`HIGH`] of the budget. It rises when
//! more steps would have taken less than [`LOW`] of it for [`PATIENCE`] frames. Everything else waits longer. The gap
//! between the two thresholds (hysteresis) keeps the detail from oscillating.

mod change;
mod pace;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::options::{EIGHTHS, Look, Steps};
pub use change::Change;
use change::change;
use pace::Pace;

/// The share of the budget above which the expected time leads to less detail.
pub const HIGH: f64 = 0.9;

/// The share of the budget below which the expected time of more detail must stay.
pub const LOW: f64 = 0.8;

/// Frames in a row for which more steps must have fitted before there are more.
pub const PATIENCE: u32 = 8;

/// The same for work without visible effect, and for seeds, whose change costs a new triangulation.
const LONG_PATIENCE: u32 = 24;
const SEED_PATIENCE: u32 = 48;

/// Frames in a row in which an eighth of a step, or the painting, did not fit, before the number of seeds is lowered.
/// Frames in which not even the mean of the last times fits count [`BADLY`]-fold.
const STARVED: u32 = 24;
const BADLY: u32 = 3;

/// Frames without refinement after which an eighth of a step is tried again. If that fails, only two frames in this
/// many are late.
const RETRY: u32 = 96;

/// The most refinement steps of a frame with a carried mesh, where the user gives no number. More have no visible
/// effect: in a few frames they add up to those of a still.
pub const MOST_STEPS: u32 = 12;

/// Per cent of the seeds, falling.
pub const SEEDS: [u32; 5] = [100, 70, 50, 35, 25];

/// Distance of the rows that colours are taken from, and about the share of the rasteriser's time that is left.
const ROWS: [(u32, f64); 3] = [(1, 1.0), (2, 0.8), (4, 0.7)];

/// Margin for the time of work that is done once in a shot: its deviation is not known.
const FEW_KNOWN: f64 = 1.25;

/// About the share of the time that features of a fresh mesh take at half the size.
const HALF: f64 = 0.4;

/// Time of a step on a fresh mesh, where all vertices move, divided by that on a carried mesh.
const FRESH_STEP: f64 = 1.5;

/// Time of the work before the first step, in steps. Measured at 0.8 % seeds: 0.4 at 1920x1080, 0.9 at 960x540
/// (`cargo bench -p polyreel-bench --bench costs`: refinement with no step and with one). The pace, which is learnt
/// from whole frames, corrects the difference.
const SETUP: f64 = 0.75;

/// Eighths of a step for the first frames, before any time is known.
const FIRST: u32 = EIGHTHS;

/// Chooses the detail of each frame.
#[derive(Clone, Debug)]
pub struct Governor {
    /// Seconds.
    budget: f64,
    mesh: MeshThread,
    paint: PaintThread,
    look: LookThread,
    /// Index in [`SEEDS`].
    seeds: usize,
    starved: u32,
    rich: u32,
    /// Since the last [`Governor::take_changes`].
    changes: Vec<Change>,
}

/// Sample, triangulate, refine.
#[derive(Clone, Debug, Default)]
struct MeshThread {
    /// Time of a step with all seeds, on a carried mesh.
    pace: Pace,
    /// Time of a fresh mesh in addition to its steps, in steps; 0 before there was one.
    fresh: f64,
    /// Eighths of a step; `None` before anything is known.
    eighths: Option<u32>,
    patience: u32,
    /// Frames without any refinement.
    idle: u32,
    /// Whether the next frame is the first with refinement after those. It takes longer than later ones, because all
    /// vertices are active and the other threads are ahead: its time is not learnt.
    is_resuming: bool,
}

#[derive(Clone, Debug, Default)]
struct PaintThread {
    /// Time with all rows.
    pace: Pace,
    /// Index in [`ROWS`].
    rung: usize,
    patience: u32,
}

#[derive(Clone, Debug, Default)]
struct LookThread {
    /// Time to find the motion.
    watch: Pace,
    /// Time of a fresh mesh's features at the full size.
    fresh: Pace,
    half: bool,
    /// Whether motion is found in every second frame only.
    pausing: bool,
    /// Whether it was not found in the last frame.
    paused: bool,
    patience: u32,
}

/// Eighths of a step as steps.
fn steps(eighths: u32) -> f64 {
    f64::from(Steps::from_eighths(eighths))
}

/// Time of a frame with this many `eighths` of a step, in steps with all seeds. Without refinement it is about 0.
fn work(seeds: u32, eighths: u32) -> f64 {
    let share = f64::from(seeds) / 100.0;
    // Half of the setup has more to do with pixels.
    if eighths == 0 { 0.0 } else { SETUP * (1.0 + share) / 2.0 + share * steps(eighths) }
}

impl Governor {
    /// A governor that keeps each thread's time for a frame within `budget`.
    pub fn new(budget: Duration) -> Self {
        Self {
            // In a budget of 0 nothing fits; above 0 no division fails.
            budget: budget.as_secs_f64().max(1e-9),
            mesh: MeshThread::default(),
            paint: PaintThread::default(),
            look: LookThread::default(),
            seeds: 0,
            starved: 0,
            rich: 0,
            changes: Vec::new(),
        }
    }

    /// The changes of detail since the last call.
    pub fn take_changes(&mut self) -> Vec<Change> {
        std::mem::take(&mut self.changes)
    }

    /// How closely level one looks at the next frame.
    pub fn look(&mut self) -> Look {
        let LookThread { watch, fresh, half, pausing, paused, patience } = &mut self.look;
        // The deviation of a few times is not known.
        let expected = FEW_KNOWN * fresh.careful();
        if !*half && expected > HIGH * self.budget {
            *half = true;
            self.changes.push(change("map", 1.0, 2.0, expected, self.budget));
        } else if *half && expected <= LOW * self.budget {
            *half = false;
            self.changes.push(change("map", 2.0, 1.0, expected, self.budget));
        }
        let expected = watch.careful();
        if !*pausing && expected > HIGH * self.budget {
            (*pausing, *patience) = (true, 0);
            self.changes.push(change("motion", 1.0, 2.0, expected, self.budget));
        } else if *pausing {
            *patience = if expected <= LOW * self.budget { *patience + 1 } else { 0 };
            if *patience >= LONG_PATIENCE {
                *pausing = false;
                self.changes.push(change("motion", 2.0, 1.0, expected, self.budget));
            }
        }
        *paused = *pausing && !*paused;
        match (*paused, *half) {
            (true, _) => Look::Reuse,
            (false, true) => Look::Half,
            (false, false) => Look::Full,
        }
    }

    /// Records the `time` of level one for a frame. `look` is how closely it looked; `fresh` says that the frame
    /// needed a fresh mesh.
    pub fn looked(&mut self, look: Look, fresh: bool, time: Duration) {
        let seconds = time.as_secs_f64();
        match (look, fresh) {
            (Look::Full, true) => self.look.fresh.learn(seconds),
            (_, true) => self.look.fresh.learn(seconds / HALF),
            (Look::Reuse, false) => {}
            (_, false) => self.look.watch.learn(seconds),
        }
    }

    /// Seeds (per cent) and refinement steps of the next frame. `requested` steps are done without a budget, and
    /// `most` at most; where none is requested, none is done. `fresh` says that the frame needs a fresh mesh.
    pub fn mesh(&mut self, requested: u32, most: u32, fresh: bool) -> (u32, Steps) {
        let before = self.seeds;
        let most = if requested == 0 { 0 } else { most.saturating_mul(EIGHTHS) };
        if !fresh {
            self.choose_seeds(most.min(1));
        }
        let eighths = if fresh || before != self.seeds {
            self.fresh_steps(most)
        } else {
            self.next_steps(most)
        };
        (SEEDS[self.seeds], Steps::from_eighths(eighths))
    }

    /// Records the `time` of the mesh thread for a frame with this many refinement `steps`.
    pub fn meshed(&mut self, fresh: bool, steps: Steps, time: Duration) {
        let (seeds, mesh, seconds) = (SEEDS[self.seeds], &mut self.mesh, time.as_secs_f64());
        if !fresh {
            // A frame without steps is not prepared for them either: its time says nothing about steps.
            if steps > Steps::default() && !std::mem::take(&mut mesh.is_resuming) {
                mesh.pace.learn(seconds / work(seeds, steps.eighths()));
            }
            return;
        }
        let steps = f64::from(steps);
        let overhead = if mesh.pace.is_known() {
            (seconds / mesh.pace.mean() - FRESH_STEP * steps).max(0.0)
        } else {
            // A guess: a step takes as long as all work before it.
            1.0
        };
        mesh.fresh = if mesh.fresh > 0.0 { (mesh.fresh + overhead) / 2.0 } else { overhead };
    }

    /// Distance of the rows that colours are taken from in the next frame.
    pub fn rows(&mut self) -> u32 {
        let paint = &mut self.paint;
        let expected = |rung: usize| paint.pace.careful() * ROWS[rung].1;
        let (now, before) = (expected(paint.rung), paint.rung);
        if now > HIGH * self.budget {
            let last = ROWS.len() - 1;
            paint.rung = (before..last).find(|&r| expected(r) <= LOW * self.budget).unwrap_or(last);
            paint.patience = 0;
        } else if before > 0 {
            let fits = expected(before - 1) <= LOW * self.budget;
            paint.patience = if fits { paint.patience + 1 } else { 0 };
            if paint.patience >= LONG_PATIENCE {
                (paint.rung, paint.patience) = (before - 1, 0);
            }
        }
        let (from, to) = (ROWS[before].0, ROWS[paint.rung].0);
        if from != to {
            self.changes.push(change("rows", f64::from(from), f64::from(to), now, self.budget));
        }
        to
    }

    /// Records the `time` of the rasteriser for a frame with colours from every `rows`-th row.
    pub fn painted(&mut self, rows: u32, time: Duration) {
        let share = ROWS.iter().find(|(r, _)| *r == rows).map_or(1.0, |(_, share)| *share);
        self.paint.pace.learn(time.as_secs_f64() / share);
    }

    /// Eighths of a step for a carried mesh.
    fn next_steps(&mut self, most: u32) -> u32 {
        if most == 0 {
            return 0;
        }
        let (seeds, mesh, budget) = (SEEDS[self.seeds], &mut self.mesh, self.budget);
        let before = mesh.eighths.unwrap_or(FIRST).min(most);
        let careful = mesh.pace.careful();
        let expected = careful * work(seeds, before);
        let fits = |n: &u32| careful * work(seeds, *n) <= LOW * budget;
        let mut eighths = before;
        if before == 0 {
            mesh.idle += 1;
            if mesh.idle >= RETRY {
                // The known times are too old: the frame after this one gives a new one.
                (mesh.pace, mesh.is_resuming) = (Pace::default(), true);
                (eighths, self.starved) = (1, STARVED - BADLY);
            }
        } else if expected > HIGH * budget {
            (eighths, mesh.patience) = ((1..before).rev().find(fits).unwrap_or(1), 0);
        } else if before < most && mesh.pace.is_known() {
            // At most twice as much: twelve steps are reached in a few rounds, and no round overshoots far.
            let more = (2 * before).min(most);
            let fitting = (before + 1..=more).rev().find(fits);
            mesh.patience = if fitting.is_some() { mesh.patience + 1 } else { 0 };
            if let Some(fitting) = fitting.filter(|_| mesh.patience >= PATIENCE) {
                (eighths, mesh.patience) = (fitting, 0);
            }
        }
        let known = mesh.eighths.replace(eighths).is_some();
        if known && eighths != before {
            self.changes.push(change("steps", steps(before), steps(eighths), expected, budget));
        }
        eighths
    }

    /// Eighths of a step for a fresh mesh: as many as fit in addition to its other work. The frames after it make up
    /// for the others.
    fn fresh_steps(&self, most: u32) -> u32 {
        let mesh = &self.mesh;
        if mesh.fresh == 0.0 || !mesh.pace.is_known() {
            return FIRST.min(most);
        }
        let time = |n: u32| (mesh.fresh + FRESH_STEP * steps(n)) * mesh.pace.careful();
        (0..=most).rev().find(|&n| FEW_KNOWN * time(n) <= HIGH * self.budget).unwrap_or(0)
    }

    /// Chooses the number of seeds. It falls where the `least` refinement or the painting has not fitted for long. It
    /// rises where more seeds have fitted for long, or where even the fewest did not help.
    fn choose_seeds(&mut self, least: u32) {
        if self.mesh.eighths.is_some_and(|n| n > 0) && !self.mesh.pace.is_known() {
            return;
        }
        let (budget, before, last) = (self.budget, self.seeds, SEEDS.len() - 1);
        let growth = |seeds: usize| f64::from(SEEDS[seeds]) / f64::from(SEEDS[before]);
        // An upper bound: all of the time is taken to grow with the seeds.
        let [paint, paint_mean] = [self.paint.pace.careful(), self.paint.pace.mean()]
            .map(|time| time * ROWS[self.paint.rung].1);
        let paint_fits = |seeds: &usize| paint * growth(*seeds) <= LOW * budget;
        let busy = self.mesh.eighths != Some(0);
        let pace = if busy { self.mesh.pace } else { Pace::default() };
        let mesh = |seeds: usize, eighths: u32| pace.careful() * work(SEEDS[seeds], eighths);
        let expected = mesh(before, least);
        let (mesh_starves, paint_starves) = (expected > HIGH * budget, paint > HIGH * budget);
        let badly = (pace.mean() * work(SEEDS[before], least)).max(paint_mean) > HIGH * budget;
        let more_starved = self.starved + if badly { BADLY } else { 1 };
        self.starved = if mesh_starves || paint_starves { more_starved } else { 0 };
        let more = (0..before).find(|s| paint_fits(s) && mesh(*s, 2 * least) <= LOW * budget);
        self.rich = if more.is_some() { self.rich + 1 } else { 0 };
        let mut seeds = if self.rich >= SEED_PATIENCE { more.unwrap_or(before) } else { before };
        if self.starved >= STARVED {
            let fewer = (before + 1..=last).find(|&s| mesh(s, least) <= LOW * budget);
            // Expected times are too long after a few slow frames: refinement ends only at the fewest seeds.
            if mesh_starves && fewer.is_none() && before == last {
                self.suspend_refinement(expected);
                // Without steps many seeds are better than few.
                seeds = (0..=before).find(paint_fits).unwrap_or(before);
            } else if mesh_starves {
                seeds = fewer.unwrap_or(last);
            }
            if paint_starves {
                seeds = seeds.max((before + 1).min(last));
            }
            self.starved = 0;
        }
        if seeds != before {
            (self.seeds, self.starved, self.rich) = (seeds, 0, 0);
            let [from, to] = [before, seeds].map(|seeds| f64::from(SEEDS[seeds]));
            self.changes.push(change("seeds", from, to, expected.max(paint), budget));
        }
    }

    /// Stops refinement for [`RETRY`] frames: an eighth of a step does not fit.
    fn suspend_refinement(&mut self, expected: f64) {
        let before = self.mesh.eighths.replace(0).unwrap_or(FIRST);
        self.mesh.idle = 0;
        self.changes.push(change("steps", steps(before), 0.0, expected, self.budget));
    }
}
