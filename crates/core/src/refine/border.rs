//! Re-places vertices on the frame's border, so that contours that leave the frame have one where they do.
//!
//! Vertices slide along the border as they move, but none gets past its neighbours there, and none onto the border or off
//! it. Without this the end of a contour comes close to the border, and a needle is left between. Measured on 16 stills
//! by default: of the triangles at the border 1.30 % had an angle below 5 degrees, and 0.1 % have.

use super::activity::Activity;
use super::cost::Cost;
use super::errors::Errors;
use super::pass::Pass;
use super::patch::{Closing, Plan, put_in, put_on_border, take_out};
use super::replace::{Opening, best_openings};
use super::ring::Ring;
use super::share::Turn;
use super::surface::{NONE, Surface, next, previous};
use crate::geom::Point;
use crate::mesh::Place;

/// The passes that look at the border. A still has some 24 until nothing is left to gain; changes later than these would
/// only put that off.
const LOOKS: [u32; 4] = [1, 6, 12, 18];

/// Places that are tried along an edge of the border.
const TRIED: i32 = 6;

/// Flatness of a triangle from which on its vertex opposite the border is moved there: an angle of 10 degrees.
const FLAT: f64 = 15.0;

/// Openings that are looked for, for each vertex that is moved to the border.
const OPENINGS: usize = 4;

/// A vertex on the border that may be removed.
struct Leaving {
    cost: Cost,
    vertex: u32,
    plan: Plan,
}

/// A place for a vertex on an edge of the border.
struct Gap {
    gain: f64,
    edge: u32,
    place: Point,
}

/// A vertex inside that may move to the edge of the border opposite it.
struct Snap {
    gain: Cost,
    vertex: u32,
    edge: u32,
    place: Point,
}

/// Whether pass `number` is one that looks at the border.
pub(super) fn is_due(number: u32) -> bool {
    LOOKS.contains(&number)
}

/// Re-places vertices on the border: see the top of this file. The numbers of vertices and of triangles stay. Returns the vertices.
pub(super) fn replace_on_border(
    surface: &mut Surface,
    errors: &mut Errors,
    activity: &Activity,
    turn: Turn,
    pass: Pass,
) -> Vec<u32> {
    let mut change = Change {
        leaving: leaving(surface, pass).into_iter(),
        taken: vec![false; surface.triangles()],
        replaced: Vec::new(),
        around: Ring::default(),
    };
    change.snap(surface, errors, activity, turn, pass);
    change.fill_gaps(surface, errors, pass);
    change.replaced
}

/// What is left to change, and what was.
struct Change {
    /// The vertices on the border, the cheapest first.
    leaving: std::vec::IntoIter<Leaving>,
    /// The triangles that were changed: half-edges of theirs may have other neighbours now.
    taken: Vec<bool>,
    replaced: Vec<u32>,
    /// What surrounds the vertex that leaves.
    around: Ring,
}

impl Change {
    /// Moves vertices to the border that are so close to it that a needle is between. For each of them one that is on the
    /// border goes inside, where the error is large.
    fn snap(
        &mut self,
        surface: &mut Surface,
        errors: &mut Errors,
        activity: &Activity,
        turn: Turn,
        pass: Pass,
    ) {
        let snaps = snaps(surface, pass);
        if snaps.is_empty() {
            return;
        }
        let tried = OPENINGS * snaps.len();
        let openings = best_openings(surface, errors, activity, turn, tried, pass);
        let mut openings = openings.into_iter();
        let (mut ring, mut inside) = <(Ring, Ring)>::default();
        for Snap { gain, vertex, edge, place } in snaps {
            if self.taken[edge as usize / 3] {
                continue;
            }
            ring.surround_at_border(surface, vertex, edge);
            if !self.is_free(&ring) {
                continue;
            }
            let Some(Leaving { cost, vertex: other, plan }) = self.next(surface, [&ring], edge)
            else {
                break;
            };
            let opening = openings.find(|Opening { site, .. }| {
                if self.taken[site.triangle() as usize] {
                    return false;
                }
                site.enclose(surface, &mut inside);
                self.is_free(&inside) && !meet(&inside, [&ring, &self.around], edge)
            });
            let Some(opening) = opening else { break };
            let whole = gain + opening.gain + cost.scaled(-1.0);
            let is_sound = ring.try_at(pass.rows, place).is_some()
                && inside.try_at(pass.rows, opening.place).is_some();
            if !is_sound || whole.total(pass.weight).min(whole.error) <= pass.min_gain {
                continue;
            }
            self.take([&ring, &inside], edge);
            let [spare, _] = take_out(surface, errors, pass.rows, &self.around, &plan);
            let between = put_on_border(surface, errors, pass, &ring, (vertex, edge, place));
            put_in(surface, errors, pass, &inside, other, opening.place, [spare, between]);
            self.replaced.extend([vertex, other]);
        }
    }

    /// Removes vertices where they lower the error least, and inserts them on edges of the border where they lower it most,
    /// as long as that gains more.
    fn fill_gaps(&mut self, surface: &mut Surface, errors: &mut Errors, pass: Pass) {
        let mut ring = Ring::default();
        for Gap { gain, edge, place } in gaps(surface, pass) {
            if self.taken[edge as usize / 3] {
                continue;
            }
            ring.enclose_border(surface, edge);
            let Some(Leaving { cost, vertex, plan }) = self.next(surface, [&ring], edge) else {
                break;
            };
            if gain - price(cost, pass) <= pass.min_gain {
                break;
            }
            if ring.try_at(pass.rows, place).is_none() {
                continue;
            }
            self.take([&ring], edge);
            let spare = take_out(surface, errors, pass.rows, &self.around, &plan);
            put_in(surface, errors, pass, &ring, vertex, place, spare);
            self.replaced.push(vertex);
        }
    }

