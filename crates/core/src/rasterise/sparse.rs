//! Mean colours from some of the rows: faster, and hardly visible in large triangles.

use super::tally::Tally;
use super::{each_triangle, mean};
use crate::frame::{Fill, Frame};
use crate::geom::Point;
use crate::mesh::Mesh;
use crate::scan;

/// The least number of rows for a mean from some of the rows.
const ENOUGH: u32 = 3;

/// As [`super::means`], but large triangles use every `every`-th row of the frame only. Areas are exact.
pub(super) fn sparse_means(mesh: &Mesh, frame: &Frame, every: u32) -> Vec<Fill> {
    each_triangle(mesh, |triangle| {
        if !has_enough(triangle, every) {
            return mean(frame, triangle);
        }
        let some = Tally::of(frame, triangle, |y| y % every == 0);
        // If they have no visible pixel, all rows count.
        match some.alpha.checked_div(some.seen) {
            None | Some(0) => mean(frame, triangle),
            Some(_) => some.fill(),
        }
    })
}

/// Whether a triangle is large enough for a mean from every `every`-th row.
pub(super) fn has_enough(triangle: [Point; 3], every: u32) -> bool {
    scan::rows(triangle).len() >= (ENOUGH * every) as usize
}

#[cfg(test)]
mod tests {
    use super::super::means;
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    #[test]
    fn colours_are_near_the_means_and_areas_exact() {
        let size = Size::new(120, 90);
        for opaque in [true, false] {
            let pixel = |x: u32, y: u32| {
                let alpha = if opaque { 255 } else { (255 - x) as u8 };
                [(x * 2) as u8, (y * 2) as u8, 90, alpha]
            };
            let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| pixel(x, y)));
            let frame = Frame::new(size, pixels.collect()).expect("a small frame");
            let at = |i: u32| {
                let bits = rank(1, Purpose::Noise, i, 0);
                Point::pixel_centre((bits % 120) as u32, (bits >> 20) as u32 % 90)
            };
            let mesh = triangulate(size, &(0..25).map(at).collect::<Vec<_>>()).expect("distinct");
            let exact = means(&mesh, &frame);
            for every in [1, 2, 4] {
                let sparse = sparse_means(&mesh, &frame, every);
                for (sparse, exact) in sparse.iter().zip(&exact) {
                    assert_eq!(sparse.area, exact.area);
                    for (a, b) in sparse.colour.into_iter().zip(exact.colour) {
                        assert!(every > 1 || a == b);
                        assert!(a.abs_diff(b) <= 8, "every {every}: {sparse:?}, not {exact:?}");
                    }
                }
                assert_eq!(sparse != exact, every > 1);
            }
        }
    }
}
