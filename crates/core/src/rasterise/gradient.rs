//! Triangles that are filled with a plane of colour.

use crate::parallel::prelude::*;

use super::each_triangle_with;
use crate::frame::{Fill, Frame, Rgba};
use crate::geom::Point;
use crate::mesh::Mesh;
use crate::moments::{Moments, Slopes, origin};
use crate::scan::{
    self,
    runs::{BAND, Bands},
};
use crate::simd::dispatch;

/// A plane of colour over a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gradient {
    /// The pixel that `base` is the colour of.
    origin: [i64; 2],
    /// In 1/65536 of an 8-bit step, plus a half.
    base: [i64; 3],
    across: [i64; 3],
    down: [i64; 3],
}

/// Binary digits of a colour below the 8-bit step.
const SHIFT: u32 = 16;
const ONE: f64 = (1 << SHIFT) as f64;

impl Gradient {
    /// Of one colour.
    pub(super) fn flat([r, g, b, _]: Rgba) -> Self {
        let base = [r, g, b].map(|v| (i64::from(v) << SHIFT) + (1 << (SHIFT - 1)));
        Self { origin: [0; 2], base, across: [0; 3], down: [0; 3] }
    }

    /// Of `slopes`, whose places count from `origin`.
    pub(super) fn of(slopes: &Slopes, origin: [i64; 2]) -> Self {
        let fixed = |v: [f64; 3]| v.map(|v| (v * ONE).round() as i64);
        let base = fixed(slopes.colour([0.0; 2])).map(|v| v + (1 << (SHIFT - 1)));
        Self { origin, base, across: fixed(slopes.across), down: fixed(slopes.down) }
    }

    /// The colour of a pixel.
    pub(super) fn at(&self, x: i64, y: i64) -> [u8; 3] {
        std::array::from_fn(|c| byte(self.value(c, x, y)))
    }

    #[inline(always)]
    fn value(&self, c: usize, x: i64, y: i64) -> i64 {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        self.base[c] + dx * self.across[c] + dy * self.down[c]
    }

    /// Shifted so that it has the colour `to` where it had `from`.
    pub(super) fn shift(&mut self, from: Rgba, to: Rgba) {
        (0..3).for_each(|c| {
            self.base[c] += (i64::from(to[c]) - i64::from(from[c])) << SHIFT;
        });
    }

    /// Fills `row`, pixels of row `y` from column `x` on.
    #[inline(always)]
    fn fill(&self, row: &mut [Rgba], x: i64, y: i64, alpha: u8) {
        let [mut r, mut g, mut b] = [0, 1, 2].map(|c| self.value(c, x, y));
        for pixel in row {
            *pixel = [byte(r), byte(g), byte(b), alpha];
            r += self.across[0];
            g += self.across[1];
            b += self.across[2];
        }
    }
}

#[inline(always)]
fn byte(value: i64) -> u8 {
    (value >> SHIFT).clamp(0, 255) as u8
}

/// The plane of each triangle that is nearest to its pixels, where they are seen; `fills` have its colour at their
/// centre.
pub(super) fn planes(mesh: &Mesh, frame: &Frame, fills: &[Fill]) -> Vec<Gradient> {
    let _ = frame.pixels();
    let unit = if frame.is_opaque() { 1.0 } else { 255.0 };
    each_triangle_with(mesh, Gradient::flat([0; 4]), |t, triangle| {
        let origin = origin(triangle);
        let slopes = Moments::of(frame, triangle, origin).plane(unit);
        slopes.map_or(Gradient::flat(fills[t].colour), |s| Gradient::of(&s, origin))
    })
}

