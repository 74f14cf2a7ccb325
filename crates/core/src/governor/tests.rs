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
    /// Time of the first frame with refinement after frames without, divided by that of later ones.
    resuming: f64,
    /// Relative, uniform on both sides.
    noise: f64,
}

const MACHINE: Machine =
    Machine { look: 6.0, setup: 6.0, step: 4.0, paint: 9.0, resuming: 1.5, noise: 0.0 };

/// As a large picture is: a whole step does not fit into 33 ms.
const LARGE: Machine = Machine { look: 7.0, setup: 10.0, step: 28.0, paint: 15.0, ..MACHINE };

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    /// Eighths of a step.
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
    is_refined: bool,
    frame: u32,
    changes: Vec<(u32, Change)>,
}

impl Trial {
    fn new(budget_ms: f64, machine: Machine) -> Self {
        let governor = Governor::new(Duration::from_secs_f64(budget_ms / 1e3));
        let changes = Vec::new();
        Self {
            governor,
            machine,
            most: MOST_STEPS,
            seeds: 100,
            is_refined: true,
            frame: 0,
            changes,
        }
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
        let begun = match (fresh || seeds != self.seeds, steps.eighths()) {
            (true, _) => 3.0 * machine.setup,
            (false, 0) => 0.05 * machine.setup,
            (false, _) => machine.setup,
        };
        let steps = steps.eighths();
        let slowdown = if self.is_refined { 1.0 } else { machine.resuming };
        self.is_refined = steps > 0;
        let step = machine.step * share * super::steps(steps);
        let meshed = time((begun * (0.5 + 0.5 * share) + step) * slowdown, 1);
        governor.meshed(fresh || seeds != self.seeds, Steps::from_eighths(steps), meshed);
        self.seeds = seeds;
        let rows = governor.rows();
        let sparse = [1.0, 1.0, 0.8, 0.75, 0.7][rows as usize];
        let painted = time(machine.paint * sparse * (0.4 + 0.6 * share), 2);
        governor.painted(rows, painted);
        let budget = Duration::from_secs_f64(governor.budget);
        self.changes.extend(governor.take_changes().into_iter().map(|change| (frame, change)));
        Seen { steps, seeds, rows, missed: looked.max(meshed).max(painted) > budget }
    }
}

#[test]
fn constant_load_settles() {
    for (budget, load) in [(33.0, 1.0), (16.0, 1.0), (33.0, 2.5), (12.0, 1.0), (5.0, 2.0)] {
        let mut trial = Trial::new(budget, MACHINE);
        let seen = trial.run(900, |_| load);
        let last = seen[899];
        let others = seen[600..].iter().filter(|s| **s != last).count();
        // But for tries whether some refinement fits by now, where none did.
        let most = if last.steps == 0 { 8 } else { 0 };
        assert!(others <= most, "{budget} ms: {:?}", trial.changes);
    }
}

#[test]
fn spare_time_goes_to_refinement_and_never_past_the_cap() {
    let mut trial = Trial::new(33.0, MACHINE);
    let steps = trial.run(200, |_| 1.0)[199].steps;
    let used = (6.0 + 4.0 * super::steps(steps)) / 33.0;
    assert!((LOW - 0.03..=LOW).contains(&used), "{used} of the budget");
    let mut trial = Trial::new(1000.0, MACHINE);
    assert_eq!(trial.run(200, |_| 1.0)[199].steps, MOST_STEPS * EIGHTHS);
    let mut capped = Trial::new(1000.0, MACHINE);
    capped.most = 3;
    assert!(capped.run(200, |_| 1.0).iter().all(|s| s.steps <= 3 * EIGHTHS));
    let mut none = Governor::new(Duration::from_secs(1));
    assert_eq!(none.mesh(0, 12, false).1, Steps::default(), "nobody asked for refinement");
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
    let back = after.iter().position(|s| 10 * s.steps >= 9 * before[199].steps);
    assert!(back.is_some_and(|frames| frames <= 60), "{back:?}: {:?}", trial.changes);
}

