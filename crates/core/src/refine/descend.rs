//! Vertices step down the error.

use crate::parallel::prelude::*;

use super::activity::Activity;
use super::colouring::Colouring;
use super::cost::Cost;
use super::errors::{Errors, scale};
use super::force::gradient;
use super::mean::Mean;
use super::pass::Pass;
use super::ring::Ring;
use super::share::Share;
use super::sums::Sums;
use super::surface::{Fans, Surface, TOGETHER, next, previous};
use crate::geom::{Point, SUBPIXEL};
use crate::mesh::Place;

/// How far a vertex tries to go first, in 1/256 pixel, when nothing is known of it or it is activated. Measured when
/// it is activated: 2 to 3 % less error than with a quarter of it, on stills and on video, in the same time.
/// Measured by `cargo xtask measure first-reach`.
const FIRST_REACH: i32 = SUBPIXEL;

/// A vertex whose step fails at this length is deactivated: 1/16 pixel.
const MIN_REACH: i32 = SUBPIXEL / 16;

/// The longest step: about half of the distance between seeds at the default number of points.
const MAX_REACH: i32 = 6 * SUBPIXEL;

/// A step is not tried when the slope promises less than this share of what it has to gain. Measured on
/// video: below it are half of the trials and one move in ten, those that gain least.
/// Measured by `cargo xtask measure promise`.
const PROMISE: f64 = 0.5;

/// A vertex whose slope promises less than this share is left alone for a while.
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

/// Places that a vertex tries along its gradient until one gains enough; in [streams](super::options::Mode::Stream)
/// the second is tried in the next frame. Measured there: second trials are 15 to 18 % of what is tried, and bring 4
/// to 6 % of what is gained; without them there is half a per cent more error.
/// Measured by `cargo xtask measure trials`.
const TRIALS: usize = 2;

/// The shortest and the longest next trial, as shares of one that failed.
const MIN_SHRINK: f64 = 0.2;
const MAX_SHRINK: f64 = 0.6;

/// The largest factor by which a step that gains is stretched, and the smallest that is tried. Measured: with twice
/// the largest, at most 1 % more error.
/// Measured by `cargo xtask measure max-stretch`.
const MAX_STRETCH: f64 = 4.0;
const MIN_STRETCH: f64 = 1.3;

/// Vertices that one piece of work looks at.
const CHUNK: usize = 32;

/// What came of a visit to a vertex.
#[derive(Clone, Copy, Debug)]
struct Visit {
    vertex: u32,
    to: Option<Point>,
    /// How far it tries to go the next time.
    reach: i32,
    /// Whether it is deactivated until its surroundings change.
    deactivates: bool,
    /// Whether hardly anything would have come of a step.
    idle: bool,
}

/// A triangle around a vertex that moves.
#[derive(Clone, Copy, Debug)]
struct Moved {
    /// Its half-edge on the other side of it from the vertex.
    link: u32,
    /// The sums of its half-edges that leave the vertex and come back to it.
    spokes: [Sums; 2],
    cost: Cost,
    mean: Mean,
    /// A guess at its squared error.
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
    /// How far each vertex tries to go, in 1/256 pixel; 0 when it last slept.
    reach: Vec<i32>,
    /// The vertices whose turn it is.
    turn: Vec<u32>,
    /// The error of the triangles around each vertex, in streams.
    around: Vec<f64>,
    /// Memory to find the largest ones in.
    largest: Vec<f64>,
    colouring: Colouring,
    found: Vec<Visits>,
}

impl Descent {
    /// Forgets everything.
    pub(super) fn reset(&mut self, vertices: usize) {
        self.reach.clear();
        self.reach.resize(vertices, FIRST_REACH);
    }

    /// Forgets what is known of these vertices.
    pub(super) fn restart(&mut self, vertices: &[u32]) {
        for &v in vertices {
            self.reach[v as usize] = FIRST_REACH;
        }
    }

