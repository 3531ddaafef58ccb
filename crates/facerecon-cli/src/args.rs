//! The arguments of every command.

mod shared;
mod stage;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

pub(crate) use shared::{CaptureArgs, FrameArg, ParamArgs, ShapeArgs, TemplateArgs};
pub(crate) use stage::{
    DeformArgs, DetectArgs, FilterArgs, FilterStep, RegisterArgs, SmoothArgs, StageArgs,
    SurfaceArgs, TextureArgs, TriangulateArgs,
};

/// Textured 3D face meshes from two stereo photographs under a projected pattern.
#[derive(Parser)]
#[command(name = "facerecon", version, propagate_version = true)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print results and errors only: no progress, no warnings.
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Print the result as JSON on stdout.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Number of threads; the result does not depend on it [default: one per core].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,
}

/// The commands.
#[derive(Subcommand)]
pub(crate) enum Command {
    /// Simulate a capture, reconstruct it and compare with the truth: needs no input.
    Demo(DemoArgs),
    /// Write a commented capture.toml to fill in.
    New {
        /// Folder of the capture.
        dir: PathBuf,
    },
    /// Check the photographs of a capture: whether they are good enough, and what to change.
    Check {
        #[command(flatten)]
        capture: CaptureArgs,
    },
    /// Reconstruct a capture: from photographs to a textured face.
    Reconstruct(ReconstructArgs),
    /// Reconstruct many captures; finished ones are skipped.
    Batch(BatchArgs),
    /// Write the image to project.
    Pattern(PatternArgs),
    /// Render a capture of a mesh under the projected pattern, with its ground truth.
    Simulate(SimulateArgs),
    /// Filter a photo as in the thesis: equalise, sharpen, threshold.
    Filter(FilterArgs),
    /// Find the dots of one photo.
    Detect(DetectArgs),
    /// Match the dots of the left photo with those of the right.
    #[command(visible_alias = "match")]
    Correspond(StageArgs),
    /// Compute points in space from a table of matches.
    Triangulate(TriangulateArgs),
    /// Align measured points with the generic head.
    Register(RegisterArgs),
    /// Deform the generic head to registered points.
    Deform(DeformArgs),
    /// Mesh the measured surface of a capture, without a generic head.
    Surface(SurfaceArgs),
    /// Smooth a mesh.
    Smooth(SmoothArgs),
    /// Colour a mesh from the photographs of a capture.
    Texture(TextureArgs),
    /// Render a mesh from named views.
    Render(RenderArgs),
    /// Measure distances between two meshes, before and after alignment.
    Compare(CompareArgs),
    /// Print facts about an image, mesh, calibration or capture, as JSON.
    Info {
        /// The file or capture folder.
        file: PathBuf,
    },
    /// Convert a mesh: OBJ, PLY, GLB, STL, VRML (read).
    Convert {
        /// Mesh to read.
        input: PathBuf,
        /// Mesh to write; the file extension sets the format.
        output: PathBuf,
    },
    /// List or export the built-in heads and the presets for known templates.
    Template {
        /// What to do.
        #[command(subcommand)]
        action: TemplateAction,
    },
    /// Print all parameters with documentation, as TOML.
    Params(ParamArgs),
    /// Print the completion script for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// `facerecon demo`.
#[derive(Args)]
pub(crate) struct DemoArgs {
    /// Folder for the result.
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Number of the simulated subject.
    #[arg(long, default_value_t = 1)]
    pub(crate) subject: u64,
    /// Also write the intermediate results of every stage.
    #[arg(long)]
    pub(crate) keep_stages: bool,
    #[command(flatten)]
    pub(crate) shape: ShapeArgs,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon reconstruct`.
#[derive(Args)]
pub(crate) struct ReconstructArgs {
    #[command(flatten)]
    pub(crate) capture: CaptureArgs,
    /// Folder for the result.
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Frame of the written coordinates.
    #[arg(long, value_enum, default_value_t = FrameArg::Model)]
    pub(crate) frame: FrameArg,
    /// Also write the intermediate results of every stage.
    #[arg(long)]
    pub(crate) keep_stages: bool,
    #[command(flatten)]
    pub(crate) template: TemplateArgs,
    #[command(flatten)]
    pub(crate) shape: ShapeArgs,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon batch`.
#[derive(Args)]
pub(crate) struct BatchArgs {
    /// Capture folders, or one folder that holds them.
    #[arg(required = true, value_name = "CAPTURE")]
    pub(crate) captures: Vec<PathBuf>,
    /// Folder for the results, one folder per capture.
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Frame of the written coordinates.
    #[arg(long, value_enum, default_value_t = FrameArg::Model)]
    pub(crate) frame: FrameArg,
    #[command(flatten)]
    pub(crate) template: TemplateArgs,
    #[command(flatten)]
    pub(crate) shape: ShapeArgs,
    #[command(flatten)]
    pub(crate) params: ParamArgs,
}

/// `facerecon pattern`.
#[derive(Args)]
pub(crate) struct PatternArgs {
    /// PNG to write.
    #[arg(long, short, value_name = "PNG")]
    pub(crate) output: PathBuf,
    /// One setting of the pattern, e.g. `columns=85`; may be repeated. `--set help` lists them.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

/// `facerecon simulate`.
#[derive(Args)]
pub(crate) struct SimulateArgs {
    /// Mesh to photograph, model frame, mm [default: a simulated subject].
    #[arg(value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    /// Capture folder to write.
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Number of the simulated subject.
    #[arg(long, default_value_t = 1)]
    pub(crate) subject: u64,
    /// One setting of the virtual rig, e.g. `distance_mm=1100`; may be repeated. `--set help` lists them.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

/// `facerecon render`.
#[derive(Args)]
pub(crate) struct RenderArgs {
    /// Mesh to render.
    pub(crate) mesh: PathBuf,
    /// Views, side by side: front, three-quarter, profile ...
    #[arg(long, value_delimiter = ',', default_value = "front,three-quarter,profile")]
    pub(crate) view: Vec<String>,
    /// Render mode: shaded, textured, lit (textured in studio light), wireframe, heat, or
    /// uncertainty (standard deviation of measured vertices; face.glb of a result has it).
    #[arg(long, default_value = "shaded")]
    pub(crate) mode: String,
    /// Mesh to which the distances of the heat map are measured.
    #[arg(long, value_name = "MESH")]
    pub(crate) against: Option<PathBuf>,
    /// Width and height of each view, pixels.
    #[arg(long, default_value_t = 600, value_name = "PX")]
    pub(crate) size: usize,
    /// PNG to write.
    #[arg(long, short, value_name = "PNG")]
    pub(crate) output: PathBuf,
}

/// `facerecon compare`.
#[derive(Args)]
pub(crate) struct CompareArgs {
    /// First mesh (A).
    pub(crate) a: PathBuf,
    /// Second mesh (B).
    pub(crate) b: PathBuf,
}

/// `facerecon template`.
#[derive(Subcommand)]
pub(crate) enum TemplateAction {
    /// List the built-in heads and the presets.
    List,
    /// Write a built-in head with its landmarks.
    Export {
        /// `head` or `head-coarse`.
        name: String,
        /// Mesh to write; `NAME.landmarks.toml` is written beside it.
        #[arg(long, short, value_name = "MESH")]
        output: PathBuf,
    },
}