#[test]
fn alternating_load_does_not_pump() {
    for period in [2, 3, 7, 16] {
        let mut trial = Trial::new(33.0, MACHINE);
        let seen = trial.run(600, |i| if i / period % 2 == 0 { 1.0 } else { 1.8 });
        let late = trial.changes.iter().filter(|(frame, _)| *frame >= 200).count();
        // Slow waves may be followed, in a few small steps each.
        let waves = 400 / (2 * period) as usize;
        assert!(late <= (4 * waves + 4).min(60), "period {period}: {late} {:?}", trial.changes);
        let missed = seen[200..].iter().filter(|s| s.missed).count();
        assert!(missed <= 8 + waves / 2, "period {period}: {missed} missed");
        let steps = || seen[200..].iter().map(|s| s.steps);
        let (least, most) = (steps().min(), steps().max());
        assert!(most <= least.map(|n| 2 * n), "period {period}: from {least:?} to {most:?}");
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
    let before = trial.run(200, |_| 1.0)[199].steps;
    let seen = trial.run(100, |i| if i == 0 { 8.0 } else { 1.0 });
    assert!(seen.iter().all(|s| s.seeds == 100), "seeds do not answer to one frame");
    assert_eq!(seen[99].steps, before, "{:?}", trial.changes);
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
    assert!(after[899].steps >= EIGHTHS);
}

/// With whole steps only, the governor ended with a quarter of the seeds and no step: the first step after a pause
/// took longer than later ones would have, and was the only one that was measured.
#[test]
fn some_refinement_fits_where_a_whole_step_does_not() {
    for noise in [0.0, 0.1] {
        let mut trial = Trial::new(33.0, Machine { noise, ..LARGE });
        let seen = trial.run(300, |_| 1.0);
        assert!(seen[60..].iter().all(|s| s.seeds == 100 && (1..EIGHTHS).contains(&s.steps)));
        let before = seen[299].steps;
        // Barely an eighth fits.
        let during = trial.run(100, |_| 2.1);
        let missed = during.iter().filter(|s| s.missed).count();
        assert!(missed <= 4, "{noise}: {missed} of 100 under load");
        assert!(during[99].steps >= 1 && during[99].steps < before);
        let after = trial.run(100, |_| 1.0);
        let back = after.iter().position(|s| s.seeds == 100 && s.steps + 1 >= before);
        assert!(back.is_some_and(|frames| frames <= 100), "{noise} {back:?}: {:?}", trial.changes);
    }
}

/// Where nothing fits for a time, all comes back after it, though the first step after the pause is slow.
#[test]
fn refinement_comes_back_after_a_pause() {
    let mut trial = Trial::new(33.0, LARGE);
    let before = trial.run(200, |_| 1.0)[199];
    let during = trial.run(300, |_| 9.0);
    assert_eq!(during[200].steps, 0, "{:?}", trial.changes);
    // Frames that are missed whatever their detail is.
    let tries = during[100..].iter().filter(|s| s.steps > 0).count();
    assert!(tries <= 4, "{tries} tries in 200 frames: {:?}", trial.changes);
    let after = trial.run(400, |_| 1.0);
    let back = after.iter().position(|s| s.seeds == 100 && s.steps + 1 >= before.steps);
    assert!(back.is_some_and(|frames| frames <= 240), "{back:?}: {:?}", trial.changes);
}

#[test]
fn a_larger_budget_never_gives_less() {
    for machine in [MACHINE, LARGE] {
        let mut last = (0, 0);
        for budget in [4.0, 8.0, 12.0, 16.0, 24.0, 33.0, 50.0, 66.0, 100.0] {
            let seen = Trial::new(budget, machine).run(600, |_| 1.0)[599];
            let detail = (seen.seeds * u32::from(seen.steps > 0), seen.steps);
            assert!(detail.0 >= last.0, "{budget} ms: {detail:?} after {last:?}");
            assert!(detail.0 > last.0 || detail.1 >= last.1, "{budget} ms: {detail:?} {last:?}");
            last = detail;
        }
    }
}

#[test]
fn a_fresh_mesh_gets_the_steps_that_fit_and_is_not_held_against_the_others() {
    let mut trial = Trial::new(33.0, MACHINE);
    let steps = trial.run(100, |_| 1.0)[99].steps;
    let ms = |ms: f64| Duration::from_secs_f64(ms / 1e3);
    // 18 ms before its first step, 6 for each.
    let (_, fresh) = trial.governor.mesh(6, 6, true);
    assert!((1..6 * EIGHTHS).contains(&fresh.eighths()), "{fresh:?}");
    trial.governor.meshed(true, fresh, ms(18.0 + 6.0 * f64::from(fresh)));
    assert_eq!(trial.governor.mesh(2, 12, false).1.eighths(), steps);
}

#[test]
fn changes_say_what_and_why() {
    let change = change("steps", 5.0, 2.375, 0.0412, 0.033);
    let said = change.to_string();
    assert_eq!(said, "refinement steps 5 -> 2.375: 41.2 ms expected of 33.0 ms");
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
            prop_assert!(steps <= Steps::new(cap));
            governor.meshed(fresh, steps, ms(mesh_ms));
            let rows = governor.rows();
            prop_assert!([1, 2, 4].contains(&rows));
            governor.painted(rows, ms(paint_ms));
            for change in governor.take_changes() {
                prop_assert!(change.from != change.to);
                prop_assert!(change.expected_ms.is_finite());
            }
        }
    }
}
