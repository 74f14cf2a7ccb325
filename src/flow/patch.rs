//! A patch of a picture looks for its like in another (inverse search: Kroeger et al. 2016, section 2.1;
//! Baker and Matthews, "Lucas-Kanade 20 Years On", 2004).

use crate::geom::Size;
use crate::plane::Plane;

/// Side of a patch in pixels (Kroeger et al., section 3).
pub(super) const PATCH: usize = 8;

/// Where a patch went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// In pixels, rightwards and downwards.
    pub(super) vector: [f32; 2],
    /// Sum of squared differences there, means taken off.
    pub(super) squares: f32,
}

/// A patch of the first picture, its slopes, and what follows from them alone.
pub(super) struct Patch {
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
    pub(super) fn new(a: &Plane<f32>, (x, y): (usize, usize)) -> Self {
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
    pub(super) fn misses(&self, b: &Plane<f32>, [u, v]: [f32; 2], misses: &mut Vec<f32>) -> f32 {
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

    /// The patch's middle pixel.
    pub(super) fn centre(&self) -> (usize, usize) {
        (self.x + self.width / 2, self.y + self.height / 2)
    }

    /// The vector that moves the patch to where `b` looks like it: the best of `tries`, the first of
    /// equally good ones, improved by at most `descents` steps.
    pub(super) fn search(&self, b: &Plane<f32>, tries: &[[f32; 2]], descents: usize) -> Found {
        let mut misses = Vec::with_capacity(PATCH * PATCH);
        let mut start = (f32::INFINITY, [0.0; 2]);
        for &vector in tries {
            let squares = self.misses(b, vector, &mut misses);
            if squares < start.0 {
                start = (squares, vector);
            }
        }
        let Some([xx, xy, yy]) = self.inverse else {
            return Found { vector: start.1, squares: start.0 };
        };
        let mut best = start;
        let mut vector = start.1;
        self.misses(b, vector, &mut misses);
        for _ in 0..descents {
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
        Found { vector: best.1, squares: best.0 }
    }
}

/// The four pixels about a place, and how far it is from the first to the second and the third.
pub(super) fn cell(size: Size, x: f32, y: f32) -> ([usize; 4], f32, f32) {
    let (right, bottom) = (size.width as usize - 1, size.height as usize - 1);
    let (x, y) = (x.clamp(0.0, right as f32), y.clamp(0.0, bottom as f32));
    let (i, j) = (x as usize, y as usize);
    let (i1, j1) = ((i + 1).min(right), (j + 1).min(bottom));
    let row = size.width as usize;
    ([j * row + i, j * row + i1, j1 * row + i, j1 * row + i1], x - i as f32, y - j as f32)
}

pub(super) fn sample(plane: &Plane<f32>, x: f32, y: f32) -> f32 {
    let (corners, fx, fy) = cell(plane.size(), x, y);
    let [a, b, c, d] = corners.map(|i| plane.values()[i]);
    let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
    top + (bottom - top) * fy
}
