//! Prefix sums along the rows of a frame, by which the sums over an area become differences along its edges (Green's
//! theorem on the pixel grid).

mod load;

use super::limits::Limits;
use super::options::RefineOptions;
use super::planes::RowPlanes;
use super::sums::{NARROW, Sums, Total, unpack};
use super::target::Target;
use crate::frame::Frame;
use crate::geom::{Point, SUBPIXEL, Size};
use crate::scan::lanes::LaneSquares;
use crate::scan::{self, Crossing, first_centre};
use crate::simd::dispatch;

/// Prefix sums along every row of a frame.
///
/// Four rows are interleaved, column by column, so that a cache line holds two columns of four rows: an edge that
/// goes down by a row moves aside by about a column, and reads half as many cache lines as with eight columns of a
/// row.
#[derive(Debug)]
pub(super) struct RowSums {
    pub(super) size: Size,
    /// The start of each row in `colour` and in `alpha`. A row has one more entry than pixels, each [`TOGETHER`]
    /// after the last.
    starts: Vec<u32>,
    /// Whether triangles may be longer than [`EXTENT`].
    needs_wide_sums: bool,
    /// Packed colours of the pixels left of each column, wrapping.
    colour: Vec<u64>,
    /// Alpha likewise; empty when the frame is opaque.
    alpha: Vec<u32>,
    /// The squares of all channels of all pixels.
    squares: u64,
    /// Squares of the pixels left of each column, in every second row from the first on. Two of these rows are
    /// interleaved.
    squares_before: Vec<u32>,
    /// Whether the squares are of this frame.
    has_subsampled: bool,
    /// Twice the area of triangles whose sums are not taken from their edges: [`LARGE`]; 0 for all of them.
    large: i64,
    /// What the costs of planes of colour are taken from.
    planes: RowPlanes,
    /// How small and how large triangles may be.
    pub(super) limits: Option<Limits>,
}

/// Rows that are interleaved.
const TOGETHER: usize = 4;

/// Entries of a cache line.
const LINE: usize = 64 / size_of::<u64>();

impl Default for RowSums {
    fn default() -> Self {
        Self {
            size: Size::new(0, 0),
            starts: Vec::new(),
            needs_wide_sums: false,
            colour: Vec::new(),
            alpha: Vec::new(),
            squares: 0,
            squares_before: Vec::new(),
            has_subsampled: false,
            large: LARGE,
            planes: RowPlanes::default(),
            limits: None,
        }
    }
}

impl RowSums {
    /// The squares of all channels of all pixels.
    pub(super) fn squares(&self) -> f64 {
        self.squares as f64
    }

    /// The signed sums of the edge from `from` to `to`. Those of a triangle's three edges, in the order of a positive
    /// `orient`, add up to the sums over its pixels.
    #[inline]
    pub(super) fn edge(&self, from: Point, to: Point) -> Sums {
        if from.y <= to.y { self.falling(from, to) } else { -self.falling(to, from) }
    }

    #[inline]
    fn falling(&self, upper: Point, lower: Point) -> Sums {
        let mut sums = Sums::default();
        self.crossings(upper, lower, |column, index| {
            sums.weight = sums.weight.wrapping_add(column as u64);
            sums.colour = sums.colour.wrapping_add(self.colour[index]);
        });
        if !self.alpha.is_empty() {
            self.crossings(upper, lower, |_, index| {
                sums.weight = sums.weight.wrapping_add(u64::from(self.alpha[index]) << 32);
            });
        }
        sums
    }

    /// As [`RowSums::edge`], and the [subsampled](super::subsampled) sums, of a frame that [has](RowSums::has_subsampled) them.
    #[inline(always)]
    pub(super) fn edges(&self, from: Point, to: Point) -> [Sums; 2] {
        debug_assert!(self.has_subsampled, "squares would be an older frame's");
        if from.y <= to.y {
            self.both_falling(from, to)
        } else {
            self.both_falling(to, from).map(|sums| -sums)
        }
    }

