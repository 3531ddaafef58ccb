//! Template heads: the built-in head, mesh files as templates, and presets for known ones.
//!
//! The built-in head is this project's own: a function (`sculpt`) maps a chart of half the head to
//! space, from anthropometric proportions. `assets/` stores only the chart positions of the
//! vertices, their texture coordinates and the triangles; vertex positions are computed on loading.
//! `tools/build-head` makes the stored part.

mod assemble;
mod built_in;
mod half_head;
mod load;
pub mod presets;
mod sculpt;
#[cfg(test)]
mod tests;

pub use assemble::Template;
pub use built_in::{built_in, head, head_coarse, named};
pub use load::{
    LoadedTemplate, TemplateError, landmarks_toml, load_template, resolve, sidecar_path,
    write_landmarks,
};

pub(crate) use assemble::assemble;
pub(crate) use built_in::stored_half;
pub(crate) use sculpt::{Mouth, Proportions, Sculpt, smoothstep};

/// What `tools/build-head` needs. Not part of the public interface.
#[doc(hidden)]
pub mod build {
    pub use super::half_head::{HALF_LANDMARKS, HalfHead};
    pub use super::sculpt::{
        Ear, Eye, Mouth, NECK_LATITUDE_DEG, Nose, Proportions, Sculpt, smoothstep,
    };
}
