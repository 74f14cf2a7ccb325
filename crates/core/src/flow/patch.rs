//! Finds the match of a patch in another picture (inverse search: Kroeger et al. 2016, section 2.1; Baker and
//! Matthews, "Lucas-Kanade 20 Years On", 2004).

use crate::geom::Size;
use crate::plane::Plane;
use crate::simd::dispatch;

/// Side of a patch in pixels (Kroeger et al., section 3).
pub(super) const PATCH: usize = 8;

/// Pixels of a whole patch.
const PIXELS: usize = PATCH * PATCH;

/// More than any coordinate.
const FAR: f32 = 65536.0;

/// The motion of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// In pixels, rightwards and downwards.
    pub(super) vector: [f32; 2],
    /// Sum of squared differences there, after means are subtracted.
    pub(super) squares: f32,
    /// The same for the first of the tries.
    pub(super) first: f32,
}

/// The pixels of a patch. Pictures narrower or lower than a patch have smaller ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

impl Window {
    /// The window at `place` in a picture of `size`.
    pub(super) fn new(size: Size, (x, y): (usize, usize)) -> Self {
        let (width, height) = (size.width as usize, size.height as usize);
        Self { x, y, width: PATCH.min(width), height: PATCH.min(height) }
    }

    /// Number of pixels; what lies behind them in an array of [`PIXELS`] is 0.
    #[inline(always)]
    pub(super) fn count(self) -> usize {
        self.width * self.height
    }

    /// The pixels of `plane` in the window after it is moved, row by row. The border's pixels are repeated outside.
    #[inline(always)]
    pub(super) fn look(self, plane: &Plane<f32>, [u, v]: [f32; 2]) -> [f32; PIXELS] {
        if self.count() < PIXELS {
            return self.look_narrowly(plane, [u, v]);
        }
        // Far outside all pixels repeat the border.
        let near = |v: f32| v.clamp(-FAR, FAR);
        let (x, y) = (near(self.x as f32 + u), near(self.y as f32 + v));
        let (left, top) = (x.floor(), y.floor());
        // All pixels of a complete window have the same offsets between those of `plane`.
        let (fx, fy) = (x - left, y - top);
        let (left, top) = (left as i32, top as i32);
        let size = plane.size();
        let (right, bottom) = (size.width as i32 - 1, size.height as i32 - 1);
        let inside = left >= 0 && left + PATCH as i32 <= right;
        let mut across = [[0.0; PATCH]; PATCH + 1];
        for (y, across) in (top..).zip(&mut across) {
            let row = plane.row(y.clamp(0, bottom) as u32);
            let mut reached = [0.0; PATCH + 1];
            if inside {
                reached.copy_from_slice(&row[left as usize..][..=PATCH]);
            } else {
                for (x, reached) in (left..).zip(&mut reached) {
                    *reached = row[x.clamp(0, right) as usize];
                }
            }
            for x in 0..PATCH {
                across[x] = reached[x] + (reached[x + 1] - reached[x]) * fx;
            }
        }
        let mut out = [0.0; PIXELS];
        for y in 0..PATCH {
            for x in 0..PATCH {
                out[y * PATCH + x] = across[y][x] + (across[y + 1][x] - across[y][x]) * fy;
            }
        }
        out
    }

    /// [`Window::look`] in a picture that is narrower or lower than a patch.
    #[cold]
    fn look_narrowly(self, plane: &Plane<f32>, [u, v]: [f32; 2]) -> [f32; PIXELS] {
        let mut out = [0.0; PIXELS];
        for j in 0..self.height {
            for i in 0..self.width {
                let (x, y) = ((self.x + i) as f32 + u, (self.y + j) as f32 + v);
                out[j * self.width + i] = sample(plane, x, y);
            }
        }
        out
    }
}

/// A patch of the first picture, with its gradient and what depends on these alone.
pub(super) struct Patch {
    window: Window,
    /// Values less their mean, row by row.
    values: [f32; PIXELS],
    /// Slopes to the right and downwards.
    slopes: [[f32; PIXELS]; 2],
    /// Inverse of the sums of products of slopes: xx, xy, yy. `None` without texture.
    inverse: Option<[f32; 3]>,
}

impl Patch {
    /// The patch at `place` of `a`.
    pub(super) fn new(a: &Plane<f32>, place: (usize, usize)) -> Self {
        dispatch(
            #[inline(always)]
            || Self::cut(a, place),
        )
    }

    #[inline(always)]
    fn cut(a: &Plane<f32>, place: (usize, usize)) -> Self {
        let window = Window::new(a.size(), place);
        let mut values = window.look(a, [0.0; 2]);
        let mean = sum(&values) / window.count() as f32;
        values[..window.count()].iter_mut().for_each(|v| *v -= mean);
        let slopes = slopes(a, window);
        let product = |i: usize, j: usize| dot(&slopes[i], &slopes[j]);
        let (xx, xy, yy) = (product(0, 0), product(0, 1), product(1, 1));
        // A gradient in one direction leaves the other undetermined: the search must not start.
        let det = xx * yy - xy * xy;
        let inverse =
            (det > 1e-3 * (xx + yy).powi(2) && det > 1.0).then(|| [yy / det, -xy / det, xx / det]);
        Self { window, values, slopes, inverse }
    }

