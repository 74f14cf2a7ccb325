//! The force on a vertex: how the squared error changes as it moves (DESIGN, level three; Lawonn and
//! Guenther, "Stylized Image Triangulation", 2019).

use super::ring::Ring;
use super::sums::RowSums;
use crate::geom::{Point, SUBPIXEL, Size};

/// Pixels of edge for each sample; edges are about 10 pixels long.
const SPACING: f32 = 2.0;

/// Samples on the longest edge.
const MOST: i32 = 8;

/// From 1/256 to 1/65536 pixel.
const FINER: i32 = 65536 / SUBPIXEL;

/// The gradient of the squared error with respect to the place of the vertex at `centre`, whose
/// surroundings are `ring` with its present spokes: squared 8-bit steps for each pixel of way.
///
/// Moving an edge by d along its normal hands its pixels from the triangle in front to the one behind,
/// so the gradient is the integral along every spoke of (|I - behind|^2 - |I - front|^2) (1 - u) times
/// the normal, u from 0 at the vertex to 1 at the far end. That the means change too is of second
/// order: a mean is where the error is least.
pub(super) fn gradient(rows: &RowSums, size: Size, centre: Point, ring: &Ring) -> (f64, f64) {
    let (mut gx, mut gy) = (0.0f32, 0.0f32);
    let mean = |i: usize| ring.total(rows, i, centre).mean();
    let mut behind = if ring.closed { mean(ring.len() - 1) } else { None };
    for i in 0..ring.len() {
        let front = mean(i);
        // A spoke on the frame's border has nothing behind it and does not move.
        if let (Some(behind), Some(front)) = (behind, front) {
            let pull = pull(rows, size, centre, ring.ends[i], behind, front);
            let (dx, dy) = pixels_between(centre, ring.ends[i]);
            // (-dy, dx) is the normal into triangle i, as long as the spoke: it carries ds.
            gx -= dy * pull;
            gy += dx * pull;
        }
        behind = front;
    }
    (f64::from(gx), f64::from(gy))
}

fn pixels_between(a: Point, b: Point) -> (f32, f32) {
    let scale = 1.0 / SUBPIXEL as f32;
    ((b.x - a.x) as f32 * scale, (b.y - a.y) as f32 * scale)
}

/// The mean over the spoke of (|I - behind|^2 - |I - front|^2) (1 - u).
fn pull(rows: &RowSums, size: Size, from: Point, to: Point, behind: [f32; 4], front: [f32; 4]) -> f32 {
    let (dx, dy) = pixels_between(from, to);
    let samples = (((dx * dx + dy * dy).sqrt() / SPACING) as i32).clamp(2, MOST);
    // 16.16 fixed point: coordinates of 2^22 fit.
    let step = [(to.x - from.x) * FINER / samples, (to.y - from.y) * FINER / samples];
    let mut at = [from.x * FINER + step[0] / 2, from.y * FINER + step[1] / 2];
    let last = [size.width as usize - 1, size.height as usize - 1];
    let mut sum = [0u32; 4];
    for i in 0..samples {
        let [x, y] = [0, 1].map(|k| ((at[k] >> 16) as usize).min(last[k]));
        // 1 - u in units of 1 / (2 samples).
        let weight = (2 * (samples - i) - 1) as u32;
        for (sum, value) in sum.iter_mut().zip(rows.pixel(x, y)) {
            *sum += value * weight;
        }
        at = [at[0] + step[0], at[1] + step[1]];
    }
    // The weights add up to samples^2. |I - b|^2 - |I - f|^2 = (f - b) . (2 I - f - b)
    let share = 1.0 / (samples * samples) as f32;
    let mut pull = 0.0;
    for c in 0..4 {
        let mean = sum[c] as f32 * share;
        pull += (front[c] - behind[c]) * (2.0 * mean - front[c] - behind[c]);
    }
    pull * 0.5
}
