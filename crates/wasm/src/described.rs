//! What there is to choose from, for the page's controls.

use polyreel_core::{Edges, FillMode, Options, PRESETS, Quality, Shape};
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

/// As JSON: `version`; `defaults`, all options by name; `presets`, each with `name`, `about` and the `options` in
/// which it differs from the defaults; `choices`, the words of options that are chosen by name.
#[wasm_bindgen]
pub fn described() -> String {
    let presets: Vec<Value> = PRESETS
        .iter()
        .map(|preset| {
            let options = Options::preset(preset.name).unwrap_or_default();
            let options = crate::look::difference(&options, &Options::default());
            json!({ "name": preset.name, "about": preset.about, "options": options })
        })
        .collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "defaults": crate::look::values(&Options::default()),
        "presets": presets,
        "choices": {
            "fill": FillMode::ALL.map(FillMode::name),
            "shape": Shape::ALL.map(Shape::name),
            "edges": Edges::ALL.map(Edges::name),
            // Nothing, or what the engine finds by itself.
            "focus": [null, "saliency", "faces"],
            "quality": Quality::ALL.map(Quality::name),
        },
    })
    .to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_and_defaults_are_listed() {
        let described: Value = serde_json::from_str(&described()).expect("JSON");
        let presets = described["presets"].as_array().expect("a list");
        assert_eq!(presets.len(), PRESETS.len());
        assert!(described["defaults"]["points"].is_string());
        // Options whose default is not written are there, too.
        assert_eq!(described["defaults"]["fill"], "mean");
        assert_eq!(described["defaults"]["contrast"], 1.0);
    }
}
