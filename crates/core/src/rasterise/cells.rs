//! Cells: triangles that are filled together. Neighbours of like colour are one pane; or the triangles around a centre
//! are one cell of a Voronoi diagram.
//!
//! All triangles of a cell have one colour, and cells that touch have different ones, so that whoever has the colours
//! has the cells: an outline runs where colours differ.

use std::collections::HashMap;

use super::colours::Colours;
use crate::draw::inner_edges;
use crate::feature::lab;
use crate::frame::{Fill, Rgba};
use crate::mesh::{DERIVED, Mesh};
use crate::voronoi::centres;

/// The largest difference of two panes that become one, in units of L*a*b*.
const LIKE: f64 = 9.0;

/// The same where they were one in the frame before, and where they were not, as shares of it at coherence 1: panes
/// neither open nor close because of grain.
const KEPT: f64 = 1.6;
const BARRED: f64 = 0.6;

/// A pane smaller than this share of the mean triangle goes to its most similar neighbour, if that is no more than
/// [`SMALL_LIKE`] units away.
const SMALL: f64 = 0.5;
const SMALL_LIKE: f64 = 30.0;

/// Of alpha: more than that and two panes are never one.
const ALPHA: u8 = 32;

/// Merges triangles of like colour.
#[derive(Clone, Debug, Default)]
pub(super) struct Panes {
    /// The edges between two triangles in the frame before, by the lasting ids of their ends, in order, and whether
    /// those were in one pane.
    before: Vec<([u64; 2], bool)>,
}

impl Panes {
    pub(super) fn forget(&mut self) {
        self.before.clear();
    }

    /// Gives the triangles of each pane its mean colour.
    pub(super) fn merge(&mut self, mesh: &Mesh, fills: &mut [Fill], coherence: f64) {
        let edges = self.edges(mesh, fills, coherence);
        let mut regions = Regions::of(fills);
        for edge in &edges {
            regions.merge_if(edge.triangles, |_, _, apart| apart <= edge.like);
        }
        let area: u64 = fills.iter().map(|fill| u64::from(fill.area)).sum();
        let small = (SMALL * area as f64 / fills.len().max(1) as f64) as i64;
        for edge in &edges {
            let is_small = |a: i64, b: i64, apart: f64| a.min(b) < small && apart <= SMALL_LIKE;
            regions.merge_if(edge.triangles, is_small);
        }
        let panes: Vec<u32> = (0..fills.len() as u32).map(|t| regions.root(t)).collect();
        self.before.clear();
        let kept = edges.iter().map(|edge| {
            let [t, u] = edge.triangles.map(|t| panes[t as usize]);
            (edge.ends, t == u)
        });
        self.before.extend(kept);
        self.before.sort_unstable();
        unite(fills, &panes);
    }

    /// The edges between two triangles, first those within panes of the frame before, so that panes grow from what
    /// they were; of these and of the others those of the most similar ones first.
    fn edges(&self, mesh: &Mesh, fills: &[Fill], coherence: f64) -> Vec<Edge> {
        let colours: Vec<_> = fills.iter().map(|fill| lab::of(fill.colour)).collect();
        let edge = |(ends, triangles): ([u32; 2], [u32; 2])| {
            let mut ends = ends.map(|v| mesh.ids[v as usize]);
            ends.sort_unstable();
            let before = self.before.binary_search_by_key(&ends, |edge| edge.0);
            let was_within = before.ok().map(|at| self.before[at].1);
            let share = match was_within {
                Some(true) => 1.0 + coherence * (KEPT - 1.0),
                Some(false) => 1.0 + coherence * (BARRED - 1.0),
                None => 1.0,
            };
            let [a, b] = triangles.map(|t| colours[t as usize]);
            let is_kept = was_within == Some(true) && coherence > 0.0;
            Edge { apart: distance(a, b), ends, is_kept, triangles, like: share * LIKE }
        };
        let mut edges: Vec<Edge> = inner_edges(mesh).into_iter().map(edge).collect();
        edges.sort_unstable_by(|a, b| {
            let by_colour = a.apart.total_cmp(&b.apart).then(a.ends.cmp(&b.ends));
            b.is_kept.cmp(&a.is_kept).then(by_colour)
        });
        edges
    }
}

/// An edge between two triangles.
#[derive(Clone, Copy, Debug)]
struct Edge {
    apart: f64,
    /// The lasting ids of its ends, ascending.
    ends: [u64; 2],
    /// Whether it was within a pane of the frame before.
    is_kept: bool,
    triangles: [u32; 2],
    /// The largest difference at which it is given up.
    like: f64,
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Triangles in groups, each with its mean.
#[derive(Debug)]
struct Regions {
    parent: Vec<u32>,
    area: Vec<i64>,
    /// L*a*b* times the area.
    sum: Vec<[f64; 3]>,
    alpha: Vec<u8>,
}

impl Regions {
    fn of(fills: &[Fill]) -> Self {
        let area = |fill: &Fill| i64::from(fill.area.max(1));
        Self {
            parent: (0..fills.len() as u32).collect(),
            area: fills.iter().map(area).collect(),
            sum: fills.iter().map(|f| lab::of(f.colour).map(|v| v * area(f) as f64)).collect(),
            alpha: fills.iter().map(|fill| fill.colour[3]).collect(),
        }
    }

