//! Level one at half the size, at a quarter of the cost.

use crate::parallel::prelude::*;

use super::mask::Mask;
use super::{Extractor, Features};
use crate::chance::{Purpose, rank};
use crate::frame::{Frame, Rgba};
use crate::geom::Size;
use crate::options::Options;
use crate::plane::Plane;

/// The features of `frame`, found at half its width and height. Each feature point becomes a random one of its four
/// pixels; pixels have the score of their position at half the size.
pub(super) fn features(extractor: &Extractor, frame: &Frame) -> Features {
    let size = frame.size();
    if size.width.min(size.height) < 2 {
        return extractor.features(frame);
    }
    let options = &extractor.options;
    // For about as many feature points: a boundary has half as many pixels, an area a quarter. A small picture needs
    // no smoothing.
    let options = Options {
        interval: options.interval.div_ceil(2),
        interior: (4.0 * options.interior).min(1.0),
        candidates: (4.0 * options.candidates).min(1.0),
        smoothing: options.smoothing.saturating_sub(1),
        entropy_radius: options.entropy_radius.div_ceil(2),
        ..options.clone()
    };
    let found = Extractor::new(&options).features(&halved(frame));
    let mut candidates = Mask::new(size);
    for (x, y) in found.candidates.iter() {
        let bits = rank(options.seed, Purpose::Phase, x, y) as u32;
        candidates.insert(2 * x + (bits & 1), 2 * y + (bits >> 1 & 1));
    }
    let score = found.score.map(|score| doubled(&score, size));
    Features { score, ..candidates.into() }
}

/// `frame` at half its width and height, rounded down: the means of four pixels each.
fn halved(frame: &Frame) -> Frame {
    let size = Size::new(frame.size().width / 2, frame.size().height / 2);
    let mut pixels = vec![[0; 4]; size.pixels()];
    pixels.par_chunks_mut(size.width as usize).enumerate().for_each(|(y, out)| {
        let (upper, _) = frame.row(2 * y as u32).as_chunks::<2>();
        let (lower, _) = frame.row(2 * y as u32 + 1).as_chunks::<2>();
        for ((out, &[a, b]), &[c, d]) in out.iter_mut().zip(upper).zip(lower) {
            *out = mean([a, b, c, d]);
        }
    });
    Frame::known(size, pixels, frame.is_opaque()).expect("a frame's half is no larger than it")
}

/// The mean colour, weighted by alpha.
fn mean(pixels: [Rgba; 4]) -> Rgba {
    let alpha: u32 = pixels.iter().map(|p| u32::from(p[3])).sum();
    if alpha == 0 {
        return [0; 4];
    }
    let channel = |c: usize| {
        let sum: u32 = pixels.iter().map(|p| u32::from(p[c]) * u32::from(p[3])).sum();
        ((sum + alpha / 2) / alpha) as u8
    };
    [channel(0), channel(1), channel(2), alpha.div_ceil(4) as u8]
}

/// A plane of `size` with the values of `half`, each four times; odd last rows and columns repeat.
fn doubled(half: &Plane<f32>, size: Size) -> Plane<f32> {
    let last = half.size();
    let value = |x: u32, y: u32| half.at((x / 2).min(last.width - 1), (y / 2).min(last.height - 1));
    let values = (0..size.height).flat_map(|y| (0..size.width).map(move |x| value(x, y)));
    Plane::new(size, values.collect()).expect("a value for each pixel")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Method;

    fn ramps(size: Size) -> Frame {
        let pixel = |x: u32, y: u32| {
            let inside = (30..70).contains(&x) && (20..50).contains(&y);
            [if inside { 220 } else { 40 }, (x * 2) as u8, (y * 2) as u8, 255]
        };
        let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| pixel(x, y)));
        Frame::new(size, pixels.collect()).expect("a small frame")
    }

    #[test]
    fn half_the_size_finds_about_the_same() {
        for method in Method::ALL {
            for size in [Size::new(101, 77), Size::new(2, 3), Size::new(1, 40)] {
                let options = Options { method, ..Options::default() };
                let extractor = Extractor::new(&options);
                let frame = ramps(size);
                let (full, half) = (extractor.features(&frame), features(&extractor, &frame));
                assert_eq!(half.candidates.size(), size);
                assert_eq!(half.score.is_some(), full.score.is_some(), "{method:?}");
                if size.width > 100 {
                    let (found, expected) = (half.candidates.len(), full.candidates.len());
                    let near = expected / 2..=expected * 2;
                    assert!(near.contains(&found), "{method:?}: {found}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn colours_that_nobody_sees_weigh_nothing() {
        let glass = [0, 255, 0, 0];
        assert_eq!(mean([[200, 100, 50, 255], glass, glass, glass]), [200, 100, 50, 64]);
        assert_eq!(mean([glass; 4]), [0; 4]);
        assert_eq!(mean([[10, 20, 30, 255], [20, 20, 30, 255], [10; 4], [10; 4]])[3], 133);
    }
}
