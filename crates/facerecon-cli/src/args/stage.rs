//! The arguments of the commands that run one stage.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::shared::{CaptureArgs, ParamArgs, TemplateArgs};

/// `facerecon filter`.
#[derive(Args)]
pub(crate) struct FilterArgs {
    /// Photo to filter.
    pub(crate) image: PathBuf,
    /// PNG to write: the image after `--step`.
    #[arg(long, short, value_name = "PNG")]
    pub(crate) output: PathBuf,
    /// The step whose image is written.
    #[arg(long, value_enum, default_value_t = FilterStep::Threshold)]
    pub(crate) step: FilterStep,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// A step of the thesis's preprocessing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FilterStep {
    /// Histogram equalisation.
    Equalize,
    /// Sharpening (Eq. 2.1).
    Sharpen,
    /// Thresholding: white dots on black.
    Threshold,
    /// One white pixel per dot.
    Thin,
}

/// `facerecon detect`.
#[derive(Args)]
pub(crate) struct DetectArgs {
    /// Photo with the pattern.
    pub(crate) image: PathBuf,
    /// CSV to write: `id,x,y,sigma_px,amplitude,score`.
    #[arg(long, short, value_name = "CSV")]
    pub(crate) output: Option<PathBuf>,
    /// PNG to write: the photo with the dots marked.
    #[arg(long, value_name = "PNG")]
    pub(crate) picture: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// A command that works on a capture and writes one file.
#[derive(Args)]
pub(crate) struct StageArgs {
    #[command(flatten)]
    pub(crate) capture: CaptureArgs,
    /// File to write.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon triangulate`.
#[derive(Args)]
pub(crate) struct TriangulateArgs {
    /// Table of matches (CSV with `xl,yl,xr,yr`), in the photos' pixels.
    pub(crate) matches: PathBuf,
    /// The capture the matches belong to.
    #[arg(long, value_name = "CAPTURE")]
    pub(crate) capture: PathBuf,
    /// Cloud to write (PLY): camera frame, mm; model units without calibration.
    #[arg(long, short, value_name = "PLY")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) template: TemplateArgs,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon register`.
#[derive(Args)]
pub(crate) struct RegisterArgs {
    /// Cloud (PLY) in the camera frame, mm.
    pub(crate) cloud: PathBuf,
    /// Registered cloud to write (PLY), model frame; the transform is written beside it as JSON.
    #[arg(long, short, value_name = "PLY")]
    pub(crate) output: PathBuf,
    /// The cloud is in model units (made without calibration).
    #[arg(long, conflicts_with = "capture")]
    pub(crate) model_units: bool,
    /// The calibrated capture from which the cloud was computed: the landmarks marked in it give
    /// the initial alignment.
    #[arg(long, value_name = "CAPTURE")]
    pub(crate) capture: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) template: TemplateArgs,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon deform`.
#[derive(Args)]
pub(crate) struct DeformArgs {
    /// Registered cloud (PLY), model frame.
    pub(crate) cloud: PathBuf,
    /// Mesh to write.
    #[arg(long, short, value_name = "MESH")]
    pub(crate) output: PathBuf,
    /// JSON written by `register` [default: the one beside the cloud, if any].
    #[arg(long, value_name = "JSON")]
    pub(crate) pose: Option<PathBuf>,
    /// The calibrated capture from which the cloud was computed: the landmarks marked in it are
    /// targets too.
    #[arg(long, value_name = "CAPTURE")]
    pub(crate) capture: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) template: TemplateArgs,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon surface`.
#[derive(Args)]
pub(crate) struct SurfaceArgs {
    #[command(flatten)]
    pub(crate) capture: CaptureArgs,
    /// Mesh to write: camera frame, mm; model units without calibration.
    #[arg(long, short, value_name = "MESH")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) template: TemplateArgs,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon smooth`.
#[derive(Args)]
pub(crate) struct SmoothArgs {
    /// Mesh to smooth.
    pub(crate) mesh: PathBuf,
    /// Mesh to write.
    #[arg(long, short, value_name = "MESH")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon texture`.
#[derive(Args)]
pub(crate) struct TextureArgs {
    /// Mesh with texture coordinates: camera frame, mm; model frame with `--pose`.
    pub(crate) mesh: PathBuf,
    /// The capture whose photos without the pattern give the colours.
    #[arg(long, value_name = "CAPTURE")]
    pub(crate) capture: PathBuf,
    /// Textured mesh to write; an OBJ gets a PNG and an MTL beside it.
    #[arg(long, short, value_name = "MESH")]
    pub(crate) output: PathBuf,
    /// JSON written by `register`: the pose of the model frame relative to the cameras.
    #[arg(long, value_name = "JSON")]
    pub(crate) pose: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}
