//! Edge flips: an edge becomes the other diagonal of its two triangles if that lowers the cost.

use crate::parallel::prelude::*;

use super::activity::Activity;
use super::cost::Cost;
use super::errors::Errors;
use super::pass::Pass;
use super::sums::Sums;
use super::surface::{NONE, Surface, next, previous};
use crate::geom::orient;

/// Half-edges in one parallel piece of work.
const CHUNK: usize = 3 * 256;

/// Flips inner edges if the other diagonal of their two triangles has lower cost (data-dependent triangulation: Dyn,
/// Levin, Rippa 1990). Only edges of a triangle that changed at or after tick `since` are tried. Returns the number
/// of flips.
pub(super) fn flip(
    surface: &mut Surface,
    errors: &mut Errors,
    activity: &Activity,
    since: u32,
    pass: Pass,
    found: &mut Vec<Vec<Diagonal>>,
) -> usize {
    surface.clock += 1;
    let here = &*surface;
    let is_allowed = |surface: &Surface, h: u32| {
        let (t, other) = (h / 3, surface.twin[h as usize] / 3);
        activity.covers(t)
            && activity.covers(other)
            && (activity.is_active_triangle(surface, t)
                || activity.is_active_triangle(surface, other))
    };
    found.resize_with(here.origin.len().div_ceil(CHUNK), Vec::new);
    found.par_iter_mut().enumerate().for_each(|(pack, found)| {
        let end = ((pack + 1) * CHUNK).min(here.origin.len());
        let edges = pack as u32 * CHUNK as u32..end as u32;
        found.clear();
        let edges = edges.filter(|&h| is_fresh(here, h, since) && is_allowed(here, h));
        found.extend(edges.filter_map(|h| turned(here, h, pass)));
    });
    let mut flips = 0;
    for &diagonal in found.iter().flatten() {
        let h = diagonal.edge;
        // A neighbour may have flipped meanwhile: evaluate again.
        let again = newest(surface, h) == surface.clock;
        let turned = if again { turned(surface, h, pass) } else { Some(diagonal) };
        if let Some(Diagonal { sums, front, back, .. }) = turned {
            let pair = [h / 3, surface.twin[h as usize] / 3];
            let squares = errors.squares(surface, pair.into_iter());
            turn(surface, h, sums);
            surface.changed(pass.rows, pair[0], front);
            surface.changed(pass.rows, pair[1], back);
            errors.distribute(surface, squares, &pair);
            flips += 1;
        }
    }
    flips
}

/// A flip that lowers the cost.
#[derive(Clone, Copy, Debug)]
pub(super) struct Diagonal {
    /// The edge.
    edge: u32,
    /// Sums of the new edge, from the opposite corner of the twin's triangle to that of its own.
    sums: Sums,
    /// Costs of the new triangles, at the edge's origin and at its end.
    front: Cost,
    back: Cost,
}

/// The last change of the two triangles of inner edge `h`.
fn newest(surface: &Surface, h: u32) -> u32 {
    let twin = surface.twin[h as usize];
    surface.stamp[h as usize / 3].max(surface.stamp[twin as usize / 3])
}

fn is_fresh(surface: &Surface, h: u32, since: u32) -> bool {
    let twin = surface.twin[h as usize];
    // Border edges are excluded here: NONE is the highest number.
    twin < h && newest(surface, h) >= since
}

/// The flip of edge `h`, if it lowers the cost.
fn turned(surface: &Surface, h: u32, pass: Pass) -> Option<Diagonal> {
    let g = surface.twin[h as usize];
    if g == NONE {
        return None;
    }
    let (a, b) = (surface.place(h), surface.place(g));
    let (c, d) = (surface.place(previous(h)), surface.place(previous(g)));
    if orient(a, d, c) <= 0 || orient(d, b, c) <= 0 {
        return None;
    }
    let before = surface.cost[h as usize / 3] + surface.cost[g as usize / 3];
    let sums = pass.rows.edge(d, c);
    let side = |h: u32| surface.sums[h as usize];
    let front = Cost::of(pass.rows, &(side(next(g)) + sums + side(previous(h))), [a, d, c]);
    let back = Cost::of(pass.rows, &(side(next(h)) - sums + side(previous(g))), [b, c, d]);
    let gain = before.gain(front + back, pass.weight);
    (gain > pass.min_gain).then_some(Diagonal { edge: h, sums, front, back })
}

/// Flips edge `h` from a-b to d-c, where c and d are the opposite corners: `h`'s triangle becomes a, d, c and its
/// twin's b, c, d. Half-edges c-a and d-b keep their numbers.
fn turn(surface: &mut Surface, h: u32, sums: Sums) {
    let g = surface.twin[h as usize];
    let (h1, g1) = (next(h), next(g));
    let (a, b) = (surface.from(h), surface.from(g));
    let (c, d) = (surface.to(h1), surface.to(g1));
    let moved = |s: &mut Surface, from: u32, to: u32| {
        s.sums[to as usize] = s.sums[from as usize];
        let twin = s.twin[from as usize];
        s.twin[to as usize] = twin;
        if let Some(back) = s.twin.get_mut(twin as usize) {
            *back = to;
        }
        let v = s.origin[from as usize] as usize;
        if s.out[v] == from {
            s.out[v] = to;
        }
    };
    for (v, h) in [(a, h), (b, g)] {
        debug_assert_eq!(surface.from(h), v);
    }
    moved(surface, g1, h);
    moved(surface, h1, g);
    surface.origin[h1 as usize] = d;
    surface.origin[g1 as usize] = c;
    surface.twin[h1 as usize] = g1;
    surface.twin[g1 as usize] = h1;
    surface.set_sums(h1, sums);
}
