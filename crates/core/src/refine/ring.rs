//! The polygon around a vertex: the area in which it may move, and the cost of each position there.

use smallvec::SmallVec;

use super::cost::Cost;
use super::mean::Mean;
use super::rows::RowSums;
use super::sums::{Sums, Total};
use super::surface::{NONE, Surface, next, previous};
use crate::geom::{Point, orient};

/// The polygon around a vertex, or around a position for a new one. Triangle `i` of the fan has the corners centre,
/// `ends[i]`, `ends[i + 1]`.
#[derive(Debug, Default)]
pub(super) struct Ring {
    /// Corners of the polygon, one more than triangles: around an inner vertex the last is the first.
    pub(super) ends: Vec<Point>,
    /// The half-edges of the polygon: from `ends[i]` to `ends[i + 1]`, inside it.
    pub(super) links: Vec<u32>,
    /// Their pixel sums.
    pub(super) link_sums: Vec<Sums>,
    /// The sums of the spokes for the last position tried, one for each of `ends`.
    pub(super) spokes: Vec<Sums>,
    /// Spokes saved by [`Ring::keep`].
    kept: Vec<Sums>,
    /// Twice the areas of the triangles for the last position tried.
    doubled: Vec<i64>,
    /// Whether the polygon is closed.
    pub(super) closed: bool,
}

impl Ring {
    /// Sets the polygon around vertex `v` with the half-edges `leaving`, without its sums: see [`Ring::sum_up`].
    pub(super) fn surround(
        &mut self,
        surface: &Surface,
        v: u32,
        leaving: impl Iterator<Item = u32>,
    ) {
        self.clear();
        leaving.for_each(|h| self.push(surface, next(h)));
        self.closed = surface.twin[surface.out[v as usize] as usize] != NONE;
        self.finish(surface);
    }

    /// The end of the last link.
    fn finish(&mut self, surface: &Surface) {
        if let Some(&link) = self.links.last() {
            self.ends.push(surface.place(next(link)));
        }
    }

    /// Reads the sums of the links, and of the spokes for the present position of the vertex of [`Ring::surround`].
    pub(super) fn sum_up(&mut self, surface: &Surface) {
        self.sum_links(surface);
        let spoke = |&link: &u32| surface.sums[previous(link) as usize];
        self.spokes.extend(self.links.iter().map(spoke));
        if let Some(&link) = self.links.last() {
            self.spokes.push(-surface.sums[next(link) as usize]);
        }
    }

    fn sum_links(&mut self, surface: &Surface) {
        self.link_sums.extend(self.links.iter().map(|&link| surface.sums[link as usize]));
    }

    /// Sets triangle `t` as the polygon.
    pub(super) fn enclose(&mut self, surface: &Surface, t: u32) {
        self.clear();
        for h in 3 * t..3 * t + 3 {
            self.push(surface, h);
        }
        self.finish(surface);
        self.sum_links(surface);
        self.closed = true;
    }

    /// Sets the two triangles of the inner edge `h` as the polygon.
    pub(super) fn enclose_pair(&mut self, surface: &Surface, h: u32) {
        self.clear();
        let g = surface.twin[h as usize];
        for h in [next(h), previous(h), next(g), previous(g)] {
            self.push(surface, h);
        }
        self.finish(surface);
        self.sum_links(surface);
        self.closed = true;
    }

    fn clear(&mut self) {
        self.ends.clear();
        self.links.clear();
        self.link_sums.clear();
        self.spokes.clear();
    }

    fn push(&mut self, surface: &Surface, link: u32) {
        self.links.push(link);
        self.ends.push(surface.place(link));
    }

    /// Sets the triangle of the border's half-edge `h` as a polygon that is open there.
    pub(super) fn enclose_border(&mut self, surface: &Surface, h: u32) {
        self.clear();
        for h in [next(h), previous(h)] {
            self.push(surface, h);
        }
        self.finish(surface);
        self.sum_links(surface);
        self.closed = false;
    }

