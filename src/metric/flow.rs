//! Dense optical flow by inverse search on a pyramid (Kroeger, Timofte, Dai and Van Gool, "Fast
//! Optical Flow using Dense Inverse Search", ECCV 2016), without its variational refinement; a median
//! over neighbouring vectors stands in for it (Sun, Roth and Black, "Secrets of Optical Flow
//! Estimation and Their Principles", CVPR 2010).

use rayon::prelude::*;

use super::same_size;
use crate::error::Result;
use crate::feature::plane::Plane;
use crate::geom::Size;

/// Side of a patch in pixels (Kroeger et al., section 3).
const PATCH: usize = 8;

/// Distance of neighbouring patches in pixels (Kroeger et al., section 3: overlap 0.4 and more).
const STRIDE: usize = 3;

/// Steps of descent for each patch and level (`OpenCV`, preset medium: 25; most end sooner).
const DESCENTS: usize = 20;

/// Shortest side of the smallest picture of the pyramid.
const LEAST_SIDE: u32 = 24;

/// Where each pixel goes: `[x, y]` in pixels, rightwards and downwards.
pub type Flow = Plane<[f32; 2]>;

/// The flow from one picture to another: what stands at a pixel p of `from` stands at p + flow(p) in
/// `to`.
///
/// # Errors
/// When the pictures differ in size.
pub fn flow(from: &Plane<u8>, to: &Plane<u8>) -> Result<Flow> {
    same_size(from.size(), to.size())?;
    let (from, to) = (pyramid(from), pyramid(to));
    let mut levels = from.iter().zip(&to).rev();
    let Some((a, b)) = levels.next() else {
        return Ok(Plane::filled(Size::new(0, 0), [0.0; 2]));
    };
    let mut flow = refine(a, b, &Plane::filled(a.size(), [0.0; 2]));
    for (a, b) in levels {
        flow = refine(a, b, &enlarge(&flow, a.size()));
    }
    Ok(flow)
}

/// The picture, and its halves for as long as they are not too small.
fn pyramid(luma: &Plane<u8>) -> Vec<Plane<f32>> {
    let mut levels = vec![luma.map(f32::from)];
    while let Some(last) = levels.last()
        && last.size().width.min(last.size().height) >= 2 * LEAST_SIDE
    {
        levels.push(halve(last));
    }
    levels
}

/// Means of 2x2 pixels; an odd last row or column is left out.
fn halve(plane: &Plane<f32>) -> Plane<f32> {
    let size = Size::new(plane.size().width / 2, plane.size().height / 2);
    let mut out = Plane::filled(size, 0.0);
    for (y, row) in (0..).zip(out.values_mut().chunks_exact_mut(size.width as usize)) {
        let (above, below) = (plane.row(2 * y), plane.row(2 * y + 1));
        for (x, value) in row.iter_mut().enumerate() {
            *value = (above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1]) / 4.0;
        }
    }
    out
}

/// The flow of a half-size picture, nearest vectors twice as long.
fn enlarge(flow: &Flow, size: Size) -> Flow {
    let last = Size::new(flow.size().width - 1, flow.size().height - 1);
    let mut out = Plane::filled(size, [0.0; 2]);
    for (y, row) in (0..).zip(out.values_mut().chunks_exact_mut(size.width as usize)) {
        for (x, value) in (0..).zip(row) {
            *value = flow.at((x / 2).min(last.width), (y / 2).min(last.height)).map(|v| 2.0 * v);
        }
    }
    out
}

/// The value of `plane` between pixels, bilinear; beyond the border that of the border.
pub(super) fn between<const N: usize>(plane: &Plane<[f32; N]>, x: f32, y: f32) -> [f32; N] {
    let (corners, fx, fy) = cell(plane.size(), x, y);
    let [a, b, c, d] = corners.map(|i| plane.values()[i]);
    std::array::from_fn(|n| {
        let (top, bottom) = (a[n] + (b[n] - a[n]) * fx, c[n] + (d[n] - c[n]) * fx);
        top + (bottom - top) * fy
    })
}

/// The four pixels about a place, and how far it is from the first to the second and the third.
fn cell(size: Size, x: f32, y: f32) -> ([usize; 4], f32, f32) {
    let (right, bottom) = (size.width as usize - 1, size.height as usize - 1);
    let (x, y) = (x.clamp(0.0, right as f32), y.clamp(0.0, bottom as f32));
    let (i, j) = (x as usize, y as usize);
    let (i1, j1) = ((i + 1).min(right), (j + 1).min(bottom));
    let row = size.width as usize;
    ([j * row + i, j * row + i1, j1 * row + i, j1 * row + i1], x - i as f32, y - j as f32)
}

fn sample(plane: &Plane<f32>, x: f32, y: f32) -> f32 {
    let (corners, fx, fy) = cell(plane.size(), x, y);
    let [a, b, c, d] = corners.map(|i| plane.values()[i]);
    let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
    top + (bottom - top) * fy
}

