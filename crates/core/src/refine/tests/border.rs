//! Where contours leave the frame.

use super::*;
use crate::mesh::Place;

/// Bands whose edges run out of the frame on both sides, at places where no vertex of an even border is.
fn bands(size: Size) -> Frame {
    let pixel = |i: usize| {
        let (x, y) = ((i % size.width as usize) as f64, (i / size.width as usize) as f64);
        let band = (y + 9.0 * (x * 0.05).sin()) / 23.0;
        let v = if (band as u32).is_multiple_of(2) { 40 } else { 215 };
        [v, v / 2 + 30, 120, 255]
    };
    Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("a small frame")
}

fn least_angle(mesh: &Mesh, t: usize) -> f64 {
    let corners = mesh.triangle(t).map(Point::to_pixels);
    let angle = |i: usize| {
        let (a, b, c) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
        let ((ux, uy), (vx, vy)) = ((b.0 - a.0, b.1 - a.1), (c.0 - a.0, c.1 - a.1));
        (ux * vy - uy * vx).abs().atan2(ux * vx + uy * vy).to_degrees()
    };
    (0..3).map(angle).fold(f64::INFINITY, f64::min)
}

#[test]
fn no_needles_are_left_at_the_border_where_contours_leave_the_frame() {
    let size = Size::new(240, 180);
    let frame = bands(size);
    let border = crate::sample::border::border_points(size, 24);
    let mut mesh =
        triangulate(size, [border, scattered(size, 150).seeds().to_vec()].concat().as_slice())
            .expect("seeds inside the frame");
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let refined = refine(&mut mesh, &frame, &RefineOptions::best());
    assert_eq!(mesh.check(), Ok(()));
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (vertices, triangles));
    assert!(refined.error_after < 0.5 * refined.error_before);
    let at_border = |t: &usize| {
        let on_border = |&v: &u32| Place::of(mesh.vertices[v as usize], size) != Place::Interior;
        mesh.triangles[*t].iter().any(on_border)
    };
    let needles: Vec<_> = (0..mesh.triangles.len())
        .filter(at_border)
        .filter(|&t| least_angle(&mesh, t) < 5.0)
        .map(|t| mesh.triangle(t).map(Point::to_pixels))
        .collect();
    assert!(needles.is_empty(), "{needles:?}");
}

#[test]
fn vertices_go_to_the_border_where_it_is_bare_and_the_mesh_stays_sound() {
    let size = Size::new(200, 120);
    let frame = bands(size);
    let on_border = |mesh: &Mesh| {
        mesh.seeds().iter().filter(|p| Place::of(**p, size) != Place::Interior).count()
    };
    let border = crate::sample::border::border_points(size, 30);
    for seed in 0..6 {
        let inner: Vec<Point> = scattered(size, 60 + 9 * seed).seeds().to_vec();
        let mut mesh =
            triangulate(size, &[border.clone(), inner].concat()).expect("seeds inside the frame");
        let (before, triangles) = (on_border(&mesh), mesh.triangles.len());
        let shifted = mesh.vertices.clone();
        refine(&mut mesh, &frame, &RefineOptions::best());
        assert_eq!(mesh.check(), Ok(()), "{seed}");
        assert_eq!((on_border(&mesh), mesh.triangles.len()), (before, triangles));
        assert_ne!(mesh.vertices, shifted);
    }
}
