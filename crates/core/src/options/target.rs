//! A target likeness for refinement, in place of a number of steps.

use crate::error::{Error, Result};

/// The target likeness of a rendering to its source. Written `psnr:30` (or `30dB`) and `ssim:0.8`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "String", into = "String")
)]
#[non_exhaustive]
pub enum Target {
    /// Peak signal-to-noise ratio over RGB in decibels, above 0 and at most 100.
    Psnr(f64),
    /// Structural similarity of the luma by a uniform window of 7x7, above 0 and below 1.
    Ssim(f64),
}

impl Target {
    /// The target value, in the unit of the measure; more is better in both.
    pub const fn value(self) -> f64 {
        match self {
            Target::Psnr(value) | Target::Ssim(value) => value,
        }
    }

    /// The same measure with another value, as a message puts it.
    pub fn describe(self, value: f64) -> String {
        match self {
            Target::Psnr(_) => format!("PSNR {value:.2} dB"),
            Target::Ssim(_) => format!("SSIM {value:.4}"),
        }
    }

    /// Whether the value is in its range.
    pub(super) fn is_sound(self) -> bool {
        match self {
            Target::Psnr(db) => db > 0.0 && db <= 100.0,
            Target::Ssim(ssim) => ssim > 0.0 && ssim < 1.0,
        }
    }
}

impl std::str::FromStr for Target {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let lower = text.trim().to_ascii_lowercase();
        let number = |text: &str| text.trim().parse::<f64>().ok();
        let parsed = match lower.split_once(':') {
            Some(("psnr", db)) => number(db.strip_suffix("db").unwrap_or(db)).map(Target::Psnr),
            Some(("ssim", value)) => number(value).map(Target::Ssim),
            Some(_) => None,
            None => lower.strip_suffix("db").and_then(number).map(Target::Psnr),
        };
        parsed.ok_or_else(|| {
            Error::options(format!("'{text}' is not a target: write psnr:30 (or 30dB) or ssim:0.8"))
        })
    }
}

impl TryFrom<String> for Target {
    type Error = Error;
    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Target> for String {
    fn from(target: Target) -> String {
        target.to_string()
    }
}

impl std::fmt::Display for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Target::Psnr(db) => write!(f, "psnr:{db}"),
            Target::Ssim(value) => write!(f, "ssim:{value}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_parse_and_print() {
        for (text, target) in [
            ("psnr:30", Target::Psnr(30.0)),
            ("30dB", Target::Psnr(30.0)),
            ("PSNR:28.5 dB", Target::Psnr(28.5)),
            ("ssim:0.8", Target::Ssim(0.8)),
        ] {
            let parsed: Target = text.parse().expect(text);
            assert_eq!(parsed, target);
            assert_eq!(parsed.to_string().parse::<Target>().expect("printed"), target);
        }
        for wrong in ["", "30", "0.8", "mse:20", "psnr:", "ssim:0.8dB", "psnr"] {
            assert!(wrong.parse::<Target>().is_err(), "{wrong}");
        }
    }
}
