//! Scales frames down to a longest side, with a Lanczos filter.
//!
//! Colours are weighted by alpha, so that the colours of transparent pixels have no effect.

use rayon::prelude::*;

use super::{Decoded, Source};
use crate::error::Result;
use crate::frame::{Frame, Rational, Rgba};
use crate::geom::Size;

/// Lobes of the filter on each side (Duchon, "Lanczos filtering in one and two dimensions", 1979).
const LOBES: f64 = 3.0;

/// `size` scaled down in proportion so that its longest side is at most `longest`.
pub(crate) fn fitted(size: Size, longest: u32) -> Size {
    let largest = size.width.max(size.height);
    if largest <= longest {
        return size;
    }
    let side = |v: u32| {
        let (v, longest, largest) = (u64::from(v), u64::from(longest), u64::from(largest));
        (((2 * v * longest + largest) / (2 * largest)) as u32).max(1)
    };
    Size::new(side(size.width), side(size.height))
}

/// A source with frames of another size.
pub(crate) struct Resize {
    inner: Box<dyn Source>,
    scaler: Scaler,
}

impl Resize {
    /// The frames of `inner`, of size `from`, scaled down to `to`.
    pub(crate) fn new(inner: Box<dyn Source>, from: Size, to: Size) -> Self {
        Self { inner, scaler: Scaler::new(from, to) }
    }
}

struct Scaler {
    columns: Vec<Tap>,
    rows: Vec<Tap>,
    from: Size,
    to: Size,
}

impl Scaler {
    fn new(from: Size, to: Size) -> Self {
        let (columns, rows) = (taps(from.width, to.width), taps(from.height, to.height));
        Self { columns, rows, from, to }
    }

    fn resize(&self, frame: &Frame) -> Result<Frame> {
        let premultiplied = !frame.is_opaque();
        let width = self.to.width as usize;
        let mut across = vec![[0f32; 4]; width * self.from.height as usize];
        across.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            let row: Vec<[f32; 4]> =
                frame.row(y as u32).iter().map(|&p| load(p, premultiplied)).collect();
            for (pixel, tap) in out.iter_mut().zip(&self.columns) {
                *pixel = tap.sum(|i| row[i]);
            }
        });
        let mut pixels = vec![[0; 4]; self.to.pixels()];
        pixels.par_chunks_mut(width).zip(&self.rows).for_each(|(out, tap)| {
            for (x, pixel) in out.iter_mut().enumerate() {
                *pixel = store(tap.sum(|i| across[i * width + x]), premultiplied);
            }
        });
        Ok(Frame::new(self.to, pixels)?)
    }
}

impl Source for Resize {
    fn skip_to(&mut self, start: Rational) {
        self.inner.skip_to(start);
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        let Some(mut decoded) = self.inner.next()? else { return Ok(None) };
        let frame = self.scaler.resize(&decoded.frame)?;
        let source = std::mem::replace(&mut decoded.frame, frame);
        self.inner.recycle(source);
        Ok(Some(decoded))
    }
}

/// The weights of the pixels that make one new pixel of a row or column.
struct Tap {
    first: usize,
    weights: Vec<f32>,
}

impl Tap {
    fn sum(&self, pixel: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
        let mut sum = [0.0; 4];
        for (i, weight) in self.weights.iter().enumerate() {
            let pixel = pixel(self.first + i);
            for (s, p) in sum.iter_mut().zip(pixel) {
                *s += weight * p;
            }
        }
        sum
    }
}

fn taps(from: u32, to: u32) -> Vec<Tap> {
    let scale = f64::from(from) / f64::from(to);
    (0..to)
        .map(|i| {
            let centre = (f64::from(i) + 0.5) * scale;
            let first = (centre - LOBES * scale).floor().max(0.0) as usize;
            let last = ((centre + LOBES * scale).ceil() as usize).min(from as usize);
            let weights: Vec<f64> =
                (first..last).map(|j| lanczos((j as f64 + 0.5 - centre) / scale)).collect();
            let total: f64 = weights.iter().sum();
            Tap { first, weights: weights.iter().map(|w| (w / total) as f32).collect() }
        })
        .collect()
}

fn lanczos(x: f64) -> f64 {
    let sinc = |x: f64| {
        if x == 0.0 { 1.0 } else { (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x) }
    };
    if x.abs() < LOBES { sinc(x) * sinc(x / LOBES) } else { 0.0 }
}

fn load(pixel: Rgba, premultiplied: bool) -> [f32; 4] {
    let [r, g, b, a] = pixel.map(f32::from);
    if premultiplied { [r * a / 255.0, g * a / 255.0, b * a / 255.0, a] } else { [r, g, b, a] }
}

fn store([r, g, b, a]: [f32; 4], premultiplied: bool) -> Rgba {
    let alpha = a.round().clamp(0.0, 255.0);
    if premultiplied && alpha == 0.0 {
        return [0; 4];
    }
    let undo = if premultiplied { 255.0 / a } else { 1.0 };
    let byte = |v: f32| (v * undo).round().clamp(0.0, 255.0) as u8;
    [byte(r), byte(g), byte(b), alpha as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resized(frame: &Frame, longest: u32) -> Frame {
        let to = fitted(frame.size(), longest);
        Scaler::new(frame.size(), to).resize(frame).expect("a smaller frame")
    }

    #[test]
    fn sizes_keep_their_proportion_and_never_grow() {
        assert_eq!(fitted(Size::new(1920, 1080), 1280), Size::new(1280, 720));
        assert_eq!(fitted(Size::new(3, 16000), 100), Size::new(1, 100));
        assert_eq!(fitted(Size::new(30, 20), 100), Size::new(30, 20));
    }

    #[test]
    fn one_colour_stays_itself() {
        for colour in [[10, 20, 250, 255], [200, 100, 0, 7], [0, 0, 0, 0]] {
            let small = resized(&Frame::filled(Size::new(97, 31), colour).expect("a frame"), 13);
            assert_eq!(small.size(), Size::new(13, 4));
            assert!(small.pixels().iter().all(|&p| p == colour), "{:?}", small.at(0, 0));
        }
    }

    #[test]
    fn a_ramp_stays_a_ramp() {
        let size = Size::new(256, 8);
        let pixels = (0..size.pixels()).map(|i| [(i % 256) as u8, 0, 0, 255]).collect();
        let small = resized(&Frame::new(size, pixels).expect("a frame"), 64);
        for x in 4..60 {
            // Four pixels 4x to 4x + 3 have the mean 4x + 1.5.
            let error = f64::from(small.at(x, 1)[0]) - (4.0 * f64::from(x) + 1.5);
            assert!(error.abs() <= 1.0, "pixel {x} is {error} off");
        }
    }

    #[test]
    fn hidden_colours_do_not_bleed() {
        let size = Size::new(64, 64);
        let pixels = (0..size.pixels())
            .map(|i| if i % 64 < 32 { [255, 0, 0, 255] } else { [0, 255, 0, 0] })
            .collect();
        let small = resized(&Frame::new(size, pixels).expect("a frame"), 9);
        assert!(small.pixels().iter().all(|p| p[3] == 0 || p[1] == 0), "{:?}", small.row(4));
        assert!(!small.is_opaque() && small.at(0, 0) == [255, 0, 0, 255]);
    }
}
