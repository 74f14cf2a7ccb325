//! What holds of every refinement, whatever the picture and the seeds.

mod border;
mod maintain;
mod places;
mod same;
mod slope;
mod steps;
mod video;

use super::*;
use crate::chance::{Purpose, rank};
use crate::geom::{Point, SUBPIXEL, Size};
use crate::mesh::CORNERS;
use crate::scan;
use crate::triangulate::tests::mesh_of;
use crate::triangulate::triangulate;

/// A picture with flat areas, slanted edges, a disk, a ramp and some noise; `noise` 0..=255.
pub(super) fn picture(size: Size, seed: u64, noise: u8, opaque: bool) -> Frame {
    let pixel = |x: u32, y: u32| {
        let [n, a, ..] = rank(seed, Purpose::Noise, x, y).to_le_bytes();
        let (fx, fy) = (f64::from(x), f64::from(y));
        let turn = seed as f64 * 0.7;
        let side = (fx - 14.0) * turn.cos() + (fy - 11.0) * turn.sin();
        let disk = (fx - 20.0).hypot(fy - 18.0) < 9.0;
        let base = if disk {
            210.0
        } else if side > 0.0 {
            40.0 + fx
        } else {
            120.0
        };
        let value = base + f64::from(n) * f64::from(noise) / 255.0;
        let value = value.clamp(0.0, 255.0) as u8;
        let alpha = if opaque {
            255
        } else if disk {
            a
        } else {
            0
        };
        [value, value / 2 + (y % 64) as u8, 255 - value, alpha]
    };
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| pixel(x, y)));
    Frame::new(size, pixels.collect()).expect("a small frame")
}

/// A mesh of `count` seeds, all over the frame.
pub(super) fn scattered(size: Size, count: u32) -> Mesh {
    let place = |i| {
        let bits = rank(9, Purpose::Keep, i, 0);
        ((bits >> 32) as f64 / 4_294_967_296.0, (bits & 0xffff_ffff) as f64 / 4_294_967_296.0)
    };
    mesh_of(size, &(0..count).map(place).collect::<Vec<_>>(), SUBPIXEL / 2)
}

/// The squared error of every triangle's mean colour, pixel by pixel from its definition.
fn error_of(mesh: &Mesh, frame: &Frame) -> f64 {
    let channels = |[r, g, b, a]: [u8; 4]| {
        let by_alpha = |v: u8| (f64::from(v) * f64::from(a) / 255.0).round();
        [by_alpha(r), by_alpha(g), by_alpha(b), f64::from(a)]
    };
    let error = |t: usize| {
        let (mut count, mut sums, mut squares) = (0.0, [0.0; 4], 0.0);
        scan::spans(mesh.triangle(t), 0..frame.size().height, |y, columns| {
            for &pixel in &frame.row(y)[columns] {
                count += 1.0;
                for (sum, v) in sums.iter_mut().zip(channels(pixel)) {
                    *sum += v;
                    squares += v * v;
                }
            }
        });
        squares - sums.iter().map(|sum| sum * sum / f64::max(count, 1.0)).sum::<f64>()
    };
    (0..mesh.triangles.len()).map(error).sum()
}

#[test]
fn few_large_triangles_are_summed_exactly() {
    // Triangles of some 40000 pixels, whose sums do not fit the packed fields.
    let frame = picture(Size::new(400, 300), 1, 200, true);
    let mut mesh = scattered(frame.size(), 2);
    let refined = refine(&mut mesh, &frame, &RefineOptions::best());
    assert_eq!(mesh.check(), Ok(()));
    assert!(refined.error_after < refined.error_before);
}

#[test]
fn draft_does_nothing() {
    let frame = picture(Size::new(40, 40), 1, 0, true);
    let mut mesh = scattered(frame.size(), 30);
    let before = mesh.clone();
    assert_eq!(refine(&mut mesh, &frame, &RefineOptions::draft()), Refined::default());
    assert_eq!(mesh, before);
    assert!(mesh.vertices.len() > CORNERS);
}
