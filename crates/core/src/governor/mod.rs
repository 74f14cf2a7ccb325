//! How much detail a frame can have within a time budget: times in, what the next frame may cost out.
//!
//! Pure arithmetic: nothing here reads a clock. Each of the three governed threads (level one; the mesh:
//! sample, triangulate, refine; the rasteriser) asks before it starts a frame, and reports afterwards
//! how long it took: so whatever waits in the channels is still given what the newest times allow.
//!
//! The ladder, from the top down:
//! 1. refinement, from more steps than were asked for down to an eighth of one. A part of a step is for
//!    that share of the vertices, so that some refinement nearly always fits, and every frame shows what
//!    the next may have;
//! 2. work without visible effect: means of every second, then every fourth row; a fresh mesh's feature map at
//!    half the size; every second frame's motion not looked for;
//! 3. seeds, from 100 to 25 per cent, while not even an eighth of a step fits, or painting does not;
//! 4. the last eighth; then as many seeds as fit, since without steps few of them are worse than many.
//!
//! Steps go down at once when they are expected to take more than [`HIGH`] of the budget, and up when
//! for [`PATIENCE`] frames more of them would have stayed below [`LOW`] of it; everything else waits
//! longer. The gap between the two is what keeps the detail from pumping.

mod change;
mod pace;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::options::{EIGHTHS, Look, Steps};
pub use change::Change;
use change::change;
use pace::Pace;

/// The share of the budget that the expected time may come to before less is done.
pub const HIGH: f64 = 0.9;

/// The share that the expected time may come to where more is to be done.
pub const LOW: f64 = 0.8;

/// Frames for which more must have fitted before more is done.
pub const PATIENCE: u32 = 8;

/// The same for work without visible effect, and for seeds, whose change costs a new triangulation.
const LONG_PATIENCE: u32 = 24;
const SEED_PATIENCE: u32 = 48;

/// Frames in which not even an eighth of a step, or not the painting, must have fitted before seeds are
/// given up; those in which it hardly does by the mean of the last times count [`BADLY`]-fold.
const STARVED: u32 = 24;
const BADLY: u32 = 3;

/// Frames without any refinement after which an eighth of a step is tried: if in vain, two frames of so
/// many take too long.
const RETRY: u32 = 96;

/// The most refinement steps of a frame whose mesh lives on, where the user names no number: in a few
/// frames as many as a still gets, and twelve a frame gain nothing that can be seen.
pub const MOST_STEPS: u32 = 12;

/// Per cent of the seeds, falling.
pub const SEEDS: [u32; 5] = [100, 70, 50, 35, 25];

/// Every how many rows colours are taken from, and about the time that the rasteriser takes then.
const ROWS: [(u32, f64); 3] = [(1, 1.0), (2, 0.8), (4, 0.7)];

/// The margin for what happens once in a shot.
const FEW_KNOWN: f64 = 1.25;

/// About the time that features of a fresh mesh take at half the size.
const HALF: f64 = 0.4;

/// A step on a fresh mesh, where everything still moves, for one on a mesh that lives on.
const FRESH_STEP: f64 = 1.5;

/// What is done before the first step, in steps. Measured at 0.8 % seeds: 0.4 at 1920x1080, 0.9 at
/// 960x540. Where it is another, the pace makes up for it.
const SETUP: f64 = 0.75;

/// The eighths of a step that the first frames get, when nothing is known yet.
const FIRST: u32 = EIGHTHS;

/// Chooses what frames may cost.
#[derive(Clone, Debug)]
pub struct Governor {
    /// Seconds.
    budget: f64,
    mesh: MeshThread,
    paint: PaintThread,
    look: LookThread,
    /// Place in [`SEEDS`].
    seeds: usize,
    starved: u32,
    rich: u32,
    news: Vec<Change>,
}

/// Sample, triangulate, refine.
#[derive(Clone, Debug, Default)]
struct MeshThread {
    /// Time of a step with all seeds, of frames whose mesh lives on.
    pace: Pace,
    /// What a fresh mesh takes in addition to its steps, in steps; 0 before there was one.
    fresh: f64,
    /// Eighths of a step; `None` before anything is known.
    eighths: Option<u32>,
    patience: u32,
    /// Frames without any refinement.
    idle: u32,
    /// The next frame is the first after those: with all vertices awake, and the other threads ahead,
    /// it takes longer than those after it, and says nothing about them.
    waking: bool,
}

