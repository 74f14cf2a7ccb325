//! The order in which facets are painted, and how far each reaches under those after it.
//!
//! Facets are taken neighbour by neighbour, so that each but the first of its patch meets at most one vertex that
//! no facet before it has. That facet reaches under all others at the vertex: its shape is the ring of the
//! vertex's neighbours. So around every vertex, and along every edge from it, one shape covers whole pixels.
//! A point of the ring is left out where what remains still covers the vertex and where its edge lies under
//! another facet's ring already. What is not opaque takes no part: nothing may show through it.

use std::collections::VecDeque;

use crate::frame::Rgba;
use crate::geom::{Point, orient};
use crate::mesh::Mesh;

/// What is drawn for one facet, or for several of one colour.
#[derive(Debug, PartialEq)]
pub(super) struct Shape {
    /// The facet whose colour it has.
    pub(super) facet: u32,
    /// Polygons of vertex numbers.
    pub(super) polygons: Vec<Vec<u32>>,
}

/// Facets as they are, those of alpha 0 left out.
pub(super) fn triangles(mesh: &Mesh, colours: &[Rgba]) -> Vec<Shape> {
    let seen = (0u32..).zip(&mesh.triangles).filter(|(t, _)| colours[*t as usize][3] > 0);
    seen.map(|(facet, ids)| Shape { facet, polygons: vec![ids.to_vec()] }).collect()
}

/// Facets in the order in which they are painted, with what they reach under. `vertices` are in the document's
/// units, `pixel` of which are one pixel.
pub(super) fn shapes(
    mesh: &Mesh,
    vertices: &[(i32, i32)],
    colours: &[Rgba],
    pixel: i32,
) -> Vec<Shape> {
    let around = Around::of(mesh);
    let ring = Rings { mesh, around: &around, vertices, colours, margin: 2 * pixel };
    let order = order(mesh, &around, colours);
    // Corners of facets whose surroundings are covered already.
    let mut claimed = vec![[false; 3]; mesh.triangles.len()];
    let mut shapes: Vec<Shape> = Vec::with_capacity(order.len());
    for &t in &order {
        let mut polygons = Vec::new();
        for i in 0..3 {
            if !claimed[t as usize][i] {
                let v = mesh.triangles[t as usize][i];
                polygons.push(ring.around(v, t, &mut claimed));
            }
        }
        if polygons.is_empty() {
            polygons.push(mesh.triangles[t as usize].to_vec());
        }
        match shapes.last_mut() {
            Some(last) if colours[last.facet as usize] == colours[t as usize] => {
                last.polygons.append(&mut polygons);
            }
            _ => shapes.push(Shape { facet: t, polygons }),
        }
    }
    let faint = |t: &u32| !matches!(colours[*t as usize][3], 0 | 255);
    let faint = (0..mesh.triangles.len() as u32).filter(faint);
    shapes.extend(
        faint.map(|facet| Shape { facet, polygons: vec![mesh.triangles[facet as usize].to_vec()] }),
    );
    shapes
}

/// The opaque facets, patch by patch, each but the first of a patch beside one before it; those of the colour that
/// was painted last come first.
fn order(mesh: &Mesh, around: &Around, colours: &[Rgba]) -> Vec<u32> {
    let opaque = |t: u32| colours[t as usize][3] == 255;
    let mut waiting: VecDeque<u32> = VecDeque::new();
    let mut taken = vec![false; mesh.triangles.len()];
    let mut order = Vec::with_capacity(mesh.triangles.len());
    let mut alike = Vec::new();
    for first in (0..mesh.triangles.len() as u32).filter(|&t| opaque(t)) {
        waiting.push_back(first);
        while let Some(next) = alike.pop().or_else(|| waiting.pop_front()) {
            if std::mem::replace(&mut taken[next as usize], true) {
                continue;
            }
            order.push(next);
            for beside in around.neighbours(mesh, next) {
                if opaque(beside) && !taken[beside as usize] {
                    if colours[beside as usize] == colours[next as usize] {
                        alike.push(beside);
                    }
                    waiting.push_back(beside);
                }
            }
        }
    }
    order
}

/// For each vertex the triangles around it, as the two other corners in their turn.
#[derive(Debug)]
struct Around {
    starts: Vec<u32>,
    /// Next corner, the one after it, and the triangle.
    wedges: Vec<(u32, u32, u32)>,
}