    fn root(&mut self, mut t: u32) -> u32 {
        while self.parent[t as usize] != t {
            let above = self.parent[self.parent[t as usize] as usize];
            self.parent[t as usize] = above;
            t = above;
        }
        t
    }

    /// Merges the regions of two triangles if `wanted(area, area, difference)`.
    fn merge_if(&mut self, pair: [u32; 2], wanted: impl Fn(i64, i64, f64) -> bool) {
        let [t, u] = pair.map(|t| self.root(t));
        let (lower, upper) = (t.min(u) as usize, t.max(u) as usize);
        if lower == upper {
            return;
        }
        let (a, b) = (self.alpha[lower], self.alpha[upper]);
        let clear = a == 0 && b == 0;
        let opaque_enough = (a == 0) == (b == 0) && a.abs_diff(b) <= ALPHA;
        let mean = |r: usize| self.sum[r].map(|v| v / self.area[r] as f64);
        let apart = distance(mean(lower), mean(upper));
        if clear || (opaque_enough && wanted(self.area[lower], self.area[upper], apart)) {
            self.parent[upper] = lower as u32;
            self.area[lower] += self.area[upper];
            for c in 0..3 {
                self.sum[lower][c] += self.sum[upper][c];
            }
        }
    }
}

/// Gives the triangles of each cell of a Voronoi diagram its mean colour, which `colours` hold back from shimmering,
/// and neighbours of the same colour slightly different ones.
pub(super) fn fill_cells(mesh: &Mesh, fills: &mut [Fill], colours: &mut Colours, coherence: f64) {
    if mesh.ids.iter().all(|&id| id < DERIVED) {
        // There was no room for cells.
        return;
    }
    let centres = centres(mesh);
    unite(fills, &centres);
    let mut of_cell: HashMap<u32, Fill> = HashMap::new();
    for (centre, fill) in centres.iter().zip(&*fills) {
        of_cell.entry(*centre).or_insert(*fill);
    }
    let mut cells: Vec<(u64, u32, Fill)> = of_cell
        .into_iter()
        .map(|(centre, fill)| (mesh.ids[centre as usize], centre, fill))
        .collect();
    cells.sort_unstable_by_key(|cell| (cell.0, cell.1));
    if coherence > 0.0 {
        let keys: Vec<[u32; 3]> =
            cells.iter().map(|(id, ..)| [(id >> 32) as u32, *id as u32, 0]).collect();
        let mut held: Vec<Fill> = cells.iter().map(|cell| cell.2).collect();
        colours.steady_all(&keys, &mut held, coherence);
        cells.iter_mut().zip(held).for_each(|(cell, held)| cell.2 = held);
    }
    let mut at = vec![[0; 4]; mesh.vertices.len()];
    cells.iter().for_each(|&(_, centre, fill)| at[centre as usize] = fill.colour);
    tell_apart(mesh, &centres, &mut at);
    for (centre, fill) in centres.iter().zip(fills) {
        fill.colour = at[*centre as usize];
    }
}

/// Changes colours, by the vertex that is the centre, so that no two cells that touch have the same.
fn tell_apart(mesh: &Mesh, centres: &[u32], colours: &mut [Rgba]) {
    let mut touching: Vec<(u32, u32)> = Vec::new();
    for (_, triangles) in inner_edges(mesh) {
        let [t, u] = triangles.map(|t| centres[t as usize]);
        if t != u {
            touching.push((t.max(u), t.min(u)));
        }
    }
    touching.sort_unstable();
    touching.dedup();
    for around in touching.chunk_by(|a, b| a.0 == b.0) {
        let here = around[0].0 as usize;
        let [r, g, b, a] = colours[here];
        if a == 0 {
            continue;
        }
        // Blue is seen least.
        let steps = [0i16, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7, 8, -8];
        let other = steps.iter().filter_map(|step| u8::try_from(i16::from(b) + step).ok());
        let free =
            |b: &u8| around.iter().all(|&(_, there)| colours[there as usize] != [r, g, *b, a]);
        if let Some(b) = other.into_iter().find(free) {
            colours[here] = [r, g, b, a];
        }
    }
}

/// Gives triangles with the same label their mean colour, by area and by what is seen of them.
fn unite(fills: &mut [Fill], labels: &[u32]) {
    let count = labels.iter().max().map_or(0, |&label| label as usize + 1);
    let mut sums = vec![([0u64; 3], 0u64, 0u64); count];
    for (fill, &label) in fills.iter().zip(labels) {
        // One that covers no pixel counts where there is nothing else.
        let area = 1024 * u64::from(fill.area) + 1;
        let (sum, alpha, all) = &mut sums[label as usize];
        let weight = area * u64::from(fill.colour[3]);
        (0..3).for_each(|c| sum[c] += weight * u64::from(fill.colour[c]));
        *alpha += weight;
        *all += area;
    }
    for (fill, &label) in fills.iter_mut().zip(labels) {
        let (sum, alpha, all) = sums[label as usize];
        let opacity = (alpha + all / 2) / all;
        fill.colour = if opacity == 0 {
            [0; 4]
        } else {
            let [r, g, b] = sum.map(|sum| ((sum + alpha / 2) / alpha) as u8);
            [r, g, b, opacity as u8]
        };
    }
}

#[cfg(test)]
mod tests {
    use super::super::{means, tests::noise};
    use super::*;
    use crate::frame::Frame;
    use crate::geom::Size;
    use crate::triangulate::tests::mesh_of;
    use crate::voronoi::cells;