#[derive(Clone, Debug, Default)]
struct PaintThread {
    /// Time with all rows.
    pace: Pace,
    /// Place in [`ROWS`].
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
    /// Whether motion is not looked for in every frame.
    pausing: bool,
    /// Whether it was not in the last one.
    paused: bool,
    patience: u32,
}

/// Eighths of a step as steps.
fn steps(eighths: u32) -> f64 {
    f64::from(Steps::from_eighths(eighths))
}

/// What a frame with this many eighths of a step costs, in steps with all seeds. What is done without any
/// is next to nothing.
fn work(seeds: u32, eighths: u32) -> f64 {
    let share = f64::from(seeds) / 100.0;
    // Half of the setup has more to do with pixels.
    if eighths == 0 { 0.0 } else { SETUP * (1.0 + share) / 2.0 + share * steps(eighths) }
}

impl Governor {
    /// A governor that keeps each thread's time for a frame within `budget`.
    pub fn new(budget: Duration) -> Self {
        Self {
            // A budget of nothing is one that nothing fits in.
            budget: budget.as_secs_f64().max(1e-9),
            mesh: MeshThread::default(),
            paint: PaintThread::default(),
            look: LookThread::default(),
            seeds: 0,
            starved: 0,
            rich: 0,
            news: Vec::new(),
        }
    }

    /// What has changed since the last call.
    pub fn take_news(&mut self) -> Vec<Change> {
        std::mem::take(&mut self.news)
    }

    /// How well level one is to look at the next frame.
    pub fn look(&mut self) -> Look {
        let LookThread { watch, fresh, half, pausing, paused, patience } = &mut self.look;
        // A few frames do not show how much they differ.
        let expected = FEW_KNOWN * fresh.careful();
        if !*half && expected > HIGH * self.budget {
            *half = true;
            self.news.push(change("map", 1.0, 2.0, expected, self.budget));
        } else if *half && expected <= LOW * self.budget {
            *half = false;
            self.news.push(change("map", 2.0, 1.0, expected, self.budget));
        }
        let expected = watch.careful();
        if !*pausing && expected > HIGH * self.budget {
            (*pausing, *patience) = (true, 0);
            self.news.push(change("motion", 1.0, 2.0, expected, self.budget));
        } else if *pausing {
            *patience = if expected <= LOW * self.budget { *patience + 1 } else { 0 };
            if *patience >= LONG_PATIENCE {
                *pausing = false;
                self.news.push(change("motion", 2.0, 1.0, expected, self.budget));
            }
        }
        *paused = *pausing && !*paused;
        match (*paused, *half) {
            (true, _) => Look::Reuse,
            (false, true) => Look::Half,
            (false, false) => Look::Full,
        }
    }

    /// Takes note that level one took `time` for a frame, at which it looked so, and whether the mesh
    /// was to begin anew.
    pub fn looked(&mut self, look: Look, fresh: bool, time: Duration) {
        let seconds = time.as_secs_f64();
        match (look, fresh) {
            (Look::Full, true) => self.look.fresh.learn(seconds),
            (_, true) => self.look.fresh.learn(seconds / HALF),
            (Look::Reuse, false) => {}
            (_, false) => self.look.watch.learn(seconds),
        }
    }

