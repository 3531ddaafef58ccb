//! Helpers of several commands.

use std::path::Path;

use facerecon_core::Params;
use facerecon_core::io::IoError;

use crate::args::{ParamArgs, ShapeArgs};
use crate::failure::Failure;

/// The parameters that the arguments select.
pub(super) fn load_params(args: &ParamArgs) -> Result<Params, Failure> {
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
pub(super) fn reconstruction_params(args: &ParamArgs, shape: ShapeArgs) -> Result<Params, Failure> {
    let mut args = args.clone();
    if shape.surface {
        args.set.insert(0, "surface.method=auto".into());
    }
    load_params(&args)
}

/// Splits `NAME=VALUE` at the first `=`.
pub(super) fn split_settings(settings: &[String]) -> Result<Vec<(String, String)>, Failure> {
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
pub(super) fn require_folder_path(folder: &Path) -> Result<(), Failure> {
    let file = folder.ancestors().find(|p| p.exists()).filter(|p| !p.is_dir());
    match file {
        Some(file) => {
            let source =
                std::io::Error::other("a file with this name exists, but a folder is expected");
            Err(IoError::Write { path: file.to_owned(), source }.into())
        }
        None => Ok(()),
    }
}

/// Checks that the name of an image to write ends in `.png`.
pub(super) fn require_png_name(path: &Path) -> Result<(), Failure> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("png") => Ok(()),
        _ => Err(Failure::usage(format!(
            "{}: images can only be written as .png; use a name that ends in .png",
            path.display()
        ))),
    }
}

/// Indented JSON for stdout.
pub(super) fn to_json(value: &serde_json::Value) -> String {
    format!("{value:#}")
}