    #[inline(always)]
    fn both_falling(&self, upper: Point, lower: Point) -> [Sums; 2] {
        let (mut all, mut subsampled) = (Sums::default(), Sums::default());
        let first = self.starts.first().map_or(0, |&first| first as usize);
        // No branch on subsampled rows: it would be mispredicted once for each edge.
        let mut taken = if first_centre(upper.y) % 2 == 0 { u64::MAX } else { 0 };
        self.crossings(
            upper,
            lower,
            #[inline(always)]
            |column, index| {
                let (colour, squares) =
                    (self.colour[index], self.squares_before[(index - first) / 2]);
                let weight = u64::from(squares) << 32 | column as u64;
                all.weight = all.weight.wrapping_add(column as u64);
                all.colour = all.colour.wrapping_add(colour);
                subsampled.weight = subsampled.weight.wrapping_add(weight & taken);
                subsampled.colour = subsampled.colour.wrapping_add(colour & taken);
                taken = !taken;
            },
        );
        [all, subsampled]
    }

    /// Calls `visit` with the first column right of the edge and its entry's index, row by row.
    #[inline]
    fn crossings(&self, upper: Point, lower: Point, mut visit: impl FnMut(usize, usize)) {
        let (start, end) = (first_centre(upper.y), first_centre(lower.y));
        if start >= end {
            return;
        }
        let mut crossing = Crossing::new(upper, lower, start);
        for &row in &self.starts[start as usize..end as usize] {
            let column = crossing.next();
            visit(column, row as usize + TOGETHER * column);
        }
    }

    /// The index of the entry of column `x` in row `y`.
    #[inline]
    fn at(&self, x: usize, y: usize) -> usize {
        self.starts[y] as usize + TOGETHER * x
    }

    /// The sums over the pixels of `triangle`, with the positive `orient` `doubled`, whose edges have the sum `sums`.
    #[inline(always)]
    pub(super) fn total(&self, sums: &Sums, doubled: i64, triangle: [Point; 3]) -> Total {
        if self.is_special(doubled, triangle) {
            return self.wide(triangle);
        }
        Total::of(sums)
    }

    /// Whether the cost of `triangle`, whose `orient` is `doubled`, does not follow from the sums of its edges.
    #[inline(always)]
    pub(super) fn is_special(&self, doubled: i64, triangle: [Point; 3]) -> bool {
        doubled >= self.large || (self.needs_wide_sums && extent(triangle) >= EXTENT)
    }

    /// Takes what a refinement as `options` say needs of `target`.
    pub(super) fn load_for(&mut self, target: &Target, options: &RefineOptions) {
        self.load(target, options.estimates());
        self.load_planes(target, options.planes);
        self.limits = Limits::of(options.facets, self.size);
    }

    /// Takes what the costs of planes of colour need of `target`, where they are `wanted` and it is opaque, after
    /// [`RowSums::load`].
    fn load_planes(&mut self, target: &Target, wanted: bool) {
        if wanted && target.is_opaque() {
            self.planes.load(target);
            self.large = 0;
        }
    }

    /// What planes of colour cost, where triangles are filled with them.
    pub(super) fn planes(&self) -> Option<&RowPlanes> {
        (self.large == 0).then_some(&self.planes)
    }

    /// As [`RowSums::total`], for triangles of any size.
    #[inline]
    pub(super) fn wide(&self, triangle: [Point; 3]) -> Total {
        // Returns numbers, not a `Total`, so that totals stay in registers: one in memory would be written number by
        // number and read two at a time, which stalls.
        let [count, r, g, b, alpha] = self.wide_sums(triangle);
        Total::new(count, [r, g, b], alpha)
    }

    /// The number of pixels of a triangle of any size, their red, green, blue and alpha.
    #[cold]
    fn wide_sums(&self, triangle: [Point; 3]) -> [i64; 5] {
        let (mut count, mut sums, mut alpha) = (0, [0; 3], 0);
        scan::spans(triangle, 0..self.size.height, |y, columns| {
            for first in columns.clone().step_by(NARROW) {
                let left = self.at(first, y as usize);
                let right = self.at(columns.end.min(first + NARROW), y as usize);
                let colour = self.colour[right].wrapping_sub(self.colour[left]);
                for (sum, part) in sums.iter_mut().zip(unpack(colour)) {
                    *sum += part;
                }
                if !self.alpha.is_empty() {
                    alpha += i64::from(self.alpha[right] - self.alpha[left]);
                }
            }
            count += columns.len() as i64;
        });
        let [r, g, b] = sums;
        [count, r, g, b, alpha]
    }

