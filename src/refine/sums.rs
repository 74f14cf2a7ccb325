//! Sums over the pixels of a triangle in time proportional to its height: running sums along each row
//! turn an area into differences along its three edges (Green's theorem on the pixel grid).
//!
//! An edge is summed once for both of its triangles, and all sums are whole numbers, so the squared
//! error of a trial move is exact, not estimated: this is what lets a step earn its move.

use std::ops::{Add, Neg, Sub};

use rayon::prelude::*;

use crate::frame::{Frame, Rgba};
use crate::geom::{Point, SUBPIXEL, orient};
use crate::scan::first_centre;

/// Number of pixels and sums of their values, in wrapping 32-bit numbers: those of an edge are a part
/// of something, but what the edges of a triangle add up to is right while it has fewer than
/// [`NARROW`] pixels. Wider ones are summed by [`RowSums::wide`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sums {
    /// Pixels.
    pub(super) count: u32,
    /// Alpha, in frames that are not opaque.
    pub(super) alpha: u32,
    /// Premultiplied red, green, blue, and the squares of all channels.
    pub(super) values: [u32; 4],
}

/// Pixels whose sums are below 2^32 for certain: four squares of 255 make 260 100.
const NARROW: u32 = 16384;

/// Sums over the pixels of one triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Total {
    count: f64,
    /// Red, green, blue, alpha.
    channels: [f64; 4],
    squares: f64,
}

impl Total {
    /// The squared error of painting these pixels in their mean: the sum over pixels and channels of
    /// (value - mean)^2, in squared 8-bit steps.
    pub(super) fn error(&self) -> f64 {
        if self.count <= 0.0 {
            return 0.0;
        }
        let products: f64 = self.channels.iter().map(|v| v * v).sum();
        // Whole numbers below 2^53 wherever triangles are smaller than a megapixel.
        (self.squares - products / self.count).max(0.0)
    }

    /// The mean of the channels; `None` where no pixel's centre is covered.
    pub(super) fn mean(&self) -> Option<[f32; 4]> {
        (self.count > 0.0).then(|| self.channels.map(|v| (v / self.count) as f32))
    }
}

impl Sums {
    fn map2(self, o: Self, f: impl Fn(u32, u32) -> u32) -> Self {
        Self {
            count: f(self.count, o.count),
            alpha: f(self.alpha, o.alpha),
            values: std::array::from_fn(|i| f(self.values[i], o.values[i])),
        }
    }
}

impl Add for Sums {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.map2(o, u32::wrapping_add)
    }
}

impl Sub for Sums {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.map2(o, u32::wrapping_sub)
    }
}

impl Neg for Sums {
    type Output = Self;
    fn neg(self) -> Self {
        Self::default() - self
    }
}

/// Running sums along every row of a frame.
///
/// They lie in tiles of [`WIDE`] x [`HIGH`] entries, bands of tiles from top to bottom: what surrounds
/// a vertex is then in a few pages of memory, where whole rows would put each line of it into a page
/// of its own.
#[derive(Debug, Default)]
pub(super) struct RowSums {
    /// Entries in a band of tiles. A row has one more entry than pixels.
    band: usize,
    /// Whether triangles may be longer than [`EXTENT`].
    vast: bool,
    /// Red, green, blue and squares of the pixels left of each column. A row of 16384 pixels with
    /// four channels of 255 sums its squares to 4 261 478 400: below 2^32.
    values: Vec<[u32; 4]>,
    /// Alpha likewise; empty when the frame is opaque.
    alpha: Vec<u32>,
}

/// Columns of a tile.
const WIDE: usize = 16;
/// Rows of a tile.
const HIGH: usize = 64;
const TILE: usize = WIDE * HIGH;

impl RowSums {
    /// Takes the sums of `frame`, in the memory of the last one's.
    pub(super) fn load(&mut self, frame: &Frame) {
        let size = frame.size();
        self.band = (size.width as usize + 1).div_ceil(WIDE) * TILE;
        self.vast = (size.width + size.height) as i32 * SUBPIXEL >= EXTENT;
        let entries = self.band * (size.height as usize).div_ceil(HIGH);
        self.values.resize(entries, [0; 4]);
        self.alpha.clear();
        if frame.is_opaque() {
            let bands = self.values.par_chunks_mut(self.band).enumerate();
            bands.for_each(|(band, values)| {
                for (line, y) in (band * HIGH..size.height as usize).take(HIGH).enumerate() {
                    sum_opaque(frame.row(y as u32), &mut values[line * WIDE..]);
                }
            });
        } else {
            self.alpha.resize(entries, 0);
            let values = self.values.par_chunks_mut(self.band);
            let bands = values.zip(self.alpha.par_chunks_mut(self.band)).enumerate();
            bands.for_each(|(band, (values, alpha))| {
                for (line, y) in (band * HIGH..size.height as usize).take(HIGH).enumerate() {
                    let line = line * WIDE;
                    sum_premultiplied(frame.row(y as u32), &mut values[line..], &mut alpha[line..]);
                }
            });
        }
    }

