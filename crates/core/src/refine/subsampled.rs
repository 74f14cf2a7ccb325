//! Estimates the errors of triangles from every second row of a frame.
//!
//! Along these rows the squares of the channels are summed as well as the channels, so that the sums over a triangle's
//! edges give its error without its pixels being read. The squares are stored where [`Sums`] have alpha, and fit there
//! up to [`NARROW`] pixels.

use super::sums::{NARROW, Sums, unpack};

/// Fewer pixels give no estimate. Measured on three clips: with 4 and 8 squared error is the same to half a per cent
/// on two and 2 to 4 % more on the third, and a step takes longer, as the errors of small triangles are then summed
/// pixel by pixel. Measured by `cargo xtask measure min-pixels`.
const MIN_PIXELS: f64 = 2.0;

/// An estimate of the squared error of a triangle of this many `pixels`, from the `subsampled` sums of some of them, in
/// squared 8-bit steps; infinite if there are too few.
#[inline]
pub(super) fn error(subsampled: Sums, pixels: f32) -> f32 {
    let count = f64::from(subsampled.weight as u32);
    if count < MIN_PIXELS || pixels >= NARROW as f32 {
        return f32::INFINITY;
    }
    let [r, g, b] = unpack(subsampled.colour).map(|sum| sum as f64);
    let squares = (subsampled.weight >> 32) as f64;
    let error = (squares - (r * r + g * g + b * b) / count).max(0.0);
    // Bessel's correction: a sample varies less around its own mean than around that of all pixels.
    (error / (count - 1.0)) as f32 * (pixels - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::geom::{Point, SUBPIXEL, Size};
    use crate::refine::rows::RowSums;
    use crate::refine::target::Target;
    use crate::refine::tests::{picture, scattered};
    use crate::scan;

    /// The errors of a mesh's triangles, exactly and about, of those that have enough pixels.
    fn errors(frame: &Frame, seeds: u32) -> Vec<(f64, f64)> {
        let mesh = scattered(frame.size(), seeds);
        let mut rows = RowSums::default();
        rows.load(&Target::Frame(frame), true);
        let errors = (0..mesh.triangles.len()).filter_map(|t| {
            let triangle = mesh.triangle(t);
            let total = rows.wide(triangle);
            let exact = rows.squares_of(&Target::Frame(frame), triangle) - total.explained();
            let estimate = error(rows.subsampled(triangle), total.count() as f32);
            estimate.is_finite().then_some((exact, estimate.into()))
        });
        errors.collect()
    }

    #[test]
    fn thin_sums_are_those_of_every_second_row() {
        let frame = picture(Size::new(161, 121), 3, 60, true);
        let mesh = scattered(frame.size(), 100);
        let mut rows = RowSums::default();
        rows.load(&Target::Frame(&frame), true);
        for t in 0..mesh.triangles.len() {
            let triangle = mesh.triangle(t);
            let (mut count, mut sums, mut squares) = (0, [0i64; 3], 0u64);
            scan::spans(triangle, 0..frame.size().height, |y, columns| {
                for pixel in frame.row(y)[columns].iter().filter(|_| y % 2 == 0) {
                    count += 1;
                    for (sum, &v) in sums.iter_mut().zip(pixel) {
                        *sum += i64::from(v);
                        squares += u64::from(v).pow(2);
                    }
                }
            });
            let subsampled = rows.subsampled(triangle);
            assert_eq!(
                (subsampled.weight as u32, subsampled.weight >> 32),
                (count, squares),
                "{triangle:?}"
            );
            assert_eq!(unpack(subsampled.colour), sums, "{triangle:?}");
        }
    }

    #[test]
    fn errors_are_right_on_the_whole_and_nearly_so_one_by_one() {
        for (width, height) in [(160, 120), (161, 121)] {
            for seed in 0..20 {
                let errors = errors(&picture(Size::new(width, height), seed, 60, true), 100);
                assert!(errors.len() > 150, "{} have enough pixels", errors.len());
                let [exact, estimate] =
                    [0, 1].map(|i| errors.iter().map(|&(e, a)| [e, a][i]).sum::<f64>());
                assert!((estimate / exact - 1.0).abs() < 0.1, "{estimate} for {exact}");
                let near = errors.iter().filter(|(e, a)| (e - a).abs() <= 0.5 * e.max(*a)).count();
                assert!(near * 10 >= errors.len() * 8, "{near} of {}", errors.len());
            }
        }
    }

    #[test]
    fn a_triangle_of_one_colour_has_none_and_a_large_one_is_not_told() {
        let grey = Frame::filled(Size::new(900, 700), [255, 0, 130, 255]).expect("a small frame");
        assert_eq!(errors(&grey, 1), [], "too large");
        for (exact, estimate) in errors(&grey, 500) {
            assert!(exact.abs() < 1e-3 && estimate == 0.0, "{exact} {estimate}");
        }
    }

    #[test]
    fn a_white_triangle_that_is_nearly_too_large_fits() {
        let white = Frame::filled(Size::new(127, 127), [255; 4]).expect("a small frame");
        let mut rows = RowSums::default();
        rows.load(&Target::Frame(&white), true);
        let far = 127 * SUBPIXEL;
        let half = [(0, 0), (far, 0), (0, far)].map(|(x, y)| Point::new(x, y));
        let subsampled = rows.subsampled(half);
        assert!(subsampled.weight as u32 > 4000);
        assert_eq!(subsampled.weight >> 32, u64::from(subsampled.weight as u32) * 3 * 255 * 255);
        assert_eq!(error(subsampled, 8001.0), 0.0);
    }

    #[test]
    fn a_sliver_in_an_odd_row_is_not_told_and_a_frame_that_is_not_opaque_has_no_such_sums() {
        let sliver =
            [(0, 1), (40, 1), (40, 2)].map(|(x, y)| Point::new(x * SUBPIXEL, y * SUBPIXEL));
        let mut rows = RowSums::default();
        rows.load(&Target::Frame(&picture(Size::new(50, 50), 1, 9, true)), true);
        assert!(rows.has_subsampled());
        assert_eq!(error(rows.subsampled(sliver), 20.0), f32::INFINITY);
        rows.load(&Target::Frame(&picture(Size::new(50, 50), 1, 9, false)), true);
        assert!(!rows.has_subsampled());
    }
}
