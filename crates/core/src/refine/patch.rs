//! Removes a vertex from the mesh, and inserts it elsewhere.

use smallvec::SmallVec;

use super::cost::Cost;
use super::errors::Errors;
use super::pass::Pass;
use super::ring::Ring;
use super::rows::RowSums;
use super::sums::Sums;
use super::surface::{NONE, Surface, next, previous};
use crate::geom::Point;
use crate::mesh::Place;

/// Vertices with more neighbours are not removed: they hold many triangles, and the number of ways to close the hole
/// grows with the cube of its corners.
pub(super) const MAX_CORNERS: usize = 9;

/// A triangulation of the hole that a removed vertex leaves. Each triangle comes before those on its inner sides.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Its cost.
    pub(super) cost: Cost,
    pieces: SmallVec<[Piece; MAX_CORNERS - 2]>,
}

/// A triangle of a [`Plan`], of three corners of the polygon, ascending.
#[derive(Clone, Copy, Debug)]
struct Piece {
    corners: [u8; 3],
    /// Sums from its first corner to its last.
    chord: Sums,
    cost: Cost,
}

/// Finds the cheapest [`Plan`], by dynamic programming over sub-polygons (Klincsek 1980).
#[derive(Debug, Default)]
pub(super) struct Closing {
    /// The corner that closes the triangle over chord `i`-`j`.
    apex: [[u8; MAX_CORNERS]; MAX_CORNERS],
    /// Sums from corner `i` to corner `j`.
    chord: [[Sums; MAX_CORNERS]; MAX_CORNERS],
    best: [[Cost; MAX_CORNERS]; MAX_CORNERS],
}

impl Closing {
    /// The cheapest triangulation of the polygon of `ring`, which an open one has the frame's border to close; `None`
    /// if it has too many corners, or if every triangulation has a triangle without area.
    pub(super) fn plan(&mut self, ring: &Ring, rows: &RowSums, weight: f64) -> Option<Plan> {
        let corners = ring.corners();
        if !(3..=MAX_CORNERS).contains(&corners) {
            return None;
        }
        for i in 0..corners {
            for j in i + 1..corners {
                let sums = if j == i + 1 {
                    ring.link_sums[i]
                } else if i == 0 && j + 1 == corners && ring.closed {
                    -ring.link_sums[j]
                } else {
                    rows.edge(ring.ends[i], ring.ends[j])
                };
                self.chord[i][j] = sums;
            }
        }
        for width in 1..corners {
            for i in 0..corners - width {
                self.solve(ring, rows, i, i + width, weight);
            }
        }
        let cost = self.best[0][corners - 1];
        cost.shape.is_finite().then(|| Plan { cost, pieces: self.pieces(ring, rows) })
    }

    fn solve(&mut self, ring: &Ring, rows: &RowSums, i: usize, j: usize, weight: f64) {
        self.best[i][j] = if j == i + 1 { Cost::default() } else { Cost::INFINITE };
        for m in i + 1..j {
            let cost = self.best[i][m] + self.best[m][j];
            if !cost.shape.is_finite() {
                continue;
            }
            let cost = cost + self.triangle_cost(rows, &ring.ends, [i, m, j]);
            let better = !self.best[i][j].shape.is_finite()
                || cost.total(weight) < self.best[i][j].total(weight);
            if cost.shape.is_finite() && better {
                self.best[i][j] = cost;
                self.apex[i][j] = m as u8;
            }
        }
    }

    /// The triangles of the solution for `ring`.
    fn pieces(&self, ring: &Ring, rows: &RowSums) -> SmallVec<[Piece; MAX_CORNERS - 2]> {
        let mut pieces = SmallVec::new();
        let mut open = SmallVec::<[_; MAX_CORNERS]>::new();
        open.push([0, ring.corners() - 1]);
        while let Some([i, j]) = open.pop() {
            let m = usize::from(self.apex[i][j]);
            let corners = [i as u8, m as u8, j as u8];
            let cost = self.triangle_cost(rows, &ring.ends, [i, m, j]);
            pieces.push(Piece { corners, chord: self.chord[i][j], cost });
            open.extend([[i, m], [m, j]].into_iter().filter(|[from, to]| to - from > 1));
        }
        pieces
    }

    fn triangle_cost(&self, rows: &RowSums, ends: &[Point], [i, m, j]: [usize; 3]) -> Cost {
        let sums = self.chord[i][m] + self.chord[m][j] - self.chord[i][j];
        Cost::of(rows, &sums, [ends[i], ends[m], ends[j]])
    }
}

/// A half-edge of the polygon, as the mesh outside refers to it.
#[derive(Clone, Copy, Debug)]
struct Link {
    vertex: u32,
    twin: u32,
    sums: Sums,
}

/// The links of `ring`, those of an open one with the frame's border as the last, whose sums are 0. They must be read
/// before any of its triangles is written.
fn links(surface: &Surface, ring: &Ring) -> SmallVec<[Link; MAX_CORNERS]> {
    let link = |&h: &u32| Link {
        vertex: surface.from(h),
        twin: surface.twin[h as usize],
        sums: surface.sums[h as usize],
    };
    let border = ring.links.last().filter(|_| !ring.closed);
    let border = border.map(|&h| Link { vertex: surface.to(h), twin: NONE, sums: Sums::default() });
    ring.links.iter().map(link).chain(border).collect()
}

