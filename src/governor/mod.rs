//! How much detail a frame can have within a time budget: times in, what the next frame may cost out.
//!
//! Pure arithmetic: nothing here reads a clock. Each of the three governed threads (level one; the mesh:
//! sample, triangulate, refine; the rasteriser) asks before it takes up a frame, and tells afterwards
//! how long it took: so whatever waits in the channels is still given what the newest times allow.
//!
//! The ladder, from the top down:
//! 1. refinement steps, from more than were asked for down to one;
//! 2. work that nobody sees: means of every second, then every fourth row; a fresh mesh's feature map at
//!    half the size; every second frame's motion not looked for;
//! 3. seeds, from 100 to 25 per cent, while not even one refinement step fits and with fewer it would;
//! 4. the last step; then as many seeds as fit, since without steps few of them are worse than many.
//!
//! Steps go down at once when they are expected to take more than [`HIGH`] of the budget, and up when
//! for [`PATIENCE`] frames more of them would have stayed below [`LOW`] of it; everything else waits
//! longer. The gap between the two is what keeps the detail from pumping.

mod pace;
#[cfg(test)]
mod tests;

use std::time::Duration;

use crate::options::Look;
use pace::{Line, Pace};

/// The share of the budget that the expected time may come to before less is done.
pub const HIGH: f64 = 0.9;

/// The share that the expected time may come to where more is to be done.
pub const LOW: f64 = 0.8;

/// Frames for which more must have fitted before more is done.
pub const PATIENCE: u32 = 8;

/// The same for work that nobody sees, and for seeds, whose change costs a new triangulation.
const LONG_PATIENCE: u32 = 24;
const SEED_PATIENCE: u32 = 48;

/// Frames for which not one step must have fitted before seeds are given up.
const STARVED: u32 = 8;

/// Frames in which steps that were taken up again may settle, and how far above the budget they may
/// be meanwhile.
const SETTLING: u32 = 3;
const FAR_ABOVE: f64 = 1.3;

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

/// How fast steps that do not fit are hoped to fit again: in some hundred frames their expected time
/// halves, and one is tried.
const HOPE: f64 = 0.993;

/// The waiting time doubles with each try in vain, so many times at most.
const MOST_DOUBT: u32 = 4;

/// The steps that the very first frame gets, when nothing is known yet.
const FIRST_STEPS: u32 = 1;

/// A change of detail, and why.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Change {
    /// What was changed: `steps`, `rows`, `map`, `motion` or `seeds`.
    pub what: &'static str,
    /// What it was.
    pub from: u32,
    /// What it is now.
    pub to: u32,
    /// What the frame was expected to take as it was, in milliseconds of the budget's.
    pub expected_ms: f64,
    /// The budget.
    pub budget_ms: f64,
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { what, from, to, expected_ms, budget_ms } = self;
        match *what {
            "steps" => write!(f, "refinement steps {from} -> {to}"),
            "rows" => write!(f, "colours from every {from}. -> {to}. row"),
            "map" => write!(f, "feature map 1/{from} -> 1/{to} of the size"),
            "motion" => write!(f, "motion found in every {from}. -> {to}. frame"),
            _ => write!(f, "{what} {from} % -> {to} %"),
        }?;
        write!(f, ": {expected_ms:.1} ms expected of {budget_ms:.1} ms")
    }
}

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
    /// Time of a frame whose mesh lives on, by steps; it is learnt from those with steps, since without
    /// any there is nothing to prepare for them either.
    line: Line,
    /// The rasteriser's time when it was learnt last. While no steps are done, only the other threads
    /// know whether the machine has got faster.
    others: f64,
    /// What is hoped of steps that were long not tried, 1 and below.
    hope: f64,
    /// Steps were tried in hope and did not fit: hope grows by so much more slowly.
    doubt: u32,
    /// Frames since steps were taken up again.
    since: u32,
    /// What a fresh mesh takes beside its steps, in seconds at a pace of 1; 0 before there was one.
    fresh: f64,
    /// `None` before anything is known.
    steps: Option<u32>,
    patience: u32,
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

