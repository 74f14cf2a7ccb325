//! Colours as options name them.

use crate::error::{Error, Result};
use crate::frame::Rgba;

/// A colour as options name it: `#rgb`, `#rrggbb`, `#rrggbbaa` or a basic name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "String", into = "String")
)]
pub struct Colour(pub Rgba);

/// The sixteen colour names of HTML 4, and the most used others of CSS.
const COLOUR_NAMES: [(&str, Rgba); 35] = [
    ("black", [0, 0, 0, 255]),
    ("silver", [192, 192, 192, 255]),
    ("gray", [128, 128, 128, 255]),
    ("white", [255, 255, 255, 255]),
    ("maroon", [128, 0, 0, 255]),
    ("red", [255, 0, 0, 255]),
    ("purple", [128, 0, 128, 255]),
    ("fuchsia", [255, 0, 255, 255]),
    ("green", [0, 128, 0, 255]),
    ("lime", [0, 255, 0, 255]),
    ("olive", [128, 128, 0, 255]),
    ("yellow", [255, 255, 0, 255]),
    ("navy", [0, 0, 128, 255]),
    ("blue", [0, 0, 255, 255]),
    ("teal", [0, 128, 128, 255]),
    ("aqua", [0, 255, 255, 255]),
    ("grey", [128, 128, 128, 255]),
    ("orange", [255, 165, 0, 255]),
    ("gold", [255, 215, 0, 255]),
    ("pink", [255, 192, 203, 255]),
    ("brown", [165, 42, 42, 255]),
    ("cyan", [0, 255, 255, 255]),
    ("magenta", [255, 0, 255, 255]),
    ("violet", [238, 130, 238, 255]),
    ("indigo", [75, 0, 130, 255]),
    ("coral", [255, 127, 80, 255]),
    ("crimson", [220, 20, 60, 255]),
    ("turquoise", [64, 224, 208, 255]),
    ("salmon", [250, 128, 114, 255]),
    ("beige", [245, 245, 220, 255]),
    ("ivory", [255, 255, 240, 255]),
    ("tan", [210, 180, 140, 255]),
    ("khaki", [240, 230, 140, 255]),
    ("lavender", [230, 230, 250, 255]),
    ("transparent", [0, 0, 0, 0]),
];

impl std::str::FromStr for Colour {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let lower = text.to_ascii_lowercase();
        if let Some((_, colour)) = COLOUR_NAMES.iter().find(|(name, _)| *name == lower) {
            return Ok(Colour(*colour));
        }
        let wrong = || {
            Error::options(format!(
                "'{text}' is not a colour: write #rgb, #rrggbb, #rrggbbaa or one of {}",
                COLOUR_NAMES.map(|(name, _)| name).join(", ")
            ))
        };
        let hex = lower.strip_prefix('#').ok_or_else(wrong)?;
        let digits: Option<Vec<u8>> =
            hex.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect();
        match digits.ok_or_else(wrong)?[..] {
            [r, g, b] => Ok(Colour([r * 17, g * 17, b * 17, 255])),
            [r, s, g, h, b, c] => Ok(Colour([r * 16 + s, g * 16 + h, b * 16 + c, 255])),
            [r, s, g, h, b, c, a, d] => {
                Ok(Colour([r * 16 + s, g * 16 + h, b * 16 + c, a * 16 + d]))
            }
            _ => Err(wrong()),
        }
    }
}

impl TryFrom<String> for Colour {
    type Error = Error;
    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Colour> for String {
    fn from(colour: Colour) -> String {
        colour.to_string()
    }
}

impl std::fmt::Display for Colour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b, a] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")?;
        if a == 255 { Ok(()) } else { write!(f, "{a:02x}") }
    }
}