    /// The signed share of the edge from `from` to `to`: those of a triangle's three edges, in the
    /// order that has a positive `orient`, add up to the sums over the pixels that it covers.
    pub(super) fn edge(&self, from: Point, to: Point) -> Sums {
        if from.y <= to.y { self.falling(from, to) } else { -self.falling(to, from) }
    }

    fn falling(&self, upper: Point, lower: Point) -> Sums {
        let mut sums = Sums::default();
        self.crossings(upper, lower, |column, index| {
            sums.count = sums.count.wrapping_add(column as u32);
            let entry = self.values[index];
            for (sum, value) in sums.values.iter_mut().zip(entry) {
                *sum = sum.wrapping_add(value);
            }
        });
        if !self.alpha.is_empty() {
            self.crossings(upper, lower, |_, index| {
                sums.alpha = sums.alpha.wrapping_add(self.alpha[index]);
            });
        }
        sums
    }

    /// Calls `visit` with the first column right of the edge and its entry's index, row by row.
    fn crossings(&self, upper: Point, lower: Point, mut visit: impl FnMut(usize, usize)) {
        let (start, end) = (first_centre(upper.y), first_centre(lower.y));
        if start >= end {
            return;
        }
        let mut crossing = Crossing::new(upper, lower, start);
        let (mut y, end) = (start as usize, end as usize);
        while y < end {
            let band = y / HIGH * self.band;
            let stop = end.min((y / HIGH + 1) * HIGH);
            for line in y % HIGH..y % HIGH + (stop - y) {
                let column = crossing.next();
                visit(column, band + line * WIDE + spread(column));
            }
            y = stop;
        }
    }

    /// The sums of the triangle `abc`, with a positive `orient`, whose edges sum to `sums`.
    pub(super) fn total(&self, sums: &Sums, a: Point, b: Point, c: Point) -> Total {
        // A convex shape covers at most its area, half its perimeter and one more centre; the half
        // perimeter is at most width and height of the box around it.
        const LARGE: i64 = 2 * (SUBPIXEL as i64) * (SUBPIXEL as i64) * (NARROW as i64 / 2);
        if orient(a, b, c) >= LARGE || (self.vast && extent(a, b, c) >= EXTENT) {
            return self.wide(a, b, c);
        }
        // Through i32 and i64, which convert faster.
        let [r, g, b, squares] = sums.values.map(|v| i64::from(v) as f64);
        let alpha = i64::from(sums.alpha) as f64;
        Total { count: f64::from(sums.count as i32), channels: [r, g, b, alpha], squares }
    }

    /// As [`RowSums::total`], for triangles of any size.
    #[cold]
    fn wide(&self, a: Point, b: Point, c: Point) -> Total {
        let (mut count, mut sums, mut alpha) = (0i64, [0i64; 4], 0i64);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (upper, lower, sign) = if from.y <= to.y { (from, to, 1) } else { (to, from, -1) };
            self.crossings(upper, lower, |column, index| {
                count += sign * column as i64;
                for (sum, value) in sums.iter_mut().zip(self.values[index]) {
                    *sum += sign * i64::from(value);
                }
                alpha += sign * self.alpha.get(index).map_or(0, |&v| i64::from(v));
            });
        }
        let [r, g, b, squares] = sums.map(|v| v as f64);
        Total { count: count as f64, channels: [r, g, b, alpha as f64], squares }
    }

    /// Pixel `(x, y)` of the frame as the error sees it: premultiplied red, green, blue, then alpha,
    /// or 0 in opaque frames, where it cannot differ.
    pub(super) fn pixel(&self, x: usize, y: usize) -> [u32; 4] {
        let line = y / HIGH * self.band + y % HIGH * WIDE;
        let (left, right) = (line + spread(x), line + spread(x + 1));
        let (before, after) = (self.values[left], self.values[right]);
        let alpha = if self.alpha.is_empty() { 0 } else { self.alpha[right] - self.alpha[left] };
        [after[0] - before[0], after[1] - before[1], after[2] - before[2], alpha]
    }
}

