//! The cost of a triangle, and the gain of a change.

use super::rows::RowSums;
use super::shape::flatness;
use super::sums::{Sums, Total};
use crate::geom::{Point, orient};

/// The cost of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost {
    /// Squared error of its mean colour over its pixels, less the pixels' squares, which do not depend on the mesh.
    /// In squared 8-bit steps.
    pub(super) error: f64,
    /// Its [`flatness`].
    pub(super) shape: f64,
}

impl Cost {
    pub(super) const INFINITE: Self = Self { error: f64::INFINITY, shape: f64::INFINITY };

    /// The cost of `triangle`, whose edges have the sum `sums`; infinite if it is folded or has no area.
    #[inline]
    pub(super) fn of(rows: &RowSums, sums: &Sums, triangle: [Point; 3]) -> Self {
        let [a, b, c] = triangle;
        let doubled = orient(a, b, c);
        if doubled <= 0 {
            return Self::INFINITE;
        }
        Self::sound(rows, sums, doubled, triangle)
    }

    /// The same for a triangle with a positive `orient`.
    #[inline(always)]
    pub(super) fn sound(rows: &RowSums, sums: &Sums, doubled: i64, triangle: [Point; 3]) -> Self {
        let cost = if rows.is_special(doubled, triangle) {
            Self::special(rows, doubled, triangle)
        } else {
            Self::with(&Total::of(sums), doubled, triangle)
        };
        cost.limited(rows, doubled)
    }

    /// The same with what the triangle costs for its size.
    #[inline(always)]
    pub(super) fn limited(self, rows: &RowSums, doubled: i64) -> Self {
        match rows.limits {
            None => self,
            Some(limits) => Self { error: self.error + limits.penalty(doubled), ..self },
        }
    }

    /// The same of a triangle whose cost does not follow from the sums of its edges: it is large, or filled with a
    /// plane of colour.
    #[cold]
    #[inline(never)]
    pub(super) fn special(rows: &RowSums, doubled: i64, triangle: [Point; 3]) -> Self {
        match rows.planes() {
            Some(planes) => {
                let error = -planes.explained(triangle);
                Self { error, shape: flatness(doubled, triangle) }
            }
            None => Self::with(&rows.wide(triangle), doubled, triangle),
        }
    }

    /// The same for a triangle whose pixels have the sums `total`.
    #[inline(always)]
    pub(super) fn with(total: &Total, doubled: i64, triangle: [Point; 3]) -> Self {
        Self { error: -total.explained(), shape: flatness(doubled, triangle) }
    }

    /// Error and shape in one number, `weight` squared 8-bit steps for each unit of flatness.
    pub(super) fn total(self, weight: f64) -> f64 {
        self.error + weight * self.shape
    }

    pub(super) fn scaled(self, by: f64) -> Self {
        Self { error: self.error * by, shape: self.shape * by }
    }

    /// The gain of a change to `after`. Never positive when the squared error would rise.
    pub(super) fn gain(self, after: Self, weight: f64) -> f64 {
        if after.error > self.error {
            self.error - after.error
        } else {
            self.total(weight) - after.total(weight)
        }
    }
}

impl std::ops::Add for Cost {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { error: self.error + o.error, shape: self.shape + o.shape }
    }
}

impl std::iter::Sum for Cost {
    fn sum<I: Iterator<Item = Self>>(costs: I) -> Self {
        costs.fold(Self::default(), |a, b| a + b)
    }
}
