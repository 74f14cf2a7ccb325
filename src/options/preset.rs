//! Presets: options by a name, and as files.

use toml::Table;

use super::{Colour, Edges, Options, Points, Quality};
use crate::error::{Error, Result};

/// Options that go well together.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// What it is called.
    pub name: &'static str,
    /// What it looks like, in a line.
    pub about: &'static str,
    make: fn() -> Options,
}

/// All named presets, in the order in which they are listed.
pub const PRESETS: [Preset; 6] = [
    Preset {
        name: "paper",
        about: "the paper to the letter: no smoothing, no refinement, each frame alone",
        make: Options::paper,
    },
    Preset { name: "bold", about: "few large, vivid facets", make: bold },
    Preset { name: "fine", about: "many small triangles, close to the picture", make: fine },
    Preset {
        name: "sketch",
        about: "pencil lines where colours change, on a pale wash",
        make: sketch,
    },
    Preset {
        name: "stained-glass",
        about: "glowing panes, dark leading where colours meet",
        make: stained_glass,
    },
    Preset { name: "crystal", about: "cut facets with fine bright seams", make: crystal },
];

fn bold() -> Options {
    Options {
        points: Points::Share(0.0015),
        quality: Quality::Best,
        saturation: 1.35,
        ..Options::default()
    }
}

fn fine() -> Options {
    Options { points: Points::Share(0.025), regularity: 0.4, ..Options::default() }
}

fn sketch() -> Options {
    Options {
        points: Points::Share(0.006),
        quality: Quality::Best,
        outline: Some(Colour([46, 42, 51, 255])),
        outline_contrast: 26,
        saturation: 0.9,
        wash: 0.62,
        ..Options::default()
    }
}

fn stained_glass() -> Options {
    Options {
        points: Points::Share(0.001),
        quality: Quality::Best,
        outline: Some(Colour([18, 14, 16, 255])),
        outline_width: 4,
        outline_contrast: 22,
        saturation: 1.7,
        ..Options::default()
    }
}

fn crystal() -> Options {
    Options {
        points: Points::Share(0.002),
        quality: Quality::Best,
        regularity: 0.8,
        outline: Some(Colour([255; 4])),
        outline_contrast: 6,
        saturation: 1.2,
        ..Options::default()
    }
}

impl Options {
    /// The paper to the letter: no smoothing, no refinement, no coherence, hard edges.
    pub fn paper() -> Self {
        Self {
            smoothing: 0,
            interval: 5,
            quality: Quality::Draft,
            coherence: 0.0,
            edges: Edges::Hard,
            ..Self::default()
        }
    }

    /// The preset called `name`.
    ///
    /// # Errors
    /// When there is none of that name; the message lists those that there are.
    pub fn preset(name: &str) -> Result<Self> {
        match PRESETS.iter().find(|preset| preset.name == name) {
            Some(preset) => Ok((preset.make)()),
            None => {
                let names = PRESETS.map(|preset| preset.name).join(", ");
                Err(Error::usage(format!(
                    "there is no preset '{name}': there are {names}, and files whose name ends in .toml"
                )))
            }
        }
    }

    /// The options as a preset file: what differs from the defaults, under a comment.
    ///
    /// # Errors
    /// When the seed is above 2^63 - 1, the largest number that TOML has.
    pub fn to_toml(&self) -> Result<String> {
        let table = |options: &Self| {
            Table::try_from(options).map_err(|_| {
                Error::usage(format!("seed {} cannot be written: TOML ends at 2^63 - 1", self.seed))
            })
        };
        let (mut mine, usual) = (table(self)?, table(&Self::default())?);
        mine.retain(|key, value| usual.get(key) != Some(value));
        Ok(format!(
            "# A preset of polyreel: use it with --preset FILE.toml. What is not named here is as by\n\
             # default; keys are the options' names.\n{mine}"
        ))
    }

    /// The options in a preset file; the defaults where it does not name them.
    ///
    /// # Errors
    /// When it is no TOML, or holds a key or a value that there is not: names line and key.
    pub fn from_toml(text: &str) -> Result<Self> {
        let options: Self = toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| line_of(text, span.start));
            Error::usage(at_line(text, line, error.message()))
        })?;
        options.validate().map_err(|error| {
            // It begins with the key.
            let said = error.to_string();
            let key = said.split_whitespace().next().unwrap_or_default();
            let line = text.lines().position(|line| key_of(line) == Some(key));
            Error::usage(at_line(text, line, &said))
        })?;
        Ok(options)
    }
}

