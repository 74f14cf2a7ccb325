//! Colours at the vertices of a mesh, mixed in between, that are nearest to the pixels (least squares).

use super::each_triangle_with;
use super::gradient::Gradient;
use crate::frame::{Fill, Frame};
use crate::geom::{Point, SUBPIXEL};
use crate::mesh::Mesh;
use crate::moments::{Moments, Slopes, origin};

/// Steps of the solver. After them the error is within 0.1 % of that of the solution.
const STEPS: usize = 24;

/// How strongly colours hold to the mean around their vertex, as a share of the pixels there: against overshoot next
/// to contours, and for vertices that no pixel is near to.
const HOLD: f64 = 0.01;

/// What a triangle adds to the equations: of its three corners each with each, and each with the colours.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    mixed: [[f64; 3]; 3],
    colours: [[f64; 3]; 3],
}

/// The gradients of the triangles of `mesh`, whose mean colours and areas are `fills`.
pub(super) fn gradients(mesh: &Mesh, frame: &Frame, fills: &[Fill]) -> Vec<Gradient> {
    let _ = frame.pixels();
    let parts = each_triangle_with(mesh, Part::default(), |_, triangle| Part::of(frame, triangle));
    let colours = solve(mesh, &parts, fills);
    let corners = mesh.triangles.iter().enumerate();
    corners.map(|(t, ids)| between(mesh.triangle(t), ids.map(|v| colours[v as usize]))).collect()
}

/// The weights of the corners at a place as planes: value at the origin, change across, change down.
fn weights(triangle: [Point; 3], from: [i64; 2]) -> [[f64; 3]; 3] {
    // Pixel centres are half a pixel in.
    let at = |p: Point| [p.x, p.y].map(|v| f64::from(v) / f64::from(SUBPIXEL)).map(|v| v - 0.5);
    let [a, b, c] = triangle.map(|p| {
        let [x, y] = at(p);
        [x - from[0] as f64, y - from[1] as f64]
    });
    let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    [(b, c), (c, a), (a, b)].map(|(p, q)| {
        let (across, down) = ((p[1] - q[1]) / doubled, (q[0] - p[0]) / doubled);
        [-(across * p[0] + down * p[1]), across, down]
    })
}

impl Part {
    fn of(frame: &Frame, triangle: [Point; 3]) -> Self {
        let from = origin(triangle);
        let moments = Moments::of(frame, triangle, from);
        if moments.weight <= 0 {
            return Self::default();
        }
        let Moments { weight, at, spread, colour, turned } = moments;
        let [n, x, y] = [weight, at[0], at[1]].map(|sum| sum as f64);
        let [xx, xy, yy] = spread.map(|sum| sum as f64);
        let sums = [[n, x, y], [x, xx, xy], [y, xy, yy]];
        let weights = weights(triangle, from);
        let mut part = Self::default();
        (0..3).for_each(|i| {
            (0..3).for_each(|j| {
                for (p, row) in sums.iter().enumerate() {
                    for (q, sum) in row.iter().enumerate() {
                        part.mixed[i][j] += weights[i][p] * sum * weights[j][q];
                    }
                }
            });
            (0..3).for_each(|c| {
                let sums = [colour[c], turned[0][c], turned[1][c]];
                part.colours[i][c] = (0..3).map(|p| weights[i][p] * sums[p] as f64).sum();
            });
        });
        part
    }
}

