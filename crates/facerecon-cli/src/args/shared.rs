//! Arguments that several commands share.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Where the parameters come from: a profile, then a file, then single settings; later ones win.
#[derive(Args, Clone, Default)]
pub(crate) struct ParamArgs {
    /// Set of methods and defaults: `precise` or `facebuilder` [default: precise].
    #[arg(long)]
    pub(crate) profile: Option<String>,
    /// TOML file with parameters (see `facerecon params`).
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// One parameter, e.g. `detect.method=thin`; may be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

/// What becomes the mesh.
#[derive(Args, Clone, Copy, Default)]
pub(crate) struct ShapeArgs {
    /// Mesh the measured surface itself instead of deforming a generic head; short for
    /// `--set surface.method=auto`.
    #[arg(long)]
    pub(crate) surface: bool,
}

/// Which generic head is fitted.
#[derive(Args, Clone, Default)]
pub(crate) struct TemplateArgs {
    /// Template to use instead of the built-in head: a mesh file with `NAME.landmarks.toml` beside
    /// it, or `PRESET=FILE` for a known template (see `facerecon template list`).
    #[arg(long, value_name = "FILE")]
    pub(crate) template: Option<String>,
}

/// A capture: a folder or capture.toml, or the photographs themselves.
#[derive(Args, Clone, Default)]
pub(crate) struct CaptureArgs {
    /// Capture folder or its capture.toml.
    #[arg(value_name = "CAPTURE")]
    pub(crate) capture: Option<PathBuf>,
    /// Left photo with the pattern, instead of a capture folder.
    #[arg(long, value_name = "IMAGE", requires = "right", conflicts_with = "capture")]
    pub(crate) left: Option<PathBuf>,
    /// Right photo with the pattern.
    #[arg(long, value_name = "IMAGE", requires = "left")]
    pub(crate) right: Option<PathBuf>,
    /// Left photo without the pattern (of the plain pair).
    #[arg(long, alias = "left-texture", value_name = "IMAGE", requires_all = ["left", "right_plain"])]
    pub(crate) left_plain: Option<PathBuf>,
    /// Right photo without the pattern (of the plain pair).
    #[arg(long, alias = "right-texture", value_name = "IMAGE", requires_all = ["left", "left_plain"])]
    pub(crate) right_plain: Option<PathBuf>,
    /// Calibration of the cameras (OpenCV YAML, XML or JSON); replaces that of the capture.
    #[arg(long, value_name = "FILE")]
    pub(crate) calibration: Option<PathBuf>,
    /// Columns of the projected pattern (`facerecon pattern`: 85) [default: the capture's].
    #[arg(long, value_name = "N")]
    pub(crate) columns: Option<usize>,
    /// Rows of the projected pattern (`facerecon pattern`: 64) [default: the capture's].
    #[arg(long, value_name = "N")]
    pub(crate) rows: Option<usize>,
}

/// Frame of the written coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FrameArg {
    /// x right, y up, z toward the viewer; the face looks along +z.
    Model,
    /// x right, y down, z forward, origin at the left camera.
    Camera,
}
