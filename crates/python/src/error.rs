//! Errors as Python's exceptions.

use pyo3::prelude::*;

pub(crate) use raised::{Error as PolyreelError, UsageError};
use raised::{InputError, OutputError};

/// The exceptions, under the names that they have in Python.
mod raised {
    use pyo3::create_exception;
    use pyo3::exceptions::PyException;

    create_exception!(
        polyreel,
        Error,
        PyException,
        "What polyreel raises; its subclasses say what is wrong."
    );
    create_exception!(
        polyreel,
        UsageError,
        Error,
        "The request itself cannot be meant: an option out of its range."
    );
    create_exception!(polyreel, InputError, Error, "An input cannot be read or understood.");
    create_exception!(polyreel, OutputError, Error, "An output cannot be written.");
}

/// Adds the exceptions to the module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<PolyreelError>())?;
    module.add("UsageError", py.get_type::<UsageError>())?;
    module.add("InputError", py.get_type::<InputError>())?;
    module.add("OutputError", py.get_type::<OutputError>())
}

/// The exception for `error`, with all its causes in the message.
pub(crate) fn raise(error: impl Into<polyreel::Error>) -> PyErr {
    let error = error.into();
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(&error);
    while let Some(error) = cause {
        let more = error.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        cause = error.source();
    }
    match error {
        _ if error.is_usage() => UsageError::new_err(text),
        polyreel::Error::Input { .. } => InputError::new_err(text),
        polyreel::Error::Output { .. } => OutputError::new_err(text),
        _ => PolyreelError::new_err(text),
    }
}

/// The exception for a panic, which is a fault of polyreel's own.
pub(crate) fn fault() -> PyErr {
    PolyreelError::new_err(
        "polyreel failed by a fault of its own: please report it, with the input that led to it",
    )
}
