//! Computes the prefix sums of a frame.

use std::ops::Range;

use crate::parallel::prelude::*;

use super::{EXTENT, LARGE, LINE, RowSums, TOGETHER};
use crate::frame::Rgba;
use crate::geom::{MAX_SIDE, SUBPIXEL};
use crate::refine::sums::pack;
use crate::refine::target::Target;
use crate::scan::lanes::{LaneSquares, square};
use crate::simd::dispatch;

impl RowSums {
    /// Computes the sums of `target`, in the same memory; with `subsample`, if it is opaque, also the squares for
    /// [subsampled](super::subsampled) sums.
    pub(in crate::refine) fn load(&mut self, target: &Target, subsample: bool) {
        self.load_rows(target, 0..target.size().height, subsample);
    }

    /// The same for `rows` only, and perhaps some next to them; sums of others must not be read.
    pub(in crate::refine) fn load_rows(
        &mut self,
        target: &Target,
        rows: Range<u32>,
        subsample: bool,
    ) {
        let (picture, size) = (target.picture(), target.size());
        self.size = size;
        self.large = LARGE;
        self.needs_wide_sums = (size.width + size.height) as i32 * SUBPIXEL >= EXTENT;
        let height = size.height as usize;
        let group = ((size.width as usize + 1) * TOGETHER).next_multiple_of(LINE);
        let entries = group * height.div_ceil(TOGETHER);
        self.colour.resize(entries + LINE, 0);
        // The start of the first cache line.
        let aligned = self.colour.as_ptr().align_offset(64).min(LINE);
        let start = |y: usize| (aligned + y / TOGETHER * group + y % TOGETHER) as u32;
        self.starts.clear();
        self.starts.extend((0..height).map(start));
        let colour = &mut self.colour[aligned..aligned + entries];
        self.alpha.clear();
        self.has_subsampled = subsample && target.is_opaque();
        if target.is_opaque() {
            let groups = rows.start as usize / TOGETHER..(rows.end as usize).div_ceil(TOGETHER);
            let rows = groups.start * TOGETHER..height.min(groups.end * TOGETHER);
            let colour = &mut colour[groups.start * group..groups.end * group];
            let colour = colour.par_chunks_mut(group);
            let width = size.width as usize;
            let sum = |pixels: &[Rgba], colour: &mut [u64], subsampled: Option<&mut [u32]>| {
                let counted = pixels.len() / width;
                // Below the frame the last row is repeated; these sums are not read.
                let row = |i: usize| &pixels[i.min(counted - 1) * width..][..width];
                sum_opaque([row(0), row(1), row(2), row(3)], counted, colour, subsampled)
            };
            self.squares = if self.has_subsampled {
                self.squares_before.resize(entries / 2, 0);
                let (first, last) = (groups.start * group / 2, groups.end * group / 2);
                let subsampled = self.squares_before[first..last].par_chunks_mut(group / 2);
                picture.pass_over(
                    rows,
                    TOGETHER,
                    colour.zip(subsampled),
                    |pixels, (colour, subsampled)| sum(pixels, colour, Some(subsampled)),
                )
            } else {
                picture
                    .pass_over(rows, TOGETHER, colour, |pixels, colour| sum(pixels, colour, None))
            };
        } else {
            self.alpha.resize(entries + LINE, 0);
            let alpha = self.alpha[aligned..aligned + entries].par_chunks_mut(group);
            let squares = colour.par_chunks_mut(group).zip(alpha).enumerate().map(
                |(four, (colour, alpha))| {
                    let rows = (TOGETHER * four..height).take(TOGETHER).enumerate();
                    let row = |(i, y)| {
                        sum_premultiplied(picture.row(y as u32), &mut colour[i..], &mut alpha[i..])
                    };
                    rows.map(row).sum::<u64>()
                },
            );
            self.squares = squares.sum();
        }
    }
}

/// Writes the prefix sums of four opaque, interleaved rows, and those of the squares of the first and third on
/// request. Returns the squares of the pixels of the first `counted` rows.
fn sum_opaque(
    rows: [&[Rgba]; TOGETHER],
    counted: usize,
    out: &mut [u64],
    subsampled: Option<&mut [u32]>,
) -> u64 {
    let [a, b, c, d] = rows;
    let (out, _) = out.as_chunks_mut::<TOGETHER>();
    dispatch(
        #[inline(always)]
        || {
            let mut sums = [0u64; TOGETHER];
            let pixels = a.iter().zip(b).zip(c.iter().zip(d));
            for (((a, b), (c, d)), out) in pixels.zip(&mut *out) {
                *out = sums;
                let column = [*a, *b, *c, *d];
                for (sum, pixel) in sums.iter_mut().zip(column) {
                    *sum = sum.wrapping_add(pack(pixel));
                }
            }
            out[a.len()] = sums;
            // The squares of every second row are in the subsampled sums.
            let step = if subsampled.is_some() { 2 } else { 1 };
            // No map_or: see `dispatch`.
            let subsampled = match subsampled {
                Some(subsampled) => sum_squares(a, c, subsampled.as_chunks_mut::<2>().0),
                None => [0; 2],
            };
            let mut others = LaneSquares::default();
            for row in rows[..counted].iter().skip(step - 1).step_by(step) {
                others.add(row, row.len());
            }
            let subsampled = subsampled.iter().take(counted.div_ceil(2)).map(|&sum| u64::from(sum));
            subsampled.sum::<u64>() + others.total()
        },
    )
}

/// Writes the prefix sums of the squares of the pixels of two interleaved rows, and returns the last.
#[inline(always)]
fn sum_squares(a: &[Rgba], b: &[Rgba], out: &mut [[u32; 2]]) -> [u32; 2] {
    // First the squares, by vector instructions, then their sums.
    const PIECE: usize = 64;
    const { assert!(MAX_SIDE as u64 * 3 * 255 * 255 <= u32::MAX as u64) };
    let mut sums = [0; 2];
    let mut squares = [[0; 2]; PIECE];
    for ((a, b), out) in a.chunks(PIECE).zip(b.chunks(PIECE)).zip(out.chunks_mut(PIECE)) {
        for (squares, (&a, &b)) in squares.iter_mut().zip(a.iter().zip(b)) {
            *squares = [a, b].map(|pixel| square(u32::from_le_bytes(pixel)));
        }
        for (out, squares) in out[..a.len()].iter_mut().zip(&squares) {
            *out = sums;
            sums = [sums[0] + squares[0], sums[1] + squares[1]];
        }
    }
    out[a.len()] = sums;
    sums
}

/// The same for one row with alpha: colours are multiplied by alpha, rounded to the nearest. Entries are [`TOGETHER`]
/// apart.
fn sum_premultiplied(row: &[Rgba], out: &mut [u64], alphas: &mut [u32]) -> u64 {
    let (mut sum, mut alpha_sum, mut squares) = (0u64, 0u32, 0u64);
    for (x, &[r, g, b, a]) in row.iter().enumerate() {
        (out[TOGETHER * x], alphas[TOGETHER * x]) = (sum, alpha_sum);
        let by_alpha = |v: u8| ((u32::from(v) * u32::from(a) + 127) / 255) as u8;
        let pixel = [by_alpha(r), by_alpha(g), by_alpha(b), a];
        squares += pixel.iter().map(|&v| u64::from(v) * u64::from(v)).sum::<u64>();
        sum = sum.wrapping_add(pack(pixel));
        alpha_sum += u32::from(a);
    }
    (out[TOGETHER * row.len()], alphas[TOGETHER * row.len()]) = (sum, alpha_sum);
    squares
}