    /// The difference of each pixel to the moved patch in `b`, less the mean; and the sum of the squares.
    #[inline(always)]
    fn misses(&self, b: &Plane<f32>, vector: [f32; 2]) -> ([f32; PIXELS], f32) {
        let mut misses = self.window.look(b, vector);
        let count = self.window.count();
        let mean = sum(&misses) / count as f32;
        let held = misses[..count].iter_mut().zip(&self.values);
        held.for_each(|(miss, value)| *miss -= mean + value);
        let squares = dot(&misses, &misses);
        (misses, squares)
    }

    /// The patch's middle pixel.
    pub(super) fn centre(&self) -> (usize, usize) {
        (self.window.x + self.window.width / 2, self.window.y + self.window.height / 2)
    }

    /// The vector that moves the patch to its match in `b`: the best of `tries`, the first of equally good ones,
    /// improved by at most `descents` steps.
    pub(super) fn search(&self, b: &Plane<f32>, tries: &[[f32; 2]], descents: usize) -> Found {
        dispatch(
            #[inline(always)]
            || self.descend(b, tries, descents),
        )
    }

    #[inline(always)]
    fn descend(&self, b: &Plane<f32>, tries: &[[f32; 2]], descents: usize) -> Found {
        let mut misses = [0.0; PIXELS];
        let mut start = (f32::INFINITY, [0.0; 2]);
        let mut first = f32::INFINITY;
        for (i, &vector) in tries.iter().enumerate() {
            if tries[..i].contains(&vector) {
                continue;
            }
            let (trial, squares) = self.misses(b, vector);
            if i == 0 {
                first = squares;
            }
            if squares < start.0 {
                start = (squares, vector);
                misses = trial;
            }
        }
        let mut best = start;
        let mut vector = start.1;
        let steps = if self.inverse.is_some() { descents } else { 0 };
        let [xx, xy, yy] = self.inverse.unwrap_or_default();
        for _ in 0..steps {
            let (gx, gy) = (dot(&misses, &self.slopes[0]), dot(&misses, &self.slopes[1]));
            let step = [xx * gx + xy * gy, xy * gx + yy * gy];
            vector = [vector[0] - step[0], vector[1] - step[1]];
            let away = [vector[0] - start.1[0], vector[1] - start.1[1]];
            // Kroeger et al.: a patch that moves further than its own size is lost.
            if away[0] * away[0] + away[1] * away[1] > (PATCH * PATCH) as f32 {
                break;
            }
            let (now, squares) = self.misses(b, vector);
            misses = now;
            if squares < best.0 {
                best = (squares, vector);
            }
            if step[0] * step[0] + step[1] * step[1] < 0.01 * 0.01 || squares > 1.5 * best.0 {
                break;
            }
        }
        Found { vector: best.1, squares: best.0, first }
    }
}

/// Slopes to the right and downwards at the window's pixels.
#[inline(always)]
fn slopes(a: &Plane<f32>, window: Window) -> [[f32; PIXELS]; 2] {
    let (right, bottom) = (a.size().width as usize - 1, a.size().height as usize - 1);
    let row = |y: usize| a.row(y as u32);
    let mut slopes = [[0.0; PIXELS]; 2];
    for j in 0..window.height {
        let y = window.y + j;
        let (above, here, below) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(bottom)));
        for i in 0..window.width {
            let (at, x) = (j * window.width + i, window.x + i);
            slopes[0][at] = (here[(x + 1).min(right)] - here[x.saturating_sub(1)]) / 2.0;
            slopes[1][at] = (below[x] - above[x]) / 2.0;
        }
    }
    slopes
}

/// Sums in as many columns as a vector register may have, so that the order is the same on every machine.
#[inline(always)]
pub(super) fn dot(a: &[f32; PIXELS], b: &[f32; PIXELS]) -> f32 {
    let mut columns = [0.0; PATCH];
    for y in 0..PATCH {
        for x in 0..PATCH {
            columns[x] += a[y * PATCH + x] * b[y * PATCH + x];
        }
    }
    columns.iter().sum()
}

#[inline(always)]
pub(super) fn sum(values: &[f32; PIXELS]) -> f32 {
    dot(values, &[1.0; PIXELS])
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_window_sees_what_each_of_its_pixels_samples(
            (width, height) in (1u32..30, 1u32..30),
            (x, y) in (0usize..22, 0usize..22),
            vector in proptest::array::uniform2(prop_oneof![-40f32..40.0, Just(-1e9), Just(3e38)]),
            values in proptest::collection::vec(0f32..255.0, 900),
        ) {
            let size = Size::new(width, height);
            let plane = Plane::new(size, values[..size.pixels()].to_vec()).expect("a small plane");
            let last = |side: u32| (side as usize).saturating_sub(PATCH);
            let place = (x.min(last(width)), y.min(last(height)));
            let window = Window::new(size, place);
            let (seen, slow) = (window.look(&plane, vector), window.look_narrowly(&plane, vector));
            for (seen, slow) in seen.iter().zip(slow) {
                prop_assert!((seen - slow).abs() < 0.01, "{seen} {slow}");
            }
        }
    }
}
