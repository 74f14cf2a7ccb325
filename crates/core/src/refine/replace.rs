//! Re-places vertices: those of the lowest removal cost go where the error is largest.

use crate::parallel::prelude::*;

use super::activity::Activity;
use super::cost::Cost;
use super::errors::Errors;
use super::force::gradient;
use super::pass::Pass;
use super::patch::{Closing, put_in, take_out};
use super::removal::{Candidate, RemovalCosts};
use super::ring::Ring;
use super::share::Turn;
use super::surface::{NONE, Surface};
use crate::geom::Point;

/// Triangles in one parallel piece of work.
const CHUNK: usize = 16;

/// For each vertex that is re-placed, this many removals are planned, those with the lowest bounds, and as many
/// triangles of the largest errors are tried; twice as many in [thorough](super::options::Mode::Thorough) mode.
const PLANNED: usize = 2;

/// In [streams](super::options::Mode::Stream), triangles that are tried for every two vertices. Measured on seven
/// clips: a hundredth more error than with four, 1 to 2 % less time for a step; with two, 3 % more error.
/// Measured by `cargo xtask measure tried-for-two`.
const TRIED_FOR_TWO: usize = 3;

/// A position for a vertex, and its gain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    pub(super) gain: Cost,
    pub(super) site: Site,
    pub(super) place: Point,
}

impl Opening {
    /// With the gain as much as its place matters.
    fn weighted(mut self, pass: Pass) -> Self {
        self.gain = self.gain.scaled(pass.focus_at(self.place));
        self
    }

    fn score(&self, weight: f64) -> f64 {
        self.gain.total(weight).min(self.gain.error)
    }
}

/// The polygon in which a vertex is inserted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Site {
    /// A triangle.
    Triangle(u32),
    /// The two triangles of an inner edge, given by one of its half-edges.
    Pair(u32),
}

/// Removes up to `limit` inner vertices of the lowest removal cost, and inserts them where one more vertex gains
/// most, the cheapest at the best position, as long as the gain is larger than the cost. Covers the parts of the mesh
/// in this `turn`, and updates their `errors`, in streams those of the whole mesh. Returns the vertices.
pub(super) fn replace(
    surface: &mut Surface,
    removals: &mut RemovalCosts,
    errors: &mut Errors,
    activity: &Activity,
    limit: usize,
    turn: Turn,
    pass: Pass,
) -> Vec<u32> {
    if limit == 0 {
        // In streams the descent chooses its vertices by errors, too.
        if pass.is_stream() {
            errors.update(surface, activity, Turn::ALL, pass);
        }
        return Vec::new();
    }
    let planned = limit * if pass.is_thorough() { 2 * PLANNED } else { PLANNED };
    let tried = if pass.is_stream() { (TRIED_FOR_TWO * limit).div_ceil(2) } else { planned };
    let (leaving, openings) = candidates_and_openings(
        [planned, tried],
        turn,
        surface,
        activity,
        (removals, errors),
        pass,
    );
    let weight = pass.weight;
    let mut taken = std::mem::take(&mut removals.taken);
    taken.clear();
    taken.resize(surface.triangles(), false);
    let mut replaced = Vec::new();
    let (mut ring, mut around, mut closing) = <(Ring, Ring, Closing)>::default();
    let mut leaving = leaving.into_iter();
    for opening in openings {
        if replaced.len() == limit {
            break;
        }
        // Half-edges of triangles that this pass has changed may have other neighbours now.
        if taken[opening.site.triangle() as usize] {
            continue;
        }
        opening.site.enclose(surface, &mut ring);
        if ring
            .links
            .iter()
            .any(|&h| taken[h as usize / 3] || !activity.is_active_triangle(surface, h / 3))
        {
            continue;
        }
        // The cheapest vertex whose surroundings this pass has not changed.
        let next = leaving.find(|&(_, i)| {
            let v = removals.candidates[i].vertex;
            around.surround(surface, v, surface.around(v));
            let free =
                |&h: &u32| !taken[h as usize / 3] && ring.links.iter().all(|&g| g / 3 != h / 3);
            around.links.iter().all(free)
        });
        let Some((cost, i)) = next else { break };
        if opening.score(weight) - cost <= pass.min_gain {
            break;
        }
        let Candidate { vertex: v, plan, .. } = &removals.candidates[i];
        let sought = if plan.is_some() {
            None
        } else {
            around.sum_up(surface);
            closing.plan(&around, pass.rows, weight)
        };
        let Some(plan) = plan.as_ref().or(sought.as_ref()) else { continue };
        for &h in around.links.iter().chain(&ring.links) {
            taken[h as usize / 3] = true;
        }
        let placed = ring.try_at(pass.rows, opening.place);
        debug_assert!(placed.is_some());
        let spare = take_out(surface, errors, pass.rows, &around, plan);
        put_in(surface, errors, pass, &ring, *v, opening.place, spare);
        replaced.push(*v);
    }
    removals.taken = taken;
    replaced
}