    /// Lets every active vertex of `share` take a step; in streams only those whose triangles have much of the
    /// `errors`. Returns how many moved.
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

/// Looks where vertex `v`, which ring `i` surrounds, goes.
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

/// Guesses at the errors of triangles around a vertex that has `moved`, of pixels of such `squares`: as if pixels
/// had kept the triangle that they are in, but together no more than there is.
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

/// The way that a vertex tries.
struct Line<'a, 'b> {
    ring: &'a mut Ring,
    from: Point,
    direction: (f64, f64),
    /// What a pixel of it gains at its beginning, in squared 8-bit steps.
    slope: f64,
    before: Cost,
    pass: Pass<'b>,
}

impl Line<'_, '_> {
    fn point(&self, reach: i32) -> Point {
        let part = |share: f64| (share * f64::from(reach)).round() as i32;
        let (x, y) = self.direction;
        Point::new(self.from.x + part(x), self.from.y + part(y))
    }

    /// What it gains to go to `to`; minus infinity where the mesh would turn over. Never positive when
    /// the error itself would rise.
    fn gain(&mut self, to: Point) -> f64 {
        let Pass { rows, weight, .. } = self.pass;
        let after = self.ring.try_at(rows, to);
        after.map_or(f64::NEG_INFINITY, |after| self.before.gain(after, weight))
    }

    /// Looks for the top of the gain along the way: a parabola with the slope at the start goes through each place
    /// that was tried, and gives the next one. Returns the place, with the ring's spokes for it, and the reach for
    /// the next time; 0 when no gain is expected in this direction.
    fn search(&mut self, reach: i32) -> (Option<Point>, i32) {
        let mut reach = reach;
        for _ in 0..if self.pass.is_stream() { 1 } else { TRIALS } {
            let to = self.point(reach);
            let gain = self.gain(to);
            let promise = self.slope * f64::from(reach) / f64::from(SUBPIXEL);
            // Where the parabola has its top, as a share of the reach.
            let top = if gain < promise { 0.5 * promise / (promise - gain) } else { f64::INFINITY };
            if gain > self.pass.min_gain {
                return self.stretch(to, gain, reach, top);
            }
            let hope = if gain.is_finite() { 0.5 * promise * top } else { promise * MAX_SHRINK };
            if reach == MIN_REACH || hope <= PROMISE * self.pass.min_gain {
                return (None, 0);
            }
            let shorter = f64::from(reach) * top.clamp(MIN_SHRINK, MAX_SHRINK);
            reach = (shorter as i32).max(MIN_REACH);
        }
        (None, reach)
    }

    /// Goes on from `to`, where it gains `gain`, as far as the top of the parabola, if that is further.
    fn stretch(&mut self, to: Point, gain: f64, reach: i32, top: f64) -> (Option<Point>, i32) {
        let longer = (f64::from(reach) * top.min(MAX_STRETCH)) as i32;
        if top < MIN_STRETCH || longer > MAX_REACH {
            return (Some(to), reach);
        }
        self.ring.keep();
        let further = self.point(longer);
        if self.gain(further) > gain {
            return (Some(further), longer);
        }
        self.ring.restore();
        (Some(to), reach)
    }
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
    fn the_least_of_the_largest_parts_them_from_the_rest() {
        let values = [3.0, f64::INFINITY, 1.0, 3.0, 0.0, 7.0];
        let least = |limit| least_of_largest(&mut values.to_vec(), limit);
        assert_eq!([1, 2, 3, 4, 5].map(least), [f64::INFINITY, 7.0, 3.0, 3.0, 1.0]);
        assert_eq!([6, 7].map(least), [f64::NEG_INFINITY; 2], "there are no more");
        assert_eq!(least(0), f64::INFINITY);
        assert_eq!(least_of_largest(&mut [], 0), f64::NEG_INFINITY);
    }
}
