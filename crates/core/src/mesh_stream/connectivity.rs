//! The triangles over vertices that are known.
//!
//! Both sides grow the mesh from the frame's border inwards. The border's edges are known: they join the vertices
//! that lie on it, in their turn. Open edges wait in a queue; for the first of them the apex of the triangle to its
//! left is coded, which closes the edge and opens up to two others. What is coded is where the apex stands among
//! those that geometry, or the frame before, lets expect: see [`Apexes`]. With v vertices, h of them on the border,
//! there are 2 v - h - 2 triangles.

use std::collections::VecDeque;

use super::apexes::Apexes;
use super::half_edges::{HalfEdges, OpenEdges};
use super::range_coder::{Bits, Model};
use super::{Fault, NONE};
use crate::geom::{Point, Size, orient};

/// What the coder has learnt.
#[derive(Clone, Debug)]
pub(super) struct Models {
    /// Whether the apex is the one of the frame before.
    same: [Model; 8],
    /// Whether it is the best, the second, the third that geometry finds.
    best: [Model; 48],
    second: [Model; 2],
    third: Model,
}

impl Default for Models {
    fn default() -> Self {
        let m = Model::default();
        Self { same: [m; 8], best: [m; 48], second: [m; 2], third: m }
    }
}

/// Triangles in coding order, the edge from which they grew first.
#[derive(Debug, Default)]
pub(super) struct Grown {
    pub(super) triangles: Vec<[u32; 3]>,
    /// The same triangle of the frame before, or [`NONE`].
    pub(super) before: Vec<u32>,
}

/// The frame before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before<'a> {
    pub(super) edges: &'a HalfEdges,
    /// Whether each vertex has moved since.
    pub(super) moved: &'a [bool],
}

/// Passes the triangles over `points`; an encoder has them in `known`.
pub(super) fn pass(
    bits: &mut impl Bits,
    models: &mut Models,
    (size, points): (Size, &[Point]),
    before: Option<Before<'_>>,
    known: Option<&HalfEdges>,
) -> Result<Grown, Fault> {
    let border = border(size, points);
    let count = (2 * points.len()).checked_sub(border.len() + 2).ok_or(Fault::Border)?;
    let mut open = OpenEdges::new(points.len());
    let mut queue = VecDeque::new();
    for (i, &a) in border.iter().enumerate() {
        let b = border[(i + 1) % border.len()];
        open.open(a, b, NONE);
        queue.push_back((a, b));
    }
    let mut apexes = Apexes::new(size, points, &border);
    let mut grown = Grown::default();
    while let Some((a, b)) = queue.pop_front() {
        if !open.is_open(a, b) {
            continue;
        }
        if grown.triangles.len() == count || bits.is_beyond_end() {
            return Err(Fault::Triangles);
        }
        let Some(right) = open.close(a, b) else { continue };
        let wanted = match known {
            Some(known) => Some(known.left_of(a, b).ok_or(Fault::Triangles)?.0),
            None => None,
        };
        let origin_same = right == NONE || grown.before[right as usize] != NONE;
        let old = before.and_then(|before| {
            let (apex, t) = before.edges.left_of(a, b)?;
            let sound = apexes.can_be(apex, &open)
                && orient(points[a as usize], points[b as usize], points[apex as usize]) > 0;
            let moved = [a, b, apex].iter().filter(|&&v| before.moved[v as usize]).count();
            sound.then_some((apex, t, moved))
        });
        let mut found = None;
        if let Some((apex, t, moved)) = old {
            let model = &mut models.same[4 * usize::from(origin_same) + moved];
            if bits.bit(model, wanted == Some(apex)) {
                found = Some((apex, t));
            }
        }
        let (apex, t) = match found {
            Some(found) => found,
            None => {
                let except = old.map(|old| old.0);
                let best = apexes.best((a, b), points, &open, except);
                (coded_apex(bits, models, &best, points.len(), wanted)?, NONE)
            }
        };
        if apex == a
            || apex == b
            || orient(points[a as usize], points[b as usize], points[apex as usize]) <= 0
        {
            return Err(Fault::Triangles);
        }
        apexes.reach(apex);
        let triangle = grown.triangles.len() as u32;
        grown.triangles.push([a, b, apex]);
        grown.before.push(t);
        for (from, to) in [(b, apex), (apex, a)] {
            if open.close(from, to).is_none() {
                open.open(to, from, triangle);
                queue.push_back((to, from));
            }
        }
    }
    if grown.triangles.len() != count { Err(Fault::Triangles) } else { Ok(grown) }
}

/// Passes where the apex stands among the `best`, or its number.
fn coded_apex(
    bits: &mut impl Bits,
    models: &mut Models,
    best: &super::apexes::Best,
    vertices: usize,
    wanted: Option<u32>,
) -> Result<u32, Fault> {
    let is = |i: usize| wanted.is_some() && wanted == best.vertices.get(i).copied();
    let context = best.context();
    for (i, &vertex) in best.vertices.iter().enumerate() {
        let model = match i {
            0 => &mut models.best[context],
            1 => &mut models.second[usize::from(context % 16 >= 8)],
            _ => &mut models.third,
        };
        if bits.bit(model, is(i)) {
            return Ok(vertex);
        }
    }
    let digits = usize::BITS - vertices.leading_zeros();
    let apex = bits.plain(wanted.unwrap_or(0), digits);
    if (apex as usize) < vertices { Ok(apex) } else { Err(Fault::Triangles) }
}

/// The vertices on the border of the frame, in the turn in which the frame lies to the left of each edge.
pub(super) fn border(size: Size, points: &[Point]) -> Vec<u32> {
    let far = size.far();
    let mut sides: [Vec<u32>; 4] = Default::default();
    for (p, v) in points.iter().zip(0u32..) {
        // Each corner begins one side.
        let side = match (p.x, p.y) {
            (x, 0) if x < far.x => 0,
            (x, y) if x == far.x && y < far.y => 1,
            (x, y) if y == far.y && x > 0 => 2,
            (0, _) => 3,
            _ => continue,
        };
        sides[side].push(v);
    }
    let at = |v: &u32| points[*v as usize];
    sides[0].sort_unstable_by_key(|v| at(v).x);
    sides[1].sort_unstable_by_key(|v| at(v).y);
    sides[2].sort_unstable_by_key(|v| -at(v).x);
    sides[3].sort_unstable_by_key(|v| -at(v).y);
    sides.concat()
}
