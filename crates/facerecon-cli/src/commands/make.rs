//! `facerecon pattern`, `facerecon simulate`.

use facerecon_core::settings::{self, Value};
use facerecon_core::synthetic::pattern::{PatternParams, pattern_image};
use facerecon_core::synthetic::simulate::{
    SimulateParams, Subject, simulate as take_photos, write_simulated,
};
use facerecon_core::{io, synthetic::Person};
use serde::Serialize;
use serde::de::DeserializeOwned;

use serde_json::json;

use super::shared::{require_folder_path, require_png_name, split_settings};
use crate::args::{PatternArgs, SimulateArgs};
use crate::failure::Failure;
use crate::output::Terminal;
use crate::progress::Progress;

/// Writes the image to project.
pub(super) fn pattern(args: &PatternArgs, terminal: &Terminal) -> Result<(), Failure> {
    let Some(params) = command_settings::<PatternParams>("pattern", &args.set, terminal)? else {
        return Ok(());
    };
    require_png_name(&args.output)?;
    let image = pattern_image(&params)?;
    io::image::write_png(&args.output, &image)?;
    terminal.wrote(&[&args.output], json!({ "width": image.width(), "height": image.height() }));
    Ok(())
}

/// Renders a capture and writes its folder with the ground truth.
pub(super) fn simulate(args: &SimulateArgs, terminal: &Terminal) -> Result<(), Failure> {
    let Some(params) = command_settings::<SimulateParams>("simulate", &args.set, terminal)? else {
        return Ok(());
    };
    require_folder_path(&args.output)?;
    let progress = Progress::new(terminal);
    let made = match &args.mesh {
        Some(path) => {
            let loaded = io::read_mesh(path)?;
            let (mesh, texture) = (&loaded.mesh, loaded.texture.as_ref());
            let subject = Subject { mesh, texture, landmarks: None, face: None };
            take_photos(&subject, &params, &progress)?
        }
        None => {
            let person = Person::new(args.subject);
            take_photos(&person.subject(), &params, &progress)?
        }
    };
    write_simulated(&args.output, &made)?;
    let facts = json!({ "dots": made.truth.dots.len() });
    terminal.wrote(&[&args.output], facts);
    Ok(())
}

/// The settings of `pattern` or `simulate` from `NAME=VALUE` arguments; `None` after printing the
/// list for `--set help`.
fn command_settings<T: Value + Serialize + DeserializeOwned + Default>(
    command: &str,
    given: &[String],
    terminal: &Terminal,
) -> Result<Option<T>, Failure> {
    if given.iter().any(|s| s == "help") {
        terminal.result(&settings::commented_toml(&T::default())?);
        return Ok(None);
    }
    let given = split_settings(given)?;
    let with_help =
        |e| Failure::usage(format!("{e}\n  `facerecon {command} --set help` lists the settings"));
    settings::from_sets(&given).map(Some).map_err(with_help)
}
