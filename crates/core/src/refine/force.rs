//! The force on a vertex: the gradient of the squared error (Lawonn and Guenther, "Stylized Image Triangulation",
//! 2019).

use super::pass::Pass;
use super::planes;
use super::ring::Ring;
use crate::geom::{Point, SUBPIXEL};

/// Distance of samples along an edge in pixels, and that in [thorough](super::options::Mode::Thorough) mode. Edges
/// are about 10 pixels long.
/// Measured by `cargo xtask measure edge-samples`.
const SPACING: f32 = 3.0;
const CLOSE_SPACING: f32 = 2.0;

/// Samples on the longest edge.
const MAX_SAMPLES: i32 = 8;

/// The gradient of the squared error with respect to the position of the vertex at `centre`, which is surrounded by
/// `ring`, in squared 8-bit steps for each pixel of motion. `mean` is the mean colour of each triangle of the ring,
/// if it has pixels.
///
/// An edge that moves by d along its normal takes pixels from the triangle in front to the one behind. The gradient
/// is therefore the integral along every spoke of (|I - behind|^2 - |I - front|^2) (1 - u) times the normal, with u
/// from 0 at the vertex to 1 at the far end. The change of the means is of second order, because the mean minimises
/// the error.
pub(super) fn gradient(
    pass: Pass,
    centre: Point,
    ring: &Ring,
    mean: impl Fn(usize) -> Option<[f32; 4]>,
) -> (f64, f64) {
    if let Some(planes) = planes::of(&pass) {
        return planes::gradient(planes, centre, ring);
    }
    let (mut gx, mut gy) = (0.0f32, 0.0f32);
    let mut behind = if ring.closed { mean(ring.len() - 1) } else { None };
    for i in 0..ring.len() {
        let front = mean(i);
        // A spoke on the frame's border has no triangle behind it and does not move.
        if let (Some(behind), Some(front)) = (behind, front) {
            let pull = pull(pass, centre, ring.ends[i], behind, front);
            let (dx, dy) = pixels_between(centre, ring.ends[i]);
            // (-dy, dx) is the normal into triangle i, of the length of the spoke: it contains ds.
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
fn pull(pass: Pass, from: Point, to: Point, behind: [f32; 4], front: [f32; 4]) -> f32 {
    let (dx, dy) = pixels_between(from, to);
    let spacing = if pass.is_thorough() { CLOSE_SPACING } else { SPACING };
    let samples = (((dx * dx + dy * dy).sqrt() / spacing) as i32).clamp(2, MAX_SAMPLES);
    let sums = pass.rows.sample(from, to, samples);
    // Weights (1 - u) add up to samples^2 there. |I - b|^2 - |I - f|^2 = (f - b) . (2 I - f - b)
    let share = 1.0 / (samples * samples) as f32;
    let part = |c: usize| (front[c] - behind[c]) * (2.0 * share * sums[c] - front[c] - behind[c]);
    0.5 * (part(0) + part(1) + part(2) + part(3))
}
