//! The number of points that a picture asks for, by the fall of its error over the number of its parts.
//!
//! A small copy of the picture is divided by straight cuts, each time where that lowers the squared error most. The
//! error falls steeply as long as cuts find contours, and slowly when only texture is left. What is taken is the mean
//! number of parts at which it falls: that of a plain picture is small. The knee of the same curve says as much, but lies
//! anywhere on a flat top, and moves by a fifth with the size of the picture; the mean moves by some per cent. The
//! squared error falls early, with the large shapes, and its root late: the number lies between them. It takes some
//! milliseconds, and as the copy has one size, the same picture has about the same number at any.

use std::collections::BinaryHeap;

use crate::frame::{Frame, Rgba, over};
use crate::geom::Size;

/// Longest side of the copy.
const SIDE: u32 = 256;

/// Parts at the end of the curve.
const PARTS: usize = 3200;

/// Pixels of the copy for each part at least.
const PIXELS_A_PART: usize = 8;

/// Points for each part: the median of 16 stills has the number of the default then. They have from 360 to 2,300.
const POINTS_A_PART: f64 = 4.7;

/// A mean squared error below it counts as none, so that faint grain asks for nothing.
const UNSEEN: f64 = 1.0;

/// The fewest points.
const FEWEST: f64 = 24.0;

/// Pixels for each point at least.
const PIXELS_A_POINT: usize = 24;

/// The number of points that `frame` asks for.
pub(super) fn points(frame: &Frame) -> u32 {
    let most = (frame.size().pixels() / PIXELS_A_POINT).max(1) as f64;
    let errors = errors(&Sums::of(frame));
    let roots: Vec<f64> = errors.iter().map(|error| error.sqrt()).collect();
    let (early, late) = (mean_fall(&errors), mean_fall(&roots));
    (POINTS_A_PART * (early * late).sqrt()).round().max(FEWEST).min(most) as u32
}

/// The mean number of parts at which the `errors` with 1, 2, ... parts fall; 0 where none does.
fn mean_fall(errors: &[f64]) -> f64 {
    let (Some(&first), Some(&last)) = (errors.first(), errors.last()) else { return 0.0 };
    if first <= last {
        return 0.0;
    }
    // An error that goes with the n-th cut is there n times.
    errors.iter().map(|error| (error - last) / (first - last)).sum()
}

/// A rectangle of the copy: its left, upper, right and lower ends.
type Part = [usize; 4];

/// A part with its best cut: what that gains, a number that makes the order definite, and the halves.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    gain: f64,
    number: usize,
    halves: [Part; 2],
}

impl Eq for Cut {}

impl Ord for Cut {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.gain.total_cmp(&other.gain).then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Cut {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// The squared error with 1, 2, ... parts in their mean colours, in squared steps of 0..255 of all pixels and channels,
/// less what cannot be seen.
fn errors(sums: &Sums) -> Vec<f64> {
    let Size { width, height } = sums.size;
    let whole = [0, 0, width as usize, height as usize];
    let pixels = sums.size.pixels();
    let unseen = UNSEEN * 3.0 * pixels as f64;
    let mut error = sums.squares - sums.explained(whole);
    let mut errors = vec![(error - unseen).max(0.0)];
    let mut cuts: BinaryHeap<Cut> = sums.cut(whole, 0).into_iter().collect();
    let parts = PARTS.min(pixels / PIXELS_A_PART);
    while errors.len() < parts {
        // Flat parts have no cut; the error stays as it is.
        if let Some(Cut { gain, halves, .. }) = cuts.pop() {
            error -= gain;
            for (half, i) in halves.into_iter().zip(0..) {
                cuts.extend(sums.cut(half, 2 * errors.len() + i));
            }
        }
        errors.push((error - unseen).max(0.0));
    }
    errors
}

/// Sums of red, green and blue over the pixels above and left of each corner of a pixel.
struct Sums {
    size: Size,
    before: Vec<[u32; 3]>,
    squares: f64,
}

impl Sums {
    /// The sums of a copy of `frame`, over white.
    fn of(frame: &Frame) -> Self {
        let size = shrunk(frame.size());
        let (width, height) = (size.width as usize, size.height as usize);
        let mut before = vec![[0; 3]; (width + 1) * (height + 1)];
        let mut squares = 0u64;
        for y in 0..height {
            let mut row = [0; 3];
            for x in 0..width {
                let colour = mean(frame, size, x as u32, y as u32);
                squares += colour.map(|v| u64::from(v).pow(2)).iter().sum::<u64>();
                let above = before[y * (width + 1) + x + 1];
                for c in 0..3 {
                    row[c] += u32::from(colour[c]);
                    before[(y + 1) * (width + 1) + x + 1][c] = above[c] + row[c];
                }
            }
        }
        Self { size, before, squares: squares as f64 }
    }

