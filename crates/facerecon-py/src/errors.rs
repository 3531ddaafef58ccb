//! Errors of the core as exceptions of `facerecon.errors`.

use std::error::Error as _;

use facerecon_core::Error;
use pyo3::prelude::*;

/// The exception for an error: the class follows from the stage, the message holds all causes.
pub(crate) fn to_py(py: Python<'_>, error: impl Into<Error>) -> PyErr {
    let error = error.into();
    let mut message = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        let text = inner.to_string();
        if !message.contains(&text) {
            message.push_str(&format!(": {text}"));
        }
        cause = inner.source();
    }
    make(py, &class(&error), &message, error.stage(), error.hint())
}

/// The exception for an argument that the facade could not check.
pub(crate) fn argument(py: Python<'_>, message: &str) -> PyErr {
    make(py, "ParameterError", message, "parameters", None)
}

fn make(py: Python<'_>, class: &str, message: &str, stage: &str, hint: Option<&str>) -> PyErr {
    let exception = py
        .import("facerecon.errors")
        // a stage without an error class of its own
        .and_then(|module| module.getattr(class).or_else(|_| module.getattr("InputError")))
        .and_then(|class| class.call1((message, stage, hint)));
    exception.map_or_else(|failure| failure, PyErr::from_value)
}

/// Name of the exception: for a stage its name and "Error", as in `DetectError`.
fn class(error: &Error) -> String {
    let name = match error {
        Error::Settings(_) => "parameter",
        Error::File(_) => "file",
        Error::Template(_) => "template",
        Error::Render(_) => "render",
        Error::Input(_) => "input",
        Error::Stage { stage, .. } => stage,
    };
    let mut letters = name.chars();
    let first = letters.next().map(|c| c.to_ascii_uppercase());
    first.into_iter().chain(letters).chain("Error".chars()).collect()
}
