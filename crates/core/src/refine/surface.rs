//! The mesh during refinement: half-edges with pixel sums, triangles with costs.

mod fans;
mod measure;

use super::cost::Cost;
use super::mean::Mean;
use super::morton::MortonOrder;
use super::rows::RowSums;
use super::sums::{Sums, Total};
use crate::frame::Fill;
use crate::geom::{Point, Size, orient};
use crate::mesh::{CORNERS, Mesh, Place, starts};
pub(super) use fans::{Fan, Fans, TOGETHER, around_each};

/// No half-edge: outside the frame.
pub(super) const NONE: u32 = u32::MAX;

/// The next half-edge around the triangle.
pub(super) const fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge before `h` around the triangle.
pub(super) const fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// Reorders `values`, `EACH` for each triangle: `old` has the old number of each triangle. `spare` is scratch memory.
pub(super) fn permute<const EACH: usize, T: Copy>(
    values: &mut Vec<T>,
    old: &[u32],
    spare: &mut Vec<T>,
) {
    spare.clear();
    let (triangles, _) = values.as_chunks::<EACH>();
    spare.extend(old.iter().flat_map(|&t| triangles[t as usize]));
    std::mem::swap(values, spare);
}

/// First corners in one parallel piece of the sort.
const SORTED: usize = 4096;

/// The mesh during refinement. Half-edge `h` belongs to triangle `h / 3` and runs from its origin to the origin of
/// the next one.
#[derive(Debug)]
pub(super) struct Surface {
    pub(super) size: Size,
    /// The vertices in an order that keeps neighbours close together: along a Z-order curve.
    pub(super) order: Vec<u32>,
    /// The positions of the vertices.
    pub(super) at: Vec<Point>,
    /// The vertex that each half-edge starts from.
    pub(super) origin: Vec<u32>,
    /// The same edge seen from the other triangle, or [`NONE`].
    pub(super) twin: Vec<u32>,
    /// A half-edge that leaves each vertex; for a vertex on the border the one that runs along it.
    pub(super) out: Vec<u32>,
    /// The signed pixel sums of each half-edge.
    pub(super) sums: Vec<Sums>,
    /// The cost of each triangle.
    pub(super) cost: Vec<Cost>,
    /// Its mean colour and number of pixels.
    pub(super) mean: Vec<Mean>,
    /// In streams, an estimate of the squared error of each triangle from the measurement, in squared 8-bit steps;
    /// infinite if unknown.
    pub(super) estimate: Vec<f32>,
    /// When each triangle last changed, in ticks of `clock`.
    pub(super) stamp: Vec<u32>,
    /// Counts passes over the mesh.
    pub(super) clock: u32,
    /// The triangles as they were last stored.
    pub(super) stored: Vec<[u32; 3]>,
    /// Second corners and numbers of the triangles of a first corner: no two triangles share two corners in order.
    numbered: Vec<(u32, u32)>,
    morton: MortonOrder,
    /// Scratch for the triangles' new numbers, and for a list in a new order.
    new: Vec<u32>,
    spare: Vec<u32>,
    /// Vertices that a step visits: the active set.
    pub(super) active: Vec<bool>,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            size: Size::new(0, 0),
            order: Vec::new(),
            at: Vec::new(),
            origin: Vec::new(),
            twin: Vec::new(),
            out: Vec::new(),
            sums: Vec::new(),
            cost: Vec::new(),
            mean: Vec::new(),
            estimate: Vec::new(),
            stamp: Vec::new(),
            clock: 0,
            stored: Vec::new(),
            numbered: Vec::new(),
            morton: MortonOrder::default(),
            new: Vec::new(),
            spare: Vec::new(),
            active: Vec::new(),
        }
    }
}

