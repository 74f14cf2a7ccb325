//! The squared error of each triangle, as far as it is known.
//!
//! A triangle's cost leaves out the squares of its pixels, which no change to the mesh changes; to know
//! where the error is large they have to be summed pixel by pixel.

use rayon::prelude::*;

use super::Field;
use super::rest::Rest;
use super::share::Turn;
use super::surface::{Surface, permute};

/// Triangles that one piece of work looks at.
const PACK: usize = 64;

/// Frames until an error is taken anew in any case. Measured on video: no more flicker and as little error as
/// if all were taken anew in every frame.
const TURNS: u32 = 8;

/// How much a triangle's colour has to change, as squared 8-bit steps over its pixels and in least
/// gains, for its error to be taken anew before its turn.
const CHANGED: f64 = 4.0;

/// What is known of a triangle's error.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Infinite where it is not known.
    error: f64,
    /// When that was found, in ticks of the surface's clock.
    asked: u32,
    /// The mean colour that the triangle had then.
    colour: [f32; 4],
}

impl Known {
    const NOTHING: Self = Self { error: f64::INFINITY, asked: 0, colour: [0.0; 4] };
}

/// The squared error of each triangle, and when it was found.
#[derive(Debug, Default)]
pub(super) struct Errors {
    known: Vec<Known>,
    /// Memory for the same in another order.
    spare: Vec<Known>,
    /// Frames since nothing was known.
    frames: u32,
    /// When this frame began.
    begin: u32,
}

impl Errors {
    /// Forgets everything.
    pub(super) fn forget(&mut self) {
        self.known.clear();
    }

    /// The triangles have new numbers; `old` has those that they had.
    pub(super) fn renumber(&mut self, old: &[u32]) {
        if self.known.len() == old.len() {
            permute::<1, _>(&mut self.known, old, &mut self.spare);
        }
    }

    /// A new frame. Those of the frame before are remembered if the mesh was `carried` over from it.
    pub(super) fn begin(&mut self, surface: &Surface, carried: bool) {
        self.begin = surface.clock;
        self.frames = self.frames.wrapping_add(1);
        if !carried || self.known.len() != surface.triangles() {
            self.known.clear();
            self.known.resize(surface.triangles(), Known::NOTHING);
            self.frames = 0;
        }
    }

    /// Brings up to date those of the triangles whose `turn` it is and that may change: exactly, or nearly on
    /// a [running](super::RefineOptions::running) video.
    pub(super) fn update(&mut self, surface: &Surface, rest: &Rest, turn: Turn, field: Field) {
        let (begin, quarter) = (self.begin, self.frames % TURNS);
        let is_due = |t: u32, known: &Known| {
            if !field.running {
                return surface.stamp[t as usize] >= known.asked;
            }
            known.error.is_infinite()
                || surface.mean[t as usize].change_from(&known.colour) >= CHANGED * field.least_gain
                || (known.asked < begin && t % TURNS == quarter)
        };
        self.known.par_chunks_mut(PACK).enumerate().for_each(|(pack, known)| {
            for (t, known) in ((pack * PACK) as u32..).zip(known) {
                let is_wanted = turn.has(t) && rest.allows_triangle(surface, t);
                if is_wanted && is_due(t, known) {
                    *known = Known {
                        error: error_of(surface, t, field),
                        asked: surface.clock,
                        colour: surface.mean[t as usize].colour,
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

/// That of triangle `t`; on a [running](super::RefineOptions::running) video an estimate from one pixel in four,
/// which is enough to tell large errors from small ones.
fn error_of(surface: &Surface, t: u32, Field { rows, frame, running, .. }: Field) -> f64 {
    let corners = surface.corners(t);
    let about = if running { rows.error_about(corners, &surface.mean[t as usize]) } else { None };
    about.unwrap_or_else(|| rows.squares_of(frame, corners) + surface.cost[t as usize].error)
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
        errors.begin(&surface, false);
        for (t, known) in errors.known.iter_mut().enumerate() {
            known.error = (t * t) as f64;
        }
        let mut sums = vec![7.0; 3];
        errors.around_all(&surface, &mut sums);
        let slowly = |v: u32| {
            let mut sum = 0.0;
            surface.around(v, |h| sum += errors.of(h / 3));
            sum
        };
        assert_eq!(sums, (0..surface.at.len() as u32).map(slowly).collect::<Vec<_>>());
    }
}