impl Around {
    fn of(mesh: &Mesh) -> Self {
        let mut starts = Vec::new();
        let corners = mesh.triangles.as_flattened().iter().copied();
        crate::mesh::starts(&mut starts, mesh.vertices.len(), corners);
        let mut at = starts.clone();
        let mut wedges = vec![(0, 0, 0); 3 * mesh.triangles.len()];
        for (&[a, b, c], t) in mesh.triangles.iter().zip(0u32..) {
            for (v, next, after) in [(a, b, c), (b, c, a), (c, a, b)] {
                let place = &mut at[v as usize];
                wedges[*place as usize] = (next, after, t);
                *place += 1;
            }
        }
        Self { starts, wedges }
    }

    fn at(&self, v: u32) -> &[(u32, u32, u32)] {
        &self.wedges[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }

    /// The triangles that share an edge with `t`.
    fn neighbours(&self, mesh: &Mesh, t: u32) -> impl Iterator<Item = u32> {
        let [a, b, c] = mesh.triangles[t as usize];
        [(a, b), (b, c), (c, a)].into_iter().filter_map(move |(from, to)| {
            self.at(to).iter().find(|wedge| wedge.0 == from).map(|wedge| wedge.2)
        })
    }
}

/// Finds what a facet that comes first at a vertex covers.
#[derive(Debug)]
struct Rings<'a> {
    mesh: &'a Mesh,
    around: &'a Around,
    vertices: &'a [(i32, i32)],
    colours: &'a [Rgba],
    /// How far around the vertex the ring must reach, in the document's units.
    margin: i32,
}

impl Rings<'_> {
    /// The polygon around `v` that facet `t` covers: the opaque facets there, from `t` on in both directions, whose
    /// corners there become claimed.
    fn around(&self, v: u32, t: u32, claimed: &mut [[bool; 3]]) -> Vec<u32> {
        let wedges = self.around.at(v);
        let opaque = |t: u32| self.colours[t as usize][3] == 255;
        let mut claim = |t: u32| {
            let corners = self.mesh.triangles[t as usize];
            (0..3).filter(|&i| corners[i] == v).for_each(|i| claimed[t as usize][i] = true);
        };
        claim(t);
        let Some(&(from, to, _)) = wedges.iter().find(|wedge| wedge.2 == t) else {
            return self.mesh.triangles[t as usize].to_vec();
        };
        let mut ring = VecDeque::from([from, to]);
        loop {
            let last = ring[ring.len() - 1];
            match wedges.iter().find(|wedge| wedge.0 == last && opaque(wedge.2)) {
                Some(&(_, next, t)) if next == ring[0] => {
                    claim(t);
                    return self.thinned(v, [from, to], ring.into(), claimed);
                }
                Some(&(_, next, t)) if ring.len() <= wedges.len() => {
                    claim(t);
                    ring.push_back(next);
                }
                _ => break,
            }
        }
        while let Some(&(before, _, t)) =
            wedges.iter().find(|wedge| wedge.1 == ring[0] && opaque(wedge.2))
            && ring.len() <= wedges.len()
        {
            claim(t);
            ring.push_front(before);
        }
        // The patch ends here: the vertex is a corner of the polygon.
        ring.push_front(v);
        ring.into()
    }

    /// The closed `ring` around `v` without points that nothing needs. Those in `kept` are the facet's own.
    fn thinned(
        &self,
        v: u32,
        kept: [u32; 2],
        mut ring: Vec<u32>,
        claimed: &[[bool; 3]],
    ) -> Vec<u32> {
        // Where opaque facets meet others at a point in several patches, each patch is covered by itself.
        let is_claimed = |here: u32| {
            self.around.at(here).iter().all(|&(_, _, t)| {
                let corner = self.mesh.triangles[t as usize].iter().position(|&v| v == here);
                self.colours[t as usize][3] < 255
                    || corner.is_some_and(|corner| claimed[t as usize][corner])
            })
        };
        let mut i = 0;
        while i < ring.len() && ring.len() > 3 {
            let [before, here, after] =
                [i + ring.len() - 1, i, i + 1].map(|i| ring[i % ring.len()]);
            if !kept.contains(&here) && is_claimed(here) && self.can_skip(v, before, here, after) {
                ring.remove(i);
            } else {
                i += 1;
            }
        }
        ring
    }

    /// Whether the chord from `before` to `after` lies inside the ring and leaves the vertex inside, and not near.
    fn can_skip(&self, v: u32, before: u32, here: u32, after: u32) -> bool {
        let [v, before, here, after] = [v, before, here, after].map(|v| {
            let (x, y) = self.vertices[v as usize];
            Point::new(x, y)
        });
        let (dx, dy) = (i64::from(after.x - before.x), i64::from(after.y - before.y));
        let margin = f64::from(self.margin) * ((dx * dx + dy * dy) as f64).sqrt();
        orient(before, here, after) >= 0 && orient(before, after, v) as f64 > margin
    }
}
