//! Edge Drawing: edges as chains of pixels, each one pixel wide (Topal and Akinlar, "Edge Drawing: A combined real-time
//! edge and segment detector", J. Visual Communication and Image Representation 23(6), 2012).
//!
//! Peaks of the gradient are anchors. From the strongest on they are joined: a walk goes along the edge, from each pixel
//! to the neighbour ahead with the largest gradient, and turns where the gradient does.

mod chains;
mod walk;

use super::edges::{about, by_rows, mirrored};
use super::mask::Mask;
use crate::error::{Error, Result};
use crate::plane::Plane;
use walk::Walker;

/// Parameters of the edge detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeDrawing {
    /// Least gradient of an edge pixel: |dx| + |dy| by Prewitt's operator in steps of luma, 1 to 1530. Default 36
    /// (Topal and Akinlar, section 2.2).
    pub gradient_threshold: u16,
    /// By how much an anchor's gradient is above that of the pixels on either side of the edge. Default 8 (Topal and
    /// Akinlar, section 2.3).
    pub anchor_threshold: u16,
    /// Anchors are looked for in every row of this number, and in every column of it elsewhere, 1 to 64. Default 1: all
    /// of them.
    pub scan_interval: u32,
    /// Pixels of the shortest edge. Default 10 (Topal and Akinlar, section 3).
    pub shortest: usize,
}

impl Default for EdgeDrawing {
    fn default() -> Self {
        Self { gradient_threshold: 36, anchor_threshold: 8, scan_interval: 1, shortest: 10 }
    }
}

/// The edges of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// All edge pixels.
    pub edges: Mask,
    /// The edges as chains of pixels, each next to the one before.
    pub chains: Vec<Vec<(u32, u32)>>,
}

/// The way an edge runs through a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Course {
    /// Along the row.
    Across,
    /// Along the column.
    Down,
}

/// Gradient of a pixel, and the way of the edge through it.
type Slope = (u16, Course);

impl EdgeDrawing {
    /// The edges of `luma`, 0..255. None lies on the frame's border.
    ///
    /// # Errors
    /// When a field is out of its range.
    pub fn draw(&self, luma: &Plane<u8>) -> Result<Drawn> {
        if !(1..=1530).contains(&self.gradient_threshold) {
            let given = self.gradient_threshold;
            return Err(Error::out_of_range("gradient-threshold", given, "1 to 1530"));
        }
        if !(1..=64).contains(&self.scan_interval) {
            return Err(Error::out_of_range("scan-interval", self.scan_interval, "1 to 64"));
        }
        let size = luma.size();
        if size.width < 5 || size.height < 5 {
            return Ok(Drawn { edges: Mask::new(size), chains: Vec::new() });
        }
        let slopes = self.slopes(&blurred(luma));
        let anchors = self.anchors(&slopes);
        let mut walker = Walker::new(self, &slopes, &anchors);
        let chains = by_gradient(anchors, &slopes).into_iter().flat_map(|at| walker.from(at));
        let chains = chains.collect();
        Ok(Drawn { edges: walker.edges(), chains })
    }

    /// The gradients by Prewitt's operator. On the border they are below the threshold.
    fn slopes(&self, luma: &Plane<u8>) -> Plane<Slope> {
        let outside = (self.gradient_threshold - 1, Course::Across);
        let last = luma.size().height - 1;
        by_rows(luma.size(), outside, |y, out| {
            if y == 0 || y == last {
                return;
            }
            let rows = about(luma, y);
            let inner = 1..out.len() - 1;
            for x in inner {
                let at = |row: usize, x: usize| i32::from(rows[row][x]);
                let column = |x: usize| at(0, x) + at(1, x) + at(2, x);
                let row = |y: usize| at(y, x - 1) + at(y, x) + at(y, x + 1);
                let dx = (column(x + 1) - column(x - 1)).unsigned_abs();
                let dy = (row(2) - row(0)).unsigned_abs();
                let course = if dx >= dy { Course::Down } else { Course::Across };
                out[x] = ((dx + dy) as u16, course);
            }
        })
    }