/// The first pixels of the patches along a side: every [`STRIDE`], and the last that fits.
fn starts(side: u32) -> Vec<usize> {
    let last = (side as usize).saturating_sub(PATCH);
    let mut starts: Vec<usize> = (0..last).step_by(STRIDE).collect();
    starts.push(last);
    starts
}

/// One level: patches search from where the level before has them, then pixels mix the vectors of the
/// patches that hold them.
fn refine(a: &Plane<f32>, b: &Plane<f32>, before: &Flow) -> Flow {
    let (columns, rows) = (starts(a.size().width), starts(a.size().height));
    let count = columns.len() * rows.len();
    let search = |i: usize| {
        let place = (columns[i % columns.len()], rows[i / columns.len()]);
        Patch::new(a, place).search(b, before)
    };
    let found: Vec<[f32; 2]> = (0..count).into_par_iter().map(search).collect();
    let mut mixed = Plane::filled(a.size(), [0.0; 2]);
    let lines = mixed.values_mut().par_chunks_exact_mut(a.size().width as usize);
    lines.enumerate().for_each(|(y, line)| {
        let holds = |start: usize, at: usize| start <= at && at < start + PATCH;
        let span = |starts: &[usize], at: usize| {
            let first = starts.partition_point(|&s| s + PATCH <= at);
            first..starts.partition_point(|&s| s <= at)
        };
        let vertical = span(&rows, y);
        for (x, value) in line.iter_mut().enumerate() {
            let here = a.at(x as u32, y as u32);
            let (mut sum, mut weights) = ([0.0; 2], 0.0);
            for j in vertical.clone() {
                for i in span(&columns, x) {
                    debug_assert!(holds(columns[i], x) && holds(rows[j], y));
                    let [u, v] = found[j * columns.len() + i];
                    let miss = sample(b, x as f32 + u, y as f32 + v) - here;
                    // Kroeger et al., equation 3.
                    let weight = 1.0 / miss.abs().max(1.0);
                    sum = [sum[0] + weight * u, sum[1] + weight * v];
                    weights += weight;
                }
            }
            *value = sum.map(|s| s / weights);
        }
    });
    median(&mixed)
}

/// Each component's median over 3x3 pixels.
fn median(flow: &Flow) -> Flow {
    let Size { width, height } = flow.size();
    let mut out = flow.clone();
    let lines = out.values_mut().par_chunks_exact_mut(width as usize);
    (0..height).into_par_iter().zip(lines).for_each(|(y, line)| {
        let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| flow.row(y));
        for (x, value) in line.iter_mut().enumerate() {
            let columns = [x.saturating_sub(1), x, (x + 1).min(width as usize - 1)];
            for (n, component) in value.iter_mut().enumerate() {
                let mut around: [f32; 9] = std::array::from_fn(|i| rows[i / 3][columns[i % 3]][n]);
                *component = *around.select_nth_unstable_by(4, f32::total_cmp).1;
            }
        }
    });
    out
}

/// A patch of the first picture, its slopes, and what follows from them alone.
struct Patch {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
    /// Value less the patch's mean, and slopes to the right and downwards, for each pixel.
    pixels: Vec<[f32; 3]>,
    /// Inverse of the sums of products of slopes: xx, xy, yy. `None` without texture.
    inverse: Option<[f32; 3]>,
}

impl Patch {
    fn new(a: &Plane<f32>, (x, y): (usize, usize)) -> Self {
        let Size { width, height } = a.size();
        let (right, bottom) = (width as usize - 1, height as usize - 1);
        let (width, height) = (PATCH.min(right + 1), PATCH.min(bottom + 1));
        let at = |x: usize, y: usize| a.row(y as u32)[x];
        let mut pixels = Vec::with_capacity(width * height);
        for v in y..y + height {
            for u in x..x + width {
                let dx = at((u + 1).min(right), v) - at(u.saturating_sub(1), v);
                let dy = at(u, (v + 1).min(bottom)) - at(u, v.saturating_sub(1));
                pixels.push([at(u, v), dx / 2.0, dy / 2.0]);
            }
        }
        let mean = pixels.iter().map(|p| p[0]).sum::<f32>() / pixels.len() as f32;
        pixels.iter_mut().for_each(|p| p[0] -= mean);
        let product = |i: usize, j: usize| pixels.iter().map(|p| p[i] * p[j]).sum::<f32>();
        let (xx, xy, yy) = (product(1, 1), product(1, 2), product(2, 2));
        // Slopes in one direction only leave the other one open: the search must stay as it began.
        let det = xx * yy - xy * xy;
        let inverse =
            (det > 1e-3 * (xx + yy).powi(2) && det > 1.0).then(|| [yy / det, -xy / det, xx / det]);
        Self { x, y, width, height, pixels, inverse }
    }

