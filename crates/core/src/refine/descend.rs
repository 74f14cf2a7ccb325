//! Gradient descent: vertices move along the slope of the error.

use crate::parallel::prelude::*;

use super::activity::Activity;
use super::colouring::Colouring;
use super::cost::Cost;
use super::errors::{Errors, scale};
use super::force::gradient;
use super::line::{Line, MAX_REACH, MIN_REACH, PROMISE};
use super::mean::Mean;
use super::pass::Pass;
use super::ring::Ring;
use super::share::Share;
use super::sums::Sums;
use super::surface::{Fans, Surface, TOGETHER, next, previous};
use crate::geom::{Point, SUBPIXEL};
use crate::mesh::Place;

/// First step length of a vertex that is new or activated, in 1/256 pixel. Measured for activated vertices: 2 to 3 %
/// less error than with a quarter of it, on stills and on video, in the same time.
/// Measured by `cargo xtask measure first-reach`.
const FIRST_REACH: i32 = SUBPIXEL;

/// A vertex whose slope promises less than this share of the minimum gain is skipped for some frames.
const IDLE: f64 = 0.25;

/// In [streams](super::options::Mode::Stream), a vertex whose triangles have less error than this, in minimum gains,
/// is not visited. Measured: this skips nine in ten of the vertices that would try a step on calm clips, and one in
/// four on the fastest. What they would gain there, a half and a tenth of what all steps do, nearly comes from
/// re-placing instead: squared error rises by 1 to 11 %, flicker by 2 % at most.
/// Measured by `cargo xtask measure min-visit-error`.
const MIN_VISIT_ERROR: f64 = 80.0;

/// In [streams](super::options::Mode::Stream), the largest share of the vertices that one step visits, those with the
/// largest error around them: the time of a step must not depend on how much of the picture moves. Measured at 1080p:
/// a snowy street has 63 % to visit, and takes a quarter less time for the first step, for 14 % more error and 5 %
/// more flicker; with three steps a seventh less, for 7 % and 3 %. A commercial has 40 %, for 1 % and 1 %.
/// Measured by `cargo xtask measure max-visited`.
const MAX_VISITED: f64 = 0.25;

/// Vertices that one piece of work looks at.
const CHUNK: usize = 32;

/// The result of a visit to a vertex.
#[derive(Clone, Copy, Debug)]
struct Visit {
    vertex: u32,
    to: Option<Point>,
    /// Length of its next step.
    reach: i32,
    /// Whether it is deactivated until its surroundings change.
    deactivates: bool,
    /// Whether a step promised almost no gain.
    idle: bool,
}

/// A triangle around a vertex that moves.
#[derive(Clone, Copy, Debug)]
struct Moved {
    /// Its half-edge opposite the vertex.
    link: u32,
    /// The sums of its half-edges from the vertex and back to it.
    spokes: [Sums; 2],
    cost: Cost,
    mean: Mean,
    /// An estimate of its squared error.
    error: f32,
}

/// The visits of one piece of work.
#[derive(Debug, Default)]
struct Visits {
    /// The rings of vertices that are visited one after the other.
    rings: [Ring; TOGETHER],
    fans: Fans,
    visits: Vec<Visit>,
    /// The triangles around all of the vertices that move.
    moved: Vec<Moved>,
}

impl Visits {
    fn clear(&mut self) {
        self.visits.clear();
        self.moved.clear();
    }

    /// Collects the rings of `vertices`, at most [`TOGETHER`]: all at once, so that their memory accesses overlap.
    fn surround(&mut self, surface: &Surface, vertices: &[u32]) {
        self.fans.walk(surface, vertices);
        for (i, (&v, ring)) in vertices.iter().zip(&mut self.rings).enumerate() {
            ring.surround(surface, v, self.fans.of(i));
            ring.sum_up(surface);
        }
    }
}

/// Vertices that are visited together, so that what surrounds them stays in the cache.
const BLOCK: usize = 4096;

