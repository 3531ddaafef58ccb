//! One file a command; what they share is here.

mod batch;
mod capture;
mod compare;
mod demo;
mod info;
mod maker;
mod params;
mod picture;
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
        Command::Pattern(args) => maker::pattern(args, terminal),
        Command::Simulate(args) => maker::simulate(args, terminal),
        Command::Filter(args) => stage::filter(args, terminal),
        Command::Detect(args) => stage::detect(args, terminal),
        Command::Match(args) => stage::find_matches(args, terminal),
        Command::Triangulate(args) => stage::triangulate(args, terminal),
        Command::Register(args) => stage::register(args, terminal),
        Command::Deform(args) => stage::deform(args, terminal),
        Command::Surface(args) => stage::surface(args, terminal),
        Command::Smooth(args) => stage::smooth(args, terminal),
        Command::Texture(args) => stage::texture(args, terminal),
        Command::Render(args) => picture::render(args, terminal),
        Command::Compare(args) => compare::compare(args, terminal),
        Command::Info { file } => info::info(file, terminal),
        Command::Convert { input, output } => info::convert(input, output, terminal),
        Command::Template { action } => template::template(action, terminal),
        Command::Params(args) => params::print(args, terminal),
        Command::Completions { shell } => params::completions(*shell, terminal),
    }
}

/// The parameters as the arguments ask for them.
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

/// The same for a whole reconstruction; a setting counts before the flag.
fn load_params_of(args: &ParamArgs, shape: ShapeArgs) -> Result<Params, Failure> {
    let mut args = args.clone();
    if shape.surface {
        args.set.insert(0, "surface.method=auto".into());
    }
    load_params(&args)
}

/// Parts `NAME=VALUE`.
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

/// Checks that a result can lie in a folder before the work for it is done.
fn free_folder(folder: &Path) -> Result<(), Failure> {
    let file = folder.ancestors().find(|p| p.exists()).filter(|p| !p.is_dir());
    match file {
        Some(file) => {
            let source = std::io::Error::other("a file of that name is there; a folder is wanted");
            Err(IoError::Write { path: file.to_owned(), source }.into())
        }
        None => Ok(()),
    }
}

/// Checks that the name of a picture to write says PNG.
fn named_png(path: &Path) -> Result<(), Failure> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("png") => Ok(()),
        _ => Err(Failure::usage(format!("{}: pictures are written as .png", path.display()))),
    }
}

/// JSON for stdout.
fn to_json(value: &serde_json::Value) -> String {
    format!("{value:#}")
}
