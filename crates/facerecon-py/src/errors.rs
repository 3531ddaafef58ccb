//! Errors of the core as exceptions of `facerecon.errors`.

use std::error::Error as _;

use facerecon_core::compare::CompareError;
use facerecon_core::error::Error;
use facerecon_core::pattern::PatternError;
use facerecon_core::simulate::SimulateError;
use pyo3::prelude::*;

/// The exception for an error: its class by the stage, its message with all causes.
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
    make(py, class(&error), &message, error.stage(), error.hint())
}

/// A fault of an argument that the facade could not see.
pub(crate) fn argument(py: Python<'_>, message: &str) -> PyErr {
    make(py, "ParameterError", message, "parameters", None)
}

fn make(py: Python<'_>, class: &str, message: &str, stage: &str, hint: Option<&str>) -> PyErr {
    let made = py
        .import("facerecon.errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1((message, stage, hint)));
    made.map_or_else(|failure| failure, PyErr::from_value)
}

fn class(error: &Error) -> &'static str {
    match error {
        Error::Settings(_)
        | Error::Simulate(SimulateError::Settings(_))
        | Error::Pattern(PatternError::Settings(_))
        | Error::Compare(CompareError::Settings(_)) => "ParameterError",
        Error::File(_) => "FileError",
        Error::Rectify(_) => "RectifyError",
        Error::Filter(_) => "FilterError",
        Error::Detect(_) => "DetectError",
        Error::Correspond(_) => "CorrespondError",
        Error::Refine(_) => "RefineError",
        Error::Triangulate(_) => "TriangulateError",
        Error::Register(_) => "RegisterError",
        Error::Deform(_) => "DeformError",
        Error::Smooth(_) => "SmoothError",
        Error::Surface(_) => "SurfaceError",
        Error::Texture(_) => "TextureError",
        Error::Render(_) => "RenderError",
        Error::Pattern(_) => "PatternError",
        Error::Simulate(_) => "SimulateError",
        Error::Compare(_) => "CompareError",
        Error::Template(_) => "TemplateError",
        Error::Input(_) => "InputError",
    }
}
