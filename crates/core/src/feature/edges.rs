//! Edge strength: the first and the second derivative of the luma, as related work uses them to find feature points.

use crate::parallel::prelude::*;

use crate::geom::Size;
use crate::plane::Plane;

/// The rows above, at and below row `y`; beyond the border the border row itself.
pub(super) fn about<T: Copy>(plane: &Plane<T>, y: u32) -> [&[T]; 3] {
    let last = plane.size().height - 1;
    [plane.row(y.saturating_sub(1)), plane.row(y), plane.row((y + 1).min(last))]
}

/// The places along a side, and `beyond` on either end: there it is mirrored about its last place.
pub(super) fn mirrored(side: u32, beyond: usize) -> Vec<usize> {
    let period = (2 * i64::from(side) - 2).max(1);
    let beyond = beyond as i64;
    let place = |v: i64| {
        let v = v.rem_euclid(period);
        v.min(period - v).min(i64::from(side) - 1) as usize
    };
    (-beyond..i64::from(side) + beyond).map(place).collect()
}

/// Fills a plane row by row in parallel: `write(y, row)`.
pub(super) fn by_rows<T, F>(size: Size, blank: T, write: F) -> Plane<T>
where
    T: Copy + Send + Sync,
    F: Fn(u32, &mut [T]) + Sync,
{
    let mut out = Plane::filled(size, blank);
    if size.pixels() > 0 {
        let rows = out.values_mut().par_chunks_exact_mut(size.width as usize);
        rows.with_min_len(8).enumerate().for_each(|(y, row)| write(y as u32, row));
    }
    out
}

/// Sobel's gradient of a plane in steps of `luma` a pixel times 8 (weights 1, 2, 1), rightwards and
/// downwards, at pixel `x` of the middle of three rows; the border repeats itself outwards.
pub(super) fn gradient<T: Copy + Into<f32>>(rows: &[&[T]; 3], x: usize) -> (f32, f32) {
    let (left, right) = (x.saturating_sub(1), (x + 1).min(rows[1].len() - 1));
    let at = |y: usize, x: usize| -> f32 { rows[y][x].into() };
    let column = |x: usize| at(0, x) + 2.0 * at(1, x) + at(2, x);
    let row = |y: usize| at(y, left) + 2.0 * at(y, x) + at(y, right);
    (column(right) - column(left), row(2) - row(0))
}

/// Magnitude of Sobel's gradient, 0..255, as scikit-image's `filters.sobel`: the root of the mean of
/// the squares of the two derivatives, each the difference of the weighted means (1, 2, 1) / 4 of
/// opposite sides. (Sobel and Feldman, "A 3x3 isotropic gradient operator", 1968.)
pub fn sobel(luma: &Plane<u8>) -> Plane<f32> {
    by_rows(luma.size(), 0.0, |y, out| {
        let rows = about(luma, y);
        for (x, value) in out.iter_mut().enumerate() {
            let (dx, dy) = gradient(&rows, x);
            *value = ((dx * dx + dy * dy) / 2.0).sqrt() / 4.0;
        }
    })
}

/// Magnitude of the Laplacian of four neighbours, 0..1020: the absolute value of scikit-image's
/// `filters.laplace` (kernel 0 -1 0, -1 4 -1, 0 -1 0; the border repeats itself outwards).
pub fn laplacian(luma: &Plane<u8>) -> Plane<f32> {
    by_rows(luma.size(), 0.0, |y, out| {
        let [above, here, below] = about(luma, y);
        let last = here.len() - 1;
        for (x, value) in out.iter_mut().enumerate() {
            let at = |row: &[u8], x: usize| i32::from(row[x]);
            let sides = at(here, x.saturating_sub(1)) + at(here, (x + 1).min(last));
            let sum = sides + at(above, x) + at(below, x);
            *value = (4 * at(here, x) - sum).unsigned_abs() as f32;
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0 left of column 4, 200 from there on.
    fn step() -> Plane<u8> {
        let pixel = |i: usize| if i % 8 < 4 { 0 } else { 200 };
        Plane::new(Size::new(8, 5), (0..40).map(pixel).collect()).expect("8 x 5")
    }

    #[test]
    fn a_step_is_seen_on_both_its_sides() {
        let (sobel, laplacian) = (sobel(&step()), laplacian(&step()));
        let expected = 200.0 / 2_f32.sqrt();
        for y in 0..5 {
            for x in 0..8 {
                let side = x == 3 || x == 4;
                assert!((sobel.at(x, y) - if side { expected } else { 0.0 }).abs() < 1e-4);
                assert_eq!(laplacian.at(x, y), if side { 200.0 } else { 0.0 });
            }
        }
    }

    #[test]
    fn the_smallest_planes_have_maps() {
        for (width, height) in [(1, 1), (1, 5), (5, 1)] {
            let plane = Plane::filled(Size::new(width, height), 77);
            assert!(sobel(&plane).values().iter().all(|&v| v == 0.0));
            assert!(laplacian(&plane).values().iter().all(|&v| v == 0.0));
        }
    }
}
