//! The top error: which stage or file failed, and what to do next.

use crate::compare::CompareError;
use crate::io::IoError;
use crate::pattern::PatternError;
use crate::render::RenderError;
use crate::settings::SettingsError;
use crate::simulate::SimulateError;
use crate::stages::correspond::CorrespondError;
use crate::stages::deform::DeformError;
use crate::stages::detect::DetectError;
use crate::stages::filter::FilterError;
use crate::stages::rectify::RectifyError;
use crate::stages::refine::RefineError;
use crate::stages::register::RegisterError;
use crate::stages::smooth::SmoothError;
use crate::stages::surface::SurfaceError;
use crate::stages::texture::TextureError;
use crate::stages::triangulate::TriangulateError;
use crate::template::TemplateError;

/// Anything that ends a run. The message names the stage, or the file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read, understood or written.
    #[error(transparent)]
    File(#[from] IoError),
    /// A parameter that cannot be used.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Photos that cannot be rectified.
    #[error("{}", of_stage("rectify", .0))]
    Rectify(#[from] RectifyError),
    /// A photo that cannot be filtered.
    #[error("{}", of_stage("filter", .0))]
    Filter(#[from] FilterError),
    /// Dots that cannot be found.
    #[error("{}", of_stage("detect", .0))]
    Detect(#[from] DetectError),
    /// Dots that cannot be matched.
    #[error("{}", of_stage("correspond", .0))]
    Correspond(#[from] CorrespondError),
    /// Matches that cannot be refined.
    #[error("{}", of_stage("refine", .0))]
    Refine(#[from] RefineError),
    /// Matches that give no points.
    #[error("{}", of_stage("triangulate", .0))]
    Triangulate(#[from] TriangulateError),
    /// Points that do not fit the head.
    #[error("{}", of_stage("register", .0))]
    Register(#[from] RegisterError),
    /// A head that cannot be bent.
    #[error("{}", of_stage("deform", .0))]
    Deform(#[from] DeformError),
    /// A mesh that cannot be smoothed.
    #[error("{}", of_stage("smooth", .0))]
    Smooth(#[from] SmoothError),
    /// A surface that cannot be made.
    #[error("{}", of_stage("surface", .0))]
    Surface(#[from] SurfaceError),
    /// A mesh that cannot be coloured.
    #[error("{}", of_stage("texture", .0))]
    Texture(#[from] TextureError),
    /// A picture that cannot be drawn.
    #[error("{}", of_stage("render", .0))]
    Render(#[from] RenderError),
    /// A pattern that cannot be made.
    #[error("{}", of_stage("pattern", .0))]
    Pattern(#[from] PatternError),
    /// A capture that cannot be simulated.
    #[error("{}", of_stage("simulate", .0))]
    Simulate(#[from] SimulateError),
    /// Meshes that cannot be compared.
    #[error("{}", of_stage("compare", .0))]
    Compare(#[from] CompareError),
    /// A template that cannot be used.
    #[error(transparent)]
    Template(#[from] TemplateError),
    /// Something else the input lacks.
    #[error("{0}")]
    Input(String),
}

/// The message of a stage, named once: many say the stage, or the parameter, themselves.
fn of_stage(stage: &str, fault: &dyn std::fmt::Display) -> String {
    let message = fault.to_string();
    match message.strip_prefix(stage) {
        Some(rest) if rest.starts_with([':', '.']) => message,
        _ => format!("{stage}: {message}"),
    }
}

impl Error {
    /// Whether the fault lies in how the tool was called, not in the input.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Settings(_))
    }

    /// Name of the stage that failed, or `"file"`, `"parameters"`, `"input"`.
    pub fn stage(&self) -> &'static str {
        match self {
            Self::File(_) => "file",
            Self::Settings(_) => "parameters",
            Self::Rectify(_) => "rectify",
            Self::Filter(_) => "filter",
            Self::Detect(_) => "detect",
            Self::Correspond(_) => "correspond",
            Self::Refine(_) => "refine",
            Self::Triangulate(_) => "triangulate",
            Self::Register(_) => "register",
            Self::Deform(_) => "deform",
            Self::Smooth(_) => "smooth",
            Self::Surface(_) => "surface",
            Self::Texture(_) => "texture",
            Self::Render(_) => "render",
            Self::Pattern(_) => "pattern",
            Self::Simulate(_) => "simulate",
            Self::Compare(_) => "compare",
            Self::Template(_) => "template",
            Self::Input(_) => "input",
        }
    }

    /// Whether the run was stopped by its observer.
    pub fn is_cancelled(&self) -> bool {
        matches!(
            self,
            Self::Rectify(RectifyError::Cancelled)
                | Self::Filter(FilterError::Cancelled)
                | Self::Detect(DetectError::Cancelled)
                | Self::Correspond(CorrespondError::Cancelled)
                | Self::Refine(RefineError::Cancelled)
                | Self::Simulate(SimulateError::Cancelled)
                | Self::Compare(CompareError::Cancelled)
                | Self::Register(RegisterError::Cancelled)
                | Self::Deform(DeformError::Cancelled)
                | Self::Smooth(SmoothError::Cancelled)
                | Self::Surface(SurfaceError::Cancelled)
                | Self::Texture(TextureError::Cancelled)
        )
    }

    /// What to try next, beyond what the message says.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Settings(_) => Some("`facerecon params` lists every parameter with its meaning"),
            Self::Detect(_) | Self::Correspond(_) | Self::Filter(_) => {
                Some("`facerecon check CAPTURE` says what the photographs lack")
            }
            Self::Register(_) | Self::Deform(_) | Self::Surface(_) => {
                Some("`--keep-stages` writes what each stage made, to see where it goes wrong")
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_names_its_stage_once() {
        let own: Error = CorrespondError::NoDots { photo: "left" }.into();
        assert!(own.to_string().starts_with("correspond: the left photo"), "{own}");
        let bare: Error = RegisterError::Degenerate.into();
        assert!(bare.to_string().starts_with("register: the measured points"), "{bare}");
    }
}
