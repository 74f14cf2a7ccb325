//! The force against the slope of the error.

use super::*;
use crate::refine::ring::Ring;

/// The force on a vertex and the error's slope there, on a smooth wave, by `chance` of it. The slope is
/// that of the picture's whole error, of a mesh with that vertex elsewhere.
fn force_and_slope(chance: u32) -> ([f64; 2], [f64; 2]) {
    let unit = |purpose| crate::chance::unit(1, purpose, chance, 0);
    let (angle, phase) = (6.0 * unit(Purpose::Interior), 6.0 * unit(Purpose::Keep));
    let wave = 40.0 + 30.0 * unit(Purpose::Trim);
    let size = Size::new(240, 240);
    let pixel = |x: u32, y: u32| {
        let along = f64::from(x) * angle.cos() + f64::from(y) * angle.sin();
        let value = (127.5 + 120.0 * (along / wave + phase).sin()).round() as u8;
        [value, 255 - value, value / 2, 255]
    };
    let pixels = (0..240).flat_map(|y| (0..240).map(move |x| pixel(x, y))).collect();
    let frame = Frame::new(size, pixels).expect("a small frame");
    let mut seeds = vec![Point::from_pixels(
        100.0 + 40.0 * unit(Purpose::Phase),
        100.0 + 40.0 * unit(Purpose::Noise),
    )];
    seeds.extend((0..7).map(|i| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 7.0).sin_cos();
        Point::from_pixels(120.0 + 72.0 * cos, 120.0 + 72.0 * sin)
    }));
    let mesh = triangulate(size, &seeds).expect("distinct seeds");
    let mut refiner = Refiner::default();
    refiner.rows.load(&Target::Frame(&frame), false);
    refiner.surface.link(&mesh);
    refiner.surface.measure(&refiner.rows);
    let mut ring = Ring::default();
    let v = CORNERS as u32;
    ring.surround(&refiner.surface, v, refiner.surface.around(v));
    ring.sum_up(&refiner.surface);
    let mean = |i: usize| refiner.surface.mean[ring.links[i] as usize / 3].known();
    let pass = Pass {
        rows: &refiner.rows,
        target: &Target::Frame(&frame),
        weight: 0.0,
        min_gain: 0.0,
        mode: Mode::Thorough,
        has_next: false,
        focus: None,
    };
    let (gx, gy) = super::force::gradient(pass, seeds[0], &ring, mean);
    // Central differences over eight pixels even out that pixels change hands whole.
    let slope = |dx: i32, dy: i32| {
        let error = |way: i32| {
            let mut moved = mesh.clone();
            moved.vertices[CORNERS] = Point::new(seeds[0].x + dx * way, seeds[0].y + dy * way);
            assert_eq!(moved.check(), Ok(()), "a small way");
            error_of(&moved, &frame)
        };
        (error(4 * SUBPIXEL) - error(-4 * SUBPIXEL)) / 8.0
    };
    ([gx, gy], [slope(1, 0), slope(0, 1)])
}

/// On pictures smooth enough to have one, against differences of the error by its definition.
#[test]
fn the_force_is_the_gradient_of_the_error() {
    let (mut off, mut all) = (0.0, 0.0);
    for chance in 0..40 {
        let (force, slope) = force_and_slope(chance);
        for (f, s) in force.into_iter().zip(slope) {
            off += (f - s) * (f - s);
            all += s * s;
        }
    }
    let share = f64::sqrt(off / all);
    assert!(share < 0.05, "the force is off by {share} of the slope");
}