/// The candidates for removal with their costs and indices, the cheapest first, at most `planned`; and the openings
/// in triangles with an error above the lowest cost, the best first, at most `tried`.
fn candidates_and_openings(
    [planned, tried]: [usize; 2],
    turn: Turn,
    surface: &Surface,
    activity: &Activity,
    (removals, errors): (&mut RemovalCosts, &mut Errors),
    pass: Pass,
) -> (Vec<(f64, usize)>, Vec<Opening>) {
    let mut worst = std::mem::take(&mut removals.worst);
    let is_open = |&t: &u32| turn.has(t) && activity.is_active_triangle(surface, t);
    // In streams the openings are found at the same time, so that threads wait less: nearly all of the triangles have
    // errors above the lowest cost.
    let ((), early) = crate::parallel::join(
        || removals.update(surface, activity, turn, planned, pass),
        || {
            errors.update(surface, activity, if pass.is_stream() { Turn::ALL } else { turn }, pass);
            find_worst((surface, errors), is_open, tried, pass, &mut worst);
            pass.is_stream().then(|| openings(surface, activity, &worst, pass))
        },
    );
    // Costs and gains are the worse of error and error with shape: a change that pays does so in both.
    let removals_by_cost = removals.costs(surface, pass);
    // A triangle with an error below the cost cannot gain more than it.
    let lowest = removals_by_cost.first().map_or(f64::INFINITY, |&(cost, _)| cost);
    let promising = worst.partition_point(|&(error, _)| error > lowest);
    let mut openings =
        early.unwrap_or_else(|| openings(surface, activity, &worst[..promising], pass));
    openings
        .retain(|opening| weighted_error(surface, errors, opening.site.triangle(), pass) > lowest);
    removals.worst = worst;
    (removals_by_cost, openings)
}

/// The best openings in the `tried` triangles of this `turn` with the largest errors, the best first.
pub(super) fn best_openings(
    surface: &Surface,
    errors: &Errors,
    activity: &Activity,
    turn: Turn,
    tried: usize,
    pass: Pass,
) -> Vec<Opening> {
    let is_open = |&t: &u32| turn.has(t) && activity.is_active_triangle(surface, t);
    let mut worst = Vec::new();
    find_worst((surface, errors), is_open, tried, pass, &mut worst);
    openings(surface, activity, &worst, pass)
}

