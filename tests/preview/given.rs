//! Inputs.

use std::path::Path;

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, DynamicImage, Rgb, RgbImage};

/// Size of all pictures.
pub(crate) const SIZE: (u32, u32) = (120, 80);

/// A bright disc that wanders over a gradient without black.
pub(crate) fn picture(t: u32) -> RgbImage {
    let (width, height) = SIZE;
    RgbImage::from_fn(width, height, |x, y| {
        let (cx, cy) = (f64::from(20 + 5 * t % 90), f64::from(height) / 2.0);
        if (f64::from(x) - cx).hypot(f64::from(y) - cy) < 18.0 {
            Rgb([230, 200, 60])
        } else {
            Rgb([40 + (x * 100 / width) as u8, 60 + (y * 90 / height) as u8, 120])
        }
    })
}

/// Writes a GIF of `frames` pictures, 25 a second.
pub(crate) fn gif(path: &Path, frames: u32) {
    let file = std::fs::File::create(path).expect("a writable folder");
    let mut encoder = GifEncoder::new(file);
    encoder.set_repeat(Repeat::Infinite).expect("a GIF");
    for t in 0..frames {
        let picture = DynamicImage::from(picture(t)).to_rgba8();
        let delay = Delay::from_numer_denom_ms(40, 1);
        let frame = image::Frame::from_parts(picture, 0, 0, delay);
        encoder.encode_frame(frame).expect("a GIF");
    }
}

/// Writes y4m of `frames` pictures, 25 a second: a bar that wanders.
pub(crate) fn y4m(path: &Path, frames: u32) {
    let (width, height) = SIZE;
    let mut bytes = format!("YUV4MPEG2 W{width} H{height} F25:1 Ip A1:1 C420jpeg\n").into_bytes();
    for t in 0..frames {
        bytes.extend_from_slice(b"FRAME\n");
        let bar = |x: u32| (x + 3 * t) % width < 30;
        let luma = (0..width * height).map(|i| if bar(i % width) { 210 } else { 90 });
        bytes.extend(luma);
        bytes.extend((0..width * height / 2).map(|i| 100 + (i % width / 4) as u8));
    }
    std::fs::write(path, bytes).expect("a writable folder");
}
