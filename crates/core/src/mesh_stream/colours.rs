//! The colours of triangles, each as its difference from what its neighbours, or the frame before, let expect.

use super::connectivity::Grown;
use super::range_coder::{Bits, Difference, Model};
use super::{Fault, NONE};
use crate::frame::Rgba;

/// What the coder has learnt.
#[derive(Clone, Debug, Default)]
pub(super) struct Models {
    /// Whether a triangle that lives on has kept its colour.
    kept: [Model; 12],
    /// Of triangles that are new, that live on but have moved, and that stand still; by how wrong others were.
    green: [[Difference; CLASSES]; 3],
    red: [[Difference; CLASSES]; 3],
    blue: [[Difference; CLASSES]; 3],
    alpha: [Difference; 3],
}

/// Classes of how wrong the neighbours were.
const CLASSES: usize = 8;

/// What is known of the frame before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before<'a> {
    /// The colours of its triangles.
    pub(super) colours: &'a [Rgba],
    /// How wrong each was there.
    pub(super) wrong: &'a [u16],
    /// Whether each vertex has moved since.
    pub(super) moved: &'a [bool],
}

/// Passes the colours of the triangles that have `grown`, which have a place each; returns how wrong each was: the
/// sum over its channels.
pub(super) fn pass(
    bits: &mut impl Bits,
    models: &mut Models,
    grown: &Grown,
    before: Before<'_>,
    alpha: bool,
    colours: &mut [Rgba],
) -> Result<Vec<u16>, Fault> {
    let beside = neighbours(&grown.triangles);
    let vertices = grown.triangles.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    let mut fans = Fans(vec![([0; 4], 0); vertices]);
    let mut wrong = vec![0u16; colours.len()];
    let mut kept = vec![false; colours.len()];
    for t in 0..colours.len() {
        if bits.is_beyond_end() {
            return Err(Fault::Colours);
        }
        let triangle = grown.triangles[t];
        let known = || beside[t].iter().filter(|&&n| n != NONE).map(|&n| n as usize);
        let count = known().count();
        let old = grown.before[t] as usize;
        let last = before.colours.get(old).copied();
        let moved = last.is_none()
            || triangle.iter().any(|&v| before.moved.get(v as usize).is_some_and(|&moved| moved));
        if let Some(last) = last {
            let keepers = known().filter(|&n| kept[n]).count();
            let neighbours = if keepers == 0 {
                0
            } else if keepers == count {
                2
            } else {
                1
            };
            let context =
                6 * usize::from(moved) + 2 * neighbours + usize::from(before.wrong[old] > 0);
            kept[t] = bits.bit(&mut models.kept[context], colours[t] == last);
            if kept[t] {
                colours[t] = last;
                fans.add(triangle, last);
                continue;
            }
        }
        let mut mean_wrong = known().map(|n| usize::from(wrong[n])).sum::<usize>() / count.max(1);
        if last.is_some() {
            mean_wrong = (mean_wrong + usize::from(before.wrong[old])) / 2;
        }
        if last.is_none() && count > 1 {
            let apart = |c: usize| {
                let (low, high) = known().fold((255, 0), |(low, high), n| {
                    (low.min(colours[n][c]), high.max(colours[n][c]))
                });
                usize::from(high.saturating_sub(low))
            };
            mean_wrong = (mean_wrong + apart(1)) / 2;
        }
        let class = class(mean_wrong);
        let kind = match (last, moved) {
            (None, _) => 0,
            (_, true) => 1,
            _ => 2,
        };
        let expected = last.unwrap_or_else(|| fans.expected(triangle, known().map(|n| colours[n])));
        let difference = |c: usize| i32::from(colours[t][c]) - i32::from(expected[c]);
        let g = models.green[kind][class].pass(bits, difference(1));
        // Red and blue change with green: only what they change beyond it is written.
        let follow = class;
        let r = models.red[kind][follow].pass(bits, difference(0).wrapping_sub(g)).wrapping_add(g);
        let b = models.blue[kind][follow].pass(bits, difference(2).wrapping_sub(g)).wrapping_add(g);
        let a = if alpha { models.alpha[kind].pass(bits, difference(3)) } else { 0 };
        let put = |c: usize, by: i32| -> Result<u8, Fault> {
            let value = i32::from(expected[c]).checked_add(by).ok_or(Fault::Colours)?;
            u8::try_from(value).map_err(|_| Fault::Colours)
        };
        let whole = if alpha { put(3, a)? } else { 255 };
        colours[t] = [put(0, r)?, put(1, g)?, put(2, b)?, whole];
        fans.add(triangle, colours[t]);
        wrong[t] = (g.unsigned_abs()
            + r.wrapping_sub(g).unsigned_abs() / 2
            + b.wrapping_sub(g).unsigned_abs() / 2)
            .max(1) as u16;
    }
    Ok(wrong)
}

/// Sums of the colours that are known around each vertex.
#[derive(Debug)]
struct Fans(Vec<([u32; 4], u32)>);

impl Fans {
    fn add(&mut self, triangle: [u32; 3], colour: Rgba) {
        for v in triangle {
            let (sum, count) = &mut self.0[v as usize];
            (0..4).for_each(|c| sum[c] += u32::from(colour[c]));
            *count += 1;
        }
    }

    /// The mean of the `neighbours` over edges, which count [`OVER_EDGES`] times, and of all triangles known at the
    /// corners.
    fn expected(&self, triangle: [u32; 3], neighbours: impl Iterator<Item = Rgba>) -> Rgba {
        let (mut sum, mut count) = ([0u32; 4], 0);
        let corners = triangle.map(|v| self.0[v as usize]);
        for colour in neighbours {
            (0..4).for_each(|c| sum[c] += OVER_EDGES * u32::from(colour[c]));
            count += OVER_EDGES;
        }
        if count == 0 {
            for (part, n) in corners {
                (0..4).for_each(|c| sum[c] += part[c]);
                count += n;
            }
        }
        if count == 0 {
            return [128, 128, 128, 255];
        }
        sum.map(|sum| ((2 * sum + count) / (2 * count)) as u8)
    }
}

const OVER_EDGES: u32 = 3;

fn class(wrong: usize) -> usize {
    [1, 3, 6, 10, 16, 26, 45].iter().filter(|&&step| wrong >= step).count()
}

/// For each triangle those before it that share an edge with it, [`NONE`] for those that do not.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let vertices = triangles.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    let edges = super::half_edges::HalfEdges::of(vertices, triangles);
    let beside = |t: usize, a: u32, b: u32| {
        edges.left_of(b, a).map(|(_, u)| u).filter(|&u| (u as usize) < t).unwrap_or(NONE)
    };
    let each = triangles.iter().enumerate();
    each.map(|(t, &[a, b, c])| [beside(t, a, b), beside(t, b, c), beside(t, c, a)]).collect()
}
