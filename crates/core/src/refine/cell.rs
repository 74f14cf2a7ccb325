//! The expected error of a triangle on a picture.

use std::ops::Range;

use super::rows::RowSums;
use super::sums::Total;
use super::target::Target;
use crate::frame::Frame;
use crate::geom::{Point, Size};
use crate::scan::{self, first_centre};

/// Triangles along each side of the frame.
const ALONG: i32 = 16;

/// The mean squared error of the triangles of a regular grid of `triangles` triangles, from 256 samples. If the frame
/// is not opaque, or has no pixels, `rows` must have all of its sums.
pub(super) fn cell_error(rows: &RowSums, target: &Target, triangles: usize) -> f64 {
    let (far, leg) = (target.size().far(), leg(target.size(), triangles));
    let picture = target.picture();
    let mut error = 0.0;
    for j in 0..ALONG {
        for i in 0..ALONG {
            let a = Point::new(place(i, far.x - leg), place(j, far.y - leg));
            let triangle = [a, Point::new(a.x + leg, a.y), Point::new(a.x, a.y + leg)];
            // From the pixels, if they exist: not all rows may have been summed then.
            let total = if picture.is_opaque() && picture.has_pixels() {
                opaque_total(picture, triangle)
            } else {
                rows.wide(triangle)
            };
            error += rows.squares_of(target, triangle) - total.explained();
        }
    }
    error / f64::from(ALONG * ALONG)
}

/// The rows of a frame of `size` that [`cell_error`] reads.
pub(super) fn cell_rows(size: Size, triangles: usize) -> impl Iterator<Item = Range<u32>> {
    let leg = leg(size, triangles);
    let (top, height) = (move |j| place(j, size.far().y - leg), size.height);
    (0..ALONG)
        .map(top)
        .map(move |y| first_centre(y) as u32..(first_centre(y + leg) as u32).min(height))
}

/// The legs of the triangles.
fn leg(size: Size, triangles: usize) -> i32 {
    let far = size.far();
    let area = f64::from(far.x) * f64::from(far.y) / triangles.max(1) as f64;
    ((2.0 * area).sqrt() as i32).clamp(1, far.x.min(far.y))
}

/// The position of the `k`-th of [`ALONG`] triangles.
fn place(k: i32, last: i32) -> i32 {
    (i64::from(last) * i64::from(k) / i64::from(ALONG - 1)) as i32
}

/// The sums over the pixels of a triangle, one by one.
fn opaque_total(picture: &Frame, triangle: [Point; 3]) -> Total {
    let (mut count, mut sums) = (0, [0i64; 3]);
    scan::spans(triangle, 0..picture.size().height, |y, columns| {
        count += columns.len() as i64;
        for pixel in &picture.row(y)[columns] {
            sums = [0, 1, 2].map(|i| sums[i] + i64::from(pixel[i]));
        }
    });
    Total::new(count, sums, 0)
}
