//! `facerecon batch`: many captures, resumable, one failure does not stop the rest.

use std::path::{Path, PathBuf};

use facerecon_core::io::{self, IoError};
use facerecon_core::output::batch::{self, Outcome, Status};
use facerecon_core::pipeline::Error;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde_json::json;

use super::{free_folder, load_params_of, reconstruct, template, to_json};
use crate::args::BatchArgs;
use crate::failure::Failure;
use crate::output::Terminal;

/// Reconstructs many captures, as many at once as there are threads.
pub(super) fn batch(args: &BatchArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params_of(&args.params, args.shape)?;
    let head = template::load(&args.template, terminal)?;
    free_folder(&args.output)?;
    let captures = find_captures(&args.captures)?;
    let shared = batch::shared_names(&captures);
    if !shared.is_empty() {
        return Err(Failure::usage(format!(
            "more than one capture is named {}; their results would overwrite each other",
            shared.join(", ")
        )));
    }
    let frame = reconstruct::frame(args.frame);
    let bar = if terminal.quiet {
        ProgressBar::hidden()
    } else {
        ProgressBar::new(captures.len() as u64)
    };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    let outcomes: Vec<Outcome> = captures
        .par_iter()
        .map(|capture| {
            let done = batch::run(capture, &args.output, &head, &params, frame, None);
            bar.set_message(done.name.clone());
            bar.inc(1);
            done
        })
        .collect();
    bar.finish_and_clear();
    io::atomic::write(&args.output.join("batch.csv"), batch::to_csv(&outcomes).as_bytes())?;
    io::atomic::write(&args.output.join("batch.html"), batch::to_html(&outcomes)?.as_bytes())?;
    let failed = outcomes.iter().filter(|o| o.status == Status::Failed).count();
    for outcome in &outcomes {
        terminal.say(outcome.to_string());
    }
    if terminal.json {
        terminal.result(&to_json(&json!(outcomes)));
    }
    if failed > 0 {
        let (count, table) = (outcomes.len(), args.output.join("batch.csv"));
        return Err(Error::Input(format!(
            "{failed} of {count} captures could not be reconstructed; {} says why",
            table.display()
        ))
        .into());
    }
    Ok(())
}

/// The capture folders named, or those in the folders named, in order of their names.
fn find_captures(given: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut found = Vec::new();
    for path in given {
        if path.is_file() || path.join("capture.toml").is_file() {
            found.push(path.clone());
            continue;
        }
        let fail = |source| IoError::Read { path: path.clone(), source };
        let mut inner: Vec<PathBuf> = std::fs::read_dir(path)
            .map_err(fail)?
            .filter_map(Result::ok)
            .map(|entry| entry.path())
            .filter(|folder| is_capture(folder))
            .collect();
        inner.sort();
        found.append(&mut inner);
    }
    if found.is_empty() {
        return Err(Failure::usage("no folder with a capture.toml was found"));
    }
    Ok(found)
}

fn is_capture(folder: &Path) -> bool {
    folder.join("capture.toml").is_file()
}
