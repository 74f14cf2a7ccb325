//! Dense optical flow by inverse search on a pyramid (Kroeger, Timofte, Dai and Van Gool, "Fast
//! Optical Flow using Dense Inverse Search", ECCV 2016), without its variational refinement; a median
//! over neighbouring vectors stands in for it (Sun, Roth and Black, "Secrets of Optical Flow
//! Estimation and Their Principles", CVPR 2010).

pub mod motion;
mod patch;
pub mod small;

use crate::parallel::prelude::*;

use crate::error::{Error, Result};
use crate::geom::Size;
use crate::plane::Plane;
use patch::{PATCH, Patch, cell, sample};

/// Distance of neighbouring patches in pixels (`OpenCV`'s `DISOpticalFlow`, preset medium).
const STRIDE: usize = 3;

/// Most steps of descent for each patch and level (preset medium has 25; most patches end sooner).
const DESCENTS: usize = 20;

/// Shortest side of the smallest picture of the pyramid.
const LEAST_SIDE: u32 = 24;

/// The motion of each pixel: `[x, y]` in pixels, rightwards and downwards.
pub type Flow = Plane<[f32; 2]>;

/// The flow from one picture to another: pixel p of `from` is at p + flow(p) in `to`.
///
/// # Errors
/// When the pictures differ in size.
pub fn flow(from: &Plane<u8>, to: &Plane<u8>) -> Result<Flow> {
    if from.size() != to.size() {
        return Err(Error::SizeMismatch(from.size(), to.size()));
    }
    if from.size().pixels() == 0 {
        return Ok(Plane::filled(from.size(), [0.0; 2]));
    }
    let mut found: Option<Flow> = None;
    for (a, b) in pyramid(from).iter().zip(&pyramid(to)).rev() {
        let before = match found {
            Some(coarser) => enlarge(&coarser, a.size()),
            None => Plane::filled(a.size(), [0.0; 2]),
        };
        found = Some(refine(a, b, &before));
    }
    Ok(found.expect("a pyramid has at least the picture itself"))
}

/// The picture, and its halves for as long as they are not too small.
pub(crate) fn pyramid(luma: &Plane<u8>) -> Vec<Plane<f32>> {
    let mut levels = vec![luma.map(f32::from)];
    while let Some(last) = levels.last()
        && last.size().width.min(last.size().height) >= 2 * LEAST_SIDE
    {
        levels.push(halve(last, Vec::new()));
    }
    levels
}

/// Means of 2x2 pixels, in `memory`; an odd last row or column is left out.
fn halve(plane: &Plane<f32>, memory: Vec<f32>) -> Plane<f32> {
    let size = Size::new(plane.size().width / 2, plane.size().height / 2);
    let mut out = Plane::in_memory(size, memory, 0.0);
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
pub(crate) fn between<const N: usize>(plane: &Plane<[f32; N]>, x: f32, y: f32) -> [f32; N] {
    let (corners, fx, fy) = cell(plane.size(), x, y);
    let [a, b, c, d] = corners.map(|i| plane.values()[i]);
    std::array::from_fn(|n| {
        let (top, bottom) = (a[n] + (b[n] - a[n]) * fx, c[n] + (d[n] - c[n]) * fx);
        top + (bottom - top) * fy
    })
}

/// The first pixels of the patches along a side: every `stride`, and the last that fits.
pub(crate) fn starts(side: u32, stride: usize) -> Vec<usize> {
    let last = (side as usize).saturating_sub(PATCH);
    let mut starts: Vec<usize> = (0..last).step_by(stride).collect();
    starts.push(last);
    starts
}

/// One level: patches search from the result of the coarser level, then each pixel mixes the vectors of the patches
/// that hold it.
fn refine(a: &Plane<f32>, b: &Plane<f32>, before: &Flow) -> Flow {
    let (columns, rows) = (starts(a.size().width, STRIDE), starts(a.size().height, STRIDE));
    let count = columns.len() * rows.len();
    let search = |i: usize| {
        let place = (columns[i % columns.len()], rows[i / columns.len()]);
        let patch = Patch::new(a, place);
        patch.search(b, &tries(&patch, before), DESCENTS).vector
    };
    let found: Vec<[f32; 2]> = (0..count).into_par_iter().map(search).collect();
    let mut mixed = Plane::filled(a.size(), [0.0; 2]);
    let lines = mixed.values_mut().par_chunks_exact_mut(a.size().width as usize);
    lines.enumerate().for_each(|(y, line)| {
        // The patches that hold a pixel: those that start at it or less than a side before.
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

/// Start vectors of a patch: those of the coarser level at its centre and one patch away on four sides; and zero.
fn tries(patch: &Patch, before: &Flow) -> [[f32; 2]; 6] {
    let Size { width, height } = before.size();
    let (x, y) = patch.centre();
    let near = |dx: usize, dy: usize| {
        let (x, y) =
            ((x + dx * PATCH).saturating_sub(PATCH), (y + dy * PATCH).saturating_sub(PATCH));
        before.at((x as u32).min(width - 1), (y as u32).min(height - 1))
    };
    [near(1, 1), near(0, 1), near(2, 1), near(1, 0), near(1, 2), [0.0; 2]]
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
        for (width, height) in [(0, 0), (1, 1), (3, 9), (8, 8), (200, 2)] {
            let size = Size::new(width, height);
            let found = flow(&waves(size, 0.0, 0.0), &waves(size, 1.0, 0.0)).expect("one size");
            assert!(found.values().iter().flatten().all(|v| v.is_finite()), "{size}");
        }
    }
}