/// The descent of all vertices.
#[derive(Debug, Default)]
pub(super) struct Descent {
    /// Length of the next step of each vertex, in 1/256 pixel; 0 if it was deactivated.
    reach: Vec<i32>,
    /// The vertices of this step.
    turn: Vec<u32>,
    /// The error of the triangles around each vertex, in streams.
    around: Vec<f64>,
    /// Scratch for the search of the largest ones.
    largest: Vec<f64>,
    colouring: Colouring,
    found: Vec<Visits>,
}

impl Descent {
    /// Forgets the step lengths of all vertices.
    pub(super) fn reset(&mut self, vertices: usize) {
        self.reach.clear();
        self.reach.resize(vertices, FIRST_REACH);
    }

    /// Forgets the step lengths of `vertices`.
    pub(super) fn restart(&mut self, vertices: &[u32]) {
        for &v in vertices {
            self.reach[v as usize] = FIRST_REACH;
        }
    }

    /// Moves every active vertex of `share` by one step; in streams only those with the largest `errors` around them.
    /// Returns how many moved.
    pub(super) fn step(
        &mut self,
        surface: &mut Surface,
        share: Share,
        activity: &mut Activity,
        errors: &mut Errors,
        pass: Pass,
    ) -> usize {
        surface.clock += 1;
        self.turn.clear();
        self.turn.extend(share.of(&surface.order));
        let is_ready = |surface: &Surface, activity: &Activity, v: u32| {
            surface.active[v as usize] && activity.is_active(v) && activity.is_due(v)
        };
        if pass.is_stream() {
            errors.around_all(surface, &mut self.around);
            let ready = self.turn.iter().filter(|&&v| is_ready(surface, activity, v));
            self.largest.clear();
            self.largest.extend(ready.map(|&v| self.around[v as usize]));
            let limit = (MAX_VISITED * self.turn.len() as f64).ceil() as usize;
            let least =
                least_of_largest(&mut self.largest, limit).max(MIN_VISIT_ERROR * pass.min_gain);
            let around = &self.around;
            self.turn.retain(|&v| around[v as usize] >= least);
        }
        let mut moved = 0;
        for block in self.turn.chunks(BLOCK) {
            let here = &*surface;
            self.colouring.colour(here, block, |v| is_ready(here, activity, v));
            let Self { colouring, reach, found, .. } = self;
            for class in &colouring.classes {
                moved += descend(surface, (activity, errors), reach, class, pass, found);
            }
        }
        moved
    }
}

/// The smallest of the `limit` largest `values`, none of which is NaN; minus infinity where there are no more
/// than that.
fn least_of_largest(values: &mut [f64], limit: usize) -> f64 {
    match values.len().checked_sub(limit) {
        None | Some(0) => f64::NEG_INFINITY,
        Some(smaller) if smaller == values.len() => f64::INFINITY,
        Some(smaller) => *values.select_nth_unstable_by(smaller, f64::total_cmp).1,
    }
}

/// Moves the vertices of `class`, no two of which are neighbours, each as far as it lowers the cost of
/// its own triangles. Returns how many moved.
fn descend(
    surface: &mut Surface,
    (activity, errors): (&mut Activity, &mut Errors),
    reach: &mut [i32],
    class: &[u32],
    pass: Pass,
    found: &mut Vec<Visits>,
) -> usize {
    let (here, known) = (&*surface, &*errors);
    let reaches = &*reach;
    let packs = class.par_chunks(CHUNK);
    found.resize_with(found.len().max(packs.len()), Visits::default);
    let found = &mut found[..packs.len()];
    found.par_iter_mut().zip(packs).for_each(|(visits, vertices)| {
        visits.clear();
        for together in vertices.chunks(TOGETHER) {
            visits.surround(here, together);
            for (i, &v) in together.iter().enumerate() {
                let reach = match reaches[v as usize] {
                    0 => FIRST_REACH,
                    reach => reach,
                };
                visit(here, known, v, reach, pass, visits, i);
            }
        }
    });
    found.iter().map(|visits| apply(surface, (activity, errors), reach, visits)).sum()
}