/// Fills the triangles of `mesh` with `gradients`, one each, on `pixels`, which are of its size; alpha is that of
/// `fills`. What has alpha 0 becomes transparent black.
pub(super) fn paint(mesh: &Mesh, fills: &[Fill], gradients: &[Gradient], pixels: &mut [Rgba]) {
    let (width, height) = (mesh.size.width as usize, mesh.size.height);
    let mut bands = Bands::default();
    bands.sort(height, (0..mesh.triangles.len()).map(|t| (mesh.triangle(t), t)));
    pixels.par_chunks_mut(width * BAND as usize).enumerate().for_each(|(band, pixels)| {
        let first = band as u32 * BAND;
        let rows = first..(first + BAND).min(height);
        dispatch(
            #[inline(always)]
            || {
                for &(triangle, t) in bands.of(band) {
                    let (gradient, alpha) = (&gradients[t], fills[t].colour[3]);
                    scan::spans(triangle, rows.clone(), |y, columns| {
                        let start = (y - first) as usize * width + columns.start;
                        let row = &mut pixels[start..start + columns.len()];
                        if alpha == 0 {
                            row.fill([0; 4]);
                        } else {
                            gradient.fill(row, columns.start as i64, i64::from(y), alpha);
                        }
                    });
                }
            },
        );
    });
}

/// Colours that a painted mesh holds, about: those at the corners and at the centre of its triangles.
pub(super) fn fills(mesh: &Mesh, fills: &[Fill], gradients: &[Gradient]) -> Vec<Fill> {
    let each = fills.iter().zip(gradients).enumerate().filter(|(_, (fill, _))| fill.area > 0);
    let around = each.flat_map(|(t, (fill, gradient))| {
        let at = |p: Point, q: Point| {
            // Half way to the centre.
            let (x, y) = Point::new((p.x + q.x) / 2, (p.y + q.y) / 2).pixel(mesh.size);
            let [r, g, b] = gradient.at(x.into(), y.into());
            let alpha = fill.colour[3];
            let colour = if alpha == 0 { [0; 4] } else { [r, g, b, alpha] };
            Fill { colour, area: fill.area.div_ceil(4) }
        };
        let triangle = mesh.triangle(t);
        let centre = super::centroid(triangle);
        [at(triangle[0], centre), at(triangle[1], centre), at(triangle[2], centre)]
    });
    around.collect()
}

#[cfg(test)]
mod tests {
    use super::super::{means, tests::noise};
    use super::*;
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    fn painted(frame: &Frame, seeds: &[Point]) -> (Vec<Rgba>, Vec<Rgba>) {
        let mesh = triangulate(frame.size(), seeds).expect("distinct seeds");
        let fills = means(&mesh, frame);
        let planes = planes(&mesh, frame, &fills);
        let mut pixels = vec![[1, 2, 3, 4]; frame.size().pixels()];
        paint(&mesh, &fills, &planes, &mut pixels);
        let flat: Vec<_> = fills.iter().map(|fill| Gradient::flat(fill.colour)).collect();
        let mut plain = pixels.clone();
        paint(&mesh, &fills, &flat, &mut plain);
        (pixels, plain)
    }

    fn error(frame: &Frame, pixels: &[Rgba]) -> u64 {
        let both = frame.pixels().as_flattened().iter().zip(pixels.as_flattened());
        both.map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum()
    }

    #[test]
    fn every_pixel_is_painted_and_a_plane_of_colour_is_met() {
        let size = Size::new(90, 150);
        let seeds = [Point::pixel_centre(30, 20), Point::pixel_centre(70, 90), Point::new(0, 9000)];
        let pixel = |i: usize| {
            let (x, y) = (i % 90, i / 90);
            [(2 * x) as u8, (y + x / 2) as u8, (250 - y) as u8, 255]
        };
        let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small");
        let (pixels, flat) = painted(&frame, &seeds);
        for (a, b) in frame.pixels().iter().zip(&pixels) {
            assert!((0..4).all(|c| a[c].abs_diff(b[c]) <= 1), "{a:?} {b:?}");
        }
        assert!(error(&frame, &flat) > 100 * error(&frame, &pixels));
        for seed in 0..5 {
            let frame = noise(size, seed, true);
            let (pixels, flat) = painted(&frame, &seeds);
            assert!(error(&frame, &pixels) <= error(&frame, &flat) + size.pixels() as u64);
        }
    }

    #[test]
    fn transparent_triangles_stay_transparent() {
        let size = Size::new(40, 40);
        let pixel = |i: usize| if i % 40 < 20 { [0, 0, 0, 0] } else { [200, 9, 9, 255] };
        let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small");
        let middle = [Point::new(20 * 256, 0), Point::new(20 * 256, 40 * 256)];
        let (pixels, _) = painted(&frame, &middle);
        assert_eq!(pixels, frame.pixels());
    }
}
