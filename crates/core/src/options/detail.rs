//! The detail of a frame: the part of its quality that a time budget decides.

use crate::error::{Error, Result};

/// The detail of a frame: how much work is done for it. It is chosen before the work and decides, with the options,
/// the bytes of the output: the same details give the same frames again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields, rename_all = "kebab-case")
)]
pub struct Detail {
    /// How closely level one looks at the frame. Default [`Look::Full`].
    pub look: Look,
    /// Number of seeds, in per cent of that of the options, 1..=100. Default 100.
    pub seeds: u32,
    /// Number of refinement steps in place of that of the options, 0..=1000, the last perhaps in part; `None` leaves
    /// it to the options. Default `None`.
    pub steps: Option<Steps>,
    /// Mean colours of large triangles are taken from every n-th row, 1..=4. Default 1.
    pub rows: u32,
}

/// A number of refinement steps in eighths. A part of a step visits that share of the vertices, in turns over the
/// frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "f64", into = "f64")
)]
pub struct Steps {
    eighths: u32,
}

/// Parts of a step.
#[doc(hidden)]
pub const EIGHTHS: u32 = 8;

impl Steps {
    /// This number of whole steps.
    pub const fn new(steps: u32) -> Self {
        Self::from_eighths(steps.saturating_mul(EIGHTHS))
    }

    /// This number of eighths of a step.
    pub const fn from_eighths(eighths: u32) -> Self {
        Self { eighths }
    }

    /// All of it in eighths.
    pub const fn eighths(self) -> u32 {
        self.eighths
    }

    /// The whole steps.
    pub const fn whole(self) -> u32 {
        self.eighths / EIGHTHS
    }

    /// The eighths of the step after them, 0..=7.
    pub const fn part(self) -> u32 {
        self.eighths % EIGHTHS
    }
}

impl From<Steps> for f64 {
    fn from(steps: Steps) -> Self {
        f64::from(steps.eighths) / f64::from(EIGHTHS)
    }
}

impl TryFrom<f64> for Steps {
    type Error = String;

    fn try_from(steps: f64) -> std::result::Result<Self, String> {
        let eighths = steps * f64::from(EIGHTHS);
        if eighths.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&eighths) {
            Ok(Self { eighths: eighths as u32 })
        } else {
            Err(format!("steps is {steps}; it counts eighths, from 0"))
        }
    }
}

/// How closely level one looks at a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Look {
    /// At full size, in every frame.
    #[default]
    Full,
    /// If seeds are chosen afresh, at half the width and height.
    Half,
    /// A carried mesh is not moved: motion and cuts are found in the next frame. Otherwise as [`Look::Half`].
    Reuse,
}

impl Detail {
    /// The detail of the options.
    pub const FULL: Self = Self { look: Look::Full, seeds: 100, steps: None, rows: 1 };

    /// The share, 0..=1, of the quality of a frame that gets `asked` steps without a budget: half of it for the steps
    /// (more than requested count as all), three tenths for the seeds, a tenth each for a full look and for all rows.
    /// For reports only.
    pub fn share(&self, asked: u32) -> f64 {
        let steps = match self.steps {
            Some(steps) if steps < Steps::new(asked) => f64::from(steps) / f64::from(asked),
            _ => 1.0,
        };
        let look = if self.look == Look::Full { 1.0 } else { 0.0 };
        // Rounded, so that the whole is 1 and not the float before it.
        let share =
            0.5 * steps + 0.003 * f64::from(self.seeds) + 0.1 * look + 0.1 / f64::from(self.rows);
        (share * 1e6).round() / 1e6
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// Names the first field out of range, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let steps = f64::from(self.steps.unwrap_or_default());
        let ranges = [
            ("seeds", f64::from(self.seeds), 1.0, 100.0),
            ("steps", steps, 0.0, 1000.0),
            ("rows", f64::from(self.rows), 1.0, 4.0),
        ];
        for (name, value, least, most) in ranges {
            if !(least..=most).contains(&value) {
                return Err(Error::out_of_range(name, value, format!("{least} to {most}")));
            }
        }
        Ok(())
    }
}

impl Default for Detail {
    fn default() -> Self {
        Self::FULL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_one_for_all_and_falls_with_every_part() {
        assert_eq!(Detail::FULL.share(2), 1.0);
        assert_eq!(Detail { steps: Some(Steps::new(9)), ..Detail::FULL }.share(2), 1.0);
        assert_eq!(Detail { steps: Some(Steps::default()), ..Detail::FULL }.share(0), 1.0);
        for less in [
            Detail { steps: Some(Steps::from_eighths(15)), ..Detail::FULL },
            Detail { seeds: 70, ..Detail::FULL },
            Detail { rows: 2, ..Detail::FULL },
            Detail { look: Look::Half, ..Detail::FULL },
        ] {
            assert!((0.0..1.0).contains(&less.share(2)), "{less:?}");
        }
    }

    #[test]
    fn wrong_details_are_named() {
        let said = |detail: Detail| detail.validate().expect_err("out of range").to_string();
        assert!(said(Detail { seeds: 0, ..Detail::FULL }).contains("seeds is 0"));
        assert!(said(Detail { rows: 5, ..Detail::FULL }).contains("rows is 5"));
        assert!(
            said(Detail { steps: Some(Steps::new(1001)), ..Detail::FULL })
                .contains("steps is 1001")
        );
        Detail::FULL.validate().expect("sound");
    }

    #[cfg(feature = "serde")]
    #[test]
    fn steps_are_written_as_a_number_and_come_back_exactly() {
        for eighths in 0..100 {
            let steps = Steps::from_eighths(eighths);
            let text = serde_json::to_string(&steps).expect("a number");
            assert_eq!(serde_json::from_str::<Steps>(&text).expect(&text), steps);
            assert_eq!(steps.whole() * EIGHTHS + steps.part(), eighths);
        }
        assert_eq!(serde_json::to_string(&Steps::from_eighths(11)).expect("a number"), "1.375");
        for wrong in ["0.3", "-1", "1e12", "null"] {
            assert!(serde_json::from_str::<Steps>(wrong).is_err(), "{wrong}");
        }
    }
}