/// Finds the step of vertex `v`, which ring `i` surrounds.
fn visit(
    surface: &Surface,
    errors: &Errors,
    v: u32,
    reach: i32,
    pass: Pass,
    out: &mut Visits,
    i: usize,
) {
    let ring = &mut out.rings[i];
    let from = surface.at[v as usize];
    let mean = |i: usize| surface.mean[ring.links[i] as usize / 3].known();
    let (gx, gy) = gradient(pass, from, ring, mean);
    let (gx, gy) = match surface.freedom(v) {
        Place::Corner => (0.0, 0.0),
        Place::SideBorder => (0.0, gy),
        Place::LevelBorder => (gx, 0.0),
        Place::Interior => (gx, gy),
    };
    let length = (gx * gx + gy * gy).sqrt();
    let reach = reach.clamp(MIN_REACH, MAX_REACH);
    let promise = length * f64::from(reach) / f64::from(SUBPIXEL);
    if promise <= PROMISE * pass.min_gain {
        let idle = promise <= IDLE * pass.min_gain;
        out.visits.push(Visit { vertex: v, to: None, reach, deactivates: true, idle });
        return;
    }
    let direction = (-gx / length, -gy / length);
    let before = ring.cost(surface);
    let mut line = Line { ring, from, direction, slope: length, before, pass };
    let (to, reach) = line.search(reach);
    if let Some(to) = to {
        let ring = &out.rings[i];
        let first = out.moved.len();
        out.moved.extend((0..ring.len()).map(|i| {
            let spokes = [ring.spokes[i], -ring.spokes[i + 1]];
            let (cost, mean) = ring.triangle(pass.rows, i, to);
            Moved { link: ring.links[i], spokes, cost, mean, error: f32::INFINITY }
        }));
        let triangles = ring.links.iter().map(|&h| h / 3);
        if let Some(squares) = errors.squares(surface, triangles) {
            guess(surface, errors, squares, &mut out.moved[first..]);
        }
    }
    out.visits.push(Visit { vertex: v, to, reach, deactivates: reach == 0, idle: false });
}

/// Estimates the errors of the triangles around a vertex that has `moved`, from the sum of the squares of their
/// pixels: each keeps its error per pixel, scaled so that their sum is right.
fn guess(surface: &Surface, errors: &Errors, squares: f64, moved: &mut [Moved]) {
    let (mut left, mut guessed) = (squares, 0.0);
    for moved in &mut *moved {
        moved.error = errors.density(surface, moved.link / 3) * moved.mean.count;
        guessed += moved.error;
        left += moved.cost.error;
    }
    let scale = scale(left, guessed);
    moved.iter_mut().for_each(|moved| moved.error *= scale);
}

/// Makes the changes that were `found`. Returns how many vertices move.
fn apply(
    surface: &mut Surface,
    (activity, errors): (&mut Activity, &mut Errors),
    reach: &mut [i32],
    found: &Visits,
) -> usize {
    let mut moved = 0;
    for visit in &found.visits {
        let v = visit.vertex as usize;
        reach[v] = visit.reach;
        activity.record_visit(visit.vertex, visit.idle);
        match visit.to {
            Some(to) => {
                surface.at[v] = to;
                moved += 1;
            }
            None => surface.active[v] = !visit.deactivates,
        }
    }
    // No two of the vertices are neighbours: no triangle of a deactivated one has changed.
    for &Moved { link, spokes: [leaving, coming], cost, mean, error } in &found.moved {
        surface.sums[previous(link) as usize] = leaving;
        surface.sums[next(link) as usize] = coming;
        surface.set_triangle(link / 3, cost, mean);
        errors.guess(surface, link / 3, error);
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_of_the_largest_is_their_lower_bound() {
        let values = [3.0, f64::INFINITY, 1.0, 3.0, 0.0, 7.0];
        let least = |limit| least_of_largest(&mut values.to_vec(), limit);
        assert_eq!([1, 2, 3, 4, 5].map(least), [f64::INFINITY, 7.0, 3.0, 3.0, 1.0]);
        assert_eq!([6, 7].map(least), [f64::NEG_INFINITY; 2], "there are no more");
        assert_eq!(least(0), f64::INFINITY);
        assert_eq!(least_of_largest(&mut [], 0), f64::NEG_INFINITY);
    }
}
