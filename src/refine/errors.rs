//! The squared error of each triangle, as far as it is known.
//!
//! A triangle's cost leaves out the squares of its pixels, which no change to the mesh changes; to know
//! where the error is large they have to be summed pixel by pixel.

use rayon::prelude::*;

use super::Field;
use super::rest::Rest;
use super::share::Turn;
use super::surface::Surface;
use super::thin;

/// Triangles that one piece of work looks at.
const PACK: usize = 64;

/// What is known of a triangle's error.
#[derive(Clone, Copy, Debug)]
struct Known {
    error: f64,
    /// When that was found, in ticks of the surface's clock; 0 for never.
    asked: u32,
}

impl Known {
    const NOTHING: Self = Self { error: f64::INFINITY, asked: 0 };
}

/// The squared error of each triangle, and when it was found.
#[derive(Debug, Default)]
pub(super) struct Errors {
    known: Vec<Known>,
    /// When this frame began.
    begin: u32,
}

impl Errors {
    /// A new frame, of whose errors nothing is known yet.
    pub(super) fn begin(&mut self, surface: &Surface) {
        self.begin = surface.clock;
        self.known.clear();
        self.known.resize(surface.triangles(), Known::NOTHING);
    }

    /// Brings up to date those of the triangles whose `turn` it is and that may change: exactly, or nearly on
    /// a [running](super::RefineOptions::running) video.
    pub(super) fn update(&mut self, surface: &Surface, rest: &Rest, turn: Turn, field: Field) {
        let begin = self.begin;
        self.known.par_chunks_mut(PACK).enumerate().for_each(|(pack, known)| {
            for (t, known) in ((pack * PACK) as u32..).zip(known) {
                let changed = surface.stamp[t as usize];
                if turn.has(t) && changed >= known.asked && rest.allows_triangle(surface, t) {
                    let as_measured = changed <= begin;
                    *known = Known {
                        error: error_of(surface, t, as_measured, field),
                        asked: surface.clock,
                    };
                }
            }
        });
    }

    /// That of triangle `t`.
    pub(super) fn of(&self, t: u32) -> f64 {
        self.known[t as usize].error
    }

    /// Those of the triangles around each vertex, together, written to `sums`.
    pub(super) fn around_all(&self, surface: &Surface, sums: &mut Vec<f64>) {
        sums.clear();
        sums.resize(surface.at.len(), 0.0);
        let (triangles, _) = surface.origin.as_chunks::<3>();
        for (known, corners) in self.known.iter().zip(triangles) {
            corners.iter().for_each(|&v| sums[v as usize] += known.error);
        }
    }
}

/// That of triangle `t`; on a [running](super::RefineOptions::running) video an estimate from every second row,
/// which is enough to tell large errors from small ones. `as_measured` says that it has not changed since.
#[inline]
fn error_of(surface: &Surface, t: u32, as_measured: bool, Field { rows, frame, .. }: Field) -> f64 {
    if rows.has_thin() {
        let pixels = surface.mean[t as usize].count;
        let anew = || thin::error(rows.thin(surface.corners(t)), pixels);
        let about = if as_measured { surface.about[t as usize] } else { anew() };
        if about.is_finite() {
            return about.into();
        }
    }
    rows.squares_of(frame, surface.corners(t)) + surface.cost[t as usize].error
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{SUBPIXEL, Size};
    use crate::triangulate::tests::mesh_of;

    #[test]
    fn errors_around_are_those_of_the_triangles_around() {
        let seeds: Vec<_> =
            (1..40).map(|i| (0.025 * f64::from(i), 0.37 * f64::from(i) % 1.0)).collect();
        let mut surface = Surface::default();
        surface.link(&mesh_of(Size::new(90, 70), &seeds, SUBPIXEL));
        let mut errors = Errors::default();
        errors.begin(&surface);
        for (t, known) in errors.known.iter_mut().enumerate() {
            known.error = (t * t) as f64;
        }
        let mut sums = vec![7.0; 3];
        errors.around_all(&surface, &mut sums);
        let slowly = |v: u32| surface.around(v).map(|h| errors.of(h / 3)).sum::<f64>();
        assert_eq!(sums, (0..surface.at.len() as u32).map(slowly).collect::<Vec<_>>());
    }
}
