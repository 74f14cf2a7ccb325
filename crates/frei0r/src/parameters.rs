//! The parameters of the plug-in: numbers of 0 to 1, as in frei0r, and their options.
//!
//! There are no text parameters: GStreamer and ffmpeg pass these in incompatible ways.

use std::ffi::CStr;

use polyreel_core::{Colour, FillMode, Focus, Length, Options, PRESETS, Points, Quality, Shape};

/// Number of parameters.
pub const COUNT: usize = PARAMETERS.len();

/// The type of a parameter for hosts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// On from 0.5.
    Switch,
    /// A number of 0 to 1.
    Number,
}

/// A parameter.
#[derive(Debug)]
pub struct Parameter {
    /// Its name in hosts.
    pub name: &'static CStr,
    /// Its description.
    pub explanation: &'static CStr,
    /// How hosts show it.
    pub kind: Kind,
    /// The value that keeps the preset's own setting; the initial value in hosts.
    pub default: f64,
    /// Sets options by a value of 0 to 1, other than the default.
    apply: fn(&mut Options, f64),
}

/// All parameters, in the order of their indices. New ones are only added at the end.
pub const PARAMETERS: [Parameter; 16] = [
    Parameter {
        name: c"points",
        explanation: c"Number of points: 0 is 50, 1 is 20000, each 0.1 is 1.8 times as many; 0.5 leaves it to the preset",
        kind: Kind::Number,
        default: 0.5,
        apply: |options, value| options.points = Points::Count(count(value)),
    },
    Parameter {
        name: c"preset",
        explanation: c"Look to begin with: 0 is the default, then one of the program's presets every 0.05, in the order of polyreel presets",
        kind: Kind::Number,
        default: 0.0,
        apply: |options, value| *options = preset(value),
    },
    Parameter {
        name: c"coherence",
        explanation: c"How firmly a frame holds to the one before: 0 draws each frame alone, 1 flickers least",
        kind: Kind::Number,
        default: 0.4,
        apply: |options, value| options.coherence = value,
    },
    Parameter {
        name: c"quality",
        explanation: c"Work on the mesh: below 0.34 draft, below 0.67 normal, above best",
        kind: Kind::Number,
        default: 0.5,
        apply: |options, value| {
            options.quality = match value {
                v if v < 0.34 => Quality::Draft,
                v if v < 0.67 => Quality::Normal,
                _ => Quality::Best,
            }
        },
    },
    Parameter {
        name: c"regularity",
        explanation: c"0 follows contours with any triangle, 1 keeps triangles round",
        kind: Kind::Number,
        default: 0.5,
        apply: |options, value| options.regularity = value,
    },
    Parameter {
        name: c"outline",
        explanation: c"Draws lines along the edges of the triangles",
        kind: Kind::Switch,
        default: 0.0,
        apply: |options, value| {
            options.outline = (value >= 0.5).then_some(BLACK);
        },
    },
    Parameter {
        name: c"saturation",
        explanation: c"Strength of colours: 0 is grey, 0.25 as in the source, 1 is four times as strong",
        kind: Kind::Number,
        default: 0.25,
        apply: |options, value| options.saturation = 4.0 * value,
    },
    Parameter {
        name: c"wash",
        explanation: c"How far colours are washed out towards white",
        kind: Kind::Number,
        default: 0.0,
        apply: |options, value| options.wash = value,
    },
    Parameter {
        name: c"hard edges",
        explanation: c"Gives each pixel the colour of its one triangle, without smoothing",
        kind: Kind::Switch,
        default: 0.0,
        apply: |options, value| {
            if value >= 0.5 {
                options.edges = polyreel_core::Edges::Hard;
            }
        },
    },
    Parameter {
        name: c"seed",
        explanation: c"Another value gives another drawing of the same picture: thousandths count",
        kind: Kind::Number,
        default: 0.0,
        apply: |options, value| options.seed = (value * 1000.0).round() as u64,
    },
    Parameter {
        name: c"fill",
        explanation: c"Colours of triangles: 0 leaves them to the preset, 0.15 mean, 0.3 median, 0.45 centroid, 0.6 linear, 0.75 gouraud, 0.9 none",
        kind: Kind::Number,
        default: 0.0,
        apply: |options, value| {
            if let Some(&fill) = chosen(&FillMode::ALL, value, 0.15) {
                options.fill = fill;
            }
        },
    },
    Parameter {
        name: c"shape",
        explanation: c"What is filled together: 0 leaves it to the preset, 0.3 triangles, 0.6 polygons, 0.9 voronoi",
        kind: Kind::Number,
        default: 0.0,
        apply: |options, value| {
            if let Some(&shape) = chosen(&Shape::ALL, value, 0.3) {
                options.shape = shape;
            }
        },
    },
    Parameter {
        name: c"outline width",
        explanation: c"Width of lines: 0 leaves it to the preset, 1 is 2 % of the picture's shorter side, 0.3 is 0.18 %; without lines it draws black ones",
        kind: Kind::Number,
        default: 0.0,
        apply: |options, value| {
            options.outline.get_or_insert(BLACK);
            options.outline_width = Length::Share(0.02 * value * value);
        },
    },
    Parameter {
        name: c"outline opacity",
        explanation: c"Opacity of lines; 1 leaves it to the preset",
        kind: Kind::Number,
        default: 1.0,
        apply: |options, value| options.outline_opacity = value,
    },
    Parameter {
        name: c"contrast",
        explanation: c"Contrast: 0 is grey, 0.5 as in the source, 1 is twice as strong",
        kind: Kind::Number,
        default: 0.5,
        apply: |options, value| options.contrast = 2.0 * value,
    },
    Parameter {
        name: c"focus",
        explanation: c"Smaller facets where the picture stands out",
        kind: Kind::Switch,
        default: 0.0,
        apply: |options, value| {
            if value >= 0.5 {
                options.focus = Some(Focus::Saliency);
            }
        },
    },
];

