//! Where a picture gets more and smaller facets, as options name it.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::geom::Size;

/// Where a picture gets more and smaller facets.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "String", into = "String")
)]
#[non_exhaustive]
pub enum Focus {
    /// Where it stands out (spectral residual), found in every frame.
    Saliency,
    /// On faces, found in stills and in every fourth frame of a clip; where there are none, as by saliency. Needs the
    /// feature `faces`.
    Faces,
    /// Around a place.
    Spot(Spot),
    /// Where a mask is light.
    Mask(FocusMask),
}

/// A place and a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// From the left, a share of the width where it is one.
    pub x: Length,
    /// From the top, a share of the height where it is one.
    pub y: Length,
    /// A share of the shorter side where it is one.
    pub radius: Length,
}

/// A length in pixels (`3`, `3px`), or a share of a side (`0.3%`).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "WrittenLength", into = "WrittenLength")
)]
pub enum Length {
    /// Pixels.
    Pixels(f64),
    /// A share, 1 being all of it.
    Share(f64),
}

/// A mask, stretched to the frame's size.
#[derive(Clone, Debug, PartialEq)]
pub struct FocusMask {
    /// What it is called: the name of its file.
    pub name: String,
    /// Its size; 0 x 0 as long as it has not been loaded.
    pub size: Size,
    /// For each pixel how much it matters, 0 to 255.
    pub weights: Arc<[u8]>,
}

impl Length {
    /// In pixels, where `whole` is what it is a share of.
    pub fn of(self, whole: u32) -> f64 {
        match self {
            Self::Pixels(pixels) => pixels,
            Self::Share(share) => share * f64::from(whole),
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (number, share) = match text.strip_suffix('%') {
            Some(number) => (number, true),
            None => (text.strip_suffix("px").unwrap_or(text), false),
        };
        let number: f64 = number.trim().parse().ok().filter(|v: &f64| v.is_finite())?;
        Some(if share {
            // As exact as it is written: 0.14 / 100 is not 0.0014.
            Self::Share(format!("{number}e-2").parse().ok()?)
        } else {
            Self::Pixels(number)
        })
    }
}

impl std::fmt::Display for Length {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Pixels(pixels) => write!(f, "{pixels}"),
            // Six digits hide the binary rounding of per cent.
            Self::Share(share) => write!(f, "{}%", (share * 1e8).round() / 1e6),
        }
    }
}

impl std::str::FromStr for Length {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        Self::parse(text).ok_or_else(|| {
            Error::options(format!(
                "'{text}' is no length: write pixels (3, 3px) or a share (0.3%)"
            ))
        })
    }
}

/// The forms in a preset: pixels need no quotes.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(untagged, expecting = "pixels (3) or a share (\"0.3%\")")]
enum WrittenLength {
    Whole(u32),
    Pixels(f64),
    Text(String),
}

#[cfg(feature = "serde")]
impl TryFrom<WrittenLength> for Length {
    type Error = Error;
    fn try_from(written: WrittenLength) -> Result<Self> {
        match written {
            WrittenLength::Whole(pixels) => Ok(Self::Pixels(f64::from(pixels))),
            WrittenLength::Pixels(pixels) => Ok(Self::Pixels(pixels)),
            WrittenLength::Text(text) => text.parse(),
        }
    }
}

#[cfg(feature = "serde")]
impl From<Length> for WrittenLength {
    fn from(length: Length) -> Self {
        match length {
            // A whole number stays one in the file.
            Length::Pixels(p) if p.fract() == 0.0 && (0.0..1e9).contains(&p) => {
                Self::Whole(p as u32)
            }
            Length::Pixels(pixels) => Self::Pixels(pixels),
            Length::Share(_) => Self::Text(length.to_string()),
        }
    }
}

impl Focus {
    pub(super) fn validate(&self) -> Result<()> {
        match self {
            Self::Saliency => Ok(()),
            Self::Faces if cfg!(feature = "faces") => Ok(()),
            Self::Faces => Err(Error::options(
                "this build finds no faces: build it with the feature `faces` (cargo install polyreel --features \
                 faces), or write saliency or X,Y,R",
            )),
            Self::Spot(Spot { radius: Length::Pixels(r) | Length::Share(r), .. }) if *r > 0.0 => {
                Ok(())
            }
            Self::Spot(spot) => Err(Error::out_of_range("focus", spot.radius, "a radius above 0")),
            Self::Mask(mask)
                if mask.weights.len() == mask.size.pixels() && !mask.weights.is_empty() =>
            {
                Ok(())
            }
            Self::Mask(mask) => {
                Err(Error::options(format!("the focus mask {} has no pixels", mask.name)))
            }
        }
    }
}

impl std::str::FromStr for Focus {
    type Err = Error;

    /// `saliency`, `faces`, `X,Y,R`, or else the name of a mask, which is to be loaded.
    fn from_str(text: &str) -> Result<Self> {
        if text == "saliency" {
            return Ok(Self::Saliency);
        }
        if text == "faces" {
            return Ok(Self::Faces);
        }
        let parts: Vec<_> = text.split(',').collect();
        if let [x, y, radius] = parts[..]
            && let (Some(x), Some(y), Some(radius)) =
                (Length::parse(x), Length::parse(y), Length::parse(radius))
        {
            return Ok(Self::Spot(Spot { x, y, radius }));
        }
        if text.contains('.') {
            let (size, weights) = (Size::new(0, 0), Arc::from([]));
            return Ok(Self::Mask(FocusMask { name: text.to_owned(), size, weights }));
        }
        Err(Error::options(format!(
            "'{text}' is no focus: write saliency, faces, X,Y,R (50%,40%,20%, or pixels) or the name of a mask (face.png)"
        )))
    }
}

impl TryFrom<String> for Focus {
    type Error = Error;
    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Focus> for String {
    fn from(focus: Focus) -> String {
        focus.to_string()
    }
}

impl std::fmt::Display for Focus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Saliency => f.write_str("saliency"),
            Self::Faces => f.write_str("faces"),
            Self::Spot(Spot { x, y, radius }) => write!(f, "{x},{y},{radius}"),
            Self::Mask(mask) => f.write_str(&mask.name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_masks_and_saliency_print_as_they_are_read() {
        for text in
            ["saliency", "faces", "50%,40%,20%", "100,20.5,30", "10%,5,7", "a,b.png", "face.png"]
        {
            assert_eq!(text.parse::<Focus>().expect(text).to_string(), text);
        }
        for wrong in ["", "face", "1,2", "a,b,c", "1,2,nan"] {
            assert!(wrong.parse::<Focus>().is_err(), "{wrong}");
        }
        let faces = "faces".parse::<Focus>().expect("read").validate();
        assert_eq!(faces.is_ok(), cfg!(feature = "faces"));
        assert!("1,2,0".parse::<Focus>().expect("read").validate().is_err());
        assert!("face.png".parse::<Focus>().expect("read").validate().is_err(), "not loaded");
    }
}
