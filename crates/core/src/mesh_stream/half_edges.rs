//! Which triangle lies to the left of an edge, found from the edge's ends.

use smallvec::SmallVec;

/// For each vertex the edges that leave it, with the apex and the number of the triangle to their left.
#[derive(Clone, Debug, Default)]
pub(super) struct HalfEdges {
    starts: Vec<u32>,
    /// The other end, the apex, the triangle.
    edges: Vec<(u32, u32, u32)>,
}

impl HalfEdges {
    pub(super) fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = Vec::new();
        crate::mesh::starts(&mut starts, vertices, triangles.as_flattened().iter().copied());
        let mut at = starts.clone();
        let mut edges = vec![(0, 0, 0); 3 * triangles.len()];
        for (&[a, b, c], t) in triangles.iter().zip(0u32..) {
            for (from, to, apex) in [(a, b, c), (b, c, a), (c, a, b)] {
                let place = &mut at[from as usize];
                edges[*place as usize] = (to, apex, t);
                *place += 1;
            }
        }
        Self { starts, edges }
    }

    /// The edges that leave `v`; none if there is no such vertex.
    pub(super) fn from(&self, v: u32) -> &[(u32, u32, u32)] {
        match self.starts.get(v as usize..v as usize + 2) {
            Some(&[start, end]) => &self.edges[start as usize..end as usize],
            _ => &[],
        }
    }

    /// Apex and triangle to the left of the edge from `a` to `b`.
    pub(super) fn left_of(&self, a: u32, b: u32) -> Option<(u32, u32)> {
        self.from(a).iter().find(|edge| edge.0 == b).map(|edge| (edge.1, edge.2))
    }
}

/// Edges to whose left nothing is known yet, by the vertex that they leave.
#[derive(Debug)]
pub(super) struct OpenEdges {
    /// The other end, and the triangle on the right, if any.
    leaving: Vec<SmallVec<[(u32, u32); 4]>>,
    /// Open edges that end or begin at each vertex.
    touching: Vec<u32>,
}

impl OpenEdges {
    pub(super) fn new(vertices: usize) -> Self {
        Self { leaving: vec![SmallVec::new(); vertices], touching: vec![0; vertices] }
    }

    pub(super) fn open(&mut self, a: u32, b: u32, right: u32) {
        self.leaving[a as usize].push((b, right));
        self.touching[a as usize] += 1;
        self.touching[b as usize] += 1;
    }

    /// Closes the edge from `a` to `b`, if it is open; returns the triangle on its right.
    pub(super) fn close(&mut self, a: u32, b: u32) -> Option<u32> {
        let leaving = &mut self.leaving[a as usize];
        let place = leaving.iter().position(|edge| edge.0 == b)?;
        let (_, right) = leaving.swap_remove(place);
        self.touching[a as usize] -= 1;
        self.touching[b as usize] -= 1;
        Some(right)
    }

    pub(super) fn is_open(&self, a: u32, b: u32) -> bool {
        self.leaving[a as usize].iter().any(|edge| edge.0 == b)
    }

    /// Whether no open edge touches `v`.
    pub(super) fn is_free(&self, v: u32) -> bool {
        self.touching[v as usize] == 0
    }

    /// The one open edge that leaves `v`, if there is just one.
    pub(super) fn only_from(&self, v: u32) -> Option<u32> {
        match self.leaving[v as usize][..] {
            [(to, _)] => Some(to),
            _ => None,
        }
    }
}
