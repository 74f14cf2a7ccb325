//! Refinement for triangles that are filled with planes of colour: what it does otherwise than for mean colours.
//!
//! The error of a plane needs more sums than that of a mean, too many to be kept with every edge: a triangle's are
//! taken row by row from [`RowPlanes`] whenever they are wanted. That takes some four times as long as with means, and
//! costs nothing where planes are not asked for.

use crate::parallel::prelude::*;

use super::pass::Pass;
use super::ring::Ring;
use super::rows::RowSums;
use super::surface::{Fan, Surface};
use super::target::Target;
use crate::geom::{Point, SUBPIXEL, Size};
use crate::moments::{Moments, Slopes};
use crate::scan;

/// Running sums along the rows of an opaque frame: of red, green and blue, and of those times their column, wrapping.
#[derive(Debug, Default)]
pub(super) struct RowPlanes {
    width: usize,
    height: u32,
    /// A row has one more than pixels.
    sums: Vec<[u32; 6]>,
}

/// Pixels whose sums, times their distance from the first, fit 32 bits: 4096 x 4095 / 2 x 255 < 2^32.
const LONGEST: usize = 4096;

impl RowPlanes {
    /// Takes the sums of `target`, in the memory of the last one's.
    pub(super) fn load(&mut self, target: &Target) {
        let picture = target.picture();
        let Size { width, height } = picture.size();
        (self.width, self.height) = (width as usize, height);
        self.sums.resize((self.width + 1) * height as usize, [0; 6]);
        let pixels = picture.pixels();
        let rows = self.sums.par_chunks_mut(self.width + 1).zip(pixels.par_chunks(self.width));
        rows.for_each(|(sums, row)| {
            let mut sum = [0u32; 6];
            for (x, (out, pixel)) in (0u32..).zip(sums.iter_mut().zip(row)) {
                *out = sum;
                (0..3).for_each(|c| {
                    let value = u32::from(pixel[c]);
                    sum[c] += value;
                    sum[c + 3] = sum[c + 3].wrapping_add(x * value);
                });
            }
            sums[row.len()] = sum;
        });
    }

    /// The sums over `triangle`, from the pixel `origin` on.
    pub(super) fn moments(&self, triangle: [Point; 3], origin: [i64; 2]) -> Moments {
        let mut all = Moments::default();
        scan::spans(triangle, 0..self.height, |y, columns| {
            let row = &self.sums[y as usize * (self.width + 1)..][..=self.width];
            for first in columns.clone().step_by(LONGEST) {
                let end = columns.end.min(first + LONGEST);
                let (from, to) = (row[first], row[end]);
                let (mut sums, mut turned) = ([0; 3], [0; 3]);
                (0..3).for_each(|c| {
                    let sum = to[c] - from[c];
                    let weighted = to[c + 3].wrapping_sub(from[c + 3]);
                    sums[c] = i64::from(sum);
                    turned[c] = i64::from(weighted.wrapping_sub((first as u32).wrapping_mul(sum)));
                });
                let (x, y) = (first as i64 - origin[0], i64::from(y) - origin[1]);
                all.add_run(x, y, (end - first) as i64, sums, turned);
            }
        });
        all
    }

    /// How much of the squares of the pixels of `triangle` its plane accounts for.
    pub(super) fn explained(&self, triangle: [Point; 3]) -> f64 {
        self.moments(triangle, crate::moments::origin(triangle)).explained()
    }

    fn pixel(&self, x: usize, y: usize) -> [f64; 3] {
        let at = y * (self.width + 1) + x;
        std::array::from_fn(|c| f64::from(self.sums[at + 1][c] - self.sums[at][c]))
    }
}

/// Pixels of an edge for each sample, and samples of the longest edge.
const SPACING: f64 = 2.0;
const MAX_SAMPLES: i32 = 12;

/// As [`super::force::gradient`], of planes of colour.
pub(super) fn gradient(planes: &RowPlanes, centre: Point, ring: &Ring) -> (f64, f64) {
    let from = crate::moments::origin([centre; 3]);
    let plane = |i: usize| {
        let triangle = [centre, ring.ends[i], ring.ends[i + 1]];
        planes.moments(triangle, from).plane(1.0)
    };
    let (mut gx, mut gy) = (0.0, 0.0);
    let mut behind = if ring.closed { plane(ring.len() - 1) } else { None };
    for i in 0..ring.len() {
        let front = plane(i);
        if let (Some(behind), Some(front)) = (&behind, &front) {
            let pull = pull(planes, (centre, ring.ends[i]), from, behind, front);
            let [dx, dy] = between(centre, ring.ends[i]);
            gx -= dy * pull;
            gy += dx * pull;
        }
        behind = front;
    }
    (gx, gy)
}

