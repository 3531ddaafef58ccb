//! Why a capture cannot be simulated.

use crate::camera::RigError;
use crate::observer::Cancelled;
use crate::render::RenderError;
use crate::settings::SettingsError;
use crate::synthetic::pattern::PatternError;

/// Why a capture cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// A parameter out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A subject that cannot be drawn.
    #[error("the subject cannot be drawn: {0}")]
    Render(#[from] RenderError),
    /// A pattern out of range.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// Invalid cameras.
    #[error("the virtual rig is invalid: {0}")]
    Rig(#[from] RigError),
    /// A list that does not match the mesh.
    #[error("the {what} of the subject has {got} entries, but the mesh has {expected} vertices")]
    Subject {
        /// Which list.
        what: &'static str,
        /// Its entries.
        got: usize,
        /// The vertices.
        expected: usize,
    },
    /// A landmark on a vertex that does not exist.
    #[error(
        "the landmark {name} of the subject is vertex {vertex}, but the mesh has {vertices} vertices (counted from 0)"
    )]
    Landmark {
        /// The landmark.
        name: String,
        /// Its vertex.
        vertex: usize,
        /// The vertices of the mesh.
        vertices: usize,
    },
    /// No part of the subject in a photo.
    #[error(
        "the {camera} camera sees no part of the subject (its frontmost point is {distance_mm:.0} mm away); move the subject, reduce focal_px or increase toe_in_deg"
    )]
    Unseen {
        /// `left` or `right`.
        camera: &'static str,
        /// Distance of the subject.
        distance_mm: f64,
    },
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(SimulateError, "simulate");
