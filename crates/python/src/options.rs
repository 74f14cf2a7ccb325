//! Options by their names on the command line, as keyword arguments. They become a command line: what they mean is
//! written once, in the program.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;

use polyreel::program::embed::{self, Described, Value};
use polyreel::{Options, PRESETS};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString, PyTuple};

use crate::error::raise;

/// The names of all presets with what they look like, in the order in which the program lists them.
#[pyfunction]
pub(crate) fn presets() -> Vec<(&'static str, &'static str)> {
    PRESETS.iter().map(|preset| (preset.name, preset.about)).collect()
}

/// All options: name, what it does, kind of value, words to choose from, whether it concerns the look.
#[pyfunction]
pub(crate) fn described() -> Vec<(String, String, &'static str, Vec<String>, bool)> {
    let kind = |option: &Described| match option.value {
        Value::None => "flag",
        Value::Whole => "int",
        Value::Real => "float",
        _ if option.unit == "COLOUR" => "colour",
        _ if ["PATH", "FILE", "FILE.json", "REPORT.json"].contains(&option.unit.as_str()) => "path",
        _ => "text",
    };
    let row = |option: &Described| {
        let name = option.name.replace('-', "_");
        (name, option.help.clone(), kind(option), option.choices.clone(), option.is_look)
    };
    all().iter().map(row).collect()
}

fn all() -> &'static [Described] {
    static ALL: OnceLock<Vec<Described>> = OnceLock::new();
    ALL.get_or_init(embed::described)
}

/// The look that keyword arguments ask for.
///
/// # Errors
/// `TypeError` for a name that is no option of the look, [`crate::error::UsageError`] for a value that it cannot have.
pub(crate) fn look(arguments: Option<&Bound<'_, PyDict>>) -> PyResult<Options> {
    embed::look(&command_line(arguments, true)?).map_err(raise)
}

/// Keyword arguments as a command line; with `only_look` they may only concern the look. What is `None` is left out.
///
/// # Errors
/// `TypeError` for a name that is no such option, and for a kind of value that no option can have.
pub(crate) fn command_line(
    arguments: Option<&Bound<'_, PyDict>>,
    only_look: bool,
) -> PyResult<Vec<OsString>> {
    let mut line = Vec::new();
    for (name, value) in arguments.iter().flat_map(|arguments| arguments.iter()) {
        let name: String = name.extract()?;
        let dashed = name.replace('_', "-");
        let Some(option) = all().iter().find(|option| option.name == dashed) else {
            return Err(unknown(&name, only_look));
        };
        if only_look && !option.is_look {
            return Err(PyTypeError::new_err(format!(
                "'{name}' is an option of render_file alone: it does not concern the look of a picture"
            )));
        }
        if !value.is_none() {
            line.extend(argument(option, &value)?);
        }
    }
    Ok(line)
}

/// Option and value in one word of a command line; `None` for a flag that is not set.
fn argument(option: &Described, value: &Bound<'_, PyAny>) -> PyResult<Option<OsString>> {
    let name = format!("--{}", option.name);
    if let Ok(flag) = value.cast::<PyBool>() {
        return match (option.value, flag.is_true()) {
            (Value::None | Value::Optional, true) => Ok(Some(name.into())),
            (Value::None | Value::Optional, false) => Ok(None),
            _ => Err(PyTypeError::new_err(format!("{} cannot be a bool", key(option)))),
        };
    }
    if option.value == Value::None {
        return Err(PyTypeError::new_err(format!("{} is True or False", key(option))));
    }
    let mut word = OsString::from(name + "=");
    word.push(text(option, value)?);
    Ok(Some(word))
}

fn key(option: &Described) -> String {
    option.name.replace('-', "_")
}

/// A value as the command line has it: colours may be red, green, blue (and alpha), several numbers a tuple.
fn text(option: &Described, value: &Bound<'_, PyAny>) -> PyResult<OsString> {
    if value.is_instance_of::<PyString>() {
        return value.extract();
    }
    if value.is_instance_of::<PyFloat>() {
        let number: f64 = value.extract()?;
        return Ok(match option.unit.as_str() {
            // Nanoseconds are the finest that is read.
            "TIME" | "RATE" => format!("{number:.9}").into(),
            _ => number.to_string().into(),
        });
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(value.str()?.extract::<String>()?.into());
    }
    if let Ok(path) = value.extract::<PathBuf>() {
        return Ok(path.into());
    }
    if option.unit == "COLOUR"
        && let Ok(colour) = value.extract::<Vec<u8>>()
    {
        let hex: String = colour.iter().map(|channel| format!("{channel:02x}")).collect();
        return Ok(format!("#{hex}").into());
    }
    if let Ok(several) = value.cast::<PyTuple>() {
        let parts: PyResult<Vec<OsString>> =
            several.iter().map(|part| text(option, &part)).collect();
        return Ok(parts?.join(",".as_ref()));
    }
    // Numbers of numpy's, and fractions.
    if value.extract::<f64>().is_ok() {
        return Ok(value.str()?.extract::<String>()?.into());
    }
    let kind = value.get_type().name()?;
    Err(PyTypeError::new_err(format!("{} cannot be a {kind}", key(option))))
}

fn unknown(name: &str, only_look: bool) -> PyErr {
    let known = all().iter().filter(|option| option.is_look || !only_look).map(key);
    let nearest = known.min_by_key(|other| distance(name, other));
    let hint = nearest
        .filter(|other| distance(name, other) <= 1 + name.len() / 3)
        .map_or_else(String::new, |other| format!("; did you mean '{other}'?"));
    PyTypeError::new_err(format!("'{name}' is not an option of polyreel{hint}"))
}

/// Levenshtein's distance: the fewest letters to insert, delete or replace.
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut corner = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.chars().enumerate() {
            let replaced = corner + usize::from(x != y);
            corner = row[j + 1];
            row[j + 1] = replaced.min(corner + 1).min(row[j] + 1);
        }
    }
    row[b.chars().count()]
}