fn between(a: Point, b: Point) -> [f64; 2] {
    [b.x - a.x, b.y - a.y].map(|v| f64::from(v) / f64::from(SUBPIXEL))
}

/// The mean over a spoke of (|I - behind|^2 - |I - front|^2) (1 - u).
fn pull(
    planes: &RowPlanes,
    (centre, end): (Point, Point),
    from: [i64; 2],
    behind: &Slopes,
    front: &Slopes,
) -> f64 {
    let [dx, dy] = between(centre, end);
    let samples = (((dx * dx + dy * dy).sqrt() / SPACING) as i32).clamp(2, MAX_SAMPLES);
    let last = [planes.width as i32 - 1, planes.height as i32 - 1];
    let mut sum = 0.0;
    for i in 0..samples {
        let along = |from: i32, to: i32, last: i32| {
            let way = i64::from(to - from) * i64::from(2 * i + 1) / i64::from(2 * samples);
            ((from + way as i32) / SUBPIXEL).clamp(0, last)
        };
        let (x, y) = (along(centre.x, end.x, last[0]), along(centre.y, end.y, last[1]));
        let at = [f64::from(x) - from[0] as f64, f64::from(y) - from[1] as f64];
        let pixel = planes.pixel(x as usize, y as usize);
        let (b, f) = (behind.colour(at), front.colour(at));
        let off: f64 = (0..3).map(|c| (f[c] - b[c]) * (2.0 * pixel[c] - f[c] - b[c])).sum();
        sum += f64::from(2 * (samples - i) - 1) * off;
    }
    0.5 * sum / f64::from(samples * samples)
}

/// An upper bound of the rise in squared error when the vertex that the half-edges are `leaving` is removed: the rise
/// when all of its triangles share one plane.
pub(super) fn cost_bound(surface: &Surface, planes: &RowPlanes, leaving: Fan) -> f32 {
    let (mut apart, mut together, mut from) = (0.0, Moments::default(), None);
    leaving.for_each(|h| {
        let triangle = surface.corners(h / 3);
        let from = *from.get_or_insert(crate::moments::origin(triangle));
        apart -= surface.cost[h as usize / 3].error;
        together += planes.moments(triangle, from);
    });
    (apart - together.explained()) as f32
}

/// Whether a pass is for planes, and if so their sums.
pub(super) fn of<'a>(pass: &Pass<'a>) -> Option<&'a RowPlanes> {
    RowSums::planes(pass.rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{picture, scattered};
    use super::super::{RefineOptions, refine};
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::frame::Frame;

    #[test]
    fn sums_by_rows_are_those_of_the_pixels() {
        for (size, seeds) in [(Size::new(160, 120), 60), (Size::new(9000, 7), 3)] {
            let pixel = |i: usize| {
                let [r, g, b, ..] = rank(3, Purpose::Noise, i as u32, 0).to_le_bytes();
                [r | 128, g, b, 255]
            };
            let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small");
            let mut planes = RowPlanes::default();
            planes.load(&Target::Frame(&frame));
            let mesh = scattered(size, seeds);
            for t in 0..mesh.triangles.len() {
                let (triangle, from) = (mesh.triangle(t), [3, 5]);
                assert_eq!(
                    planes.moments(triangle, from),
                    Moments::of(&frame, triangle, from),
                    "{triangle:?}"
                );
            }
        }
    }

    /// The squared error of each triangle's plane.
    fn error(mesh: &crate::mesh::Mesh, frame: &Frame) -> f64 {
        let squares: f64 =
            frame.pixels().iter().flat_map(|p| &p[..3]).map(|&v| f64::from(v).powi(2)).sum();
        let mut planes = RowPlanes::default();
        planes.load(&Target::Frame(frame));
        let each = (0..mesh.triangles.len()).map(|t| planes.explained(mesh.triangle(t)));
        squares - each.sum::<f64>()
    }

    #[test]
    fn a_mesh_that_is_refined_for_planes_has_less_of_their_error() {
        for seed in 0..4 {
            let frame = picture(Size::new(160, 120), seed, 60, true);
            let fresh = scattered(frame.size(), 120);
            let (mut flat, mut sloped) = (fresh.clone(), fresh.clone());
            let options = RefineOptions { steps: 20, ..RefineOptions::best() };
            refine(&mut flat, &frame, &options);
            let refined = refine(&mut sloped, &frame, &RefineOptions { planes: true, ..options });
            assert_eq!(sloped.check(), Ok(()));
            let (before, after) = (error(&fresh, &frame), error(&sloped, &frame));
            assert!((refined.error_before / before - 1.0).abs() < 1e-6);
            assert!((refined.error_after / after - 1.0).abs() < 1e-6);
            assert!(after < error(&flat, &frame), "{after} {}", error(&flat, &frame));
        }
    }
}
