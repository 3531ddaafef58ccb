//! `facerecon batch`: many captures; resumable; a failure does not stop the others.

use facerecon_core::Error;
use facerecon_core::io;
use facerecon_core::output::batch::{self, Outcome, Status};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde_json::json;

use super::shared::{reconstruction_params, require_folder_path, to_json};
use super::{reconstruct, template};
use crate::args::BatchArgs;
use crate::failure::Failure;
use crate::output::Terminal;

/// Reconstructs many captures, as many at once as there are threads.
pub(super) fn batch(args: &BatchArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = reconstruction_params(&args.params, args.shape)?;
    let head = template::load(&args.template, terminal)?;
    require_folder_path(&args.output)?;
    let captures = batch::find_captures(&args.captures);
    let shared = batch::shared_names(&captures);
    if !shared.is_empty() {
        return Err(Failure::usage(format!(
            "several captures are named {}; their results would overwrite each other, so rename the folders",
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
            let outcome = batch::run(capture, &args.output, &head, &params, frame, None);
            bar.set_message(outcome.name.clone());
            bar.inc(1);
            outcome
        })
        .collect();
    bar.finish_and_clear();
    io::atomic::write(&args.output.join("batch.csv"), batch::to_csv(&outcomes).as_bytes())?;
    io::atomic::write(&args.output.join("batch.html"), batch::to_html(&outcomes)?.as_bytes())?;
    let failed = outcomes.iter().filter(|o| o.status == Status::Failed).count();
    for outcome in &outcomes {
        terminal.message(outcome.to_string());
    }
    if terminal.json {
        terminal.result(&to_json(&json!(outcomes)));
    }
    if failed > 0 {
        let (count, table) = (outcomes.len(), args.output.join("batch.csv"));
        return Err(Error::Input(format!(
            "{failed} of {count} captures could not be reconstructed; see the column `error` of {}",
            table.display()
        ))
        .into());
    }
    Ok(())
}
