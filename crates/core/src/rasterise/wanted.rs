//! The lines of one mesh: along which edges, in which colour, how strong.

use super::style::Style;
use crate::draw::sides;
use crate::frame::Rgba;
use crate::geom::SUBPIXEL;
use crate::mesh::Mesh;

/// A dash shorter than the first share of the frame's shorter side is not drawn, one longer than the second is drawn
/// as it is.
const DASH: [f64; 2] = [0.05, 0.14];

/// A line along an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// The numbers of the edge's vertices, the smaller first.
    pub(super) edge: [u32; 2],
    /// Its colour, and the opacity of what it runs along.
    pub(super) paint: Rgba,
    /// Its strength, of 255.
    pub(super) strength: u8,
    /// The mean colour of what it runs along.
    pub(super) ground: Rgba,
}

/// The lines along the edges of `mesh`, those of no strength among them, in the order of their edges. `colours` are
/// those of the triangles, `shown` what is seen of them.
pub(super) fn wanted(style: &Style, mesh: &Mesh, colours: &[Rgba], shown: &[Rgba]) -> Vec<Wanted> {
    let Some(outline) = style.outline else { return Vec::new() };
    let sides = sides(mesh);
    let edges = sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
    let mut lines: Vec<Wanted> = edges
        .filter_map(|edge| {
            let (a, b, t) = edge[0];
            let u = edge.get(1).map(|side| side.2 as usize);
            let there = u.map(|u| colours[u]);
            let (paint, strength) = style.line(outline, colours[t as usize], there)?;
            let here = shown[t as usize];
            let ground = mean(here, u.map_or(here, |u| shown[u]));
            let paint = tinted(paint, ground, style.tint);
            Some(Wanted { edge: [a, b], paint, strength, ground })
        })
        .collect();
    if style.has_gaps() {
        fade_dashes(mesh, &mut lines);
    }
    lines
}

/// Weakens short lines that hang in the air: those that are joined to no closed one.
fn fade_dashes(mesh: &Mesh, lines: &mut [Wanted]) {
    let strongest = lines.iter().map(|line| line.strength).max().unwrap_or(0);
    let is_seen = |line: &Wanted| line.strength > strongest / 4;
    let mut chains = Chains::of(mesh);
    lines.iter().filter(|line| is_seen(line)).for_each(|line| chains.join(mesh, line.edge));
    let shorter = f64::from(mesh.size.width.min(mesh.size.height));
    let [shortest, whole] = DASH.map(|share| share * shorter);
    for line in lines.iter_mut().filter(|line| is_seen(line)) {
        let chain = chains.root(line.edge[0]) as usize;
        if !chains.closed[chain] {
            let share = (chains.length[chain] - shortest) / (whole - shortest);
            line.strength = (f64::from(line.strength) * share.clamp(0.0, 1.0)).round() as u8;
        }
    }
}

/// Vertices that lines join.
#[derive(Debug)]
struct Chains {
    parent: Vec<u32>,
    /// The length of the lines of a chain, in pixels, at its root.
    length: Vec<f64>,
    /// Whether the chain has a ring, at its root.
    closed: Vec<bool>,
}

impl Chains {
    fn of(mesh: &Mesh) -> Self {
        let count = mesh.vertices.len();
        Self {
            parent: (0..count as u32).collect(),
            length: vec![0.0; count],
            closed: vec![false; count],
        }
    }

    fn root(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            let above = self.parent[self.parent[v as usize] as usize];
            self.parent[v as usize] = above;
            v = above;
        }
        v
    }

    fn join(&mut self, mesh: &Mesh, edge: [u32; 2]) {
        let [a, b] = edge.map(|v| mesh.vertices[v as usize]);
        let (dx, dy) = (f64::from(a.x - b.x), f64::from(a.y - b.y));
        let length = dx.hypot(dy) / f64::from(SUBPIXEL);
        let [a, b] = edge.map(|v| self.root(v) as usize);
        let (lower, upper) = (a.min(b), a.max(b));
        self.length[lower] += length;
        if lower == upper {
            self.closed[lower] = true;
            return;
        }
        self.parent[upper] = lower as u32;
        self.length[lower] += self.length[upper];
        self.closed[lower] |= self.closed[upper];
    }
}

/// The mean of two colours, in any order, weighted by alpha.
fn mean(a: Rgba, b: Rgba) -> Rgba {
    let all = u32::from(a[3]) + u32::from(b[3]);
    if all == 0 {
        return [0; 4];
    }
    let [red, green, blue] = [0, 1, 2].map(|c| {
        let sum = u32::from(a[c]) * u32::from(a[3]) + u32::from(b[c]) * u32::from(b[3]);
        ((sum + all / 2) / all) as u8
    });
    [red, green, blue, all.div_ceil(2) as u8]
}

/// `paint` with a share of the colour of `ground`.
fn tinted(paint: Rgba, ground: Rgba, share: f64) -> Rgba {
    if share == 0.0 {
        return paint;
    }
    let [r, g, b] = [0, 1, 2].map(|c| {
        let (from, to) = (f64::from(paint[c]), f64::from(ground[c]));
        (from + share * (to - from)).round() as u8
    });
    [r, g, b, paint[3]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Point, Size};

    #[test]
    fn rings_stay_and_dashes_fade_the_more_the_shorter_they_are() {
        // Points ten pixels apart, in rows of 21.
        let vertices = (0..441).map(|i| Point::new(i % 21 * 2560, i / 21 * 2560)).collect();
        let mesh = Mesh::new(Size::new(200, 200), vertices, Vec::new());
        let ring = [[0, 1], [1, 22], [21, 22], [0, 21]];
        let (short, middle, long) =
            ([[43, 44]], [[84, 85], [85, 86]], [[126, 127], [127, 128], [128, 129]]);
        let edges = [&ring[..], &short, &middle, &long].concat();
        let line = |&edge| Wanted { edge, paint: [0, 0, 0, 255], strength: 200, ground: [0; 4] };
        let mut lines: Vec<_> = edges.iter().map(line).collect();
        fade_dashes(&mesh, &mut lines);
        let strengths: Vec<_> = lines.iter().map(|line| line.strength).collect();
        assert_eq!(strengths, [200, 200, 200, 200, 0, 111, 111, 200, 200, 200]);
    }
}