    /// |sum|^2 / count of a part.
    fn explained(&self, [left, top, right, bottom]: Part) -> f64 {
        let stride = self.size.width as usize + 1;
        let at = |x: usize, y: usize| self.before[y * stride + x];
        let [a, b, c, d] = [at(left, top), at(right, top), at(left, bottom), at(right, bottom)];
        let sum = |i: usize| f64::from(d[i] + a[i] - b[i] - c[i]);
        let count = ((right - left) * (bottom - top)) as f64;
        (sum(0) * sum(0) + sum(1) * sum(1) + sum(2) * sum(2)) / count
    }

    /// The best cut of a part, if one gains anything.
    fn cut(&self, part: Part, number: usize) -> Option<Cut> {
        let [left, top, right, bottom] = part;
        let upright = (left + 1..right).map(|x| [[left, top, x, bottom], [x, top, right, bottom]]);
        let level = (top + 1..bottom).map(|y| [[left, top, right, y], [left, y, right, bottom]]);
        let gain = |halves: &[Part; 2]| self.explained(halves[0]) + self.explained(halves[1]);
        let scored = upright.chain(level).map(|halves| (gain(&halves), halves));
        let (best, halves) = scored.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        let gain = best - self.explained(part);
        // Less is rounding.
        (gain > 1e-3).then_some(Cut { gain, number, halves })
    }
}

/// The size of the copy.
fn shrunk(size: Size) -> Size {
    let longer = size.width.max(size.height);
    if longer <= SIDE {
        return size;
    }
    let side = |side: u32| {
        let exact = u64::from(side) * u64::from(SIDE);
        ((exact + u64::from(longer) / 2) / u64::from(longer)).max(1) as u32
    };
    Size::new(side(size.width), side(size.height))
}

/// The mean colour of the pixels of `frame` that pixel `(x, y)` of the copy of `size` stands for.
fn mean(frame: &Frame, size: Size, x: u32, y: u32) -> [u8; 3] {
    let range = |i: u32, own: u32, side: u32| {
        let at = |i: u32| (u64::from(i) * u64::from(side) / u64::from(own)) as u32;
        at(i) as usize..at(i + 1) as usize
    };
    let columns = range(x, size.width, frame.size().width);
    let rows = range(y, size.height, frame.size().height);
    let mut sums = [0u64; 3];
    for row in rows.clone() {
        for &pixel in &frame.row(row as u32)[columns.clone()] {
            let [r, g, b, _] = seen(pixel);
            sums[0] += u64::from(r);
            sums[1] += u64::from(g);
            sums[2] += u64::from(b);
        }
    }
    let count = (rows.len() * columns.len()) as u64;
    sums.map(|sum| ((sum + count / 2) / count) as u8)
}

fn seen(pixel: Rgba) -> Rgba {
    if pixel[3] == 255 { pixel } else { over(pixel, [255; 4]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, unit};

    /// `count` disks of all sizes and colours, with a little grain, at any size.
    fn disks(size: Size, count: u32) -> Frame {
        let throw = |i: u32, n: u32| unit(5, Purpose::Noise, i, n);
        let disks: Vec<_> = (0..count)
            .map(|i| (throw(i, 0), 0.66 * throw(i, 1), 0.02 + 0.1 * throw(i, 2), i))
            .collect();
        let longer = f64::from(size.width.max(size.height));
        let pixel = |i: u32| {
            let (x, y) = (f64::from(i % size.width) / longer, f64::from(i / size.width) / longer);
            let inside = |&&(cx, cy, r, _): &&(f64, f64, f64, u32)| (cx - x).hypot(cy - y) < r;
            let top = disks.iter().rev().find(inside).map_or(0, |disk| disk.3 + 1);
            [3, 4, 5].map(|n| (255.0 * throw(top, n)) as u8)
        };
        let pixels = (0..size.pixels() as u32).map(|i| {
            let [r, g, b] = pixel(i);
            [r, g, b, 255]
        });
        Frame::new(size, pixels.collect()).expect("small")
    }

    #[test]
    fn more_content_asks_for_more_points() {
        let size = Size::new(300, 200);
        let found = [0, 3, 30, 300].map(|count| points(&disks(size, count)));
        assert_eq!(found[0], 24);
        assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "{found:?}");
    }

    #[test]
    fn a_picture_asks_for_the_same_at_any_size() {
        let found =
            [256, 511, 1024].map(|side| f64::from(points(&disks(Size::new(side, side), 60))));
        let (least, most) =
            (found.iter().copied().fold(f64::MAX, f64::min), found[0].max(found[1]).max(found[2]));
        assert!(most / least < 1.1, "{found:?}");
    }

    #[test]
    fn grain_and_the_smallest_pictures_ask_for_nothing() {
        let size = Size::new(200, 150);
        let grain = |i: u32| {
            let v = 90 + (unit(2, Purpose::Noise, i, 0) * 2.0) as u8;
            [v, v, v, 255]
        };
        let frame = Frame::new(size, (0..30_000).map(grain).collect()).expect("small");
        assert_eq!(points(&frame), 24);
        for (width, height) in [(1, 1), (3, 1), (1, 5000)] {
            let frame = Frame::filled(Size::new(width, height), [7, 7, 7, 0]).expect("flat");
            assert!((1..=208).contains(&points(&frame)));
        }
    }
}