/// Width and height of a box, together, within which a triangle of less than half of [`NARROW`] in area
/// covers fewer centres than that.
const EXTENT: i32 = (NARROW as i32 / 2 - 1) * SUBPIXEL;

/// Width and height of the box around a triangle, together, in 1/256 pixel.
fn extent(a: Point, b: Point, c: Point) -> i32 {
    let span = |a: i32, b: i32, c: i32| a.max(b).max(c) - a.min(b).min(c);
    span(a.x, b.x, c.x) + span(a.y, b.y, c.y)
}

/// How far into its line of a band of tiles the entry of a column stands.
const fn spread(column: usize) -> usize {
    column + column / WIDE * (TILE - WIDE)
}

/// Writes running sums of `row` into its line of a band of tiles.
fn sum_opaque(row: &[Rgba], line: &mut [[u32; 4]]) {
    let mut sum = [0u32; 4];
    line[0] = sum;
    // Entry x + 1 stands for pixel x: the first tile takes one pixel less.
    let (first, rest) = row.split_at(row.len().min(WIDE - 1));
    let mut add = |row: &[Rgba], line: &mut [[u32; 4]]| {
        for (&[r, g, b, _], entry) in row.iter().zip(line) {
            let [r, g, b] = [r, g, b].map(u32::from);
            let values = [r, g, b, r * r + g * g + b * b];
            for (sum, value) in sum.iter_mut().zip(values) {
                *sum += value;
            }
            *entry = sum;
        }
    };
    add(first, &mut line[1..WIDE]);
    for (pixels, tile) in rest.chunks(WIDE).zip(line.chunks_mut(TILE).skip(1)) {
        add(pixels, &mut tile[..WIDE]);
    }
}

/// As [`sum_opaque`], with alpha.
fn sum_premultiplied(row: &[Rgba], line: &mut [[u32; 4]], alphas: &mut [u32]) {
    let (mut sum, mut alpha_sum) = ([0u32; 4], 0u32);
    line[0] = sum;
    alphas[0] = 0;
    for (x, &pixel) in (1..).zip(row) {
        let [r, g, b, a] = premultiplied(pixel).map(u32::from);
        let values = [r, g, b, r * r + g * g + b * b + a * a];
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += value;
        }
        alpha_sum += a;
        (line[spread(x)], alphas[spread(x)]) = (sum, alpha_sum);
    }
}

/// Colour channels multiplied by alpha, rounded to the nearest: what is left of a pixel on black.
fn premultiplied([r, g, b, a]: Rgba) -> Rgba {
    let by_alpha = |v: u8| ((u32::from(v) * u32::from(a) + 127) / 255) as u8;
    [by_alpha(r), by_alpha(g), by_alpha(b), a]
}

/// The first column whose centre lies on an edge or right of it, row by row, in 16.48 fixed point.
///
/// The same whole numbers as `scan` finds, with one division an edge: a crossing that is no whole
/// column lies at least 1 / (256 dy) >= 2^-30 pixel from one, while all rounding here stays below
/// 2^-33. So [`NUDGE`] between the two tells "on" from "right of" exactly.
struct Crossing {
    at: i64,
    step: i64,
}

const FRACTION: u32 = 48;

/// 2^-32 pixel.
const NUDGE: f64 = 1.0 / 4_294_967_296.0;

impl Crossing {
    fn new(upper: Point, lower: Point, row: i32) -> Self {
        let slope = f64::from(lower.x - upper.x) / f64::from(lower.y - upper.y);
        let down = f64::from(row * SUBPIXEL + SUBPIXEL / 2 - upper.y);
        let x = (f64::from(upper.x) + down * slope) / f64::from(SUBPIXEL);
        let scale = (1i64 << FRACTION) as f64;
        // Steeper slopes than 2^15 saturate, but cross one row only.
        Self { at: ((x + 0.5 - NUDGE) * scale) as i64, step: (slope * scale) as i64 }
    }

    fn next(&mut self) -> usize {
        let column = (self.at >> FRACTION) as usize;
        self.at = self.at.wrapping_add(self.step);
        column
    }
}
