//! One pixel in four of a frame, by which errors are estimated.

use std::ops::Range;

use rayon::prelude::*;

use super::mean::Mean;
use crate::frame::Rgba;
use crate::geom::{Point, SUBPIXEL, Size};
use crate::scan;
use crate::scan::lanes::LaneDeviations;
use crate::vector::widest;

/// Every second pixel of every second row, from the first on. They fit a core's cache where the frame does
/// not.
#[derive(Debug)]
pub(super) struct Thin {
    size: Size,
    pixels: Vec<Rgba>,
}

impl Default for Thin {
    fn default() -> Self {
        Self { size: Size::new(0, 0), pixels: Vec::new() }
    }
}

/// Of fewer pixels nothing is told.
const LEAST: u64 = 4;

/// As many pixels at most are summed in lanes before they are taken: with those of a row's, half of
/// [`crate::geom::MAX_SIDE`], they have room there.
const WAITING: usize = 512;

impl Thin {
    /// No pixels.
    pub(super) fn clear(&mut self) {
        self.size = Size::new(0, 0);
    }

    /// Room for those `rows` of a frame of `size`, each `together` of them, an even number, that lie
    /// together.
    pub(super) fn rows_mut(
        &mut self,
        size: Size,
        rows: Range<usize>,
        together: usize,
    ) -> impl IndexedParallelIterator<Item = &mut [Rgba]> {
        self.size = Size::new(size.width.div_ceil(2), size.height.div_ceil(2));
        self.pixels.resize(self.size.pixels(), [0; 4]);
        let width = self.size.width as usize;
        let ours = rows.start / 2 * width..rows.end.div_ceil(2) * width;
        self.pixels[ours].par_chunks_mut(together / 2 * width)
    }

    /// About the squared error of `triangle`, whose pixels have that `mean`, in squared 8-bit steps; `None`
    /// where too few of them are here.
    pub(super) fn error(&self, triangle: [Point; 3], mean: &Mean) -> Option<f64> {
        let [r, g, b, _] = mean.colour;
        let (seen, sum) = widest(
            #[inline(always)]
            || self.deviations(triangle, [r, g, b]),
        );
        // Sums are in 1/16.
        (seen >= LEAST).then(|| sum as f64 / 16.0 * f64::from(mean.count) / seen as f64)
    }

    /// The pixels of `triangle` that are here, and their squared distances from `colour`, in 1/16.
    #[inline(always)]
    fn deviations(&self, triangle: [Point; 3], colour: [f32; 3]) -> (u64, u64) {
        // The centre of pixel 2 i comes to lie on that of pixel i.
        let half = |v: i32| (v + SUBPIXEL / 2) / 2;
        let triangle = triangle.map(|p| Point::new(half(p.x), half(p.y)));
        let width = self.size.width as usize;
        let mut lanes = LaneDeviations::new(colour);
        let (mut seen, mut sum, mut waiting) = (0, 0, 0);
        scan::spans(
            triangle,
            0..self.size.height,
            #[inline(always)]
            |y, columns| {
                lanes.add(&self.pixels[y as usize * width + columns.start..], columns.len());
                waiting += columns.len();
                if waiting >= WAITING {
                    sum += lanes.take();
                    seen += waiting as u64;
                    waiting = 0;
                }
            },
        );
        (seen + waiting as u64, sum + lanes.take())
    }
}

/// Copies every second pixel of every second row, `width` long, to `out`.
pub(super) fn take(rows: &[Rgba], width: usize, out: &mut [Rgba]) {
    let rows = rows.chunks(width).step_by(2).zip(out.chunks_mut(width.div_ceil(2)));
    for (row, out) in rows {
        let (pairs, last) = row.as_chunks::<2>();
        let firsts = pairs.iter().map(|&[first, _]| first).chain(last.first().copied());
        out.iter_mut().zip(firsts).for_each(|(out, pixel)| *out = pixel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::refine::rows::RowSums;
    use crate::refine::tests::{picture, scattered};

    /// The errors of a mesh's triangles, exactly and about, of those that have enough pixels.
    fn errors(frame: &Frame, seeds: u32) -> Vec<(f64, f64)> {
        let mesh = scattered(frame.size(), seeds);
        let mut rows = RowSums::default();
        rows.load(frame);
        let errors = (0..mesh.triangles.len()).filter_map(|t| {
            let triangle = mesh.triangle(t);
            let total = rows.wide(triangle);
            let exact = rows.squares_of(frame, triangle) - total.explained();
            Some((exact, rows.error_about(triangle, &Mean::of(&total))?))
        });
        errors.collect()
    }

    #[test]
    fn errors_are_right_on_the_whole_and_nearly_so_one_by_one() {
        for (width, height) in [(160, 120), (161, 121)] {
            for seed in 0..20 {
                let errors = errors(&picture(Size::new(width, height), seed, 60, true), 100);
                assert!(errors.len() > 150, "{} have enough pixels", errors.len());
                let [exact, about] =
                    [0, 1].map(|i| errors.iter().map(|&(e, a)| [e, a][i]).sum::<f64>());
                assert!((about / exact - 1.0).abs() < 0.1, "{about} for {exact}");
                let near = errors.iter().filter(|(e, a)| (e - a).abs() <= 0.5 * e.max(*a)).count();
                assert!(near * 10 >= errors.len() * 8, "{near} of {}", errors.len());
            }
        }
    }

    #[test]
    fn a_triangle_of_one_colour_has_none_and_a_large_one_no_overflow() {
        let grey = Frame::filled(Size::new(900, 700), [255, 0, 130, 255]).expect("a small frame");
        for (exact, about) in errors(&grey, 1).into_iter().chain(errors(&grey, 500)) {
            assert!(exact.abs() < 1e-3 && about == 0.0, "{exact} {about}");
        }
        let black_below =
            |i: usize| if i < 450 * 700 { [255, 255, 255, 255] } else { [0, 0, 0, 255] };
        let pixels = (0..900 * 700).map(black_below).collect();
        let halves = Frame::new(Size::new(900, 700), pixels).expect("a small frame");
        for (exact, about) in errors(&halves, 0) {
            assert!((about / exact - 1.0).abs() < 0.01, "{about} for {exact}");
        }
    }

    #[test]
    fn slivers_and_frames_that_are_not_opaque_have_no_estimate() {
        // In an odd row, of which nothing is kept.
        let sliver =
            [(0, 1), (40, 1), (40, 2)].map(|(x, y)| Point::new(x * SUBPIXEL, y * SUBPIXEL));
        for (opaque, triangle) in [
            (true, sliver),
            (false, [Point::new(0, 0), Point::new(40 * SUBPIXEL, 0), Point::new(0, 40 * SUBPIXEL)]),
        ] {
            let mut rows = RowSums::default();
            rows.load(&picture(Size::new(50, 50), 1, 9, true));
            rows.load(&picture(Size::new(50, 50), 1, 9, opaque));
            let mean = Mean::of(&rows.wide(triangle));
            assert_eq!(rows.error_about(triangle, &mean), None);
        }
    }
}
