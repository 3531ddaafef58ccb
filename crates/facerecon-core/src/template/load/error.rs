//! Why a template cannot be used.

use std::path::PathBuf;

use crate::io::{IoError, LengthUnit};

/// Why a template cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TemplateError {
    /// A file cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// No template of that name.
    #[error(
        "unknown template {name}{hint}; give one of head, head-coarse, {known}, or a mesh file"
    )]
    Unknown {
        /// The name given.
        name: String,
        /// The most similar name.
        hint: String,
        /// The presets.
        known: String,
    },
    /// A preset without a file.
    #[error(
        "the mesh of {name} ({title}) is not part of this program; give its file as {name}=FILE"
    )]
    NoFile {
        /// The preset.
        name: &'static str,
        /// What it is.
        title: &'static str,
    },
    /// A file that does not match the preset.
    #[error(
        "{path} has {got} vertices, but {name} has {expected}; give the file of the preset, or use this file without it"
    )]
    VertexCount {
        /// The file.
        path: PathBuf,
        /// The preset.
        name: &'static str,
        /// Vertices of the file.
        got: usize,
        /// Vertices of the files of the preset.
        expected: String,
    },
    /// The unit of the file is not stated.
    #[error(
        "the unit of {path} is not stated; its height is {height:.4} units{fits}. Write unit = \"mm\" (or cm, m ...) into {sidecar}{preset}"
    )]
    UnitMissing {
        /// The file.
        path: PathBuf,
        /// Height in the unit of the file.
        height: f64,
        /// Units in which it has the size of a head.
        fits: String,
        /// The file in which to state it.
        sidecar: PathBuf,
        /// A preset with the same number of vertices.
        preset: String,
    },
    /// Not the size of a head.
    #[error(
        "in the unit {unit} {what} of the template {path} is {got_mm:.1} mm ({low} to {high} mm expected){fits}; state the right unit, or keep only the head"
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// What is measured: its height, or the distance between the outer corners of its eyes.
        what: &'static str,
        /// The unit.
        unit: LengthUnit,
        /// The measured length, mm.
        got_mm: f64,
        /// Least accepted length, mm.
        low: f64,
        /// Greatest accepted length, mm.
        high: f64,
        /// Units in which it has the size of a head.
        fits: String,
    },
    /// A landmark on a vertex that does not exist.
    #[error("{path}: {name} is vertex {index}, but {reason}")]
    Landmark {
        /// The file with the landmarks.
        path: PathBuf,
        /// The landmark.
        name: String,
        /// Its vertex, counted from 0.
        index: usize,
        /// Why that is invalid.
        reason: String,
    },
    /// Cropping left no mesh.
    #[error(
        "{path}: the {vertices} vertices have no face left after cropping; correct keep and top_mm"
    )]
    NothingKept {
        /// The file.
        path: PathBuf,
        /// Vertices of the file.
        vertices: usize,
    },
}
