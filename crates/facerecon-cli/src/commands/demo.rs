//! `facerecon demo`.

use facerecon_core::observer::Observer;
use facerecon_core::render::Frame;
use facerecon_core::{io, output, synthetic::demo as core_demo};
use serde_json::json;

use super::reconstruct;
use super::shared::{reconstruction_params, require_folder_path, to_json};
use crate::args::DemoArgs;
use crate::failure::Failure;
use crate::output::Terminal;

/// Simulates a capture, reconstructs it and compares the result with the ground truth.
pub(super) fn demo(args: &DemoArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = reconstruction_params(&args.params, args.shape)?;
    require_folder_path(&args.output)?;
    let stages = args.keep_stages.then_some(args.output.as_path());
    let run = |observer: &dyn Observer| core_demo::demo(args.subject, &params, observer);
    let (made, record) = reconstruct::recorded(run, stages, terminal)?;
    let folder = &args.output;
    facerecon_core::synthetic::simulate::write_simulated(&folder.join("capture"), &made.simulated)?;
    output::write_result(
        folder,
        &made.simulated.capture,
        &made.reconstruction,
        &record,
        Frame::Model,
        args.keep_stages,
    )?;
    io::image::write_png(&folder.join("picture.png"), &core_demo::picture(&made)?)?;
    reconstruct::print_summary(&made.reconstruction, terminal);
    let error = &made.error;
    terminal.message(format!(
        "Distance from the true face: median {:.3} mm, 90 % within {:.3} mm, 99 % within {:.3} mm.",
        error.median_mm, error.p90_mm, error.p99_mm
    ));
    terminal
        .message(format!("wrote {0}; see {0}/report.html and {0}/picture.png", folder.display()));
    terminal.message(made.reconstruction.verdict.to_string());
    if terminal.json {
        let mut facts = output::result_json(&made.reconstruction);
        facts["error_mm"] = json!(error);
        terminal.result(&to_json(&facts));
    }
    Ok(())
}