/// The colour of each vertex: conjugate gradients from the mean colour around it on, with the diagonal as
/// preconditioner.
fn solve(mesh: &Mesh, parts: &[Part], fills: &[Fill]) -> Vec<[f64; 3]> {
    let vertices = mesh.vertices.len();
    let (mut held, mut weight) = (vec![[0.0; 3]; vertices], vec![0.0; vertices]);
    for (ids, fill) in mesh.triangles.iter().zip(fills) {
        // One that covers no pixel has a colour, too.
        let w = if fill.colour[3] == 0 { 0.0 } else { f64::from(fill.area) + 1e-3 };
        for &v in ids {
            weight[v as usize] += w;
            (0..3).for_each(|c| held[v as usize][c] += w * f64::from(fill.colour[c]));
        }
    }
    for (held, &weight) in held.iter_mut().zip(&weight) {
        held.iter_mut().for_each(|sum| *sum /= f64::max(weight, 1e-9));
    }
    let mut diagonal = vec![0.0; vertices];
    let mut residual = vec![[0.0; 3]; vertices];
    for (ids, part) in mesh.triangles.iter().zip(parts) {
        for (i, &v) in ids.iter().enumerate() {
            diagonal[v as usize] += part.mixed[i][i];
            for c in 0..3 {
                let known: f64 = (0..3).map(|j| part.mixed[i][j] * held[ids[j] as usize][c]).sum();
                residual[v as usize][c] += part.colours[i][c] - known;
            }
        }
    }
    // The hold is proportional to the diagonal, which is positive then.
    let hold: Vec<f64> = diagonal.iter().map(|d| HOLD * d + 1e-6).collect();
    diagonal.iter_mut().zip(&hold).for_each(|(d, hold)| *d += hold);
    let mut colours = held;
    let ahead = |residual: &[[f64; 3]]| -> Vec<[f64; 3]> {
        residual.iter().zip(&diagonal).map(|(r, d)| r.map(|v| v / d)).collect()
    };
    let dot = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        let mut sum = [0.0; 3];
        for (a, b) in a.iter().zip(b) {
            (0..3).for_each(|c| sum[c] += a[c] * b[c]);
        }
        sum
    };
    let mut scaled = ahead(&residual);
    let mut way = scaled.clone();
    let mut energy = dot(&residual, &scaled);
    for _ in 0..STEPS {
        let mut turned: Vec<[f64; 3]> =
            way.iter().zip(&hold).map(|(way, hold)| way.map(|v| v * hold)).collect();
        for (ids, part) in mesh.triangles.iter().zip(parts) {
            for (i, &v) in ids.iter().enumerate() {
                for (j, &w) in ids.iter().enumerate() {
                    let (mixed, way) = (part.mixed[i][j], &way[w as usize]);
                    (0..3).for_each(|c| turned[v as usize][c] += mixed * way[c]);
                }
            }
        }
        let along = dot(&way, &turned);
        let step: [f64; 3] =
            std::array::from_fn(|c| if along[c] > 0.0 { energy[c] / along[c] } else { 0.0 });
        for (v, way) in way.iter().enumerate() {
            (0..3).for_each(|c| {
                colours[v][c] += step[c] * way[c];
                residual[v][c] -= step[c] * turned[v][c];
            });
        }
        scaled = ahead(&residual);
        let next = dot(&residual, &scaled);
        let keep: [f64; 3] =
            std::array::from_fn(|c| if energy[c] > 0.0 { next[c] / energy[c] } else { 0.0 });
        for (way, scaled) in way.iter_mut().zip(&scaled) {
            (0..3).for_each(|c| way[c] = scaled[c] + keep[c] * way[c]);
        }
        energy = next;
    }
    colours.iter().map(|colour| colour.map(|v| v.clamp(0.0, 255.0))).collect()
}

/// The gradient that has `colours` at the corners.
fn between(triangle: [Point; 3], colours: [[f64; 3]; 3]) -> Gradient {
    let from = origin(triangle);
    let weights = weights(triangle, from);
    let mixed = |p: usize| -> [f64; 3] {
        std::array::from_fn(|c| (0..3).map(|i| weights[i][p] * colours[i][c]).sum())
    };
    let slopes = Slopes { at: [0.0; 2], mean: mixed(0), across: mixed(1), down: mixed(2) };
    Gradient::of(&slopes, from)
}

#[cfg(test)]
mod tests {
    use super::super::{means, tests::noise};
    use super::*;
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    #[test]
    fn colours_go_on_over_edges_and_a_plane_of_colour_is_met() {
        let size = Size::new(90, 70);
        let seeds = [Point::pixel_centre(30, 20), Point::pixel_centre(70, 50), Point::new(0, 9000)];
        let mesh = triangulate(size, &seeds).expect("three seeds");
        let pixel = |i: usize| [(i % 90 * 2) as u8, (i / 90 * 3) as u8, 90, 255];
        let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small");
        for (frame, most) in [(frame, 4), (noise(size, 3, true), 255)] {
            let fills = means(&mesh, &frame);
            let gradients = gradients(&mesh, &frame, &fills);
            let mut at = vec![None; mesh.vertices.len()];
            for (t, ids) in mesh.triangles.iter().enumerate() {
                for &v in ids {
                    let (x, y) = mesh.vertices[v as usize].pixel(size);
                    let colour = gradients[t].at(x.into(), y.into());
                    let known = *at[v as usize].get_or_insert(colour);
                    // A vertex lies within a pixel of the centre that is asked for.
                    assert!(
                        (0..3).all(|c| known[c].abs_diff(colour[c]) <= 8),
                        "{known:?} {colour:?}"
                    );
                }
            }
            let mut pixels = vec![[0; 4]; size.pixels()];
            super::super::gradient::paint(&mesh, &fills, &gradients, &mut pixels);
            for (a, b) in frame.pixels().iter().zip(&pixels) {
                assert!((0..3).all(|c| a[c].abs_diff(b[c]) <= most), "{a:?} {b:?}");
            }
        }
    }
}
