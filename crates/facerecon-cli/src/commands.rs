//! The commands, one file each or a few related ones together, and their shared helpers.

mod batch;
mod capture;
mod compare;
mod demo;
mod info;
mod make;
mod params;
mod pose;
mod render;
mod reconstruct;
mod stage;
mod template;

use std::path::Path;

use facerecon_core::io::IoError;
use facerecon_core::pipeline::Params;

use crate::args::{Cli, Command, ParamArgs, ShapeArgs};
use crate::failure::Failure;
use crate::output::Terminal;

/// Runs the command that was given.
pub(crate) fn run(cli: &Cli, terminal: &Terminal) -> Result<(), Failure> {
    match &cli.command {
        Command::Demo(args) => demo::demo(args, terminal),
        Command::New { dir } => capture::new(dir, terminal),
        Command::Check { capture } => capture::check(capture, terminal),
        Command::Reconstruct(args) => reconstruct::reconstruct(args, terminal),
        Command::Batch(args) => batch::batch(args, terminal),
        Command::Pattern(args) => make::pattern(args, terminal),
        Command::Simulate(args) => make::simulate(args, terminal),
        Command::Filter(args) => stage::filter(args, terminal),
        Command::Detect(args) => stage::detect(args, terminal),
        Command::Correspond(args) => stage::correspond(args, terminal),
        Command::Triangulate(args) => stage::triangulate(args, terminal),
        Command::Register(args) => stage::register(args, terminal),
        Command::Deform(args) => stage::deform(args, terminal),
        Command::Surface(args) => stage::surface(args, terminal),
        Command::Smooth(args) => stage::smooth(args, terminal),
        Command::Texture(args) => stage::texture(args, terminal),
        Command::Render(args) => render::render(args, terminal),
        Command::Compare(args) => compare::compare(args, terminal),
        Command::Info { file } => info::info(file, terminal),
        Command::Convert { input, output } => info::convert(input, output, terminal),
        Command::Template { action } => template::template(action, terminal),
        Command::Params(args) => params::print(args, terminal),
        Command::Completions { shell } => params::completions(*shell, terminal),
    }
}

/// The parameters that the arguments select.
fn load_params(args: &ParamArgs) -> Result<Params, Failure> {
    let text = match &args.config {
        Some(path) => {
            let text = facerecon_core::io::read_text(path, "parameter file")?;
            let fault = |e| Failure::usage(format!("{}: {e}", path.display()));
            text.parse::<toml::Table>().map_err(fault)?;
            Some(text)
        }
        None => None,
    };
    let sets = split_settings(&args.set)?;
    Ok(Params::load(args.profile.as_deref(), text.as_deref(), &sets)?)
}

/// The parameters of a reconstruction; `--set surface.method=...` overrides `--surface`.
fn reconstruction_params(args: &ParamArgs, shape: ShapeArgs) -> Result<Params, Failure> {
    let mut args = args.clone();
    if shape.surface {
        args.set.insert(0, "surface.method=auto".into());
    }
    load_params(&args)
}

/// Splits `NAME=VALUE` at the first `=`.
fn split_settings(settings: &[String]) -> Result<Vec<(String, String)>, Failure> {
    settings
        .iter()
        .map(|setting| match setting.split_once('=') {
            Some((name, value)) => Ok((name.trim().to_owned(), value.trim().to_owned())),
            None => Err(Failure::usage(format!(
                "--set {setting}: write NAME=VALUE, e.g. --set detect.method=thin"
            ))),
        })
        .collect()
}

/// Checks, before any work is done, that a folder can be made at this path.
fn require_folder_path(folder: &Path) -> Result<(), Failure> {
    let file = folder.ancestors().find(|p| p.exists()).filter(|p| !p.is_dir());
    match file {
        Some(file) => {
            let source = std::io::Error::other("a file with this name exists, but a folder is expected");
            Err(IoError::Write { path: file.to_owned(), source }.into())
        }
        None => Ok(()),
    }
}

/// Checks that the name of an image to write ends in `.png`.
fn require_png_name(path: &Path) -> Result<(), Failure> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("png") => Ok(()),
        _ => Err(Failure::usage(format!("{}: images can only be written as .png; use a name that ends in .png", path.display()))),
    }
}

/// Indented JSON for stdout.
fn to_json(value: &serde_json::Value) -> String {
    format!("{value:#}")
}
