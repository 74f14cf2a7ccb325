//! Line search: how far a vertex goes along its gradient.

use super::cost::Cost;
use super::pass::Pass;
use super::ring::Ring;
use crate::geom::{Point, SUBPIXEL};

/// A vertex whose step fails at this length is deactivated: 1/16 pixel.
pub(super) const MIN_REACH: i32 = SUBPIXEL / 16;

/// The longest step: about half of the distance between seeds at the default number of points.
pub(super) const MAX_REACH: i32 = 6 * SUBPIXEL;

/// A step is not tried when the slope promises less than this share of the minimum gain. Measured on video: below it
/// are half of the trials and one move in ten, those that gain least.
/// Measured by `cargo xtask measure promise`.
pub(super) const PROMISE: f64 = 0.5;

/// Places that a vertex tries along its gradient until one gains enough; in [streams](super::options::Mode::Stream)
/// the second is tried in the next frame. Measured there: second trials are 15 to 18 % of what is tried, and bring 4
/// to 6 % of what is gained; without them there is half a per cent more error.
/// Measured by `cargo xtask measure trials`.
const TRIALS: usize = 2;

/// The shortest and the longest next step, as shares of one that failed.
const MIN_SHRINK: f64 = 0.2;
const MAX_SHRINK: f64 = 0.6;

/// The largest factor by which a step that gains is stretched, and the smallest that is tried. Measured: with twice
/// the largest, at most 1 % more error.
/// Measured by `cargo xtask measure max-stretch`.
const MAX_STRETCH: f64 = 4.0;
const MIN_STRETCH: f64 = 1.3;

/// The half-line along which a vertex may move.
pub(super) struct Line<'a, 'b> {
    /// The triangles around the vertex.
    pub(super) ring: &'a mut Ring,
    pub(super) from: Point,
    pub(super) direction: (f64, f64),
    /// Gain for each pixel of length at its beginning, in squared 8-bit steps.
    pub(super) slope: f64,
    /// Cost of the triangles before the move.
    pub(super) before: Cost,
    pub(super) pass: Pass<'b>,
}

impl Line<'_, '_> {
    /// The point at this distance, in 1/256 pixel.
    fn point(&self, reach: i32) -> Point {
        let part = |share: f64| (share * f64::from(reach)).round() as i32;
        let (x, y) = self.direction;
        Point::new(self.from.x + part(x), self.from.y + part(y))
    }

    /// The gain of a move to `to`; minus infinity if a triangle would fold. Never positive when the squared error
    /// would rise.
    fn gain(&mut self, to: Point) -> f64 {
        let Pass { rows, weight, .. } = self.pass;
        let after = self.ring.try_at(rows, to);
        after.map_or(f64::NEG_INFINITY, |after| self.before.gain(after, weight))
    }

    /// Finds the maximum of the gain by parabolic interpolation: a parabola with the slope at the start goes through
    /// each point that was tried, and its top is the next one. Returns the point, with the ring's spokes for it, and
    /// the length of the next step; 0 if no gain is expected in this direction.
    pub(super) fn search(&mut self, reach: i32) -> (Option<Point>, i32) {
        let mut reach = reach;
        for _ in 0..if self.pass.is_stream() { 1 } else { TRIALS } {
            let to = self.point(reach);
            let gain = self.gain(to);
            let promise = self.slope * f64::from(reach) / f64::from(SUBPIXEL);
            // The top of the parabola, as a share of the reach.
            let top = if gain < promise { 0.5 * promise / (promise - gain) } else { f64::INFINITY };
            if gain > self.pass.min_gain {
                return self.stretch(to, gain, reach, top);
            }
            let expected =
                if gain.is_finite() { 0.5 * promise * top } else { promise * MAX_SHRINK };
            if reach == MIN_REACH || expected <= PROMISE * self.pass.min_gain {
                return (None, 0);
            }
            let shorter = f64::from(reach) * top.clamp(MIN_SHRINK, MAX_SHRINK);
            reach = (shorter as i32).max(MIN_REACH);
        }
        (None, reach)
    }

    /// Goes on from `to`, where the gain is `gain`, to the top of the parabola, if that is further away and better.
    fn stretch(&mut self, to: Point, gain: f64, reach: i32, top: f64) -> (Option<Point>, i32) {
        let longer = (f64::from(reach) * top.min(MAX_STRETCH)) as i32;
        if top < MIN_STRETCH || longer > MAX_REACH {
            return (Some(to), reach);
        }
        self.ring.keep();
        let further = self.point(longer);
        if self.gain(further) > gain {
            return (Some(further), longer);
        }
        self.ring.restore();
        (Some(to), reach)
    }
}