impl Surface {
    /// Links the half-edges of `mesh`, which must be sound. O(n).
    pub(super) fn link(&mut self, mesh: &Mesh) {
        self.size = mesh.size;
        self.at.clone_from(&mesh.vertices);
        self.put_in_order();
        self.number(mesh);
        // Half-edges by origin: a counting sort.
        let mut start = Vec::new();
        starts(&mut start, self.at.len(), self.origin.iter().copied());
        let mut leaving = vec![0u32; self.origin.len()];
        let mut fill = start.clone();
        for (h, &v) in (0u32..).zip(&self.origin) {
            leaving[fill[v as usize] as usize] = h;
            fill[v as usize] += 1;
        }
        let range = |v: u32| start[v as usize] as usize..start[v as usize + 1] as usize;
        self.twin.clear();
        self.twin.extend((0..self.origin.len() as u32).map(|h| {
            let (from, to) = (self.origin[h as usize], self.origin[next(h) as usize]);
            let back = |g: &&u32| self.origin[next(**g) as usize] == from;
            leaving[range(to)].iter().find(back).copied().unwrap_or(NONE)
        }));
        self.out.clear();
        self.out.extend((0..self.at.len() as u32).map(|v| {
            let leaving = &leaving[range(v)];
            let border = leaving.iter().find(|&&h| self.twin[h as usize] == NONE);
            border.or(leaving.first()).copied().unwrap_or(NONE)
        }));
        self.clock = 1;
        self.stamp.clear();
        self.stamp.resize(mesh.triangles.len(), self.clock);
        self.active.clear();
        self.active.resize(self.at.len(), true);
    }

    /// Links the `mesh` of the last frame. Returns whether its triangles are unchanged: then only vertices have
    /// moved, and triangles and half-edges keep their numbers.
    pub(super) fn relink(&mut self, mesh: &Mesh) -> bool {
        let same = mesh.size == self.size && mesh.triangles == self.stored;
        if same {
            self.at.clone_from(&mesh.vertices);
            self.clock += 1;
        } else {
            self.link(mesh);
        }
        same
    }

    fn put_in_order(&mut self) {
        let order = self.morton.sort(self.size, self.at.iter().copied());
        self.order.clear();
        self.order.extend_from_slice(order);
    }

    /// Sorts the vertices again and renumbers the triangles, so that vertices that were re-placed are close to their
    /// neighbours in memory. Returns the old numbers of the triangles. Their sums, costs and means have to be
    /// [measured](Surface::measure) afterwards.
    pub(super) fn renumber(&mut self) -> &[u32] {
        self.put_in_order();
        let Self { size, at, origin, twin, out, stamp, numbered, morton, new, spare, .. } = self;
        let firsts = origin.iter().step_by(3).map(|&v| at[v as usize]);
        let old = morton.sort(*size, firsts);
        new.resize(old.len(), 0);
        for (number, &t) in (0u32..).zip(old) {
            new[t as usize] = number;
        }
        permute::<3, _>(origin, old, spare);
        permute::<3, _>(twin, old, spare);
        let renamed = |h: u32| if h == NONE { NONE } else { 3 * new[h as usize / 3] + h % 3 };
        twin.iter_mut().chain(out).for_each(|h| *h = renamed(*h));
        permute::<1, _>(stamp, old, spare);
        numbered.iter_mut().for_each(|(_, number)| *number = new[*number as usize]);
        old
    }

    /// Numbers the triangles in the `order` of their first vertices, so that neighbours are close in memory.
    fn number(&mut self, mesh: &Mesh) {
        let mut start = vec![0u32; self.at.len() + 1];
        for t in &mesh.triangles {
            start[t[0] as usize] += 1;
        }
        let mut sum = 0;
        for &v in &self.order {
            sum += std::mem::replace(&mut start[v as usize], sum);
        }
        self.origin.clear();
        self.origin.resize(mesh.triangles.len() * 3, 0);
        let (triangles, _) = self.origin.as_chunks_mut::<3>();
        for t in &mesh.triangles {
            let at = &mut start[t[0] as usize];
            triangles[*at as usize] = *t;
            *at += 1;
        }
    }

    /// Number of triangles.
    pub(super) fn triangles(&self) -> usize {
        self.origin.len() / 3
    }

    /// The squared error of the whole mesh.
    pub(super) fn error(&self, rows: &RowSums) -> f64 {
        rows.squares() + self.cost.iter().map(|cost| cost.error).sum::<f64>()
    }

    /// The three corners of triangle `t`.
    pub(super) fn corners(&self, t: u32) -> [Point; 3] {
        [3 * t, 3 * t + 1, 3 * t + 2].map(|h| self.place(h))
    }

    /// The vertex that half-edge `h` starts from.
    pub(super) fn from(&self, h: u32) -> u32 {
        self.origin[h as usize]
    }

    /// The vertex that half-edge `h` runs to.
    pub(super) fn to(&self, h: u32) -> u32 {
        self.origin[next(h) as usize]
    }

