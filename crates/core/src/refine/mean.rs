//! The mean colours of triangles.

use super::sums::{NARROW, Total};
use crate::frame::Fill;

/// The mean colour of a triangle and its number of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Mean {
    /// Number of pixels.
    pub(super) count: f32,
    /// Red, green, blue, alpha as in [`Total::mean`]; 0 without pixels.
    pub(super) colour: [f32; 4],
}

impl Mean {
    pub(super) fn of(total: &Total) -> Self {
        Self { count: total.count() as f32, colour: total.mean().unwrap_or_default() }
    }

    /// The change from another `colour`: squared 8-bit steps, summed over all pixels.
    pub(super) fn change_from(&self, colour: &[f32; 4]) -> f64 {
        let squared: f32 = self.colour.iter().zip(colour).map(|(a, b)| (a - b) * (a - b)).sum();
        f64::from(self.count) * f64::from(squared)
    }

    /// As [`Total::fill`]; `None` with too many pixels for the same rounding.
    pub(super) fn fill(&self) -> Option<Fill> {
        // Halves are exact, and all other values are at least 1 / (2 count) >= 2^-14 away from one: colours are exact
        // to 2^-17.
        let rounded = |channel: f32| (channel + 0.5) as u8;
        let [r, g, b, _] = self.colour.map(rounded);
        let fill = Fill { colour: [r, g, b, 255], area: self.count as u32 };
        (self.count < NARROW as f32).then_some(fill)
    }

    /// The colour, if there are pixels.
    pub(super) fn known(&self) -> Option<[f32; 4]> {
        (self.count > 0.0).then_some(self.colour)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Sums near halves above all.
        #[test]
        fn fills_of_means_are_those_of_totals(
            (count, channels) in (0..NARROW as i64 + 1, proptest::array::uniform3(0i64..255)),
            (half, near) in (any::<bool>(), -2i64..=2),
        ) {
            let sum = |c: i64| (c * count + if half { count / 2 } else { 0 } + near).clamp(0, 255 * count);
            let total = Total::new(count, channels.map(sum), 0);
            let expected = (count < NARROW as i64).then(|| total.fill());
            prop_assert_eq!(Mean::of(&total).fill(), expected);
        }
    }
}
