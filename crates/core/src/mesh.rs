//! A triangle mesh that covers a frame exactly, and its invariants as one function.

use crate::frame::Fill;
use crate::geom::{Point, Size, orient};

/// A mesh over a frame: every point of `[0, width] x [0, height]` lies in a triangle, and interiors
/// do not overlap.
///
/// Coordinates are in 1/256 pixel, see [`Point`].
#[derive(Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Mesh {
    /// The frame's size in pixels.
    pub size: Size,
    /// Vertices: the frame's four [`Mesh::corners`] first, then the seeds in their own order (border
    /// points among them). No two are equal.
    pub vertices: Vec<Point>,
    /// A lasting id of each vertex: a vertex that is carried from one frame to the next keeps it, wherever it moves;
    /// a new vertex gets an id that none had before. Those of the corners are 0 to 3.
    pub ids: Vec<u64>,
    /// Vertex numbers of each triangle, turning from the x axis towards the y axis; the smallest number stands first
    /// and triangles are sorted, so that equal meshes are equal values.
    pub triangles: Vec<[u32; 3]>,
    /// The colour of each triangle where edges are hard, and its area in pixels without outlines. Empty if the mesh
    /// is not painted.
    pub fills: Vec<Fill>,
}

impl Clone for Mesh {
    fn clone(&self) -> Self {
        let mut other = Self::default();
        other.clone_from(self);
        other
    }

    /// Reuses the memory.
    fn clone_from(&mut self, other: &Self) {
        let Self { size, vertices, ids, triangles, fills } = other;
        self.size = *size;
        self.vertices.clone_from(vertices);
        self.ids.clone_from(ids);
        self.triangles.clone_from(triangles);
        self.fills.clone_from(fills);
    }
}

/// The first of the [`Mesh::ids`] of vertices that follow from others: of corners of Voronoi cells.
pub(crate) const DERIVED: u64 = 1 << 63;

/// Number of corner vertices, which stand before the seeds in [`Mesh::vertices`].
pub const CORNERS: usize = 4;

/// Where a vertex may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A corner of the frame: nowhere.
    Corner,
    /// On the left or right border: up and down.
    SideBorder,
    /// On the top or bottom border: left and right.
    LevelBorder,
    /// Inside the frame: anywhere inside.
    Interior,
}

impl Place {
    /// The kind of position of `p` in a frame of `size`.
    pub const fn of(p: Point, size: Size) -> Self {
        let far = size.far();
        match (p.x == 0 || p.x == far.x, p.y == 0 || p.y == far.y) {
            (true, true) => Self::Corner,
            (true, false) => Self::SideBorder,
            (false, true) => Self::LevelBorder,
            (false, false) => Self::Interior,
        }
    }
}

/// The first broken invariant that [`Mesh::check`] found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshFault {
    /// A vertex lies outside the frame.
    #[error("vertex {0} at {1:?} lies outside the frame")]
    Outside(usize, Point),
    /// The first four vertices are not the corners.
    #[error("the first four vertices are not the frame's corners")]
    Corners,
    /// Two vertices are equal.
    #[error("two vertices lie at {0:?}")]
    Twins(Point),
    /// A vertex belongs to no triangle.
    #[error("vertex {0} belongs to no triangle")]
    Unused(usize),
    /// A triangle names a vertex that is not there.
    #[error("triangle {0} names vertex {1}, which is not there")]
    Missing(usize, u32),
    /// A triangle has no area or is folded.
    #[error("triangle {0} has doubled area {1}")]
    Flat(usize, i64),
    /// Triangles are not in canonical order.
    #[error("triangle {0} is out of order")]
    Order(usize),
    /// An edge is used twice in the same direction: triangles overlap.
    #[error("edge {0}-{1} is used twice in the same direction")]
    Overlap(u32, u32),
    /// An edge inside the frame has a triangle on one side only: a gap.
    #[error("edge {0}-{1} has no triangle on its other side")]
    Gap(u32, u32),
    /// The areas do not add up to the frame's.
    #[error("the triangles' doubled areas add up to {found}, the frame's is {expected}")]
    Area {
        /// Sum over the triangles.
        found: i64,
        /// Twice the frame's area, in (1/256 pixel)^2.
        expected: i64,
    },
}

impl Mesh {
    /// A mesh that is not painted, with ids in the order of its vertices.
    #[doc(hidden)]
    pub fn new(size: Size, vertices: Vec<Point>, triangles: Vec<[u32; 3]>) -> Self {
        let ids = (0..vertices.len() as u64).collect();
        Self { size, vertices, ids, triangles, fills: Vec::new() }
    }

    /// The frame's corners in the order in which they stand in [`Mesh::vertices`].
    pub const fn corners(size: Size) -> [Point; CORNERS] {
        let far = size.far();
        [Point::new(0, 0), Point::new(far.x, 0), Point::new(0, far.y), far]
    }

    /// The three corners of triangle `t`.
    pub fn triangle(&self, t: usize) -> [Point; 3] {
        self.triangles[t].map(|v| self.vertices[v as usize])
    }

    /// The seeds: all vertices but the corners.
    pub fn seeds(&self) -> &[Point] {
        &self.vertices[CORNERS..]
    }

