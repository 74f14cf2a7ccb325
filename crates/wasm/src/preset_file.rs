//! Preset files, as the program reads and writes them.

use polyreel_core::Options;
use toml::Table;

use crate::error::{Error, Result};

/// The options as a preset file: those that differ from the defaults.
///
/// # Errors
/// When the seed is larger than numbers of TOML.
pub(crate) fn write(options: &Options) -> Result<String> {
    let table = |options: &Options| Table::try_from(options).map_err(Error::file);
    let (mut mine, usual) = (table(options)?, table(&Options::default())?);
    mine.retain(|key, value| usual.get(key) != Some(value));
    Ok(format!(
        "# A preset of polyreel: use it with --preset FILE.toml. What is not named here is as by\n\
         # default; keys are the options' names.\n{mine}"
    ))
}

/// The options in a preset file. A mask that it names is left out: its pixels are not there.
///
/// # Errors
/// When it is no TOML, or has an unknown key or value.
pub(crate) fn read(text: &str) -> Result<Options> {
    let mut options: Options =
        toml::from_str(text).map_err(|error| Error::Settings(error.to_string()))?;
    if matches!(options.focus, Some(polyreel_core::Focus::Mask(_))) {
        options.focus = None;
    }
    options.validate()?;
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel_core::PRESETS;

    #[test]
    fn presets_come_back_from_their_files() {
        for preset in PRESETS {
            let options = Options::preset(preset.name).expect(preset.name);
            let text = write(&options).expect(preset.name);
            assert_eq!(read(&text).expect(preset.name), options);
        }
        let said = read("pionts = 3").expect_err("a misspelt key").to_string();
        assert!(said.contains("pionts"), "{said}");
        assert_eq!(read("focus = \"face.png\"").expect("without it"), Options::default());
    }
}
