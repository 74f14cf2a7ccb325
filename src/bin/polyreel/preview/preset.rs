//! The file that keeps settings.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

use polyreel::error::{Error, Result};
use polyreel::options::Options;

/// Writes `options` to the new file `name`.
///
/// # Errors
/// When it cannot be written, or is there already.
pub(super) fn write(options: &Options, name: &str) -> Result<()> {
    let text = options.to_toml()?;
    let file = OpenOptions::new().write(true).create_new(true).open(Path::new(name));
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| Error::output(name, format!("cannot be written: {error}")))
}
