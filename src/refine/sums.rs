//! Sums over the pixels of a triangle in time proportional to its height: running sums along each row
//! turn an area into differences along its three edges (Green's theorem on the pixel grid).
//!
//! An edge is summed once for both of its triangles, and all sums are whole numbers, so the squared
//! error of a trial move is exact, not estimated: this is what lets a step earn its move.

use std::ops::{Add, Neg, Sub};

use rayon::prelude::*;

use crate::frame::Frame;
use crate::geom::{Point, SUBPIXEL};
use crate::scan::first_centre;

/// Number of pixels and sums of their values: premultiplied red, green, blue, the sum of all squares
/// and, in frames that are not opaque, alpha. Signed and wrapping: an edge's share is only a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sums {
    pub(super) count: i64,
    /// Red, green, blue, squares.
    pub(super) values: [u64; 4],
    pub(super) alpha: u64,
}

impl Sums {
    /// The squared error of painting these pixels in their mean: the sum over pixels and channels of
    /// (value - mean)^2, in squared 8-bit steps.
    pub(super) fn error(&self) -> f64 {
        if self.count <= 0 {
            return 0.0;
        }
        let [r, g, b, squares] = self.values.map(|v| v as f64);
        let a = self.alpha as f64;
        let products = r * r + g * g + b * b + a * a;
        // Whole numbers below 2^53 wherever triangles are smaller than a megapixel.
        (squares - products / self.count as f64).max(0.0)
    }

    /// The mean of the premultiplied channels; `None` where no pixel's centre is covered.
    pub(super) fn mean(&self) -> Option<[f32; 4]> {
        let scale = 1.0 / self.count as f64;
        let [r, g, b, _] = self.values;
        (self.count > 0).then(|| [r, g, b, self.alpha].map(|v| (v as f64 * scale) as f32))
    }
}

impl Add for Sums {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let values = std::array::from_fn(|i| self.values[i].wrapping_add(o.values[i]));
        Self { count: self.count + o.count, values, alpha: self.alpha.wrapping_add(o.alpha) }
    }
}

impl Neg for Sums {
    type Output = Self;
    fn neg(self) -> Self {
        let values = self.values.map(u64::wrapping_neg);
        Self { count: -self.count, values, alpha: self.alpha.wrapping_neg() }
    }
}

impl Sub for Sums {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

/// A pixel as the error sees it: premultiplied red, green, blue, then alpha, or 0 in opaque frames,
/// where it cannot differ.
pub(super) fn premultiplied([r, g, b, a]: [u8; 4]) -> [u8; 4] {
    if a == 255 {
        return [r, g, b, a];
    }
    let by_alpha = |v: u8| ((u32::from(v) * u32::from(a) + 127) / 255) as u8;
    [by_alpha(r), by_alpha(g), by_alpha(b), a]
}

/// Running sums along every row of a frame.
#[derive(Debug, Default)]
pub(super) struct RowSums {
    /// Entries in a row: one more than it has pixels, padded.
    stride: usize,
    /// Red, green, blue and squares of the pixels left of each column. A row of 16384 pixels with
    /// four channels of 255 sums its squares to 4 261 478 400: below 2^32.
    values: Vec<[u32; 4]>,
    /// Alpha likewise; empty when the frame is opaque.
    alpha: Vec<u32>,
}

/// Rows that are summed as one piece of work.
const ROWS: usize = 16;

impl RowSums {
    /// Takes the sums of `frame`, in the memory of the last one's.
    pub(super) fn load(&mut self, frame: &Frame) {
        let size = frame.size();
        // An odd number of cache lines, so that the rows of a narrow triangle do not all compete for
        // one set of the cache.
        self.stride = ((size.width as usize + 1).div_ceil(4) | 1) * 4;
        let entries = self.stride * size.height as usize;
        self.values.resize(entries, [0; 4]);
        self.alpha.clear();
        if frame.is_opaque() {
            let chunks = self.values.par_chunks_mut(self.stride * ROWS).enumerate();
            chunks.for_each(|(chunk, entries)| {
                for (i, entries) in entries.chunks_exact_mut(self.stride).enumerate() {
                    sum_opaque(frame.row((chunk * ROWS + i) as u32), entries);
                }
            });
        } else {
            self.alpha.resize(entries, 0);
            let values = self.values.par_chunks_mut(self.stride);
            let alpha = self.alpha.par_chunks_mut(self.stride);
            values.zip(alpha).enumerate().for_each(|(y, (values, alpha))| {
                sum_premultiplied(frame.row(y as u32), values, alpha);
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
        let (start, end) = (first_centre(upper.y), first_centre(lower.y));
        if start >= end {
            return sums;
        }
        let mut crossing = Crossing::new(upper, lower, start);
        let rows = start as usize * self.stride..end as usize * self.stride;
        for row in self.values[rows.clone()].chunks_exact(self.stride) {
            let column = crossing.next();
            sums.count += column as i64;
            let entry = row[column];
            for (sum, value) in sums.values.iter_mut().zip(entry) {
                *sum += u64::from(value);
            }
        }
        if !self.alpha.is_empty() {
            let mut crossing = Crossing::new(upper, lower, start);
            for row in self.alpha[rows].chunks_exact(self.stride) {
                sums.alpha += u64::from(row[crossing.next()]);
            }
        }
        sums
    }
}

fn sum_opaque(row: &[[u8; 4]], entries: &mut [[u32; 4]]) {
    let mut sum = [0u32; 4];
    entries[0] = sum;
    for (&[r, g, b, _], entry) in row.iter().zip(&mut entries[1..]) {
        let [r, g, b] = [r, g, b].map(u32::from);
        let values = [r, g, b, r * r + g * g + b * b];
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += value;
        }
        *entry = sum;
    }
}

fn sum_premultiplied(row: &[[u8; 4]], entries: &mut [[u32; 4]], alphas: &mut [u32]) {
    let (mut sum, mut alpha_sum) = ([0u32; 4], 0u32);
    entries[0] = sum;
    alphas[0] = 0;
    for ((&pixel, entry), alpha) in row.iter().zip(&mut entries[1..]).zip(&mut alphas[1..]) {
        let [r, g, b, a] = premultiplied(pixel).map(u32::from);
        let values = [r, g, b, r * r + g * g + b * b + a * a];
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += value;
        }
        alpha_sum += a;
        *entry = sum;
        *alpha = alpha_sum;
    }
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
