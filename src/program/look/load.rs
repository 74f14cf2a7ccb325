//! Loads what options of the look name: presets, palettes and masks.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use polyreel::error::{Error, Result};
use polyreel::frame::{Rgba, luma};
use polyreel::options::{Focus, Options, PRESETS, Palette, STUDIES};
use polyreel::source::{self, SourceOptions};

use crate::program::suggest::meant;

/// Reads the mask of the focus of `options`, if there is one that has no pixels yet.
pub(super) fn load_focus(options: &mut Options) -> Result<()> {
    let Some(Focus::Mask(mask)) = &mut options.focus else { return Ok(()) };
    if !mask.weights.is_empty() {
        return Ok(());
    }
    let path = std::path::PathBuf::from(&mask.name);
    let input = source::open(&[path], &SourceOptions::default())?;
    let first = input.start()?.next()?;
    let Some(first) = first else { return Err(Error::usage("the focus mask has no picture")) };
    let frame = first.frame;
    // What is transparent does not matter.
    let weight = |&pixel: &Rgba| (u16::from(luma(pixel)) * u16::from(pixel[3]) / 255) as u8;
    mask.size = frame.size();
    mask.weights = frame.pixels().iter().map(weight).collect();
    Ok(())
}

/// A palette as the command line names it.
pub(super) fn palette(text: &str) -> Result<Palette> {
    let path = Path::new(text);
    if !path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("gpl") || e.eq_ignore_ascii_case("hex"))
    {
        return Ok(text.parse()?);
    }
    let read = read_small(path, "palette")?;
    Palette::from_file(&read).map_err(|error| Error::input(path, error.to_string()))
}

/// The preset `name`, or the one in the file of that name.
pub(crate) fn preset(name: &str) -> Result<Options> {
    let path = Path::new(name);
    if !name.ends_with(".toml") && !path.is_file() {
        let names = PRESETS.map(|preset| preset.name);
        return Options::preset(name).map_err(|unknown| meant(unknown, name, &names));
    }
    let text = read_small(path, "preset")?;
    polyreel::preset::from_toml(&text).map_err(|error| Error::input(path, error.to_string()))
}

/// The study `name`.
pub(crate) fn study(name: &str) -> Result<Options> {
    let names = STUDIES.map(|study| study.name);
    Options::study(name).map_err(|unknown| meant(unknown, name, &names))
}

/// The text of a small file that is a `kind`.
fn read_small(path: &Path, kind: &str) -> Result<String> {
    let wrong = |what: String| Error::input(path, what);
    let mut text = String::new();
    let file = File::open(path)
        .map_err(|error| wrong(format!("cannot be read: {error}")).caused_by(error))?;
    let read = file.take(MOST_BYTES).read_to_string(&mut text);
    read.map_err(|error| wrong(format!("is no {kind}: {error}")).caused_by(error))?;
    Ok(text)
}

/// The most bytes of a preset file: many times the size of all options.
const MOST_BYTES: u64 = 1 << 16;
