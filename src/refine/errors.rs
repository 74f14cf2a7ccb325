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
                    let squares = field.rows.squares_of(field.frame, surface.corners(t));
                    *known = Known {
                        error: squares + surface.cost[t as usize].error,
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

    /// That of the triangles around vertex `v`, together.
    pub(super) fn around(&self, surface: &Surface, v: u32) -> f64 {
        let mut sum = 0.0;
        surface.around(v, |h| sum += self.of(h / 3));
        sum
    }
}
