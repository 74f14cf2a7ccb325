//! `polyreel presets`: lists presets, or prints one as a file.

use std::fmt::Write;

use polyreel::error::Result;
use polyreel::options::{Options, PRESETS};

use crate::program::suggest::meant;
use crate::program::{Outcome, print};

/// Lists the presets, or prints the one called `name` as TOML.
pub(crate) fn presets(name: Option<&str>) -> Result<Outcome> {
    if let Some(name) = name.filter(|name| *name != "list") {
        let names = PRESETS.map(|preset| preset.name);
        let preset = Options::preset(name).map_err(|unknown| meant(unknown, name, &names))?;
        return print(polyreel::preset::to_toml(&preset)?.as_bytes());
    }
    let mut list = String::new();
    for preset in PRESETS {
        // Writing to a string cannot fail.
        let _ = writeln!(list, "{:<14} {}", preset.name, preset.about);
    }
    print(list.as_bytes())
}
