//! The colours of triangles, each as its difference from what its neighbours, or the frame before, let expect.

use super::connectivity::Grown;
use super::half_edges::HalfEdges;
use super::places::Places;
use super::range_coder::{Bits, Difference, Model, Steps};
use super::{Fault, NONE};
use crate::frame::Rgba;
use crate::geom::{Point, orient};

/// What the coder has learnt.
#[derive(Clone, Debug, Default)]
pub(super) struct Models {
    /// Whether a triangle that lives on has kept its colour; by its area.
    kept: [[Model; 12]; AREAS],
    kinds: [Box<KindModels>; KINDS],
}

/// What it has learnt of a kind of triangles.
#[derive(Clone, Debug, Default)]
struct KindModels {
    /// By how wrong others were; green by area, too.
    green: [[Difference; AREAS]; CLASSES],
    red: [Difference; CLASSES],
    blue: [Difference; CLASSES],
    /// By how far green was off and which way, and how far red was off in the neighbours.
    red_by_green: [[[Steps; 5]; 2]; 6],
    /// By how far red was off and which way, and how far green was.
    blue_by_red: [[[Steps; 6]; 2]; 6],
    alpha: Difference,
}

/// Kinds of triangles: new ones, those that live on but have moved, those that stand still, new ones of which it is
/// known where they lay in the frame before.
const NEW: usize = 0;
const MOVED: usize = 1;
const STILL: usize = 2;
const PLACED: usize = 3;
const KINDS: usize = 4;
/// Classes of how wrong the neighbours were.
const CLASSES: usize = 8;
/// Classes of area: twice 16, 64 and 256 pixels, in (1/256 pixel)^2.
const AREA_STEPS: [i64; 3] = [1 << 21, 1 << 23, 1 << 25];
const AREAS: usize = AREA_STEPS.len() + 1;

/// What is known of the frame, and of the one before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before<'a> {
    /// The edges of the frame's own triangles.
    pub(super) edges: &'a HalfEdges,
    pub(super) points: &'a [Point],
    /// The colours of the triangles of the frame before.
    pub(super) colours: &'a [Rgba],
    /// How wrong each was there.
    pub(super) wrong: &'a [u16],
    /// Whether each vertex has moved since.
    pub(super) moved: &'a [bool],
    /// Where triangles lay there.
    pub(super) places: Option<Places<'a>>,
    /// By how much an encoder may be off.
    pub(super) tolerance: u8,
}

/// What is expected of a triangle's colour.
struct Expected {
    kind: usize,
    colour: Rgba,
    /// How wrong that may be.
    class: usize,
    area: usize,
}

/// A frame's colours on their way.
struct Colours<'a> {
    grown: &'a Grown,
    before: Before<'a>,
    /// For each triangle those before it that share an edge with it, [`NONE`] for those that do not.
    neighbours: Vec<[u32; 3]>,
    fans: Fans,
    wrong: Vec<u16>,
    /// By how much red was off beyond green.
    red: Vec<u16>,
    kept: Vec<bool>,
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
    let count = colours.len();
    let mut known = Colours {
        grown,
        before,
        neighbours: neighbours(&grown.triangles, before.edges),
        fans: Fans(vec![([0; 4], 0); before.points.len()]),
        wrong: vec![0; count],
        red: vec![0; count],
        kept: vec![false; count],
    };
    for t in 0..count {
        if bits.is_beyond_end() {
            return Err(Fault::Colours);
        }
        if !known.pass_kept(bits, models, t, colours) {
            known.pass_differences(bits, models, alpha, t, colours)?;
        }
        known.fans.add(grown.triangles[t], colours[t]);
    }
    Ok(known.wrong)
}

