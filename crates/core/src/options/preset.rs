//! Presets: named options.

use super::{Colour, Edges, Options, Points, Quality};
use crate::error::{Error, Result};

/// A named set of options.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// Its look, in a line.
    pub about: &'static str,
    make: fn() -> Options,
}

/// All presets, in the order of lists.
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
    /// The settings of the paper: no smoothing, no refinement, no coherence, hard edges.
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
    /// When there is no preset of this name; the message lists those that there are.
    pub fn preset(name: &str) -> Result<Self> {
        match PRESETS.iter().find(|preset| preset.name == name) {
            Some(preset) => Ok((preset.make)()),
            None => {
                let names = PRESETS.map(|preset| preset.name).join(", ");
                Err(Error::options(format!(
                    "there is no preset '{name}': there are {names}, and files whose name ends in .toml"
                )))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_sound_and_distinct() {
        for (i, preset) in PRESETS.iter().enumerate() {
            let options = Options::preset(preset.name).expect(preset.name);
            options.validate().expect(preset.name);
            let others = PRESETS[..i].iter().map(|p| (p.make)());
            assert!(others.into_iter().all(|other| other != options), "{}", preset.name);
        }
        let said = Options::preset("bald").expect_err("none").to_string();
        assert!(said.contains("bold") && said.contains(".toml"), "{said}");
    }
}