    /// The squares of all channels of the pixels of a triangle, summed one by one. `target` is the loaded one; if it
    /// has no pixels, or not only opaque ones, they are differences of sums.
    pub(super) fn squares_of(&self, target: &Target, triangle: [Point; 3]) -> f64 {
        let picture = target.picture();
        if picture.is_opaque() && picture.has_pixels() {
            return dispatch(
                #[inline(always)]
                || opaque_squares_of(picture, triangle),
            ) as f64;
        }
        let mut squares = 0u64;
        scan::spans(triangle, 0..self.size.height, |y, columns| {
            let mut left = self.colour[self.at(columns.start, y as usize)];
            for x in columns.clone() {
                let right = self.colour[self.at(x + 1, y as usize)];
                let [r, g, b] = unpack(right.wrapping_sub(left));
                squares += (r * r + g * g + b * b) as u64;
                left = right;
            }
            if !self.alpha.is_empty() {
                let alpha = |x: usize| u64::from(self.alpha[self.at(x, y as usize)]);
                squares += columns.map(|x| (alpha(x + 1) - alpha(x)).pow(2)).sum::<u64>();
            }
        });
        squares as f64
    }

    /// Whether there are [subsampled](super::subsampled) sums: for opaque frames, on request.
    pub(super) fn has_subsampled(&self) -> bool {
        self.has_subsampled
    }

    /// The [subsampled](super::subsampled) sums of `triangle`.
    pub(super) fn subsampled(&self, [a, b, c]: [Point; 3]) -> Sums {
        let edge = |from, to| self.edges(from, to)[1];
        edge(a, b) + edge(b, c) + edge(c, a)
    }

    /// The weighted sum over the pixels at `samples` points, evenly spaced between `from` and `to`, with weights from
    /// 2 `samples` - 1 down to 1: red, green, blue, alpha (0 in opaque frames). At most 90 samples.
    #[inline]
    pub(super) fn sample(&self, from: Point, to: Point, samples: i32) -> [f32; 4] {
        // 16.16 fixed point: coordinates of 2^22 fit.
        let step = [(to.x - from.x) * FINER / samples, (to.y - from.y) * FINER / samples];
        let mut at = [from.x * FINER + step[0] / 2, from.y * FINER + step[1] / 2];
        let last = [self.size.width as usize - 1, self.size.height as usize - 1];
        let (mut colour, mut alpha) = (0u64, 0u32);
        for i in 0..samples {
            let x = ((at[0] >> 16) as usize).min(last[0]);
            let y = ((at[1] >> 16) as usize).min(last[1]);
            // Weights add up to samples^2: 8100 x 255 < 2^21.
            let weight = (2 * (samples - i) - 1) as u32;
            let left = self.at(x, y);
            let right = left + TOGETHER;
            let pixel = self.colour[right].wrapping_sub(self.colour[left]);
            colour += pixel * u64::from(weight);
            if !self.alpha.is_empty() {
                alpha += (self.alpha[right] - self.alpha[left]) * weight;
            }
            at = [at[0] + step[0], at[1] + step[1]];
        }
        let [r, g, b] = unpack(colour);
        [r as f32, g as f32, b as f32, alpha as f32]
    }
}

/// Twice the area of triangles that may have too many pixels for [`Sums`]. A convex shape covers at most its area, half
/// its perimeter and one more centre; the half perimeter is at most width and height of the box around it.
const LARGE: i64 = 2 * (SUBPIXEL as i64) * (SUBPIXEL as i64) * (NARROW as i64 / 2);

/// From 1/256 to 1/65536 pixel.
const FINER: i32 = 65536 / SUBPIXEL;

/// Sum of width and height of a bounding box up to which a triangle of less than half of [`NARROW`] in area covers
/// fewer than [`NARROW`] centres.
const EXTENT: i32 = (NARROW as i32 / 2 - 1) * SUBPIXEL;