    /// Seeds (per cent) and refinement steps of the next frame, for which `asked` steps are done without
    /// a budget and `most` at most; no step is added where none was asked for. `fresh` says that its
    /// mesh begins anew.
    pub fn mesh(&mut self, asked: u32, most: u32, fresh: bool) -> (u32, Steps) {
        let before = self.seeds;
        let most = if asked == 0 { 0 } else { most.saturating_mul(EIGHTHS) };
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

    /// Takes note that the mesh's thread took `time` for a frame with this many refinement steps.
    pub fn meshed(&mut self, fresh: bool, steps: Steps, time: Duration) {
        let (seeds, mesh, seconds) = (SEEDS[self.seeds], &mut self.mesh, time.as_secs_f64());
        if !fresh {
            // Without any steps there is nothing to prepare for them either: that says nothing about them.
            if steps > Steps::default() && !std::mem::take(&mut mesh.waking) {
                mesh.pace.learn(seconds / work(seeds, steps.eighths()));
            }
            return;
        }
        let steps = f64::from(steps);
        let overhead = if mesh.pace.is_known() {
            (seconds / mesh.pace.mean() - FRESH_STEP * steps).max(0.0)
        } else {
            // As if a step took as long as all that is done before it.
            1.0
        };
        mesh.fresh = if mesh.fresh > 0.0 { (mesh.fresh + overhead) / 2.0 } else { overhead };
    }

    /// Every how many rows colours are taken from in the next frame.
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
            self.news.push(change("rows", f64::from(from), f64::from(to), now, self.budget));
        }
        to
    }

    /// Takes note that the rasteriser took `time` for a frame, colours from every `rows`-th row.
    pub fn painted(&mut self, rows: u32, time: Duration) {
        let share = ROWS.iter().find(|(r, _)| *r == rows).map_or(1.0, |(_, share)| *share);
        self.paint.pace.learn(time.as_secs_f64() / share);
    }

    /// Eighths of a step for a mesh that lives on.
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
                // That time says nothing about now; the frame after this one shows it.
                (mesh.pace, mesh.waking) = (Pace::default(), true);
                (eighths, self.starved) = (1, STARVED - BADLY);
            }
        } else if expected > HIGH * budget {
            (eighths, mesh.patience) = ((1..before).rev().find(fits).unwrap_or(1), 0);
        } else if before < most && mesh.pace.is_known() {
            // Twice as much: a dozen steps are reached in some rounds, and one cannot go far wrong.
            let more = (2 * before).min(most);
            let fitting = (before + 1..=more).rev().find(fits);
            mesh.patience = if fitting.is_some() { mesh.patience + 1 } else { 0 };
            if let Some(fitting) = fitting.filter(|_| mesh.patience >= PATIENCE) {
                (eighths, mesh.patience) = (fitting, 0);
            }
        }
        let known = mesh.eighths.replace(eighths).is_some();
        if known && eighths != before {
            self.news.push(change("steps", steps(before), steps(eighths), expected, budget));
        }
        eighths
    }

    /// Eighths of a step for a fresh mesh: as many as fit in addition to its other work, the rest
    /// is made up for in the frames after it.
    fn fresh_steps(&self, most: u32) -> u32 {
        let mesh = &self.mesh;
        if mesh.fresh == 0.0 || !mesh.pace.is_known() {
            return FIRST.min(most);
        }
        let time = |n: u32| (mesh.fresh + FRESH_STEP * steps(n)) * mesh.pace.careful();
        (0..=most).rev().find(|&n| FEW_KNOWN * time(n) <= HIGH * self.budget).unwrap_or(0)
    }

    /// Fewer seeds where for long not even the `least` refinement fits, or painting does not; more where
    /// there is room for long, or where even the fewest did not help.
    fn choose_seeds(&mut self, least: u32) {
        if self.mesh.eighths.is_some_and(|n| n > 0) && !self.mesh.pace.is_known() {
            return;
        }
        let (budget, before, last) = (self.budget, self.seeds, SEEDS.len() - 1);
        let growth = |seeds: usize| f64::from(SEEDS[seeds]) / f64::from(SEEDS[before]);
        // All of it is taken to grow with the seeds, which is more than it does.
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
            // Expectations are high after a few long frames: all seeds are tried before nothing is.
            if mesh_starves && fewer.is_none() && before == last {
                self.rest(expected);
                // Without any steps many seeds are better than few.
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
            self.news.push(change("seeds", from, to, expected.max(paint), budget));
        }
    }

    /// No refinement for a time: not even an eighth of a step fits.
    fn rest(&mut self, expected: f64) {
        let before = self.mesh.eighths.replace(0).unwrap_or(FIRST);
        self.mesh.idle = 0;
        self.news.push(change("steps", steps(before), 0.0, expected, self.budget));
    }
}
