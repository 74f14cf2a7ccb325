//! `polyreel presets`: lists presets and studies, or prints one as a file.

use std::fmt::Write;

use polyreel::error::Result;
use polyreel::options::{Options, PRESETS, STUDIES};

use crate::program::suggest::meant;
use crate::program::{Outcome, print};

/// Lists the presets and the studies, or prints the one called `name` as TOML.
pub(crate) fn presets(name: Option<&str>) -> Result<Outcome> {
    if let Some(name) = name.filter(|name| *name != "list") {
        let names: Vec<_> = PRESETS.iter().chain(&STUDIES).map(|preset| preset.name).collect();
        let found = Options::study(name).or_else(|_| Options::preset(name));
        let preset = found.map_err(|unknown| meant(unknown, name, &names))?;
        return print(polyreel::preset::to_toml(&preset)?.as_bytes());
    }
    let mut list = String::new();
    // Writing to a string cannot fail.
    for preset in PRESETS {
        let _ = writeln!(list, "{:<19} {}", preset.name, preset.about);
    }
    let _ = writeln!(list, "\nStudies, for --study:");
    for study in STUDIES {
        let _ = writeln!(list, "{:<19} {}", study.name, study.about);
    }
    print(list.as_bytes())
}