    /// The next vertex to leave whose surroundings have nothing to do with `rings`, nor with the triangle of `edge`, and have
    /// not changed.
    fn next<const N: usize>(
        &mut self,
        surface: &Surface,
        rings: [&Ring; N],
        edge: u32,
    ) -> Option<Leaving> {
        let Self { leaving, taken, around, .. } = self;
        leaving.find(|candidate| {
            around.surround(surface, candidate.vertex, surface.around(candidate.vertex));
            around.links.iter().all(|&h| !taken[h as usize / 3]) && !meet(around, rings, edge)
        })
    }

    fn is_free(&self, ring: &Ring) -> bool {
        ring.links.iter().all(|&h| !self.taken[h as usize / 3])
    }

    fn take<const N: usize>(&mut self, rings: [&Ring; N], edge: u32) {
        self.taken[edge as usize / 3] = true;
        for &h in rings.into_iter().chain([&self.around]).flat_map(|ring| &ring.links) {
            self.taken[h as usize / 3] = true;
        }
    }
}

/// Whether `ring` has a triangle of one of `rings`, or that of `edge`.
fn meet<const N: usize>(ring: &Ring, rings: [&Ring; N], edge: u32) -> bool {
    let others = || rings.iter().flat_map(|ring| &ring.links).chain([&edge]);
    ring.links.iter().any(|h| others().any(|other| other / 3 == h / 3))
}

/// The vertices on the border, the cheapest to remove first.
fn leaving(surface: &Surface, pass: Pass) -> Vec<Leaving> {
    let (mut ring, mut closing) = <(Ring, Closing)>::default();
    let is_on_border =
        |v: &u32| matches!(surface.freedom(*v), Place::SideBorder | Place::LevelBorder);
    let mut leaving: Vec<Leaving> = (0..surface.at.len() as u32)
        .filter(is_on_border)
        .filter_map(|vertex| {
            ring.surround(surface, vertex, surface.around(vertex));
            ring.sum_up(surface);
            let plan = closing.plan(&ring, pass.rows, pass.weight)?;
            let cost = plan.cost + ring.cost(surface).scaled(-1.0);
            let cost = cost.scaled(pass.focus_at(surface.at[vertex as usize]));
            Some(Leaving { cost, vertex, plan })
        })
        .collect();
    leaving.sort_by(|a, b| price(a.cost, pass).total_cmp(&price(b.cost, pass)));
    leaving
}

/// The cost of a change: of error, or of error with shape, whichever is larger.
fn price(cost: Cost, pass: Pass) -> f64 {
    cost.total(pass.weight).max(cost.error)
}

/// The best place on each edge of the border, the best first.
fn gaps(surface: &Surface, pass: Pass) -> Vec<Gap> {
    let mut ring = Ring::default();
    let edges = (0..surface.twin.len() as u32).filter(|&h| surface.twin[h as usize] == NONE);
    let mut gaps: Vec<Gap> = edges
        .filter_map(|edge| {
            ring.enclose_border(surface, edge);
            let before = surface.cost[edge as usize / 3];
            let (from, to) = (surface.place(edge), surface.place(next(edge)));
            let mut gain = |place: Point| {
                let after = ring.try_at(pass.rows, place)?;
                let gain = before + after.scaled(-1.0);
                Some(gain.total(pass.weight).min(gain.error) * pass.focus_at(place))
            };
            let places = (1..TRIED).map(|i| part(from, to, i));
            let tried = places.filter_map(|place| Some(Gap { gain: gain(place)?, edge, place }));
            tried.max_by(|a, b| a.gain.total_cmp(&b.gain))
        })
        .collect();
    gaps.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    gaps
}

/// The place at `i` of [`TRIED`] parts of the way.
fn part(from: Point, to: Point, i: i32) -> Point {
    let along = |a: i32, b: i32| {
        a + ((i64::from(b) - i64::from(a)) * i64::from(i) / i64::from(TRIED)) as i32
    };
    Point::new(along(from.x, to.x), along(from.y, to.y))
}

/// The vertices inside that are close to the border, those first that gain most.
fn snaps(surface: &Surface, pass: Pass) -> Vec<Snap> {
    let mut ring = Ring::default();
    let is_flat =
        |&h: &u32| surface.twin[h as usize] == NONE && surface.cost[h as usize / 3].shape > FLAT;
    let edges = (0..surface.twin.len() as u32).filter(is_flat);
    let snap = |edge: u32| {
        let vertex = surface.from(previous(edge));
        if surface.freedom(vertex) != Place::Interior {
            return None;
        }
        let (from, to) = (surface.place(edge), surface.place(next(edge)));
        let at = surface.at[vertex as usize];
        let place =
            if from.y == to.y { Point::new(at.x, from.y) } else { Point::new(from.x, at.y) };
        let before = ring.surround_at_border(surface, vertex, edge);
        let after = ring.try_at(pass.rows, place)?;
        Some(Snap { gain: before + after.scaled(-1.0), vertex, edge, place })
    };
    let mut snaps: Vec<Snap> = edges.filter_map(snap).collect();
    let gain = |snap: &Snap| snap.gain.total(pass.weight);
    snaps.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
    snaps
}