/// Removes the vertex inside `ring` and closes the hole as planned. Returns the numbers of the two triangles that
/// become free; for a vertex on the border of one, and [`NONE`].
pub(super) fn take_out(
    surface: &mut Surface,
    errors: &mut Errors,
    rows: &RowSums,
    ring: &Ring,
    plan: &Plan,
) -> [u32; 2] {
    let links = links(surface, ring);
    let squares = errors.squares(surface, ring.links.iter().map(|&h| h / 3));
    let mut slots = ring.links.iter().map(|&h| h / 3);
    let first = slots.next().unwrap_or(NONE);
    let second = if ring.closed { slots.next().unwrap_or(NONE) } else { NONE };
    let left = [first, second];
    // The outer half-edges of the triangles that are not made yet.
    let mut open = SmallVec::<[_; MAX_CORNERS]>::new();
    open.push(NONE);
    let mut made = SmallVec::<[_; MAX_CORNERS]>::new();
    for (piece, t) in plan.pieces.iter().zip(slots) {
        let Some(outer) = open.pop() else { break };
        let [i, m, j] = piece.corners.map(usize::from);
        let h = 3 * t;
        for (side, (from, to)) in (0..).zip([(i, m), (m, j)]) {
            if to == from + 1 {
                attach(surface, h + side, links[from]);
            } else {
                surface.origin[(h + side) as usize] = links[from].vertex;
                open.push(h + side);
            }
        }
        let sums = -piece.chord;
        if outer == NONE {
            let sums = if ring.closed { links[j].sums } else { sums };
            attach(surface, h + 2, Link { sums, ..links[j] });
        } else {
            attach(surface, h + 2, Link { vertex: links[j].vertex, twin: outer, sums });
            surface.sums[outer as usize] = -sums;
        }
        made.push(t);
    }
    // All of them have their sums only now.
    for (&t, piece) in made.iter().zip(&plan.pieces) {
        surface.changed(rows, t, piece.cost);
    }
    errors.distribute(surface, squares, &made);
    left
}

/// Moves vertex `v` to `p` on the border's half-edge `h` opposite it, which `ring` surrounds there: see
/// [`Ring::surround_at_border`]. Returns the triangle between, which becomes free.
pub(super) fn put_on_border(
    surface: &mut Surface,
    errors: &mut Errors,
    pass: Pass,
    ring: &Ring,
    (v, h, p): (u32, u32, Point),
) -> u32 {
    let (coming, leaving) = (surface.twin[previous(h) as usize], surface.twin[next(h) as usize]);
    surface.at[v as usize] = p;
    for border in [coming, leaving] {
        surface.twin[border as usize] = NONE;
        let from = surface.from(border);
        surface.out[from as usize] = border;
    }
    for (i, &link) in ring.links.iter().enumerate() {
        surface.sums[previous(link) as usize] = ring.spokes[i];
        surface.sums[next(link) as usize] = -ring.spokes[i + 1];
    }
    for (i, &link) in ring.links.iter().enumerate() {
        let (cost, mean) = ring.triangle(pass.rows, i, p);
        surface.set_triangle(link / 3, cost, mean);
        errors.remeasure(surface, link / 3, pass);
    }
    h / 3
}

/// Inserts vertex `v` at `p` inside the polygon of `ring`, or on the border that closes it, whose spokes are those of
/// `p`: its triangles and those of `spare` become the fan around it.
pub(super) fn put_in(
    surface: &mut Surface,
    errors: &mut Errors,
    pass: Pass,
    ring: &Ring,
    v: u32,
    p: Point,
    spare: [u32; 2],
) {
    let links = links(surface, ring);
    let mut slots: SmallVec<[u32; MAX_CORNERS]> = ring.links.iter().map(|&h| h / 3).collect();
    slots.sort_unstable();
    slots.dedup();
    slots.extend(spare.into_iter().filter(|&t| t != NONE));
    debug_assert_eq!(slots.len(), ring.len());
    surface.at[v as usize] = p;
    if !ring.closed {
        surface.twin[3 * slots[0] as usize] = NONE;
    }
    for i in 0..ring.len() {
        let after = (i + 1) % links.len();
        let h = 3 * slots[i];
        let onward = slots.get(after).map_or(NONE, |t| 3 * t);
        surface.origin[h as usize] = v;
        surface.sums[h as usize] = ring.spokes[i];
        attach(surface, h + 1, links[i]);
        let back = Link { vertex: links[after].vertex, twin: onward, sums: -ring.spokes[after] };
        attach(surface, h + 2, back);
    }
    surface.out[v as usize] = 3 * slots[0];
    for (i, &t) in slots.iter().enumerate() {
        let (cost, mean) = ring.triangle(pass.rows, i, p);
        surface.set_triangle(t, cost, mean);
        errors.remeasure(surface, t, pass);
    }
}

/// Writes half-edge `h` and its twin's link, and, unless the vertex is on the border, makes it the first half-edge of
/// its vertex.
fn attach(surface: &mut Surface, h: u32, link: Link) {
    let Link { vertex, twin, sums } = link;
    surface.origin[h as usize] = vertex;
    surface.twin[h as usize] = twin;
    surface.sums[h as usize] = sums;
    if twin != NONE {
        surface.twin[twin as usize] = h;
    }
    // The first half-edge of a border vertex is always the one along the border.
    if twin == NONE || surface.freedom(vertex) == Place::Interior {
        surface.out[vertex as usize] = h;
    }
}