/// The line, from 0, that holds byte `at`.
fn line_of(text: &str, at: usize) -> usize {
    text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

/// The key that a line of TOML gives a value to.
fn key_of(line: &str) -> Option<&str> {
    let key = line.split_once('=')?.0.trim();
    Some(key).filter(|key| !key.is_empty() && !key.starts_with('#'))
}

fn at_line(text: &str, line: Option<usize>, what: &str) -> String {
    let what = what.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let Some(line) = line else { return what };
    let key = text.lines().nth(line).and_then(key_of).filter(|key| {
        // Where it is told already there is no need to.
        !what.starts_with(*key) && !what.contains(&format!("`{key}`"))
    });
    let key = key.map_or_else(String::new, |key| format!(", {key}"));
    format!("line {}{key}: {what}", line + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Target;

    #[test]
    fn presets_are_sound_distinct_and_come_back_from_their_files() {
        for (i, preset) in PRESETS.iter().enumerate() {
            let options = Options::preset(preset.name).expect(preset.name);
            options.validate().expect(preset.name);
            let text = options.to_toml().expect(preset.name);
            assert_eq!(Options::from_toml(&text).expect(preset.name), options);
            assert!(text.starts_with("# "), "{text}");
            let others = PRESETS[..i].iter().map(|p| (p.make)());
            assert!(others.into_iter().all(|other| other != options), "{}", preset.name);
        }
        let said = Options::preset("bald").expect_err("none").to_string();
        assert!(said.contains("bold") && said.contains(".toml"), "{said}");
    }

    #[test]
    fn only_what_differs_is_written() {
        let text = Options::default().to_toml().expect("defaults");
        assert!(text.lines().all(|line| line.starts_with('#')), "{text}");
        let options = Options {
            points: Points::Auto,
            error: Some(Target::Psnr(30.0)),
            thresholds: crate::options::Thresholds { high: 0.3, ..Default::default() },
            ..Options::default()
        };
        let text = options.to_toml().expect("plain data");
        assert_eq!(Options::from_toml(&text).expect("what was written"), options);
        assert!(!text.contains("clusters"), "{text}");
        let huge = Options { seed: u64::MAX, ..Options::default() };
        assert!(huge.to_toml().expect_err("no such number").to_string().contains("seed"));
    }

    #[test]
    fn a_count_of_points_needs_no_quotes() {
        let points = |text: &str| Options::from_toml(text).map(|options| options.points);
        assert_eq!(points("points = 1500").expect("a count"), Points::Count(1500));
        assert_eq!(points("points = \"1500\"").expect("a count"), Points::Count(1500));
        assert_eq!(points("points = \"2%\"").expect("a share"), Points::Share(0.02));
        for wrong in ["points = 1.5", "points = -3", "points = [1]"] {
            let said = points(wrong).expect_err("no count").to_string();
            assert!(said.starts_with("line 1, points: ") && said.contains("0.8%"), "{said}");
        }
    }

    #[test]
    fn errors_name_line_and_key() {
        let said = |text: &str| Options::from_toml(text).expect_err("wrong").to_string();
        let unknown = said("# mine\npionts = \"3\"\n");
        assert!(unknown.starts_with("line 2: unknown field `pionts`"), "{unknown}");
        let kind = said("seed = 4\nclusters = \"many\"");
        assert!(kind.starts_with("line 2, clusters: invalid type"), "{kind}");
        let value = said("\n\noutline = \"blurple\"");
        assert!(value.starts_with("line 3, outline: 'blurple' is not a colour"), "{value}");
        assert_eq!(said("a"), said("a"));
        assert!(
            said("clusters = 4\nseed 4").starts_with("line 2"),
            "{}",
            said("clusters = 4\nseed 4")
        );
        let range = said("seed = 1\nclusters = 1");
        assert_eq!(range, "line 2: clusters is 1; it can be 2 to 64");
    }
}
