//! The governor on invented machines: a frame takes what it asks for, times the load, times noise.

use std::time::Duration;

use super::*;
use crate::chance::{Purpose, unit};
use proptest::prelude::*;

/// Milliseconds at load 1.
#[derive(Clone, Copy, Debug)]
struct Machine {
    look: f64,
    setup: f64,
    step: f64,
    paint: f64,
    /// Relative, uniform on both sides.
    noise: f64,
}

const MACHINE: Machine = Machine { look: 6.0, setup: 6.0, step: 4.0, paint: 9.0, noise: 0.0 };

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    steps: u32,
    seeds: u32,
    rows: u32,
    missed: bool,
}

struct Trial {
    governor: Governor,
    machine: Machine,
    most: u32,
    seeds: u32,
    frame: u32,
    changes: Vec<(u32, Change)>,
}

impl Trial {
    fn new(budget_ms: f64, machine: Machine) -> Self {
        let governor = Governor::new(Duration::from_secs_f64(budget_ms / 1e3));
        Self { governor, machine, most: MOST_STEPS, seeds: 100, frame: 0, changes: Vec::new() }
    }

    fn run(&mut self, frames: u32, load: impl Fn(u32) -> f64) -> Vec<Seen> {
        (0..frames).map(|i| self.frame(load(i))).collect()
    }

    fn frame(&mut self, load: f64) -> Seen {
        let (frame, machine) = (self.frame, self.machine);
        self.frame += 1;
        let fresh = frame == 0;
        let time = |ms: f64, what: u32| {
            let noise = 1.0 + machine.noise * (2.0 * unit(7, Purpose::Noise, frame, what) - 1.0);
            Duration::from_secs_f64(ms * load * noise / 1e3)
        };
        let governor = &mut self.governor;
        let look = governor.look();
        let looked = match (look, fresh) {
            (Look::Full, true) => 6.0 * machine.look,
            (_, true) => 2.0 * machine.look,
            (Look::Reuse, false) => 0.01,
            (_, false) => machine.look,
        };
        let looked = time(looked, 0);
        governor.looked(look, fresh, looked);
        let (seeds, steps) = governor.mesh(if fresh { 6 } else { 2 }, self.most, fresh);
        let share = f64::from(seeds) / 100.0;
        let begun = match (fresh || seeds != self.seeds, steps) {
            (true, _) => 3.0 * machine.setup,
            (false, 0) => 0.05 * machine.setup,
            (false, _) => machine.setup,
        };
        let meshed = time(begun * (0.5 + 0.5 * share) + machine.step * share * f64::from(steps), 1);
        governor.meshed(fresh || seeds != self.seeds, steps, meshed);
        self.seeds = seeds;
        let rows = governor.rows();
        let sparse = [1.0, 1.0, 0.8, 0.75, 0.7][rows as usize];
        let painted = time(machine.paint * sparse * (0.4 + 0.6 * share), 2);
        governor.painted(rows, painted);
        let budget = Duration::from_secs_f64(governor.budget);
        self.changes.extend(governor.take_news().into_iter().map(|change| (frame, change)));
        Seen { steps, seeds, rows, missed: looked.max(meshed).max(painted) > budget }
    }
}

#[test]
fn constant_load_settles() {
    for (budget, load) in [(33.0, 1.0), (16.0, 1.0), (33.0, 2.5), (12.0, 1.0), (5.0, 2.0)] {
        let mut trial = Trial::new(budget, MACHINE);
        let seen = trial.run(900, |_| load);
        let last = seen[899];
        // But for one try whether a step fits by now, where none did.
        let others = seen[600..].iter().filter(|s| **s != last).count();
        let most = if last.steps == 0 { 1 } else { 0 };
        assert!(others <= most, "{budget} ms: {:?}", trial.changes);
    }
}

#[test]
fn spare_time_goes_to_refinement_and_never_past_the_cap() {
    let mut trial = Trial::new(33.0, MACHINE);
    // 0.8 of 33 ms hold 6 + 5 x 4.
    assert_eq!(trial.run(200, |_| 1.0)[199].steps, 5);
    let mut trial = Trial::new(1000.0, MACHINE);
    assert_eq!(trial.run(200, |_| 1.0)[199].steps, MOST_STEPS);
    let mut capped = Trial::new(1000.0, MACHINE);
    capped.most = 3;
    assert!(capped.run(200, |_| 1.0).iter().all(|s| s.steps <= 3));
    let mut none = Governor::new(Duration::from_secs(1));
    assert_eq!(none.mesh(0, 12, false).1, 0, "nobody asked for refinement");
}

#[test]
fn a_step_in_load_is_answered_at_once_and_taken_back_when_it_ends() {
    let noisy = Machine { noise: 0.08, ..MACHINE };
    let mut trial = Trial::new(33.0, noisy);
    let before = trial.run(200, |_| 1.0);
    let during = trial.run(200, |_| 2.2);
    let after = trial.run(200, |_| 1.0);
    let missed = |seen: &[Seen]| seen.iter().filter(|s| s.missed).count();
    assert_eq!(missed(&before[24..]), 0);
    assert!(missed(&during) <= 2, "{} of 200 under load", missed(&during));
    assert_eq!(missed(&after), 0);
    assert!(during[199].steps < before[199].steps);
    // Within two seconds at 30 frames a second.
    let back = after.iter().position(|s| s.steps >= before[199].steps);
    assert!(back.is_some_and(|frames| frames <= 60), "{back:?}: {:?}", trial.changes);
}

