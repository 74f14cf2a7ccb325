//! Running sums along the rows of a frame, which turn the sums over an area into differences along
//! its edges (Green's theorem on the pixel grid).

use rayon::prelude::*;

use super::sums::{NARROW, Sums, Total, pack, unpack};
use crate::frame::{Frame, Rgba};
use crate::geom::{Point, SUBPIXEL, Size, orient};
use crate::scan::{self, Crossing, first_centre};

/// Running sums along every row of a frame.
///
/// They lie in tiles of [`WIDE`] x [`HIGH`] entries, bands of tiles from top to bottom: what surrounds
/// a vertex is then in a few pages of memory, where whole rows would put each line of it into a page
/// of its own. Within a tile 2 columns of 4 rows lie together, a cache line: an edge that falls by a
/// row goes aside by a column or so, and meets half as many lines as if they held 8 columns of a row.
#[derive(Debug)]
pub(super) struct RowSums {
    pub(super) size: Size,
    /// Entries in a band of tiles. A row has one more entry than pixels.
    band: usize,
    /// Whether triangles may be longer than [`EXTENT`].
    vast: bool,
    /// Packed colours of the pixels left of each column, wrapping.
    colour: Vec<u64>,
    /// Alpha likewise; empty when the frame is opaque.
    alpha: Vec<u32>,
    /// The squares of all channels of all pixels.
    squares: u64,
}

/// Columns of a tile.
const WIDE: usize = 16;
/// Rows of a tile.
const HIGH: usize = 64;
const TILE: usize = WIDE * HIGH;

impl Default for RowSums {
    fn default() -> Self {
        Self {
            size: Size::new(0, 0),
            band: 0,
            vast: false,
            colour: Vec::new(),
            alpha: Vec::new(),
            squares: 0,
        }
    }
}

impl RowSums {
    /// Takes the sums of `frame`, in the memory of the last one's.
    pub(super) fn load(&mut self, frame: &Frame) {
        let size = frame.size();
        self.size = size;
        self.band = (size.width as usize + 1).div_ceil(WIDE) * TILE;
        self.vast = (size.width + size.height) as i32 * SUBPIXEL >= EXTENT;
        let entries = self.band * (size.height as usize).div_ceil(HIGH);
        self.colour.resize(entries, 0);
        self.alpha.clear();
        let rows = |band: usize| (band * HIGH..size.height as usize).take(HIGH).enumerate();
        if frame.is_opaque() {
            let bands = self.colour.par_chunks_mut(self.band).enumerate();
            let squares = bands.map(|(band, colour)| {
                let row = |(line, y)| sum_opaque(frame.row(y as u32), &mut colour[down(line)..]);
                rows(band).map(row).sum::<u64>()
            });
            self.squares = squares.sum();
        } else {
            self.alpha.resize(entries, 0);
            let bands = self.colour.par_chunks_mut(self.band);
            let bands = bands.zip(self.alpha.par_chunks_mut(self.band)).enumerate();
            let squares = bands.map(|(band, (colour, alpha))| {
                let row = |(line, y)| {
                    let at = down(line);
                    sum_premultiplied(frame.row(y as u32), &mut colour[at..], &mut alpha[at..])
                };
                rows(band).map(row).sum::<u64>()
            });
            self.squares = squares.sum();
        }
    }

    /// The squares of all channels of all pixels: what a mesh is to account for.
    pub(super) fn squares(&self) -> f64 {
        self.squares as f64
    }

    /// The signed share of the edge from `from` to `to`: those of a triangle's three edges, in the
    /// order that has a positive `orient`, add up to the sums over the pixels that it covers.
    #[inline]
    pub(super) fn edge(&self, from: Point, to: Point) -> Sums {
        if from.y <= to.y { self.falling(from, to) } else { -self.falling(to, from) }
    }

    #[inline]
    fn falling(&self, upper: Point, lower: Point) -> Sums {
        let mut sums = Sums::default();
        self.crossings(upper, lower, |column, index| {
            sums.count = sums.count.wrapping_add(column as u32);
            sums.colour = sums.colour.wrapping_add(self.colour[index]);
        });
        if !self.alpha.is_empty() {
            self.crossings(upper, lower, |_, index| {
                sums.alpha = sums.alpha.wrapping_add(self.alpha[index]);
            });
        }
        sums
    }