/// Fills `worst` with the errors and numbers of the `limit` open triangles of the largest errors, the worst first.
fn find_worst(
    (surface, errors): (&Surface, &Errors),
    is_open: impl Fn(&u32) -> bool,
    limit: usize,
    pass: Pass,
    worst: &mut Vec<(f64, u32)>,
) {
    worst.clear();
    // Nearly all are open: a vector that grows would take three times the memory.
    worst.reserve(surface.triangles());
    let open = (0..surface.triangles() as u32).filter(is_open);
    worst.extend(open.map(|t| (weighted_error(surface, errors, t, pass), t)));
    let order = |a: &(f64, u32), b: &(f64, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    if worst.len() > limit {
        worst.select_nth_unstable_by(limit, order);
        worst.truncate(limit);
    }
    worst.sort_unstable_by(order);
}

/// The best openings in the triangles `worst`, the best first.
fn openings(
    surface: &Surface,
    activity: &Activity,
    worst: &[(f64, u32)],
    pass: Pass,
) -> Vec<Opening> {
    let found: Vec<Option<Opening>> = worst
        .par_iter()
        .with_min_len(CHUNK)
        .map_init(<[Ring; 2]>::default, |rings, &(_, t)| {
            best_opening(surface, activity, t, pass, rings)
        })
        .collect();
    let mut openings: Vec<Opening> = found.into_iter().flatten().collect();
    let gain = |o: &Opening| o.score(pass.weight);
    openings.sort_unstable_by(|a, b| gain(b).total_cmp(&gain(a)).then(a.site.cmp(&b.site)));
    openings
}

/// A good position for one more vertex in triangle `t` or on one of its edges: the best of their centres, improved by
/// a few steps. `rings` are scratch memory.
fn best_opening(
    surface: &Surface,
    activity: &Activity,
    t: u32,
    pass: Pass,
    [ring, best_ring]: &mut [Ring; 2],
) -> Option<Opening> {
    let has_other = |h: &u32| {
        let twin = surface.twin[*h as usize];
        twin != NONE && activity.covers(twin / 3)
    };
    let pairs = (3 * t..3 * t + 3).filter(has_other).map(Site::Pair);
    let mut best: Option<(Opening, Cost)> = None;
    for site in std::iter::once(Site::Triangle(t)).chain(pairs) {
        site.enclose(surface, ring);
        let place = site.centre(surface);
        if let Some(cost) = ring.try_at(pass.rows, place) {
            let found = Opening { gain: site.cost(surface) + cost.scaled(-1.0), site, place };
            if best.is_none_or(|(b, _)| found.score(pass.weight) > b.score(pass.weight)) {
                best = Some((found, cost));
                std::mem::swap(ring, best_ring);
            }
        }
    }
    let (Opening { site, place, .. }, cost) = best?;
    let (place, cost) = improve(place, cost, pass, best_ring);
    Some(Opening { gain: site.cost(surface) + cost.scaled(-1.0), site, place }.weighted(pass))
}

/// The error of triangle `t`, as much as it matters.
#[inline]
fn weighted_error(surface: &Surface, errors: &Errors, t: u32, pass: Pass) -> f64 {
    let error = errors.of(t);
    if pass.focus.is_none() {
        error
    } else {
        error * pass.focus_at(Site::Triangle(t).centre(surface))
    }
}

/// Steps of a new vertex before its gain is counted, and those in [thorough](super::options::Mode::Thorough) mode.
/// Later it moves with all others.
const SETTLING: usize = 2;
const CLOSE_SETTLING: usize = 4;

/// The position of a vertex that starts at `place` inside `ring`, which has its spokes and the cost `cost`, after a
/// few steps; and its cost there.
fn improve(mut place: Point, mut cost: Cost, pass: Pass, ring: &mut Ring) -> (Point, Cost) {
    let weight = pass.weight;
    let mut reach = 2.0 * f64::from(crate::geom::SUBPIXEL);
    let mut slope = None;
    for _ in 0..if pass.is_thorough() { CLOSE_SETTLING } else { SETTLING } {
        let mean = |i: usize| ring.total(pass.rows, i, place).mean();
        // The gradient is the same until it moves; and the spokes may be those of another position.
        let (gx, gy) = slope.unwrap_or_else(|| gradient(pass, place, ring, mean));
        slope = Some((gx, gy));
        let length = (gx * gx + gy * gy).sqrt();
        if length == 0.0 {
            break;
        }
        for _ in 0..2 {
            let step = |g: f64| (-g / length * reach).round() as i32;
            let to = Point::new(place.x + step(gx), place.y + step(gy));
            match ring.try_at(pass.rows, to) {
                Some(after) if after.total(weight) < cost.total(weight) => {
                    (place, cost, slope) = (to, after, None);
                    reach *= 1.5;
                    break;
                }
                _ => reach /= 2.5,
            }
        }
    }
    (place, cost)
}

impl Site {
    pub(super) fn triangle(self) -> u32 {
        match self {
            Site::Triangle(t) => t,
            Site::Pair(h) => h / 3,
        }
    }

    pub(super) fn enclose(self, surface: &Surface, ring: &mut Ring) {
        match self {
            Site::Triangle(t) => ring.enclose(surface, t),
            Site::Pair(h) => ring.enclose_pair(surface, h),
        }
    }

    fn cost(self, surface: &Surface) -> Cost {
        match self {
            Site::Triangle(t) => surface.cost[t as usize],
            Site::Pair(h) => {
                let twin = surface.twin[h as usize];
                surface.cost[h as usize / 3] + surface.cost[twin as usize / 3]
            }
        }
    }

    fn centre(self, surface: &Surface) -> Point {
        let place = |h: u32| surface.place(h);
        match self {
            Site::Triangle(t) => {
                let [a, b, c] = [3 * t, 3 * t + 1, 3 * t + 2].map(place);
                Point::new((a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3)
            }
            Site::Pair(h) => {
                let (a, b) = (place(h), place(surface.twin[h as usize]));
                Point::new((a.x + b.x) / 2, (a.y + b.y) / 2)
            }
        }
    }
}
