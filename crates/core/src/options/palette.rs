//! Palettes and pairs of colours as options name them.

use super::Colour;
use crate::error::{Error, Result};

/// The most colours of a palette.
const MOST_COLOURS: usize = 256;

/// The colours that a picture may have.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Written", into = "String")
)]
#[non_exhaustive]
pub enum Palette {
    /// This many, 2..=256, learned from the first frame.
    Learned(u32),
    /// These, 1..=256.
    Colours(Vec<Colour>),
}

impl Palette {
    /// The palette in the `text` of a file: of GIMP (`.gpl`), or one colour a line (`.hex`).
    ///
    /// # Errors
    /// When it has no colours or too many, or a line is not a colour.
    pub fn from_file(text: &str) -> Result<Self> {
        let is_gimp = text.trim_start_matches('\u{feff}').starts_with("GIMP Palette");
        let mut colours = Vec::new();
        for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let line = line.trim();
            let is_head = is_gimp
                && (number == 1 || line.starts_with("Name:") || line.starts_with("Columns:"));
            // In GIMP's files a comment begins with #; in others that is a colour.
            let is_comment = if is_gimp { line.starts_with('#') } else { line.starts_with(';') };
            if line.is_empty() || is_head || is_comment {
                continue;
            }
            let colour = if is_gimp { gimp(line) } else { hex(line) };
            let wrong = || Error::options(format!("line {number}: '{line}' is not a colour"));
            colours.push(colour.ok_or_else(wrong)?);
        }
        Self::of(colours)
    }

    fn of(colours: Vec<Colour>) -> Result<Self> {
        let palette = Self::Colours(colours);
        palette.validate()?;
        Ok(palette)
    }

    pub(super) fn validate(&self) -> Result<()> {
        let (count, least) = match self {
            Self::Learned(count) => (*count as usize, 2),
            Self::Colours(colours) => (colours.len(), 1),
        };
        if (least..=MOST_COLOURS).contains(&count) {
            return Ok(());
        }
        Err(Error::out_of_range("palette", count, format!("{least} to {MOST_COLOURS} colours")))
    }
}

/// Three numbers, and a name perhaps.
fn gimp(line: &str) -> Option<Colour> {
    let mut numbers = line.split_whitespace().map(|word| word.parse::<u8>().ok());
    let mut next = || numbers.next().flatten();
    Some(Colour([next()?, next()?, next()?, 255]))
}

fn hex(line: &str) -> Option<Colour> {
    let word = line.split_whitespace().next()?;
    format!("#{}", word.trim_start_matches('#')).parse().ok()
}

impl std::str::FromStr for Palette {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        if let Ok(count) = text.trim().parse() {
            let palette = Self::Learned(count);
            palette.validate()?;
            return Ok(palette);
        }
        let colours: Result<Vec<Colour>> =
            text.split([',', ' ']).filter(|word| !word.is_empty()).map(str::parse).collect();
        match colours {
            Ok(colours) => Self::of(colours),
            Err(error) => Err(Error::options(format!(
                "'{text}' is not a palette: write a number of colours (12) or colours (#102030,gold,white); {error}"
            ))),
        }
    }
}

impl std::fmt::Display for Palette {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Learned(count) => write!(f, "{count}"),
            Self::Colours(colours) => {
                let names: Vec<String> = colours.iter().map(Colour::to_string).collect();
                f.write_str(&names.join(","))
            }
        }
    }
}

impl From<Palette> for String {
    fn from(palette: Palette) -> String {
        palette.to_string()
    }
}

/// How a preset may write it: a number needs no quotes, and colours may stand in a list.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "a number of colours (12), or colours (\"#102030,white\")")]
enum Written {
    Count(u32),
    Text(String),
    List(Vec<String>),
}

#[cfg(feature = "serde")]
impl TryFrom<Written> for Palette {
    type Error = Error;
    fn try_from(written: Written) -> Result<Self> {
        match written {
            Written::Count(count) => Ok(Palette::Learned(count)),
            Written::Text(text) => text.parse(),
            Written::List(names) => names.join(",").parse(),
        }
    }
}

/// The colours that black and white become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "String", into = "String")
)]
pub struct Duotone {
    /// In place of black.
    pub dark: Colour,
    /// In place of white.
    pub light: Colour,
}

impl std::str::FromStr for Duotone {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            Error::options(format!("'{text}' is not two colours: write DARK,LIGHT (navy,#ffe8c0)"))
        };
        let (dark, light) = text.split_once(',').ok_or_else(wrong)?;
        let colour = |name: &str| name.trim().parse().map_err(|_| wrong());
        Ok(Self { dark: colour(dark)?, light: colour(light)? })
    }
}

impl TryFrom<String> for Duotone {
    type Error = Error;
    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Duotone> for String {
    fn from(duotone: Duotone) -> String {
        duotone.to_string()
    }
}

impl std::fmt::Display for Duotone {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{}", self.dark, self.light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn palettes_are_numbers_or_colours_and_print_as_they_are_read() {
        for text in ["12", "#102030", "#102030,#ffffff,#00000080"] {
            let palette: Palette = text.parse().expect(text);
            assert_eq!(palette.to_string(), text);
        }
        assert_eq!("12".parse(), Ok(Palette::Learned(12)));
        for wrong in ["1", "257", "", "0", "blurple", "#102030,none"] {
            assert!(wrong.parse::<Palette>().is_err(), "{wrong}");
        }
        let duotone: Duotone = "navy, #fff".parse().expect("two colours");
        assert_eq!(duotone.to_string(), "#000080,#ffffff");
        assert!("navy".parse::<Duotone>().is_err() && "a,b".parse::<Duotone>().is_err());
    }

    #[test]
    fn files_of_palettes_are_read() {
        let wanted: Palette = "#102030,#ff0000".parse().expect("two colours");
        let gimp =
            "GIMP Palette\nName: mine\nColumns: 2\n# a comment\n 16  32 48\tink\n255 0 0 red\n";
        for text in [gimp, "102030\nff0000\n", "; mine\r\n#102030\r\n#ff0000\r\n"] {
            assert_eq!(Palette::from_file(text), Ok(wanted.clone()), "{text}");
        }
        for wrong in ["", "GIMP Palette\n300 0 0\n", "10203\n", "GIMP Palette\n"] {
            assert!(Palette::from_file(wrong).is_err(), "{wrong}");
        }
        let many = "000000\n".repeat(257);
        assert!(Palette::from_file(&many).is_err());
    }
}