    /// Calls `visit` with the first column right of the edge and its entry's index, row by row.
    #[inline]
    fn crossings(&self, upper: Point, lower: Point, mut visit: impl FnMut(usize, usize)) {
        let (start, end) = (first_centre(upper.y), first_centre(lower.y));
        if start >= end {
            return;
        }
        let mut crossing = Crossing::new(upper, lower, start);
        let (mut y, end) = (start as usize, end as usize);
        while y < end {
            let stop = end.min((y / HIGH + 1) * HIGH);
            let band = y / HIGH * self.band;
            for y in y..stop {
                let column = crossing.next();
                visit(column, band + down(y) + across(column));
            }
            y = stop;
        }
    }

    /// Where the line of row `y` begins.
    fn line(&self, y: usize) -> usize {
        y / HIGH * self.band + down(y)
    }

    /// The sums of the triangle `abc`, with a positive `orient`, whose edges sum to `sums`.
    #[inline]
    pub(super) fn total(&self, sums: &Sums, a: Point, b: Point, c: Point) -> Total {
        // A convex shape covers at most its area, half its perimeter and one more centre; the half
        // perimeter is at most width and height of the box around it.
        const LARGE: i64 = 2 * (SUBPIXEL as i64) * (SUBPIXEL as i64) * (NARROW as i64 / 2);
        if orient(a, b, c) >= LARGE || (self.vast && extent(a, b, c) >= EXTENT) {
            return self.wide([a, b, c]);
        }
        Total::new(i64::from(sums.count as i32), unpack(sums.colour), i64::from(sums.alpha))
    }