    /// The position of the vertex that half-edge `h` starts from.
    pub(super) fn place(&self, h: u32) -> Point {
        self.at[self.origin[h as usize] as usize]
    }

    /// Where vertex `v` may move.
    pub(super) fn freedom(&self, v: u32) -> Place {
        if (v as usize) < CORNERS {
            Place::Corner
        } else {
            Place::of(self.at[v as usize], self.size)
        }
    }

    /// The half-edges that leave `v`, in the order of their triangles around it.
    pub(super) fn around(&self, v: u32) -> impl Iterator<Item = u32> {
        let first = self.out[v as usize];
        std::iter::successors(Some(first), move |&h| {
            let following = self.twin[previous(h) as usize];
            (following != first && following != NONE).then_some(following)
        })
    }

    /// The pixel sums of triangle `t`.
    #[inline(always)]
    pub(super) fn total(&self, rows: &RowSums, t: u32) -> Total {
        let [a, b, c] = self.corners(t);
        let h = 3 * t as usize;
        let sums = self.sums[h] + self.sums[h + 1] + self.sums[h + 2];
        rows.total(&sums, orient(a, b, c), [a, b, c])
    }

    /// Writes the sums of half-edge `h` and its twin.
    pub(super) fn set_sums(&mut self, h: u32, sums: Sums) {
        self.sums[h as usize] = sums;
        let twin = self.twin[h as usize];
        if twin != NONE {
            self.sums[twin as usize] = -sums;
        }
    }

    /// Stores the cost, the mean and the time of the change of triangle `t`, after its sums, and activates its
    /// vertices.
    pub(super) fn changed(&mut self, rows: &RowSums, t: u32, cost: Cost) {
        self.set_triangle(t, cost, Mean::of(&self.total(rows, t)));
    }

    /// The same with a known mean.
    pub(super) fn set_triangle(&mut self, t: u32, cost: Cost, mean: Mean) {
        self.cost[t as usize] = cost;
        self.mean[t as usize] = mean;
        self.stamp[t as usize] = self.clock;
        for i in 0..3 {
            self.active[self.origin[(3 * t + i) as usize] as usize] = true;
        }
    }

    /// Writes the vertices and triangles back, in canonical order.
    pub(super) fn store(&mut self, mesh: &mut Mesh) {
        mesh.vertices.clone_from(&self.at);
        let (triangles, _) = self.origin.as_chunks::<3>();
        let canonical = || triangles.iter().map(|&t| Mesh::smallest_first(t));
        // A counting sort by the first corner. Few triangles share one, except in a mesh with all seeds on a line.
        let start = &mut self.spare;
        starts(start, self.at.len(), canonical().map(|[first, ..]| first));
        self.numbered.resize(triangles.len(), (0, 0));
        for ([first, second, _], number) in canonical().zip(0..) {
            let at = &mut start[first as usize];
            self.numbered[*at as usize] = (second, number);
            *at += 1;
        }
        mesh.triangles.resize(triangles.len(), [0; 3]);
        let (mut numbered, mut sorted) = (&mut self.numbered[..], &mut mesh.triangles[..]);
        crate::parallel::scope(|scope| {
            let mut begin = 0;
            // Each start has become that of the next corner.
            for ends in start[..self.at.len()].chunks(SORTED) {
                let end = ends.last().map_or(begin, |&end| end);
                let count = (end - begin) as usize;
                let numbered = numbered.split_off_mut(..count).expect("ends ascend");
                let sorted = sorted.split_off_mut(..count).expect("as many triangles");
                scope.spawn(move |_| {
                    let mut first = 0;
                    for &end in ends {
                        let end = (end - begin) as usize;
                        numbered[first..end].sort_unstable_by_key(|&(second, _)| second);
                        first = end;
                    }
                    for (sorted, &(_, number)) in sorted.iter_mut().zip(&*numbered) {
                        *sorted = Mesh::smallest_first(triangles[number as usize]);
                    }
                });
                begin = end;
            }
        });
        self.stored.clone_from(&mesh.triangles);
    }

    /// The mean colours and areas of the triangles in the order in which they were last stored.
    pub(super) fn stored_fills(&self, rows: &RowSums) -> Vec<Fill> {
        let total = |number: u32| self.total(rows, number).fill();
        let fill = |number: u32| self.mean[number as usize].fill().unwrap_or_else(|| total(number));
        self.numbered.iter().map(|&(_, number)| fill(number)).collect()
    }
}