/// Sum of width and height of the bounding box of a triangle, in 1/256 pixel.
fn extent([a, b, c]: [Point; 3]) -> i32 {
    let span = |a: i32, b: i32, c: i32| a.max(b).max(c) - a.min(b).min(c);
    span(a.x, b.x, c.x) + span(a.y, b.y, c.y)
}

#[inline(always)]
fn opaque_squares_of(picture: &Frame, triangle: [Point; 3]) -> u64 {
    let (mut squares, mut lanes, mut pixels) = (0, LaneSquares::default(), 0);
    scan::spans(
        triangle,
        0..picture.size().height,
        #[inline(always)]
        |y, columns| {
            lanes.add(&picture.row(y)[columns.start..], columns.len());
            pixels += columns.len();
            if pixels >= NARROW {
                squares += std::mem::take(&mut lanes).total();
                pixels = 0;
            }
        },
    );
    squares + lanes.total()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient;
    use crate::refine::tests::picture;
    use proptest::prelude::*;

    fn slowly(frame: &Frame, triangle: [Point; 3]) -> (Total, f64) {
        let (mut count, mut sums, mut squares) = (0, [0i64; 4], 0.0);
        scan::spans(triangle, 0..frame.size().height, |y, columns| {
            for &[r, g, b, a] in &frame.row(y)[columns] {
                let by_alpha = |v: u8| (f64::from(v) * f64::from(a) / 255.0).round() as i64;
                let alpha = if frame.is_opaque() { 0 } else { i64::from(a) };
                for (sum, v) in sums.iter_mut().zip([by_alpha(r), by_alpha(g), by_alpha(b), alpha])
                {
                    *sum += v;
                    squares += (v * v) as f64;
                }
                count += 1;
            }
        });
        let [r, g, b, a] = sums;
        (Total::new(count, [r, g, b], a), squares)
    }

    proptest! {
        #[test]
        fn edges_add_up_to_the_pixels_that_the_rasteriser_gives(
            corners in proptest::array::uniform3((0i32..=90 * SUBPIXEL, 0i32..=130 * SUBPIXEL)),
            snap in prop_oneof![Just(1), Just(SUBPIXEL / 2), Just(SUBPIXEL)],
            (seed, opaque) in (any::<u64>(), any::<bool>()),
        ) {
            let frame = picture(Size::new(90, 130), seed % 1000, 255, opaque);
            let mut rows = RowSums::default();
            rows.load(&Target::Frame(&frame), false);
            let [a, mut b, mut c] = corners.map(|(x, y)| Point::new(x / snap * snap, y / snap * snap));
            prop_assume!(orient(a, b, c) != 0);
            if orient(a, b, c) < 0 {
                (b, c) = (c, b);
            }
            let sums = rows.edge(a, b) + rows.edge(b, c) + rows.edge(c, a);
            let (slow, squares) = slowly(&frame, [a, b, c]);
            prop_assert_eq!(rows.total(&sums, orient(a, b, c), [a, b, c]), slow);
            prop_assert_eq!(rows.wide([a, b, c]), slow);
            prop_assert_eq!(rows.squares_of(&Target::Frame(&frame), [a, b, c]), squares);
        }
    }

    /// Rows longer than the packed sums can tell apart, as one triangle and as many.
    #[test]
    fn the_longest_rows_are_summed_exactly() {
        let size = Size::new(16384, 3);
        let frame = Frame::filled(size, [255, 254, 253, 255]).expect("a frame");
        let mut rows = RowSums::default();
        rows.load(&Target::Frame(&frame), false);
        let far = size.far();
        let [a, b, c] = [Point::new(0, 0), far, Point::new(0, far.y)];
        let sums = rows.edge(a, b) + rows.edge(b, c) + rows.edge(c, a);
        let (slow, squares) = slowly(&frame, [a, b, c]);
        assert_eq!(rows.total(&sums, orient(a, b, c), [a, b, c]), slow);
        assert!((squares - slow.explained()).abs() < 1.0, "a flat frame has no error");
    }
}