    /// As [`RowSums::total`], for triangles of any size.
    #[cold]
    fn wide(&self, triangle: [Point; 3]) -> Total {
        let (mut count, mut sums, mut alpha) = (0, [0; 3], 0);
        scan::spans(triangle, 0..self.size.height, |y, columns| {
            let line = self.line(y as usize);
            for first in columns.clone().step_by(NARROW) {
                let left = line + across(first);
                let right = line + across(columns.end.min(first + NARROW));
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
        Total::new(count, sums, alpha)
    }

    /// The squares of all channels of the pixels of a triangle, one by one. `frame` is the one that was
    /// loaded.
    pub(super) fn squares_of(&self, frame: &Frame, triangle: [Point; 3]) -> f64 {
        let mut squares = 0u64;
        if frame.is_opaque() {
            scan::spans(triangle, 0..self.size.height, |y, columns| {
                // A row has at most 16384 pixels: 3 x 255^2 each stays below 2^32.
                let square = |v: u8| u32::from(v) * u32::from(v);
                let mut row = 0;
                for &[r, g, b, _] in &frame.row(y)[columns] {
                    row += square(r) + square(g) + square(b);
                }
                squares += u64::from(row);
            });
            return squares as f64;
        }
        scan::spans(triangle, 0..self.size.height, |y, columns| {
            let line = self.line(y as usize);
            let mut left = self.colour[line + across(columns.start)];
            for x in columns.clone() {
                let right = self.colour[line + across(x + 1)];
                let [r, g, b] = unpack(right.wrapping_sub(left));
                squares += (r * r + g * g + b * b) as u64;
                left = right;
            }
            let alpha = |x: usize| u64::from(self.alpha[line + across(x)]);
            squares += columns.map(|x| (alpha(x + 1) - alpha(x)).pow(2)).sum::<u64>();
        });
        squares as f64
    }

    /// The mean squared error of triangles of a plain grid, when `triangles` of them share the frame:
    /// the measure of what a triangle may be expected to have on this picture. From some 1000 samples.
    pub(super) fn cell_error(&self, frame: &Frame, triangles: usize) -> f64 {
        const ALONG: i32 = 32;
        let far = self.size.far();
        let area = f64::from(far.x) * f64::from(far.y) / triangles.max(1) as f64;
        let leg = ((2.0 * area).sqrt() as i32).clamp(1, far.x.min(far.y));
        let mut error = 0.0;
        for j in 0..ALONG {
            for i in 0..ALONG {
                let place = |k: i32, far: i32| {
                    (i64::from(far - leg) * i64::from(k) / i64::from(ALONG - 1)) as i32
                };
                let a = Point::new(place(i, far.x), place(j, far.y));
                let triangle = [a, Point::new(a.x + leg, a.y), Point::new(a.x, a.y + leg)];
                error += self.squares_of(frame, triangle) - self.wide(triangle).explained();
            }
        }
        error / f64::from(ALONG * ALONG)
    }

    /// The weighted sum over the pixels below `samples` points, evenly spaced between `from` and `to`,
    /// the weights falling from 2 `samples` - 1 to 1: red, green, blue, alpha (0 in opaque frames).
    /// At most 90 samples.
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
            let (left, right) = (self.line(y) + across(x), self.line(y) + across(x + 1));
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

/// From 1/256 to 1/65536 pixel.
const FINER: i32 = 65536 / SUBPIXEL;

/// Width and height of a box, together, within which a triangle of less than half of [`NARROW`] in area
/// covers fewer centres than that.
const EXTENT: i32 = (NARROW as i32 / 2 - 1) * SUBPIXEL;

/// Width and height of the box around a triangle, together, in 1/256 pixel.
fn extent(a: Point, b: Point, c: Point) -> i32 {
    let span = |a: i32, b: i32, c: i32| a.max(b).max(c) - a.min(b).min(c);
    span(a.x, b.x, c.x) + span(a.y, b.y, c.y)
}

/// How far into its line of a band of tiles the entry of a column stands.
const fn across(column: usize) -> usize {
    column / WIDE * TILE + column % WIDE / 2 * 8 + column % 2
}

/// How far into its band of tiles the line of row `y` begins.
const fn down(y: usize) -> usize {
    y % HIGH / 4 * (4 * WIDE) + y % 4 * 2
}

/// Writes the running sums of an opaque row to its line and returns the squares of its pixels.
fn sum_opaque(row: &[Rgba], line: &mut [u64]) -> u64 {
    let (mut sum, mut squares) = (0u64, 0u64);
    for (pixels, tile) in row.chunks(WIDE).zip(line.chunks_mut(TILE)) {
        let mut part = 0u32;
        for (x, &pixel) in pixels.iter().enumerate() {
            tile[across(x)] = sum;
            sum = sum.wrapping_add(pack(pixel));
            let square = |v: u8| u32::from(v) * u32::from(v);
            part += square(pixel[0]) + square(pixel[1]) + square(pixel[2]);
        }
        squares += u64::from(part);
    }
    line[across(row.len())] = sum;
    squares
}

/// As [`sum_opaque`], with alpha: colours are multiplied by it, rounded to the nearest, so that they
/// are what is left of a pixel on black.
fn sum_premultiplied(row: &[Rgba], line: &mut [u64], alphas: &mut [u32]) -> u64 {
    let (mut sum, mut alpha_sum, mut squares) = (0u64, 0u32, 0u64);
    for (x, &[r, g, b, a]) in row.iter().enumerate() {
        (line[across(x)], alphas[across(x)]) = (sum, alpha_sum);
        let by_alpha = |v: u8| ((u32::from(v) * u32::from(a) + 127) / 255) as u8;
        let pixel = [by_alpha(r), by_alpha(g), by_alpha(b), a];
        squares += pixel.iter().map(|&v| u64::from(v) * u64::from(v)).sum::<u64>();
        sum = sum.wrapping_add(pack(pixel));
        alpha_sum += u32::from(a);
    }
    (line[across(row.len())], alphas[across(row.len())]) = (sum, alpha_sum);
    squares
}

#[cfg(test)]
mod tests {
    use super::*;
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
            rows.load(&frame);
            let [a, mut b, mut c] = corners.map(|(x, y)| Point::new(x / snap * snap, y / snap * snap));
            prop_assume!(orient(a, b, c) != 0);
            if orient(a, b, c) < 0 {
                (b, c) = (c, b);
            }
            let sums = rows.edge(a, b) + rows.edge(b, c) + rows.edge(c, a);
            let (slow, squares) = slowly(&frame, [a, b, c]);
            prop_assert_eq!(rows.total(&sums, a, b, c), slow);
            prop_assert_eq!(rows.wide([a, b, c]), slow);
            prop_assert_eq!(rows.squares_of(&frame, [a, b, c]), squares);
        }
    }

    /// Rows longer than the packed sums can tell apart, as one triangle and as many.
    #[test]
    fn the_longest_rows_are_summed_exactly() {
        let size = Size::new(16384, 3);
        let frame = Frame::filled(size, [255, 254, 253, 255]).expect("a frame");
        let mut rows = RowSums::default();
        rows.load(&frame);
        let far = size.far();
        let [a, b, c] = [Point::new(0, 0), far, Point::new(0, far.y)];
        let sums = rows.edge(a, b) + rows.edge(b, c) + rows.edge(c, a);
        let (slow, squares) = slowly(&frame, [a, b, c]);
        assert_eq!(rows.total(&sums, a, b, c), slow);
        assert!((squares - slow.explained()).abs() < 1.0, "a flat frame has no error");
    }
}
