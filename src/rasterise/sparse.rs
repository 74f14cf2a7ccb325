//! Mean colours from a sparser sample: cheaper, and hardly to be seen in large triangles.

use rayon::prelude::*;

use super::{PACK, mean_opaque, mean_weighted, rounded};
use crate::frame::{Fill, Frame};
use crate::geom::Point;
use crate::mesh::Mesh;
use crate::scan;

/// Rows that a mean is taken from at least, where it is not taken from all.
const ENOUGH: u32 = 3;

/// As [`super::means`], but of triangles with rows enough only every `every`-th row of the frame
/// counts. Areas are exact.
pub(super) fn sparse_means(mesh: &Mesh, frame: &Frame, every: u32) -> Vec<Fill> {
    let mut fills = vec![Fill { colour: [0; 4], area: 0 }; mesh.triangles.len()];
    fills.par_chunks_mut(PACK).enumerate().for_each(|(pack, fills)| {
        for (i, fill) in fills.iter_mut().enumerate() {
            let triangle = mesh.triangle(pack * PACK + i);
            let tall = scan::rows(triangle).len() >= (ENOUGH * every) as usize;
            let sparse = if tall { mean(frame, triangle, every) } else { None };
            *fill = sparse.unwrap_or_else(|| match frame.is_opaque() {
                true => mean_opaque(frame, triangle),
                false => mean_weighted(frame, triangle),
            });
        }
    });
    fills
}

/// The mean of every `every`-th row of `frame`; `None` where nothing is seen in them.
fn mean(frame: &Frame, triangle: [Point; 3], every: u32) -> Option<Fill> {
    let (mut sum, mut area, mut count) = ([0u64; 4], 0, 0u64);
    scan::spans(triangle, 0..frame.size().height, |y, columns| {
        area += columns.len() as u32;
        if y % every != 0 {
            return;
        }
        count += columns.len() as u64;
        let pixels = &frame.row(y)[columns];
        if frame.is_opaque() {
            // A row has at most 16384 pixels: its sums fit 32 bits.
            let mut row = [0u32; 4];
            for pixel in pixels {
                row.iter_mut().zip(pixel).for_each(|(sum, &v)| *sum += u32::from(v));
            }
            sum.iter_mut().zip(row).for_each(|(sum, row)| *sum += u64::from(row));
        } else {
            for &[r, g, b, a] in pixels {
                let parts = [r, g, b].map(|v| u64::from(v) * u64::from(a));
                sum.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
                sum[3] += u64::from(a);
            }
        }
    });
    let alpha = sum[3].checked_div(count).filter(|&alpha| alpha > 0)?;
    let [r, g, b, total] = sum;
    let weight = if frame.is_opaque() { count } else { total };
    let [r, g, b] = [r, g, b].map(|sum| rounded(sum, weight));
    let alpha = if alpha == 255 { 255 } else { rounded(total, count) };
    Some(Fill { colour: [r, g, b, alpha], area })
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