#[test]
fn alternating_load_does_not_pump() {
    for period in [2, 3, 7, 16] {
        let mut trial = Trial::new(33.0, MACHINE);
        let seen = trial.run(600, |i| if i / period % 2 == 0 { 1.0 } else { 1.8 });
        let late = trial.changes.iter().filter(|(frame, _)| *frame >= 200).count();
        // Slow waves may be followed; at most two changes a wave.
        let waves = 400 / (2 * period) as usize;
        assert!(late <= (2 * waves + 2).min(60), "period {period}: {late} {:?}", trial.changes);
        let missed = seen[200..].iter().filter(|s| s.missed).count();
        assert!(missed <= 8 + waves / 2, "period {period}: {missed} missed");
    }
}

#[test]
fn noise_neither_pumps_nor_misses() {
    for noise in [0.05, 0.15, 0.25] {
        let mut trial = Trial::new(33.0, Machine { noise, ..MACHINE });
        let seen = trial.run(1000, |_| 1.0);
        let missed = seen[30..].iter().filter(|s| s.missed).count();
        assert!(missed <= 10, "{noise}: {missed} missed");
        let late = trial.changes.iter().filter(|(frame, _)| *frame >= 100).count();
        assert!(late <= 60, "{noise}: {late} changes in 900 frames");
    }
}

#[test]
fn a_single_long_frame_does_not_bring_the_house_down() {
    let mut trial = Trial::new(33.0, MACHINE);
    trial.run(200, |_| 1.0);
    let seen = trial.run(100, |i| if i == 0 { 8.0 } else { 1.0 });
    assert!(seen.iter().all(|s| s.seeds == 100), "seeds do not answer to one frame");
    assert_eq!(seen[99].steps, 5, "{:?}", trial.changes);
}

#[test]
fn rungs_are_taken_in_order() {
    // So slow that everything has to go.
    let mut trial = Trial::new(8.0, MACHINE);
    let seen = trial.run(400, |_| 3.0);
    let first = |what: &str| trial.changes.iter().position(|(_, c)| c.what == what);
    assert!(first("rows") < first("seeds"), "{:?}", trial.changes);
    assert_eq!((seen[399].seeds, seen[399].rows, seen[399].steps), (25, 4, 0), "the floor");
    let after = trial.run(900, |_| 0.3);
    assert_eq!((after[899].seeds, after[899].rows), (100, 1), "all comes back");
    assert!(after[899].steps >= 1);
}

#[test]
fn a_fresh_mesh_gets_the_steps_that_fit_and_is_not_held_against_the_others() {
    let mut trial = Trial::new(33.0, MACHINE);
    let steps = trial.run(100, |_| 1.0)[99].steps;
    let ms = |ms: f64| Duration::from_secs_f64(ms / 1e3);
    // 18 ms before its first step, 6 for each.
    let (_, fresh) = trial.governor.mesh(6, 6, true);
    assert!((1..6).contains(&fresh), "{fresh}");
    trial.governor.meshed(true, fresh, ms(18.0 + 6.0 * f64::from(fresh)));
    assert_eq!(trial.governor.mesh(2, 12, false).1, steps);
}

#[test]
fn changes_say_what_and_why() {
    let change = change("steps", 5, 2, 0.0412, 0.033);
    let said = change.to_string();
    assert_eq!(said, "refinement steps 5 -> 2: 41.2 ms expected of 33.0 ms");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn details_stay_between_floor_and_cap(
        budget in 0.0f64..200.0,
        times in proptest::collection::vec((0.0f64..500.0, 0.0f64..500.0, 0.0f64..500.0), 1..300),
        cap in 0u32..20,
        cuts: u64,
    ) {
        let mut governor = Governor::new(Duration::from_secs_f64(budget / 1e3));
        let ms = |ms: f64| Duration::from_secs_f64(ms / 1e3);
        for (i, (look_ms, mesh_ms, paint_ms)) in times.into_iter().enumerate() {
            let fresh = i == 0 || cuts >> (i % 64) & 7 == 0;
            let look = governor.look();
            governor.looked(look, fresh, ms(look_ms));
            let (seeds, steps) = governor.mesh(if fresh { 6 } else { 2 }, cap, fresh);
            prop_assert!(SEEDS.contains(&seeds));
            prop_assert!(steps <= cap);
            governor.meshed(fresh, steps, ms(mesh_ms));
            let rows = governor.rows();
            prop_assert!([1, 2, 4].contains(&rows));
            governor.painted(rows, ms(paint_ms));
            for change in governor.take_news() {
                prop_assert!(change.from != change.to);
                prop_assert!(change.expected_ms.is_finite());
            }
        }
    }
}