/// What nearly all frames with `steps` stay below, when they take `ease` times what `line` says. What is
/// done without any steps is next to nothing.
fn expected(line: &Line, steps: u32, ease: f64) -> f64 {
    if steps == 0 { 0.0 } else { line.careful(f64::from(steps)) * ease }
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
        // Of few frames one cannot tell how much they differ.
        let expected = FEW_KNOWN * fresh.careful();
        if !*half && expected > HIGH * self.budget {
            *half = true;
            self.news.push(change("map", 1, 2, expected, self.budget));
        } else if *half && expected <= LOW * self.budget {
            *half = false;
            self.news.push(change("map", 2, 1, expected, self.budget));
        }
        let expected = watch.careful();
        if !*pausing && expected > HIGH * self.budget {
            (*pausing, *patience) = (true, 0);
            self.news.push(change("motion", 1, 2, expected, self.budget));
        } else if *pausing {
            *patience = if expected <= LOW * self.budget { *patience + 1 } else { 0 };
            if *patience >= LONG_PATIENCE {
                *pausing = false;
                self.news.push(change("motion", 2, 1, expected, self.budget));
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
    pub fn mesh(&mut self, asked: u32, most: u32, fresh: bool) -> (u32, u32) {
        let before = self.seeds;
        if !fresh {
            self.choose_seeds(asked);
        }
        let most = if asked == 0 { 0 } else { most };
        let steps = if fresh || before != self.seeds {
            self.fresh_steps(most)
        } else {
            self.next_steps(asked, most)
        };
        (SEEDS[self.seeds], steps)
    }

    /// Takes note that the mesh's thread took `time` for a frame with so many refinement steps.
    pub fn meshed(&mut self, fresh: bool, steps: u32, time: Duration) {
        let paint = self.paint.pace.mean();
        let (mesh, seconds) = (&mut self.mesh, time.as_secs_f64());
        if !fresh {
            if steps > 0 {
                mesh.line.learn(f64::from(steps), seconds);
                (mesh.others, mesh.hope) = (paint, 1.0);
                mesh.since += 1;
                if mesh.since > SEED_PATIENCE {
                    mesh.doubt = 0;
                }
            } else {
                mesh.hope *= HOPE.powf(1.0 / f64::from(1u32 << mesh.doubt));
            }
            return;
        }
        let steps = f64::from(steps);
        let beside = if mesh.line.is_known() {
            (seconds / mesh.line.pace() - mesh.line.step() * FRESH_STEP * steps).max(0.0)
        } else {
            // As if a step took as long as all that is done before it.
            seconds / (1.0 + steps)
        };
        mesh.fresh = if mesh.fresh > 0.0 { (mesh.fresh + beside) / 2.0 } else { beside };
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
            self.news.push(change("rows", from, to, now, self.budget));
        }
        to
    }

    /// Takes note that the rasteriser took `time` for a frame, colours from every `rows`-th row.
    pub fn painted(&mut self, rows: u32, time: Duration) {
        let share = ROWS.iter().find(|(r, _)| *r == rows).map_or(1.0, |(_, share)| *share);
        self.paint.pace.learn(time.as_secs_f64() / share);
    }

    /// What steps are expected to take, for what they took when they were done last.
    fn ease(&self) -> f64 {
        let (now, then) = (self.paint.pace.mean(), self.mesh.others);
        let others = if then > 0.0 { (now / then).clamp(0.25, 4.0) } else { 1.0 };
        if self.mesh.hope < 1.0 { others * self.mesh.hope } else { 1.0 }
    }

    /// Steps for a mesh that lives on.
    fn next_steps(&mut self, asked: u32, most: u32) -> u32 {
        let ease = self.ease();
        let (mesh, budget) = (&mut self.mesh, self.budget);
        let line = mesh.line;
        let expected = |steps: u32| expected(&line, steps, ease);
        let first = FIRST_STEPS.min(asked);
        let before = mesh.steps.unwrap_or(first).min(most);
        let mut steps = before;
        // The first frames with steps are slower than those after them: while the mesh was quick its
        // neighbours worked ahead, and now they use the cores that it will have when they wait for it.
        let settling = before == 1 && mesh.since < SETTLING;
        let high = if settling { FAR_ABOVE } else { HIGH };
        if expected(before) > high * budget {
            steps = (0..before).rev().find(|&n| expected(n) <= LOW * budget).unwrap_or(0);
            mesh.patience = 0;
        } else if before < most && mesh.line.is_known() {
            // More by half: a dozen is reached in a few rounds, and one round cannot go far wrong.
            let more = (before + (before / 2).max(1)).min(most);
            let fitting = (before + 1..=more).rev().find(|&n| expected(n) <= LOW * budget);
            mesh.patience = if fitting.is_some() { mesh.patience + 1 } else { 0 };
            if let Some(fitting) = fitting.filter(|_| mesh.patience >= PATIENCE) {
                (steps, mesh.patience) = (fitting, 0);
            }
        }
        if before > 0 && steps == 0 && mesh.since <= PATIENCE {
            mesh.doubt = (mesh.doubt + 1).min(MOST_DOUBT);
        }
        mesh.since = if steps == 0 { 0 } else { mesh.since };
        let told = expected(before);
        let known = mesh.steps.replace(steps).is_some();
        if known && steps != before {
            self.news.push(change("steps", before, steps, told, budget));
        }
        steps
    }

    /// Steps for a mesh that begins anew: as many as fit beside what else it takes, the rest is made up
    /// for in the frames after it.
    fn fresh_steps(&self, most: u32) -> u32 {
        let mesh = &self.mesh;
        if mesh.fresh == 0.0 || !mesh.line.is_known() {
            return FIRST_STEPS.min(most);
        }
        let step = mesh.line.step() * FRESH_STEP;
        let time = |steps: u32| (mesh.fresh + step * f64::from(steps)) * mesh.line.careful_pace();
        (0..=most).rev().find(|&n| FEW_KNOWN * time(n) <= HIGH * self.budget).unwrap_or(0)
    }

    /// Fewer seeds where not one step fits for long and it would with fewer; more where there is plenty
    /// of room for long, or where even the fewest did not help.
    fn choose_seeds(&mut self, asked: u32) {
        let (mesh, budget, before) = (&self.mesh, self.budget, self.seeds);
        if !mesh.line.is_known() {
            return;
        }
        let ease = self.ease();
        let step_at = |seeds: usize| {
            let mut line = mesh.line;
            line.scale(f64::from(SEEDS[seeds]) / f64::from(SEEDS[before]));
            expected(&line, asked.min(1), ease)
        };
        let paint = self.paint.pace.careful() * ROWS[self.paint.rung].1;
        let paint_starves = paint > HIGH * budget;
        let mesh_starves = mesh.steps == Some(0) && step_at(before) > LOW * budget;
        self.starved = if paint_starves || mesh_starves { self.starved + 1 } else { 0 };
        let expected = step_at(before).max(paint);
        // All work is taken to grow with the seeds, which is more than it does.
        let growth = |seeds: usize| f64::from(SEEDS[seeds]) / f64::from(SEEDS[before]);
        let fits = |seeds: usize| expected * growth(seeds) <= LOW * budget;
        self.rich = if before > 0 && fits(before - 1) { self.rich + 1 } else { 0 };
        if self.starved >= STARVED {
            let last = SEEDS.len() - 1;
            let helping = (before..=last).find(|&seeds| step_at(seeds) <= LOW * budget);
            self.seeds = match helping {
                Some(seeds) if mesh_starves => seeds,
                // Without any steps many seeds are better than few.
                None if mesh_starves && paint * growth(0) <= LOW * budget => 0,
                _ => before,
            };
            if paint_starves {
                self.seeds = self.seeds.max((before + 1).min(last));
            }
        } else if self.rich >= SEED_PATIENCE {
            self.seeds -= 1;
        }
        if self.seeds != before {
            (self.starved, self.rich) = (0, 0);
            self.mesh.line.scale(f64::from(SEEDS[self.seeds]) / f64::from(SEEDS[before]));
            self.news.push(change("seeds", SEEDS[before], SEEDS[self.seeds], expected, budget));
        }
    }
}

fn change(what: &'static str, from: u32, to: u32, expected: f64, budget: f64) -> Change {
    // Microseconds are plenty for a reader.
    let ms = |seconds: f64| (seconds * 1e6).round() / 1e3;
    Change { what, from, to, expected_ms: ms(expected), budget_ms: ms(budget) }
}
