//! Where a new triangle lay in the frame before, had it gone the way of its corners: its colour is likely the one there.

use super::NONE;
use super::half_edges::HalfEdges;
use crate::geom::{Point, orient};

/// The frame before, in its own numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places<'a> {
    pub(super) points: &'a [Point],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) edges: &'a HalfEdges,
    /// The number that each vertex of this frame had there, [`NONE`] of new ones.
    pub(super) back: &'a [u32],
    /// Where each stands now.
    pub(super) now: &'a [Point],
}

/// The most triangles that are walked through.
const MOST_STEPS: usize = 32;

impl Places<'_> {
    /// The triangle of the frame before in which the middle of `triangle` lay; `None` if all its corners are new.
    pub(super) fn find(&self, triangle: [u32; 3]) -> Option<u32> {
        let old = triangle.map(|v| self.back[v as usize]);
        let from = old.iter().find(|&&v| v != NONE)?;
        let mut t = self.edges.from(*from).first()?.2;
        let place = |i: usize| match old[i] {
            NONE => self.now[triangle[i] as usize],
            v => self.points[v as usize],
        };
        let corners = [place(0), place(1), place(2)];
        // Coordinates are below 2^23.
        let middle = |c: fn(&Point) -> i32| corners.iter().map(c).sum::<i32>().div_euclid(3);
        let p = Point::new(middle(|p| p.x), middle(|p| p.y));
        for _ in 0..MOST_STEPS {
            let [a, b, c] = self.triangles[t as usize];
            let beyond = |&(from, to): &(u32, u32)| {
                orient(self.points[from as usize], self.points[to as usize], p) < 0
            };
            let Some((from, to)) = [(a, b), (b, c), (c, a)].into_iter().find(beyond) else { break };
            let Some((_, next)) = self.edges.left_of(to, from) else { break };
            t = next;
        }
        Some(t)
    }
}