/// Index of the preset, which is applied before all others.
const PRESET: usize = 1;

const BLACK: Colour = Colour([0, 0, 0, 255]);

/// The one of `all` that stands at `value`, one every `step` from `step` on.
fn chosen<T>(all: &[T], value: f64, step: f64) -> Option<&T> {
    let number = (value / step).round() as usize;
    all.get(number.min(all.len()).checked_sub(1)?)
}

fn count(value: f64) -> u32 {
    (50.0 * 400_f64.powf(value)).round() as u32
}

fn preset(value: f64) -> Options {
    let index = (value * 20.0).round() as usize;
    let named = index.checked_sub(1).and_then(|index| PRESETS.get(index));
    named.and_then(|preset| Options::preset(preset.name).ok()).unwrap_or_default()
}

/// The values that a host has set.
#[derive(Clone, Debug, PartialEq)]
pub struct Values([f64; COUNT]);

impl Default for Values {
    fn default() -> Self {
        Self(PARAMETERS.each_ref().map(|parameter| parameter.default))
    }
}

impl Values {
    /// The value of parameter `index`, 0 to 1; `None` if there is no such parameter.
    pub fn get(&self, index: usize) -> Option<f64> {
        self.0.get(index).copied()
    }

    /// Sets parameter `index`. Values are clamped to 0 to 1; NaN and unknown indices are ignored.
    pub fn set(&mut self, index: usize, value: f64) {
        if let Some(slot) = self.0.get_mut(index)
            && !value.is_nan()
        {
            *slot = value.clamp(0.0, 1.0);
        }
    }

    /// The options of the values. A parameter at its default changes nothing, so that the defaults are the program's.
    pub fn options(&self) -> Options {
        let mut options = Options::default();
        let others = (0..COUNT).filter(|&index| index != PRESET);
        for index in std::iter::once(PRESET).chain(others) {
            let (parameter, value) = (&PARAMETERS[index], self.0[index]);
            // Some hosts keep single precision.
            if (value - parameter.default).abs() > 1e-6 {
                (parameter.apply)(&mut options, value);
            }
        }
        // Panes and cells have one colour each.
        if options.shape != Shape::Triangles && options.fill.is_gradient() {
            options.fill = FillMode::Mean;
        }
        options
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_the_programs_own() {
        assert_eq!(Values::default().options(), Options::default());
    }

    #[test]
    fn every_value_makes_sound_options() {
        for index in 0..COUNT {
            for step in 0..=100 {
                let mut values = Values::default();
                values.set(index, f64::from(step) / 100.0);
                values.options().validate().expect("any value can be used");
            }
        }
    }

    #[test]
    fn every_parameter_changes_the_options() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let mut values = Values::default();
            values.set(index, if index == PRESET { 0.05 } else { 0.8 });
            assert_ne!(values.options(), Options::default(), "{:?}", parameter.name);
        }
    }

    #[test]
    fn presets_stand_every_twentieth() {
        for (i, named) in PRESETS.iter().enumerate().take(20) {
            let mut values = Values::default();
            values.set(PRESET, 0.05 * (i + 1) as f64);
            assert_eq!(values.options(), Options::preset(named.name).expect("a preset"));
        }
    }

    #[test]
    fn fills_and_shapes_stand_in_their_order() {
        let mut values = Values::default();
        for (i, &fill) in FillMode::ALL.iter().enumerate() {
            values.set(10, 0.15 * (i + 1) as f64);
            assert_eq!(values.options().fill, fill);
        }
        values.set(10, 1.0);
        assert_eq!(values.options().fill, FillMode::None);
        values.set(10, 0.6);
        values.set(11, 0.6);
        assert_eq!(
            (values.options().fill, values.options().shape),
            (FillMode::Mean, Shape::Polygons)
        );
        for (i, &shape) in Shape::ALL.iter().enumerate() {
            values.set(11, 0.3 * (i + 1) as f64);
            assert_eq!(values.options().shape, shape);
        }
    }

    #[test]
    fn values_out_of_range_are_moved_into_it() {
        let mut values = Values::default();
        values.set(0, 7.0);
        assert_eq!(values.get(0), Some(1.0));
        values.set(0, f64::NAN);
        assert_eq!(values.get(0), Some(1.0));
        values.set(99, 0.3);
        assert_eq!(values.get(99), None);
    }
}