    /// Sets the polygon around vertex `v`, which lies opposite the border's half-edge `h`, as it is when `v` is moved to
    /// the border: open there, without the triangle between, which has no area then. Returns the cost of all triangles
    /// as they are in the mesh.
    pub(super) fn surround_at_border(&mut self, surface: &Surface, v: u32, h: u32) -> Cost {
        let between = previous(h);
        let leaving: SmallVec<[u32; 16]> = surface.around(v).collect();
        let first = leaving.iter().position(|&h| h == between).unwrap_or(0);
        let others = leaving[first + 1..].iter().chain(&leaving[..first]);
        self.clear();
        others.for_each(|&h| self.push(surface, next(h)));
        self.closed = false;
        self.finish(surface);
        self.sum_links(surface);
        self.cost(surface) + surface.cost[h as usize / 3]
    }

    /// Number of corners of the polygon.
    pub(super) fn corners(&self) -> usize {
        self.links.len() + usize::from(!self.closed)
    }

    /// Number of triangles in the fan.
    pub(super) fn len(&self) -> usize {
        self.links.len()
    }

    /// The cost of the triangles as they are in the mesh; for a polygon around a vertex, of its fan.
    pub(super) fn cost(&self, surface: &Surface) -> Cost {
        self.links.iter().map(|&h| surface.cost[h as usize / 3]).sum()
    }

    fn triangle_sums(&self, i: usize) -> Sums {
        self.spokes[i] + self.link_sums[i] - self.spokes[i + 1]
    }

    /// The sums of triangle `i` with the present spokes and the centre at `p`, which [`Ring::try_at`] has found to be
    /// valid.
    pub(super) fn total(&self, rows: &RowSums, i: usize, p: Point) -> Total {
        let (a, b) = (self.ends[i], self.ends[i + 1]);
        rows.total(&self.triangle_sums(i), orient(p, a, b), [p, a, b])
    }

    /// Cost and mean of triangle `i` with the present spokes and the centre at `p`, which [`Ring::try_at`] has found
    /// to be valid.
    pub(super) fn triangle(&self, rows: &RowSums, i: usize, p: Point) -> (Cost, Mean) {
        let (a, b) = (self.ends[i], self.ends[i + 1]);
        let total = self.total(rows, i, p);
        let doubled = orient(p, a, b);
        let cost = match rows.planes() {
            Some(_) => Cost::special(rows, doubled, [p, a, b]),
            None => Cost::with(&total, doubled, [p, a, b]),
        };
        (cost.limited(rows, doubled), Mean::of(&total))
    }

    /// Saves the spokes, for [`Ring::restore`] after another trial.
    pub(super) fn keep(&mut self) {
        std::mem::swap(&mut self.spokes, &mut self.kept);
    }

    /// Restores the saved spokes.
    pub(super) fn restore(&mut self) {
        std::mem::swap(&mut self.spokes, &mut self.kept);
    }

    /// Sums the spokes for a centre at `p` and returns the cost of the fan; `None` if one of its triangles would fold
    /// or have no area.
    pub(super) fn try_at(&mut self, rows: &RowSums, p: Point) -> Option<Cost> {
        self.doubled.clear();
        for pair in self.ends.windows(2) {
            let doubled = orient(p, pair[0], pair[1]);
            if doubled <= 0 {
                return None;
            }
            self.doubled.push(doubled);
        }
        self.spokes.clear();
        let distinct = &self.ends[..self.ends.len() - usize::from(self.closed)];
        self.spokes.extend(distinct.iter().map(|&end| rows.edge(p, end)));
        if self.closed {
            self.spokes.push(self.spokes[0]);
        }
        let triangles = self.ends.windows(2).zip(&self.doubled);
        let sums = self.spokes.windows(2).zip(&self.link_sums);
        let costs = triangles.zip(sums).map(|((ends, &doubled), (spokes, &link))| {
            let sums = spokes[0] + link - spokes[1];
            Cost::sound(rows, &sums, doubled, [p, ends[0], ends[1]])
        });
        Some(costs.sum())
    }
}
