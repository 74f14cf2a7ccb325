//! Makes the pictures in `samples/`: a still, a GIF and a short sequence, the same bytes on every run.
//!
//! ```sh
//! cargo run --release --example make_samples -- samples
//! ```

use std::error::Error;
use std::fs::File;
use std::path::Path;

use image::codecs::gif::{GifEncoder, Repeat};
use image::codecs::jpeg::JpegEncoder;
use image::{Delay, Frame, Rgb, RgbImage, buffer::ConvertBuffer};
use polyreel::chance::{Purpose, unit};

const SEED: u64 = 20;

type Colour = [f64; 3];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "samples".into());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder.join("boat"))?;

    let still = paint(960, 600, |u, v| lake(u, v, 0.35));
    JpegEncoder::new_with_quality(File::create(folder.join("lake.jpg"))?, 88)
        .encode_image(&still)?;

    let mut gif = GifEncoder::new_with_speed(File::create(folder.join("planet.gif"))?, 10);
    gif.set_repeat(Repeat::Infinite)?;
    for t in 0..16 {
        let frame = paint(240, 180, |u, v| planet(u, v, f64::from(t) / 16.0));
        let delay = Delay::from_numer_denom_ms(80, 1);
        gif.encode_frame(Frame::from_parts(frame.convert(), 0, 0, delay))?;
    }
    for t in 0..8 {
        let frame = paint(320, 200, |u, v| lake(u, v, 0.15 + 0.07 * f64::from(t)));
        frame.save(folder.join(format!("boat/{:04}.png", t + 1)))?;
    }
    Ok(())
}

/// Samples `colour(u, v)` (u to the right in heights of the picture, v downwards, 0..1) four times a
/// pixel.
fn paint(width: u32, height: u32, colour: impl Fn(f64, f64) -> Colour) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let mut sum = [0.0; 3];
        for (dx, dy) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let u = (f64::from(x) + dx) / f64::from(height);
            let v = (f64::from(y) + dy) / f64::from(height);
            for (sum, channel) in sum.iter_mut().zip(colour(u, v)) {
                *sum += channel / 4.0;
            }
        }
        Rgb(sum.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8))
    })
}

fn mix(a: Colour, b: Colour, t: f64) -> Colour {
    let t = t.clamp(0.0, 1.0);
    [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * t)
}

/// Smooth noise in 0..1 along a line, one knot a unit.
fn ripple(x: f64, layer: u32) -> f64 {
    let knot = |i: f64| unit(SEED, Purpose::Noise, (i as i64 + 1000) as u32, layer);
    let t = x - x.floor();
    let ease = t * t * (3.0 - 2.0 * t);
    knot(x.floor()) * (1.0 - ease) + knot(x.floor() + 1.0) * ease
}

fn ridge(u: f64, layer: u32, pitch: f64) -> f64 {
    ripple(u * pitch, layer) * 0.6
        + ripple(u * pitch * 2.7, layer + 10) * 0.28
        + ripple(u * pitch * 7.1, layer + 20) * 0.12
}

/// A lake before mountains at sunset, with a sailing boat at `boat` of the way across.
fn lake(u: f64, v: f64, boat: f64) -> Colour {
    const SHORE: f64 = 0.62;
    let above =
        if v < SHORE { v } else { 2.0 * SHORE - v + 0.012 * (v * 160.0).sin() * (v - SHORE) };
    let mut colour = landscape(u, above.max(0.0), SHORE);
    if v >= SHORE {
        colour = mix(colour, [0.05, 0.10, 0.22], 0.25 + 0.6 * (v - SHORE));
    }
    sail(u, v, boat * 1.6).unwrap_or(colour)
}

fn landscape(u: f64, v: f64, shore: f64) -> Colour {
    let mut colour = mix([0.16, 0.20, 0.45], [0.98, 0.62, 0.38], (v / shore).powf(1.4));
    let sun = (u - 1.05).hypot(v - 0.36);
    colour = mix(colour, [1.0, 0.82, 0.55], 0.55 * (-sun * 5.0).exp());
    if sun < 0.075 {
        colour = [1.0, 0.95, 0.80];
    }
    let ranges = [
        (0.30, 0.26, 2.0, [0.52, 0.40, 0.55]),
        (0.42, 0.20, 3.1, [0.33, 0.27, 0.45]),
        (0.53, 0.12, 5.0, [0.14, 0.17, 0.27]),
    ];
    for (layer, (base, height, pitch, shade)) in ranges.into_iter().enumerate() {
        let top = base + height * (0.5 - ridge(u + 3.0, layer as u32, pitch));
        if v > top {
            let snow = layer == 0 && v < top + 0.03 + 0.05 * ridge(u, 7, 14.0);
            colour = if snow { [0.93, 0.80, 0.80] } else { mix(shade, colour, 0.12 * (v - top)) };
        }
    }
    colour
}

fn sail(u: f64, v: f64, at: f64) -> Option<Colour> {
    let (x, y) = (u - at, v - 0.74);
    if (0.0..0.028).contains(&y) && x.abs() < 0.11 - y * 1.6 {
        return Some([0.35, 0.12, 0.10]);
    }
    if (-0.24..0.0).contains(&y) {
        if x > 0.006 && x < 0.10 * (1.0 + y / 0.24) {
            return Some(mix([0.97, 0.94, 0.88], [0.85, 0.70, 0.62], x / 0.1));
        }
        if x < -0.006 && x > -0.07 * (1.0 + y / 0.20) {
            return Some([0.90, 0.36, 0.25]);
        }
    }
    None
}

/// A ringed planet with a moon on its way around it; `t` in 0..1 is a full turn.
fn planet(u: f64, v: f64, t: f64) -> Colour {
    let turn = std::f64::consts::TAU * t;
    let (x, y) = (u - 0.667, v - 0.5);
    let mut colour = mix([0.03, 0.03, 0.10], [0.16, 0.06, 0.24], v + 0.2 * (u * 3.0).sin());
    let star = ((u * 45.0).floor() as u32, (v * 45.0).floor() as u32);
    if unit(SEED, Purpose::Interior, star.0, star.1) > 0.985 {
        colour = [0.8, 0.8, 0.9];
    }
    let tilted = (x + 0.35 * y, y * 2.6 - 0.55 * x);
    let ring = tilted.0.hypot(tilted.1);
    let on_ring = (0.40..0.58).contains(&ring);
    let ring_colour = mix([0.85, 0.72, 0.52], [0.55, 0.42, 0.38], (ring * 60.0).sin() * 0.5 + 0.5);
    if on_ring {
        colour = ring_colour;
    }
    let r = x.hypot(y) / 0.30;
    if r < 1.0 && !(on_ring && tilted.1 > 0.0) {
        let height = (1.0 - r * r).sqrt();
        let light = (0.75 * height - 0.55 * x / 0.30 - 0.35 * y / 0.30).clamp(0.08, 1.0);
        let band = (y * 34.0 + 1.2 * ridge(u + 6.0 + t * 2.0 * height, 40, 9.0)).sin() * 0.5 + 0.5;
        colour = mix([0.0; 3], mix([0.93, 0.60, 0.34], [0.70, 0.30, 0.28], band), light);
    }
    let (mx, my) = (x - 0.56 * turn.cos(), y - 0.16 * turn.sin() + 0.18 * turn.cos());
    let hidden = turn.sin() < 0.0 && r < 1.0;
    if mx.hypot(my) < 0.06 && !hidden {
        let light = (0.8 - 6.0 * mx - 5.0 * my).clamp(0.15, 1.0);
        colour = mix([0.0; 3], [0.75, 0.80, 0.88], light);
    }
    colour
}
