//! Which vertex is likely to be the apex over an edge: of those near it, the one that sees it under the largest
//! angle, as in a Delaunay triangulation.

use smallvec::SmallVec;

use super::half_edges::OpenEdges;
use crate::geom::{Point, SUBPIXEL, Size, orient};

/// Vertices by the cells of a grid, of about two each.
#[derive(Debug)]
pub(super) struct Apexes {
    /// Side of a cell, in 1/256 pixel.
    cell: i32,
    columns: i32,
    rows: i32,
    starts: Vec<u32>,
    /// The vertices of each cell, and where they stand.
    vertices: Vec<(u32, Point)>,
    /// Vertices that some edge has touched.
    reached: Vec<bool>,
}

/// The vertices that are most likely, first the best.
#[derive(Debug, Default)]
pub(super) struct Best {
    pub(super) vertices: SmallVec<[u32; 3]>,
    /// The cotangent of the angle under which each sees the edge.
    cotangents: SmallVec<[f64; 3]>,
    /// Whether the best closes a second edge.
    closes: bool,
}

impl Best {
    /// How sure the best one is: 0 to 7 for one that opens two edges, 8 to 15 for one that closes one.
    pub(super) fn context(&self) -> usize {
        let sure = match self.cotangents[..] {
            [first, second, ..] => {
                let gap = second - first;
                STEPS.iter().filter(|&&step| gap > step).count()
            }
            _ => STEPS.len(),
        };
        let wide = match self.cotangents.first() {
            Some(&first) if first < 0.25 => 0,
            Some(&first) if first < 1.0 => 16,
            _ => 32,
        };
        sure + if self.closes { 8 } else { 0 } + wide
    }

    /// Where a vertex would stand among them; 3 is nowhere.
    fn place(&self, vertex: u32, cotangent: f64) -> usize {
        let better = |i: usize| (cotangent, vertex) < (self.cotangents[i], self.vertices[i]);
        (0..self.vertices.len()).find(|&i| better(i)).unwrap_or(self.vertices.len())
    }

    fn put(&mut self, place: usize, vertex: u32, cotangent: f64) {
        self.vertices.truncate(2.max(place));
        self.cotangents.truncate(2.max(place));
        self.vertices.insert(place, vertex);
        self.cotangents.insert(place, cotangent);
    }
}

/// Gaps between the cotangents of the best and the second, by which their contexts differ.
const STEPS: [f64; 7] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0];

/// The most cells that are searched for an edge.
const MOST_CELLS: i32 = 400;
/// How far around an edge they are searched at most, in cells.
const MOST_MARGIN: i32 = 8;

impl Apexes {
    pub(super) fn new(size: Size, points: &[Point], border: &[u32]) -> Self {
        let far = size.far();
        let each = 2 * i64::from(far.x) * i64::from(far.y) / points.len() as i64;
        let cell = ((each as f64).sqrt() as i32).max(SUBPIXEL);
        let (columns, rows) = (far.x / cell + 1, far.y / cell + 1);
        let place = |p: &Point| (p.y / cell * columns + p.x / cell) as u32;
        let mut starts = Vec::new();
        crate::mesh::starts(&mut starts, (columns * rows) as usize, points.iter().map(place));
        let mut at = starts.clone();
        let mut vertices = vec![(0, Point::default()); points.len()];
        for (p, v) in points.iter().zip(0u32..) {
            let at = &mut at[place(p) as usize];
            vertices[*at as usize] = (v, *p);
            *at += 1;
        }
        let mut reached = vec![false; points.len()];
        border.iter().for_each(|&v| reached[v as usize] = true);
        Self { cell, columns, rows, starts, vertices, reached }
    }

    /// An edge has touched `v`.
    pub(super) fn reach(&mut self, v: u32) {
        self.reached[v as usize] = true;
    }

    /// Whether there is room for another triangle at `v`.
    pub(super) fn can_be(&self, v: u32, open: &OpenEdges) -> bool {
        self.reached.get(v as usize).is_some_and(|reached| !reached || !open.is_free(v))
    }

    /// The vertices to the left of the edge from `a` to `b` that see it under the largest angles.
    pub(super) fn best(
        &self,
        (a, b): (u32, u32),
        points: &[Point],
        open: &OpenEdges,
        except: Option<u32>,
    ) -> Best {
        let (p, q) = (points[a as usize], points[b as usize]);
        let mut best = Best::default();
        // Where just one open edge goes on from b, and bends to the left, no apex can lie beyond it.
        let next = open.only_from(b).map(|v| (v, points[v as usize]));
        let next = next.filter(|&(_, n)| orient(p, q, n) > 0);
        for &(v, c) in self.near(p, q) {
            let area = orient(p, q, c);
            if area <= 0 {
                continue;
            }
            let dot = i64::from(p.x - c.x) * i64::from(q.x - c.x)
                + i64::from(p.y - c.y) * i64::from(q.y - c.y);
            // Both are below 2^53: the quotient is the same on any machine.
            let cotangent = dot as f64 / area as f64;
            let place = best.place(v, cotangent);
            // What takes longest to find out is asked last, of few.
            if place == 3 || v == a || v == b || Some(v) == except || !self.can_be(v, open) {
                continue;
            }
            if next.is_none_or(|(n, at)| n == v || orient(q, at, c) > 0) {
                best.put(place, v, cotangent);
            }
        }
        best.closes =
            best.vertices.first().is_some_and(|&v| open.is_open(b, v) || open.is_open(v, a));
        best
    }

    /// The vertices in the cells around the edge from `p` to `q`, row by row.
    fn near(&self, p: Point, q: Point) -> impl Iterator<Item = &(u32, Point)> {
        let long = (p.x - q.x).abs().max((p.y - q.y).abs());
        let margin = long.clamp(self.cell, MOST_MARGIN * self.cell);
        let cells = |a: i32, b: i32, count: i32| {
            let first = (a.min(b) - margin).max(0) / self.cell;
            let last = ((a.max(b) + margin) / self.cell).min(count - 1);
            (first, last)
        };
        let ((left, right), (top, bottom)) =
            (cells(p.x, q.x, self.columns), cells(p.y, q.y, self.rows));
        let many = (right - left + 1) * (bottom - top + 1) > MOST_CELLS;
        let rows = if many { 1..1 } else { top..bottom + 1 };
        rows.flat_map(move |row| {
            let [start, end] =
                [left, right + 1].map(|x| self.starts[(row * self.columns + x) as usize]);
            self.vertices[start as usize..end as usize].iter()
        })
    }
}