    /// The lasting ids of the seeds; of a Voronoi diagram those of the cells, without their corners.
    #[doc(hidden)]
    pub fn seed_ids(&self) -> impl Iterator<Item = u64> + '_ {
        self.ids.iter().skip(CORNERS).copied().filter(|&id| id < DERIVED)
    }

    /// Rotates each triangle so that its smallest vertex number comes first, and sorts them.
    #[doc(hidden)]
    pub fn canonicalise(triangles: &mut [[u32; 3]]) {
        for t in triangles.iter_mut() {
            *t = Self::smallest_first(*t);
        }
        triangles.sort_unstable();
    }

    /// The triangle rotated so that its smallest vertex number comes first.
    #[doc(hidden)]
    pub fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
        if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    }

    /// Proves that the triangles cover the frame exactly, without gap, overlap or a triangle of no
    /// area, and that vertices and triangles are in canonical order.
    ///
    /// With consistent orientation, every interior edge shared by two triangles, one-sided edges only
    /// on the border and areas that add up, coverage follows. O(n log n).
    ///
    /// # Errors
    /// The first invariant that does not hold.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), MeshFault> {
        self.check_vertices()?;
        let mut edges = Vec::with_capacity(self.triangles.len() * 3);
        let mut used = vec![false; self.vertices.len()];
        let mut area = 0i64;
        for (t, ids) in self.triangles.iter().enumerate() {
            for &v in ids {
                *used.get_mut(v as usize).ok_or(MeshFault::Missing(t, v))? = true;
            }
            let [a, b, c] = self.triangle(t);
            let doubled = orient(a, b, c);
            if doubled <= 0 {
                return Err(MeshFault::Flat(t, doubled));
            }
            let ordered = t == 0 || self.triangles[t - 1] < *ids;
            if !ordered || ids[0] > ids[1] || ids[0] > ids[2] {
                return Err(MeshFault::Order(t));
            }
            area += doubled;
            edges.extend([[ids[0], ids[1]], [ids[1], ids[2]], [ids[2], ids[0]]]);
        }
        if let Some(v) = used.iter().position(|&u| !u) {
            return Err(MeshFault::Unused(v));
        }
        self.check_edges(edges)?;
        let expected = 2 * i64::from(self.size.far().x) * i64::from(self.size.far().y);
        if area != expected {
            return Err(MeshFault::Area { found: area, expected });
        }
        Ok(())
    }

    fn check_vertices(&self) -> Result<(), MeshFault> {
        if !self.vertices.starts_with(&Self::corners(self.size)) {
            return Err(MeshFault::Corners);
        }
        if let Some(v) = self.vertices.iter().position(|&p| !self.size.contains(p)) {
            return Err(MeshFault::Outside(v, self.vertices[v]));
        }
        let mut sorted = self.vertices.clone();
        sorted.sort_unstable();
        match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(MeshFault::Twins(pair[0])),
            None => Ok(()),
        }
    }

    fn check_edges(&self, mut edges: Vec<[u32; 2]>) -> Result<(), MeshFault> {
        edges.sort_unstable();
        if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(MeshFault::Overlap(pair[0][0], pair[0][1]));
        }
        for &[a, b] in &edges {
            if edges.binary_search(&[b, a]).is_err() && !self.on_one_border(a, b) {
                return Err(MeshFault::Gap(a, b));
            }
        }
        Ok(())
    }

    /// Whether both ends of the edge lie on the same side of the frame.
    pub fn on_one_border(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.vertices[a as usize], self.vertices[b as usize]);
        let far = self.size.far();
        (a.x == b.x && (a.x == 0 || a.x == far.x)) || (a.y == b.y && (a.y == 0 || a.y == far.y))
    }
}

/// Fills `start` with the start of the keys of each of `vertices` in sorted order, and the end of the last: the first
/// half of a counting sort.
pub(crate) fn starts(start: &mut Vec<u32>, vertices: usize, keys: impl Iterator<Item = u32>) {
    start.clear();
    start.resize(vertices + 1, 0);
    for v in keys {
        start[v as usize + 1] += 1;
    }
    for v in 0..vertices {
        start[v + 1] += start[v];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        let size = Size::new(4, 4);
        let mut vertices = Mesh::corners(size).to_vec();
        vertices.push(Point::new(512, 512));
        let mut triangles = vec![[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4]];
        Mesh::canonicalise(&mut triangles);
        Mesh::new(size, vertices, triangles)
    }

    #[test]
    fn a_fan_around_the_centre_is_sound() {
        assert_eq!(square().check(), Ok(()));
    }

    #[test]
    fn a_mesh_is_written_in_the_memory_of_another_one() {
        let size = Size::new(9, 2);
        let vertices = vec![Point::new(1, 1); 30];
        let mut other = Mesh::new(size, vertices, vec![[0, 1, 2]]);
        let memory = other.vertices.as_ptr();
        other.clone_from(&square());
        assert_eq!(other, square());
        assert_eq!(other.vertices.as_ptr(), memory);
    }

    #[test]
    fn check_names_what_is_broken() {
        let mut gap = square();
        gap.triangles.pop();
        assert!(matches!(gap.check(), Err(MeshFault::Gap(..))), "{:?}", gap.check());

        let mut twins = square();
        twins.vertices.push(Point::new(512, 512));
        assert!(matches!(twins.check(), Err(MeshFault::Twins(_))));

        let mut flat = square();
        flat.vertices[4] = Point::new(512, 0);
        assert!(matches!(flat.check(), Err(MeshFault::Flat(..))));

        let mut order = square();
        order.triangles.reverse();
        assert!(matches!(order.check(), Err(MeshFault::Order(_))));

        let mut unused = square();
        unused.vertices.push(Point::new(600, 600));
        assert!(matches!(unused.check(), Err(MeshFault::Unused(5))));

        let mut outside = square();
        outside.vertices[4] = Point::new(512, 5000);
        assert!(matches!(outside.check(), Err(MeshFault::Outside(4, _))));
    }
}
