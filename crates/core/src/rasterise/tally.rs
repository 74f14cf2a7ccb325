//! Sums over the pixels of a triangle.

use crate::frame::{Fill, Frame, Rgba};
use crate::geom::Point;
use crate::scan;
use crate::scan::lanes::{LANES, LaneSums, MOST_ADDED};

/// `sum / count`, rounded to the nearest, halves up.
fn rounded(sum: u64, count: u64) -> u8 {
    ((sum + count / 2) / count) as u8
}

/// Sums over the pixels of a triangle, in some rows of the frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// Pixels in all rows.
    pub(super) area: u32,
    /// Pixels in the rows that count.
    pub(super) seen: u64,
    /// Red, green and blue, each multiplied by the pixel's alpha, or by 1 if all pixels are opaque.
    colour: [u64; 3],
    weight: u64,
    pub(super) alpha: u64,
    /// The squares of alpha, where not all pixels are opaque.
    alpha_squares: u64,
}

/// A triangle on the outline of a cut-out figure holds some pixels of the other side. If they are fewer than one in
/// this number, they are ignored: otherwise such triangles form a haze of rays around the figure, or of holes in it.
/// Their squared error grows by a third at most.
const STRAY: u64 = 4;

/// Whether the `sum` of alpha over `seen` pixels (or of 255 - alpha) comes from few pixels with high values.
fn is_stray(sum: u64, squares: u64, seen: u64) -> bool {
    sum * STRAY < 255 * seen && 2 * squares > 255 * sum
}

impl Tally {
    /// The pixels of `triangle` in the rows of `frame` that are `looked_at`.
    #[inline(always)]
    pub(super) fn of(frame: &Frame, triangle: [Point; 3], looked_at: impl Fn(u32) -> bool) -> Self {
        if frame.is_opaque() {
            Self::of_opaque(frame, triangle, looked_at)
        } else {
            Self::of_weighted(frame, triangle, looked_at)
        }
    }

    #[inline(always)]
    fn of_opaque(frame: &Frame, triangle: [Point; 3], looked_at: impl Fn(u32) -> bool) -> Self {
        let mut tally = Self::default();
        let mut lanes = LaneSums::default();
        scan::spans(
            triangle,
            0..frame.size().height,
            #[inline(always)]
            |y, columns| {
                tally.area += columns.len() as u32;
                if looked_at(y) {
                    tally.seen += columns.len() as u64;
                    tally.add_opaque(&mut lanes, &frame.row(y)[columns.start..], columns.len());
                }
            },
        );
        tally.take(&mut lanes);
        tally.alpha = 255 * tally.seen;
        tally.weight = tally.seen;
        tally
    }

    fn of_weighted(frame: &Frame, triangle: [Point; 3], looked_at: impl Fn(u32) -> bool) -> Self {
        let mut tally = Self::default();
        scan::spans(triangle, 0..frame.size().height, |y, columns| {
            tally.area += columns.len() as u32;
            if looked_at(y) {
                tally.seen += columns.len() as u64;
                tally.add_weighted(&frame.row(y)[columns]);
            }
        });
        tally.weight = tally.alpha;
        tally
    }

    /// Adds the first `count` pixels of `row`.
    #[inline(always)]
    fn add_opaque(&mut self, lanes: &mut LaneSums, row: &[Rgba], count: usize) {
        if !lanes.is_full_with(count) {
            lanes.add(row, count);
            return;
        }
        let most = LANES * MOST_ADDED as usize;
        for first in (0..count).step_by(most) {
            self.take(lanes);
            lanes.add(&row[first..], most.min(count - first));
        }
    }

    #[inline(always)]
    fn take(&mut self, lanes: &mut LaneSums) {
        for (sum, part) in self.colour.iter_mut().zip(lanes.take()) {
            *sum += part;
        }
    }

    #[inline]
    fn add_weighted(&mut self, pixels: &[Rgba]) {
        for &[r, g, b, a] in pixels {
            let weight = u64::from(a);
            for (sum, channel) in self.colour.iter_mut().zip([r, g, b]) {
                *sum += weight * u64::from(channel);
            }
            self.alpha += weight;
            self.alpha_squares += weight * weight;
        }
    }

    /// The mean of the pixels that count, of which there must be at least one.
    pub(super) fn fill(&self) -> Fill {
        let alpha = self.mean_alpha();
        if alpha == 0 {
            return Fill { colour: [0; 4], area: self.area };
        }
        let [r, g, b] = self.colour.map(|sum| rounded(sum, self.weight));
        Fill { colour: [r, g, b, alpha], area: self.area }
    }

    /// The mean alpha, without [strays](STRAY).
    fn mean_alpha(&self) -> u8 {
        let all = 255 * self.seen;
        if self.alpha == all {
            return 255;
        }
        // (255 - alpha)^2 of every pixel.
        let lacking_squares = 255 * all + self.alpha_squares - 510 * self.alpha;
        if is_stray(self.alpha, self.alpha_squares, self.seen) {
            0
        } else if is_stray(all - self.alpha, lacking_squares, self.seen) {
            255
        } else {
            rounded(self.alpha, self.seen)
        }
    }
}
