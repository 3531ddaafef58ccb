//! Errors of the core as exceptions of `facerecon.errors`.

use std::error::Error as _;

use facerecon_core::pipeline::Error;
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
    make(py, class(&error), &message, error.stage(), error.hint())
}

/// The exception for an argument that the facade could not check.
pub(crate) fn argument(py: Python<'_>, message: &str) -> PyErr {
    make(py, "ParameterError", message, "parameters", None)
}

fn make(py: Python<'_>, class: &str, message: &str, stage: &str, hint: Option<&str>) -> PyErr {
    let exception = py
        .import("facerecon.errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1((message, stage, hint)));
    exception.map_or_else(|failure| failure, PyErr::from_value)
}

fn class(error: &Error) -> &'static str {
    match error {
        Error::Settings(_) => "ParameterError",
        Error::File(_) => "FileError",
        Error::Template(_) => "TemplateError",
        Error::Render(_) => "RenderError",
        Error::Input(_) => "InputError",
        Error::Stage { stage, .. } => match *stage {
            "rectify" => "RectifyError",
            "filter" => "FilterError",
            "detect" => "DetectError",
            "correspond" => "CorrespondError",
            "refine" => "RefineError",
            "triangulate" => "TriangulateError",
            "register" => "RegisterError",
            "deform" => "DeformError",
            "smooth" => "SmoothError",
            "surface" => "SurfaceError",
            "texture" => "TextureError",
            "pattern" => "PatternError",
            "simulate" => "SimulateError",
            "compare" => "CompareError",
            _ => "InputError",
        },
    }
}
