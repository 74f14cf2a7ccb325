//! A picture to measure on.

use polyreel::chance::{Purpose, rank};
use polyreel::frame::Frame;
use polyreel::geom::Size;

/// Disks of colour on a gradient, one in every `cell` x `cell` pixels, with a little noise, as a
/// photograph has it; all `shift` pixels further to the left.
pub(crate) fn disks(size: Size, cell: u32, shift: u32) -> Frame {
    let (middle, radius) = (cell / 2, cell * 45 / 128);
    let pixel = |i: u32| {
        let (x, y) = (i % size.width + shift, i / size.width);
        let (u, v) = (x % cell, y % cell);
        let disk = u.abs_diff(middle).pow(2) + v.abs_diff(middle).pow(2) < radius * radius;
        let noise = (rank(1, Purpose::Noise, x, y) % 9) as u32;
        let tone = if disk { (x / cell * 47 + y / cell * 91) % 200 } else { (x + y) / 16 };
        [tone + noise, tone / 2 + 60, 200 - tone / 2 + noise, 255].map(|c| c.min(255) as u8)
    };
    let pixels = (0..size.pixels() as u32).map(pixel).collect();
    Frame::new(size, pixels).expect("as many as pixels")
}