    /// What each pixel misses in `b` when the patch moves by `flow`, the mean taken off.
    fn misses(&self, b: &Plane<f32>, [u, v]: [f32; 2], misses: &mut Vec<f32>) -> f32 {
        misses.clear();
        for j in 0..self.height {
            for i in 0..self.width {
                misses.push(sample(b, (self.x + i) as f32 + u, (self.y + j) as f32 + v));
            }
        }
        let mean = misses.iter().sum::<f32>() / misses.len() as f32;
        let mut squares = 0.0;
        for (miss, pixel) in misses.iter_mut().zip(&self.pixels) {
            *miss -= mean + pixel[0];
            squares += *miss * *miss;
        }
        squares
    }

    /// The vector that moves the patch to where `b` looks like it: the best of those that the level
    /// before has about here, improved by descent.
    fn search(&self, b: &Plane<f32>, before: &Flow) -> [f32; 2] {
        let mut misses = Vec::with_capacity(PATCH * PATCH);
        let Size { width, height } = before.size();
        let near = |dx: usize, dy: usize| {
            // The centre and the four places a patch away, where neighbours may know better.
            let x = (self.x + self.width / 2 + dx * PATCH).saturating_sub(PATCH);
            let y = (self.y + self.height / 2 + dy * PATCH).saturating_sub(PATCH);
            before.at((x as u32).min(width - 1), (y as u32).min(height - 1))
        };
        let tries = [near(1, 1), near(0, 1), near(2, 1), near(1, 0), near(1, 2), [0.0; 2]];
        let mut start = (f32::INFINITY, [0.0; 2]);
        for vector in tries {
            let squares = self.misses(b, vector, &mut misses);
            if squares < start.0 {
                start = (squares, vector);
            }
        }
        let Some([xx, xy, yy]) = self.inverse else {
            return start.1;
        };
        let mut best = start;
        let mut vector = start.1;
        self.misses(b, vector, &mut misses);
        for _ in 0..DESCENTS {
            let (mut gx, mut gy) = (0.0, 0.0);
            for (miss, pixel) in misses.iter().zip(&self.pixels) {
                gx += miss * pixel[1];
                gy += miss * pixel[2];
            }
            let step = [xx * gx + xy * gy, xy * gx + yy * gy];
            vector = [vector[0] - step[0], vector[1] - step[1]];
            let away = [vector[0] - start.1[0], vector[1] - start.1[1]];
            // Kroeger et al.: a patch that runs further than its own size has lost its way.
            if away[0].hypot(away[1]) > PATCH as f32 {
                break;
            }
            let squares = self.misses(b, vector, &mut misses);
            if squares < best.0 {
                best = (squares, vector);
            }
            if step[0].hypot(step[1]) < 0.01 || squares > 1.5 * best.0 {
                break;
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A soft pattern without repetition, moved by `(u, v)`.
    fn waves(size: Size, u: f64, v: f64) -> Plane<u8> {
        let value = |i: u32| {
            let (x, y) = (f64::from(i % size.width) - u, f64::from(i / size.width) - v);
            let wave = (x * 0.31).sin() * (y * 0.23).cos()
                + (x * 0.11 + y * 0.17).sin()
                + ((x * x + y * y) * 0.0007).cos();
            (128.0 + 40.0 * wave).round() as u8
        };
        Plane::new(size, (0..size.pixels() as u32).map(value).collect()).expect("as many as pixels")
    }

    /// Mean end-point error away from the border.
    fn error(flow: &Flow, right: [f32; 2]) -> f32 {
        let Size { width, height } = flow.size();
        let inner = (20..height - 20).flat_map(|y| (20..width - 20).map(move |x| (x, y)));
        let ends = inner.map(|(x, y)| {
            let [u, v] = flow.at(x, y);
            (u - right[0]).hypot(v - right[1])
        });
        let ends: Vec<f32> = ends.collect();
        ends.iter().sum::<f32>() / ends.len() as f32
    }

    #[test]
    fn a_moved_pattern_is_followed_to_a_fraction_of_a_pixel() {
        let size = Size::new(160, 120);
        for (u, v) in [(0.0, 0.0), (0.5, -0.25), (3.0, 2.0), (-5.5, 4.0)] {
            let found = flow(&waves(size, 0.0, 0.0), &waves(size, u, v)).expect("one size");
            let off = error(&found, [u as f32, v as f32]);
            assert!(off < 0.1, "moved by ({u}, {v}): {off} pixels off on average");
        }
    }

    #[test]
    fn nothing_moves_between_equal_pictures() {
        let picture = waves(Size::new(70, 50), 0.0, 0.0);
        let found = flow(&picture, &picture).expect("one size");
        assert!(found.values().iter().all(|v| *v == [0.0; 2]));
        let flat = Plane::filled(Size::new(70, 50), 9);
        let found = flow(&flat, &flat).expect("one size");
        assert!(found.values().iter().all(|v| *v == [0.0; 2]));
    }

    #[test]
    fn the_smallest_pictures_have_a_flow() {
        for (width, height) in [(1, 1), (3, 9), (8, 8), (200, 2)] {
            let size = Size::new(width, height);
            let found = flow(&waves(size, 0.0, 0.0), &waves(size, 1.0, 0.0)).expect("one size");
            assert!(found.values().iter().flatten().all(|v| v.is_finite()), "{size}");
        }
    }
}