    /// The pixels with a larger gradient than those on either side of the edge, row by row.
    fn anchors(&self, slopes: &Plane<Slope>) -> Vec<(u32, u32)> {
        let size = slopes.size();
        let mut anchors = Vec::new();
        for y in 2..size.height - 2 {
            let is_scanned = y.is_multiple_of(self.scan_interval);
            let step = if is_scanned { 1 } else { self.scan_interval };
            let first = if is_scanned { 2 } else { self.scan_interval.max(2) };
            for x in (first..size.width - 2).step_by(step as usize) {
                let (gradient, course) = slopes.at(x, y);
                if gradient < self.gradient_threshold {
                    continue;
                }
                let (one, other) = match course {
                    Course::Down => (slopes.at(x - 1, y), slopes.at(x + 1, y)),
                    Course::Across => (slopes.at(x, y - 1), slopes.at(x, y + 1)),
                };
                let rises = |side: Slope| {
                    i32::from(gradient) - i32::from(side.0) >= i32::from(self.anchor_threshold)
                };
                if rises(one) && rises(other) {
                    anchors.push((x, y));
                }
            }
        }
        anchors
    }
}

/// `anchors` by their gradient, the largest first; of equal ones the last.
fn by_gradient(mut anchors: Vec<(u32, u32)>, slopes: &Plane<Slope>) -> Vec<(u32, u32)> {
    anchors.reverse();
    anchors.sort_by_key(|&(x, y)| std::cmp::Reverse(slopes.at(x, y).0));
    anchors
}

/// `luma` under a Gaussian of 5x5 pixels with standard deviation 1, rounded; the border is mirrored about its pixels.
fn blurred(luma: &Plane<u8>) -> Plane<u8> {
    let size = luma.size();
    let weight = |d: f64| (-d * d / 2.0).exp();
    let total = weight(0.0) + 2.0 * (weight(1.0) + weight(2.0));
    let taps = [0.0, 1.0, 2.0].map(|d| (weight(d) / total) as f32);
    let (xs, ys) = (mirrored(size.width, 2), mirrored(size.height, 2));
    by_rows(size, 0, |y, out| {
        let rows = [0, 1, 2, 3, 4].map(|d| luma.row(ys[y as usize + d] as u32));
        let column = |x: usize| {
            let pair = |d: usize| f32::from(rows[2 - d][x]) + f32::from(rows[2 + d][x]);
            taps[0] * f32::from(rows[2][x]) + taps[1] * pair(1) + taps[2] * pair(2)
        };
        let columns: Vec<f32> = (0..out.len()).map(column).collect();
        for (x, value) in out.iter_mut().enumerate() {
            let at = |d: usize| columns[xs[x + d]];
            let sum = taps[0] * at(2) + taps[1] * (at(1) + at(3)) + taps[2] * (at(0) + at(4));
            *value = (sum + 0.5) as u8;
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feature::canny::tests::{disk, from_centre};
    use crate::geom::Size;

    #[test]
    fn the_edge_of_a_disk_is_one_closed_chain() {
        let Drawn { edges, chains } = EdgeDrawing::default().draw(&disk()).expect("in range");
        assert!((80..110).contains(&edges.len()), "{}", edges.len());
        assert_eq!(chains.len(), 1);
        let near = |a: (u32, u32), b: (u32, u32)| a.0.abs_diff(b.0) <= 1 && a.1.abs_diff(b.1) <= 1;
        assert!(chains[0].windows(2).all(|pair| near(pair[0], pair[1]) && pair[0] != pair[1]));
        let (first, last) = (chains[0][0], chains[0][chains[0].len() - 1]);
        assert!(first.0.abs_diff(last.0) <= 3 && first.1.abs_diff(last.1) <= 3, "closed");
        for (x, y) in edges.iter() {
            let r = from_centre(x, y);
            assert!((r - 15.0).abs() < 2.0, "({x}, {y}) is {r:.1} from the centre");
        }
    }

    #[test]
    fn flat_and_small_planes_have_no_edges() {
        for (width, height) in [(1, 1), (4, 9), (5, 5), (40, 30)] {
            let flat = Plane::filled(Size::new(width, height), 128);
            let drawn = EdgeDrawing::default().draw(&flat).expect("in range");
            assert!(drawn.edges.is_empty() && drawn.chains.is_empty());
        }
    }

    #[test]
    fn fields_out_of_range_are_refused() {
        let flat = Plane::filled(Size::new(4, 4), 0);
        let wrong = [
            EdgeDrawing { gradient_threshold: 0, ..EdgeDrawing::default() },
            EdgeDrawing { gradient_threshold: 1600, ..EdgeDrawing::default() },
            EdgeDrawing { scan_interval: 0, ..EdgeDrawing::default() },
        ];
        assert!(wrong.iter().all(|detector| detector.draw(&flat).is_err()));
    }
}
