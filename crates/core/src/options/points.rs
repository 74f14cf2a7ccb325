//! How many seeds a frame is to have.

use crate::error::{Error, Result};
use crate::geom::Size;

/// How many seeds a frame is to have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Written", into = "String")
)]
#[non_exhaustive]
pub enum Points {
    /// This number.
    Count(u32),
    /// This share of the pixels, 0..1 (the command line and presets write per cent).
    Share(f64),
    /// The fewest seeds that reach [`super::Options::error`], found on the first frame.
    Auto,
}

impl Points {
    /// The number of seeds for a frame of `size`; at most its pixels. For [`Points::Auto`], before the number is
    /// found, that of the default.
    pub fn target(self, size: Size) -> usize {
        let wanted = match self {
            Points::Count(n) => n as usize,
            Points::Share(share) => (size.pixels() as f64 * share).floor() as usize,
            Points::Auto => Points::default().target(size),
        };
        wanted.min(size.pixels())
    }
}

impl Default for Points {
    fn default() -> Self {
        // Paper, Table 2: 0.8 % of the pixels are left after level two.
        Points::Share(0.008)
    }
}

impl std::str::FromStr for Points {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            Error::options(format!(
                "'{text}' is not a number of points: write a count (2000), a share (0.8%) or auto"
            ))
        };
        if let Some(percent) = text.strip_suffix('%') {
            let percent: f64 = percent.trim().parse().map_err(|_| wrong())?;
            Ok(Points::Share(percent / 100.0))
        } else if text.trim() == "auto" {
            Ok(Points::Auto)
        } else {
            Ok(Points::Count(text.trim().parse().map_err(|_| wrong())?))
        }
    }
}

/// The forms in a preset: a count needs no quotes.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "a count (2000), a share (\"0.8%\") or \"auto\"")]
enum Written {
    Count(u32),
    Text(String),
}

#[cfg(feature = "serde")]
impl TryFrom<Written> for Points {
    type Error = Error;
    fn try_from(written: Written) -> Result<Self> {
        match written {
            Written::Count(count) => Ok(Points::Count(count)),
            Written::Text(text) => text.parse(),
        }
    }
}

impl From<Points> for String {
    fn from(points: Points) -> String {
        points.to_string()
    }
}

impl std::fmt::Display for Points {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Points::Count(n) => write!(f, "{n}"),
            // Six digits hide the binary rounding of percent / 100 * 100.
            Points::Share(share) => write!(f, "{}%", (share * 1e8).round() / 1e6),
            Points::Auto => f.write_str("auto"),
        }
    }
}
