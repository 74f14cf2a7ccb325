//! Options by their names, as the page keeps them.

use std::sync::Arc;

use polyreel_core::{Focus, FocusMask, Options, Points, Size};
use serde_json::{Map, Value};
use wasm_bindgen::prelude::*;

use crate::error::{Error, Result};
use crate::{command, preset_file};

/// The name of the mask that is painted on the page.
pub(crate) const MASK: &str = "focus.png";

/// How a picture looks.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Look {
    pub(crate) options: Options,
    /// The preset that it began with.
    pub(crate) preset: Option<String>,
}

#[wasm_bindgen]
impl Look {
    /// The look of `settings`, a JSON object: options by their names on the command line, with the values that a preset
    /// file has, and `preset`, the name of the one that they change.
    ///
    /// # Errors
    /// When a name or a value is not known, or out of range.
    #[wasm_bindgen(constructor)]
    pub fn new(settings: &str) -> std::result::Result<Self, JsError> {
        Ok(Self::of(settings)?)
    }

    /// The look of a preset file, and of the settings that stand in it.
    ///
    /// # Errors
    /// When it is no preset file.
    #[wasm_bindgen(js_name = fromFile)]
    pub fn from_file(text: &str) -> std::result::Result<Self, JsError> {
        Ok(Self { options: preset_file::read(text)?, preset: None })
    }

    /// The options that differ from the defaults, as a JSON object.
    pub fn settings(&self) -> String {
        difference(&self.options, &Options::default()).to_string()
    }

    /// All options, as a JSON object.
    pub fn values(&self) -> String {
        Value::Object(values(&self.options)).to_string()
    }

    /// The text of a preset file.
    ///
    /// # Errors
    /// When the seed is too large for one.
    #[wasm_bindgen(js_name = toFile)]
    pub fn to_file(&self) -> std::result::Result<String, JsError> {
        Ok(preset_file::write(&self.options)?)
    }

    /// The command line that makes `output` of `input` with this look; `more` are options that are no part of it.
    #[wasm_bindgen(js_name = commandLine)]
    pub fn command_line(&self, input: &str, output: &str, more: &str) -> String {
        command::line(self, input, output, more)
    }

    /// The number of points of a frame of this size.
    pub fn points(&self, width: u32, height: u32) -> u32 {
        self.options.seeds(Size::new(width, height)) as u32
    }

    /// Gives the focus a mask of `width` x `height`, a byte a pixel: more facets where it is light.
    ///
    /// # Errors
    /// When there are not as many bytes.
    #[wasm_bindgen(js_name = setMask)]
    pub fn set_mask(
        &mut self,
        weights: &[u8],
        width: u32,
        height: u32,
    ) -> std::result::Result<(), JsError> {
        Ok(self.mask(weights, Size::new(width, height))?)
    }

    /// The look for a preview of `width` x `height` of a picture of another size: as many points, lines as wide by
    /// proportion.
    #[wasm_bindgen(js_name = forPreview)]
    pub fn for_preview(
        &self,
        picture_width: u32,
        picture_height: u32,
        width: u32,
        height: u32,
    ) -> Self {
        let (picture, preview) =
            (Size::new(picture_width, picture_height), Size::new(width, height));
        if picture == preview {
            return self.clone();
        }
        let share = f64::from(width) / f64::from(picture_width.max(1));
        let mut look = Self { options: self.options.enlarged(share), preset: self.preset.clone() };
        if self.options.points != Points::Auto {
            // Smaller triangles than some pixels would not be seen.
            let most = (preview.pixels() / 40).max(4);
            let points = self.options.seeds(picture).min(most);
            look.options.points = Points::Count(points as u32);
        }
        look
    }
}

impl Look {
    pub(crate) fn of(settings: &str) -> Result<Self> {
        let wrong = |error: serde_json::Error| Error::Settings(error.to_string());
        let mut given: Map<String, Value> = serde_json::from_str(settings).map_err(wrong)?;
        let preset = match given.remove("preset") {
            None | Some(Value::Null) => None,
            Some(Value::String(name)) => Some(name),
            Some(other) => return Err(Error::Settings(format!("{other} is no preset's name"))),
        };
        let base = preset.as_deref().map_or_else(|| Ok(Options::default()), Options::preset)?;
        let mut all = values(&base);
        all.extend(given);
        let options: Options = serde_json::from_value(Value::Object(all)).map_err(wrong)?;
        let look = Self { options, preset };
        // The mask may come later.
        let mut masked = look.clone();
        if let Some(Focus::Mask(mask)) = &look.options.focus
            && mask.weights.is_empty()
        {
            masked.options.focus = None;
        }
        masked.options.validate()?;
        Ok(look)
    }

