//! Finds faces in pictures, photographed and drawn.
//!
//! The network is YuNet (W. Wu, H. Peng, S. Yu: YuNet: A Tiny Millisecond-level Face Detector, 2023), whose 71,590
//! numbers are in `model/`, under the Apache License 2.0. It consists of one kind of layer, so that it is
//! computed here, without the hundred packages of a runtime: sums have a fixed order, and the same picture has the same
//! faces on every machine and any number of threads.
//!
//! ```
//! let grey = vec![[128, 128, 128, 255]; 64 * 48];
//! assert!(polyreel_faces::Detector::new().find(&grey, 64, 48, 0.6).is_empty());
//! ```

mod decode;
mod layers;
mod net;
mod shrink;

use net::Net;

/// Where a face is, in pixels of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Its left side; below 0 where it is cut off.
    pub left: f32,
    /// Its top.
    pub top: f32,
    /// Its width, from ear to ear.
    pub width: f32,
    /// Its height, from the hair to the chin.
    pub height: f32,
    /// How certain it is, 0 to 1.
    pub score: f32,
}

impl Face {
    /// The area that both have in common, as a share of that which they cover together.
    pub fn overlap(&self, other: &Self) -> f32 {
        let along = |a: f32, a_long: f32, b: f32, b_long: f32| {
            ((a + a_long).min(b + b_long) - a.max(b)).max(0.0)
        };
        let common = along(self.left, self.width, other.left, other.width)
            * along(self.top, self.height, other.top, other.height);
        let both = self.width * self.height + other.width * other.height - common;
        if both > 0.0 { common / both } else { 0.0 }
    }
}

/// Finds faces. Making one costs less than a millisecond.
#[derive(Debug)]
pub struct Detector(Net);

impl Default for Detector {
    fn default() -> Self {
        Self::new()
    }
}

impl Detector {
    /// A detector.
    pub fn new() -> Self {
        Self(Net::new())
    }

    /// The faces in a picture of RGBA `pixels`, row by row, which are at least as certain as `least`, 0 to 1; the most
    /// certain first. The picture is reduced to 640 pixels: faces smaller than some 12 pixels of these are not found.
    ///
    /// # Panics
    /// When there are not `width` x `height` pixels.
    pub fn find(&self, pixels: &[[u8; 4]], width: usize, height: usize, least: f32) -> Vec<Face> {
        assert_eq!(pixels.len(), width * height, "{width} x {height}");
        if pixels.is_empty() {
            return Vec::new();
        }
        let (input, scale) = shrink::shrink(pixels, width, height);
        decode::faces(&self.0.run(&input), scale, least)
    }
}
