//! Presets: named options.

use super::points::PAPER_SHARE;
use super::{Colour, Duotone, Edges, Length, Options, Palette, Points, Quality, Shape};
use crate::error::{Error, Result};

/// A named set of options.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// Its look, in a line.
    pub about: &'static str,
    pub(super) make: fn() -> Options,
}

impl Preset {
    pub(super) const fn new(
        name: &'static str,
        about: &'static str,
        make: fn() -> Options,
    ) -> Self {
        Self { name, about, make }
    }

    /// The options of the one of `all` that is called `name`.
    ///
    /// # Errors
    /// When there is none: the message calls it a `kind`, and lists those that there are, and `more`.
    pub(super) fn find(all: &[Self], name: &str, kind: &str, more: &str) -> Result<Options> {
        if let Some(found) = all.iter().find(|preset| preset.name == name) {
            return Ok((found.make)());
        }
        let names: Vec<_> = all.iter().map(|preset| preset.name).collect();
        Err(Error::options(format!(
            "there is no {kind} '{name}': there are {}{more}",
            names.join(", ")
        )))
    }
}

/// All presets, in the order of lists: new ones at the end, as hosts know them by their place.
pub const PRESETS: [Preset; 15] = [
    Preset {
        name: "paper",
        about: "the paper to the letter: no smoothing, no refinement, each frame alone",
        make: Options::paper,
    },
    Preset { name: "bold", about: "few large, vivid facets", make: bold },
    Preset { name: "fine", about: "many small triangles, close to the picture", make: fine },
    Preset {
        name: "sketch",
        about: "ink lines where colours change, on a pale wash",
        make: sketch,
    },
    Preset { name: "stained-glass", about: "glowing panes in dark lead", make: stained_glass },
    Preset { name: "crystal", about: "cut facets with fine bright seams", make: crystal },
    Preset {
        name: "low-poly",
        about: "the default: facets that are seen, in the source's colours",
        make: Options::default,
    },
    Preset {
        name: "faithful",
        about: "the paper's number of points, refined: close to the source",
        make: faithful,
    },
    Preset { name: "poster", about: "large shapes in eight colours", make: poster },
    Preset { name: "neon", about: "a glowing wireframe in the dark", make: neon },
    Preset { name: "paper-cut", about: "layers of coloured paper with soft rims", make: paper_cut },
    Preset { name: "riso", about: "two inks on warm paper", make: riso },
    Preset { name: "pastel", about: "soft chalky facets of even size", make: pastel },
    Preset { name: "mosaic", about: "tiles in pale grout", make: mosaic },
    Preset { name: "noir", about: "black and white, large facets, hard light", make: noir },
];

fn opaque(r: u8, g: u8, b: u8) -> Colour {
    Colour([r, g, b, 255])
}

fn bold() -> Options {
    Options { points: Points::Scaled(400), chroma: 1.45, contrast: 1.12, ..Options::default() }
}

fn fine() -> Options {
    Options { points: Points::Scaled(6000), regularity: 0.4, ..Options::default() }
}

fn faithful() -> Options {
    Options { points: Points::Share(PAPER_SHARE), quality: Quality::Normal, ..Options::default() }
}

fn sketch() -> Options {
    Options {
        points: Points::Scaled(2200),
        outline: Some(opaque(38, 34, 44)),
        outline_width: Length::Share(0.0013),
        outline_contrast: 28,
        chroma: 0.9,
        wash: 0.5,
        ..Options::default()
    }
}

fn stained_glass() -> Options {
    Options {
        points: Points::Scaled(500),
        shape: Shape::Polygons,
        outline: Some(opaque(18, 14, 16)),
        outline_width: Length::Share(0.004),
        chroma: 1.6,
        contrast: 1.05,
        ..Options::default()
    }
}

fn crystal() -> Options {
    Options {
        points: Points::Scaled(900),
        regularity: 0.8,
        outline: Some(opaque(255, 255, 255)),
        outline_width: Length::Share(0.0014),
        outline_opacity: 0.4,
        outline_tint: 0.35,
        chroma: 1.35,
        contrast: 1.05,
        ..Options::default()
    }
}

fn poster() -> Options {
    Options {
        points: Points::Scaled(900),
        shape: Shape::Polygons,
        palette: Some(Palette::Learned(8)),
        chroma: 1.5,
        contrast: 1.2,
        ..Options::default()
    }
}

fn neon() -> Options {
    Options {
        points: Points::Scaled(1000),
        duotone: Some(Duotone { dark: opaque(6, 5, 18), light: opaque(70, 24, 110) }),
        outline: Some(opaque(60, 240, 255)),
        outline_width: Length::Share(0.002),
        outline_contrast: 18,
        ..Options::default()
    }
}

fn paper_cut() -> Options {
    Options {
        points: Points::Scaled(450),
        shape: Shape::Polygons,
        regularity: 0.7,
        palette: Some(Palette::Learned(14)),
        outline: Some(opaque(20, 16, 24)),
        outline_width: Length::Share(0.008),
        outline_opacity: 0.3,
        outline_tint: 0.35,
        chroma: 1.2,
        ..Options::default()
    }
}

fn riso() -> Options {
    Options {
        points: Points::Scaled(900),
        duotone: Some(Duotone { dark: opaque(38, 52, 140), light: opaque(255, 232, 214) }),
        contrast: 1.35,
        palette: Some(Palette::Learned(6)),
        ..Options::default()
    }
}

fn pastel() -> Options {
    Options {
        points: Points::Scaled(800),
        regularity: 0.85,
        outline: Some(opaque(255, 255, 255)),
        outline_width: Length::Share(0.002),
        outline_opacity: 0.45,
        chroma: 0.85,
        wash: 0.5,
        ..Options::default()
    }
}

fn mosaic() -> Options {
    Options {
        points: Points::Scaled(1000),
        regularity: 0.8,
        shape: Shape::Voronoi,
        outline: Some(opaque(236, 230, 218)),
        outline_width: Length::Share(0.0018),
        chroma: 1.25,
        ..Options::default()
    }
}

fn noir() -> Options {
    Options {
        points: Points::Scaled(600),
        duotone: Some(Duotone { dark: opaque(8, 8, 12), light: opaque(250, 248, 242) }),
        contrast: 1.5,
        ..Options::default()
    }
}

impl Options {
    /// The settings of the paper: no smoothing, no refinement, no coherence, hard edges.
    pub fn paper() -> Self {
        Self {
            points: Points::Share(PAPER_SHARE),
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
        Preset::find(&PRESETS, name, "preset", ", and files whose name ends in .toml")
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Each of `all`, which `find` finds by its name, is sound and differs from the others.
    pub(in crate::options) fn are_sound_and_distinct(
        all: &[Preset],
        find: fn(&str) -> Result<Options>,
    ) {
        for (i, preset) in all.iter().enumerate() {
            let options = find(preset.name).expect(preset.name);
            options.validate().expect(preset.name);
            let mut others = all[..i].iter().map(|other| (other.make)());
            assert!(others.all(|other| other != options), "{}", preset.name);
        }
    }

    #[test]
    fn presets_are_sound_and_distinct() {
        are_sound_and_distinct(&PRESETS, Options::preset);
        let said = Options::preset("bald").expect_err("none").to_string();
        assert!(said.contains("bold") && said.contains(".toml"), "{said}");
    }
}