    fn places(count: u32) -> Vec<(f64, f64)> {
        let place = |i: u32| {
            let bits = crate::chance::rank(4, crate::chance::Purpose::Noise, i, 0);
            ((bits >> 32) as f64 / 4_294_967_296.0, (bits & 0xffff_ffff) as f64 / 4_294_967_296.0)
        };
        (0..count).map(place).collect()
    }

    /// A red disk on blue, with grain.
    fn disk(size: Size, grain: u64) -> Frame {
        let pixel = |i: usize| {
            let (x, y) = ((i % size.width as usize) as f64, (i / size.width as usize) as f64);
            let n =
                (crate::chance::rank(grain, crate::chance::Purpose::Noise, i as u32, 0) % 9) as u8;
            if (x - 40.0).hypot(y - 30.0) < 20.0 {
                [200 + n, 40 + n, 30, 255]
            } else {
                [20, 40 + n, 120 + n, 255]
            }
        };
        Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small")
    }

    #[test]
    fn like_neighbours_become_one_pane_and_grain_does_not_change_that() {
        let size = Size::new(80, 60);
        let mesh = mesh_of(size, &places(60), 1);
        let mut panes = Panes::default();
        let colours = |panes: &mut Panes, grain: u64| {
            let mut fills = means(&mesh, &disk(size, grain));
            panes.merge(&mesh, &mut fills, 0.4);
            let mut colours: Vec<_> = fills.iter().map(|fill| fill.colour).collect();
            let all = colours.clone();
            colours.sort_unstable();
            colours.dedup();
            (all, colours.len())
        };
        let (first, count) = colours(&mut panes, 1);
        assert!((2..mesh.triangles.len() / 3).contains(&count), "{count}");
        let labels = |all: &[Rgba]| {
            let alike = |(_, [t, u]): ([u32; 2], [u32; 2])| all[t as usize] == all[u as usize];
            inner_edges(&mesh).into_iter().map(alike).collect::<Vec<_>>()
        };
        for grain in 2..9 {
            let (next, _) = colours(&mut panes, grain);
            assert_eq!(labels(&next), labels(&first), "grain {grain}");
        }
    }

    #[test]
    fn panes_have_the_mean_of_their_triangles() {
        let size = Size::new(80, 60);
        let mesh = mesh_of(size, &places(60), 1);
        let mut fills = means(&mesh, &noise(size, 3, false));
        let before = fills.clone();
        Panes::default().merge(&mesh, &mut fills, 0.0);
        let sum = |fills: &[Fill]| -> f64 {
            fills.iter().map(|f| f64::from(f.area) * f64::from(f.colour[3])).sum()
        };
        assert!((sum(&before) / sum(&fills) - 1.0).abs() < 0.01);
        assert!(before.iter().zip(&fills).all(|(a, b)| a.area == b.area));
    }

    #[test]
    fn cells_have_one_colour_each_and_those_that_touch_differ() {
        let size = Size::new(80, 60);
        let grey = Frame::filled(size, [90, 90, 90, 255]).expect("small");
        for frame in [grey, noise(size, 5, true)] {
            let mesh = cells(&mesh_of(size, &places(60), 1));
            let mut fills = means(&mesh, &frame);
            fill_cells(&mesh, &mut fills, &mut Colours::default(), 0.4);
            let centres = centres(&mesh);
            for (_, triangles) in inner_edges(&mesh) {
                let [t, u] = triangles.map(|t| t as usize);
                let alike = fills[t].colour == fills[u].colour;
                assert_eq!(alike, centres[t] == centres[u], "{:?}", fills[t]);
            }
        }
    }
}