impl Colours<'_> {
    fn neighbours(&self, t: usize) -> impl Iterator<Item = usize> + Clone {
        self.neighbours[t].into_iter().filter(|&n| n != NONE).map(|n| n as usize)
    }

    /// The triangle's number and colour in the frame before, if it was there.
    fn last(&self, t: usize) -> Option<(usize, Rgba)> {
        let old = self.grown.before[t] as usize;
        self.before.colours.get(old).map(|&colour| (old, colour))
    }

    fn has_moved(&self, t: usize) -> bool {
        let moved = |&v: &u32| self.before.moved.get(v as usize).is_some_and(|&moved| moved);
        self.grown.triangles[t].iter().any(moved)
    }

    fn area(&self, t: usize) -> usize {
        let [a, b, c] = self.grown.triangles[t].map(|v| self.before.points[v as usize]);
        let area = orient(a, b, c);
        AREA_STEPS.iter().filter(|&&step| area >= step).count()
    }

    /// Passes whether the triangle has the colour that it had.
    fn pass_kept(
        &mut self,
        bits: &mut impl Bits,
        models: &mut Models,
        t: usize,
        colours: &mut [Rgba],
    ) -> bool {
        let Some((old, last)) = self.last(t) else { return false };
        let keepers = self.neighbours(t).filter(|&n| self.kept[n]).count();
        let neighbours = if keepers == 0 {
            0
        } else if keepers == self.neighbours(t).count() {
            2
        } else {
            1
        };
        let context = 6 * usize::from(self.has_moved(t))
            + 2 * neighbours
            + usize::from(self.before.wrong[old] > 0);
        let model = &mut models.kept[self.area(t)][context];
        let near = self.before.is_near(colours[t], last);
        self.kept[t] = bits.bit(model, near);
        if self.kept[t] {
            colours[t] = last;
        }
        self.kept[t]
    }

    fn expected(&self, t: usize, colours: &[Rgba]) -> Expected {
        let neighbours = self.neighbours(t);
        let count = neighbours.clone().count();
        let sum: usize = neighbours.clone().map(|n| usize::from(self.wrong[n])).sum();
        let mean = sum / count.max(1);
        let triangle = self.grown.triangles[t];
        let around = || self.fans.expected(triangle, self.neighbours(t).map(|n| colours[n]));
        let apart = |a: u8, b: u8| usize::from(a.abs_diff(b));
        let place = || self.before.places.and_then(|places| places.find(triangle));
        let (kind, colour, wrong) = if let Some((old, last)) = self.last(t) {
            let kind = if self.has_moved(t) { MOVED } else { STILL };
            (kind, last, (mean + usize::from(self.before.wrong[old])) / 2)
        } else if let Some(place) = place() {
            let (there, around) = (self.before.colours[place as usize], around());
            let off = apart(there[1], around[1]) + apart(there[0], around[0]) / 2;
            let mix = |c: usize| ((2 * u16::from(there[c]) + u16::from(around[c])) / 3) as u8;
            (PLACED, [mix(0), mix(1), mix(2), mix(3)], (mean + off) / 2)
        } else if count > 1 {
            let greens = neighbours.map(|n| colours[n][1]);
            let (low, high) = greens.fold((255, 0), |(low, high), g| (g.min(low), g.max(high)));
            (NEW, around(), (mean + apart(high, low)) / 2)
        } else {
            (NEW, around(), mean)
        };
        Expected { kind, colour, class: class(wrong), area: self.area(t) }
    }

    /// Passes by how much a triangle's colour differs from what is expected.
    fn pass_differences(
        &mut self,
        bits: &mut impl Bits,
        models: &mut Models,
        alpha: bool,
        t: usize,
        colours: &mut [Rgba],
    ) -> Result<(), Fault> {
        let Expected { kind, colour: expected, class, area } = self.expected(t, colours);
        let models = &mut models.kinds[kind];
        let near = |c: usize, beyond: i32| self.before.near(colours[t][c], expected[c], beyond);
        let g = sound(models.green[class][area].pass(bits, near(1, 0)))?;
        let (green, count) = (g.unsigned_abs(), self.neighbours(t).count().max(1));
        // Red and blue change with green: only what they change beyond it is written.
        let reds = self.neighbours(t).map(|n| usize::from(self.red[n])).sum::<usize>() / count;
        let by_green = &mut models.red_by_green[far(green)][usize::from(g < 0)];
        let by_green = &mut by_green[[1, 2, 4, 8].iter().filter(|&&step| reds >= step).count()];
        let r = sound(models.red[class].pass_with(bits, by_green, near(0, g)))?;
        let by_red = &mut models.blue_by_red[far(r.unsigned_abs())][usize::from(r < 0)];
        let by_red = &mut by_red[far(green)];
        let b = sound(models.blue[class].pass_with(bits, by_red, near(2, g)))?;
        let exact = i32::from(colours[t][3]) - i32::from(expected[3]);
        let a = if alpha { models.alpha.pass(bits, exact) } else { 0 };
        let put = |c: usize, by: i32, beyond: i32| -> Result<u8, Fault> {
            let value = i32::from(expected[c]).checked_add(by).and_then(|v| v.checked_add(beyond));
            value.and_then(|value| u8::try_from(value).ok()).ok_or(Fault::Colours)
        };
        let whole = if alpha { put(3, a, 0)? } else { 255 };
        colours[t] = [put(0, r, g)?, put(1, g, 0)?, put(2, b, g)?, whole];
        self.red[t] = r.unsigned_abs() as u16;
        self.wrong[t] = (green + r.unsigned_abs() / 2 + b.unsigned_abs() / 2).max(1) as u16;
        Ok(())
    }
}

impl Before<'_> {
    /// Whether a colour is near enough to be taken for another one.
    fn is_near(&self, a: Rgba, b: Rgba) -> bool {
        (0..3).all(|c| a[c].abs_diff(b[c]) <= self.tolerance) && a[3] == b[3]
    }

    /// The difference of `value` from what is expected with `beyond` added, one of those that are near enough.
    fn near(&self, value: u8, expected: u8, beyond: i32) -> i32 {
        let (expected, tolerance) = (i32::from(expected), i32::from(self.tolerance));
        let exact = i32::from(value) - expected - beyond;
        let step = 2 * tolerance + 1;
        let rounded = (exact.abs() + tolerance) / step * step * exact.signum();
        rounded.clamp(-expected - beyond, 255 - expected - beyond)
    }
}

/// A difference that two colours can have, also beyond another one.
fn sound(difference: i32) -> Result<i32, Fault> {
    if difference.unsigned_abs() < 512 { Ok(difference) } else { Err(Fault::Colours) }
}

/// Classes of how far a channel is off.
fn far(off: u32) -> usize {
    [1, 2, 4, 8, 20].iter().filter(|&&step| off >= step).count()
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
fn neighbours(triangles: &[[u32; 3]], edges: &HalfEdges) -> Vec<[u32; 3]> {
    let beside = |t: usize, a: u32, b: u32| {
        edges.left_of(b, a).map(|(_, u)| u).filter(|&u| (u as usize) < t).unwrap_or(NONE)
    };
    let each = triangles.iter().enumerate();
    each.map(|(t, &[a, b, c])| [beside(t, a, b), beside(t, b, c), beside(t, c, a)]).collect()
}