    fn mask(&mut self, weights: &[u8], size: Size) -> Result<()> {
        if weights.len() != size.pixels() || weights.is_empty() {
            return Err(Error::file("a mask has not as many bytes as pixels"));
        }
        let weights = Arc::from(weights);
        self.options.focus = Some(Focus::Mask(FocusMask { name: MASK.to_owned(), size, weights }));
        Ok(())
    }
}

/// All options by their names.
pub(crate) fn values(options: &Options) -> Map<String, Value> {
    let mut all = plain(options);
    // Those that are left out where they have their defaults.
    let rest = [
        ("fill", Value::from(options.fill.name())),
        ("shape", options.shape.name().into()),
        ("outline-opacity", options.outline_opacity.into()),
        ("outline-tint", options.outline_tint.into()),
        ("contrast", options.contrast.into()),
        ("chroma", options.chroma.into()),
        ("duotone", Value::Null),
        ("palette", Value::Null),
        ("focus", Value::Null),
        ("min-facet", Value::Null),
        ("max-facet", Value::Null),
    ];
    for (name, value) in rest {
        all.entry(name).or_insert(value);
    }
    all
}

/// Those options by their names that are written.
fn plain(options: &Options) -> Map<String, Value> {
    match serde_json::to_value(options) {
        Ok(Value::Object(all)) => all,
        _ => Map::new(),
    }
}

/// The options in which `options` differ from `base`, as a JSON object.
pub(crate) fn difference(options: &Options, base: &Options) -> Value {
    let (mut mine, base) = (values(options), values(base));
    mine.retain(|name, value| base.get(name) != Some(value));
    Value::Object(mine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel_core::{Length, PRESETS};

    #[test]
    fn settings_change_a_preset() {
        for preset in PRESETS {
            let settings = serde_json::json!({ "preset": preset.name, "seed": 7 }).to_string();
            let mut wanted = Options::preset(preset.name).expect(preset.name);
            wanted.seed = 7;
            let look = Look::of(&settings).expect("sound settings");
            assert_eq!(look.options, wanted);
            assert_eq!(Look::of(&look.settings()).expect("its own").options, wanted);
            assert_eq!(Look::of(&look.values()).expect("its own").options, wanted);
        }
    }

    #[test]
    fn wrong_settings_are_named() {
        for (settings, word) in [
            ("[]", "map"),
            (r#"{"pionts": 3}"#, "pionts"),
            (r#"{"points": "few"}"#, "few"),
            (r#"{"coherence": 2}"#, "coherence"),
            (r#"{"preset": "bald"}"#, "bald"),
            (r#"{"preset": 3}"#, "3"),
        ] {
            let said = Look::of(settings).expect_err(settings).to_string();
            assert!(said.contains(word), "{said}");
        }
    }

    #[test]
    fn a_mask_comes_after_the_settings() {
        let mut look = Look::of(r#"{"focus": "focus.png"}"#).expect("a mask to come");
        assert!(look.options.validate().is_err());
        look.mask(&[0, 255], Size::new(2, 1)).expect("as many bytes as pixels");
        look.options.validate().expect("there it is");
        assert!(look.mask(&[0], Size::new(2, 1)).is_err());
    }

    #[test]
    fn a_preview_has_the_points_of_the_picture() {
        let look = Look::of(r#"{"points": "0.1%", "outline-width": 8}"#).expect("sound");
        let preview = look.for_preview(4000, 3000, 1000, 750);
        assert_eq!(preview.options.points, Points::Count(12000));
        assert_eq!(preview.options.outline_width, Length::Pixels(2.0));
        assert_eq!(look.for_preview(400, 300, 400, 300).options, look.options);
        let small = Look::of(r#"{"min-facet": 2, "max-facet": 4}"#).expect("sound");
        small.for_preview(4000, 3000, 400, 300).options.validate().expect("a preview, too");
    }
}
