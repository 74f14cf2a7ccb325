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
    /// This number for a picture of 1024 x 1024 pixels, and for others too, so that the same picture has the same look
    /// at any size; fewer for sprites, and never more than the paper's share of the pixels (written `1200@1MP`).
    Scaled(u32),
    /// The fewest seeds that reach [`super::Options::error`], found on the first frame; without an error to reach, as
    /// many as the picture asks for, found on the first frame of each shot and followed slowly from there on.
    Auto,
}

impl Points {
    /// The number of seeds for a frame of `size`; at most its pixels. For [`Points::Auto`], before the number is
    /// found, that of the default.
    pub fn target(self, size: Size) -> usize {
        let wanted = match self {
            Points::Count(n) => n as usize,
            Points::Share(share) => (size.pixels() as f64 * share).floor() as usize,
            Points::Scaled(n) => scaled(n, size),
            Points::Auto => Points::default().target(size),
        };
        wanted.min(size.pixels())
    }
}

impl Default for Points {
    fn default() -> Self {
        // Chosen by eye, from 800 to 2,500, on stills and clips of 256 x 256 to 3108 x 1760 pixels: with 800 faces in
        // groups and lettering are lost, with 2,500 a picture on a screen looks like its source.
        Points::Scaled(1200)
    }
}

/// Paper, Table 2: 0.8 % of the pixels are left after level two.
pub(super) const PAPER_SHARE: f64 = 0.008;

/// The area below which numbers shrink faster, so that few points stay fewer than many: there the paper's share is
/// less than the default.
const SPRITE: f64 = 150_000.0;
const SHRINKAGE: f64 = 0.6;

/// `count` of a picture of 1024 x 1024 pixels, for one of `size`. It does not grow with the area: with 18 % more seeds at
/// 4096 pixels than at 512 a busy street differed by 0.070 in its SSIM, both brought to 512 pixels, and without by 0.033.
fn scaled(count: u32, size: Size) -> usize {
    let pixels = size.pixels() as f64;
    let sprite = (pixels / SPRITE).min(1.0).powf(SHRINKAGE);
    let wanted = f64::from(count) * sprite;
    wanted.min(PAPER_SHARE * pixels) as usize
}

impl std::str::FromStr for Points {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            Error::options(format!(
                "'{text}' is not a number of points: write a count (2000), a share (0.8%), a count of a picture of 1024 x 1024 (1200@1MP) or auto"
            ))
        };
        if let Some((count, size)) = text.split_once('@') {
            let count =
                count.trim().parse().ok().filter(|_| size.trim().eq_ignore_ascii_case("1mp"));
            Ok(Points::Scaled(count.ok_or_else(wrong)?))
        } else if let Some(percent) = text.strip_suffix('%') {
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
            Points::Scaled(n) => write!(f, "{n}@1MP"),
            Points::Auto => f.write_str("auto"),
        }
    }
}
