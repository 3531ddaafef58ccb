//! `facerecon demo`.

use facerecon_core::observer::Observer;
use facerecon_core::output::Recorder;
use facerecon_core::render::Frame;
use facerecon_core::{io, output, synthetic::demo as core_demo};
use serde_json::json;

use super::{free_folder, load_params_of, reconstruct, to_json};
use crate::args::DemoArgs;
use crate::failure::Failure;
use crate::output::Terminal;
use crate::progress::Progress;

/// Simulates a capture, reconstructs it, compares with the truth.
pub(super) fn demo(args: &DemoArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params_of(&args.params, args.shape)?;
    free_folder(&args.output)?;
    let recorder = Recorder::default();
    let progress = Progress::new(terminal.quiet);
    let made = core_demo::demo(args.subject, &params, &[&progress as &dyn Observer, &recorder])?;
    drop(progress);
    let folder = &args.output;
    facerecon_core::synthetic::simulate::write_simulated(&folder.join("capture"), &made.simulated)?;
    output::write_result(
        folder,
        &made.simulated.capture,
        &made.found,
        &recorder.take(),
        Frame::Model,
        args.keep_stages,
    )?;
    io::image::write_png(&folder.join("picture.png"), &core_demo::picture(&made)?)?;
    reconstruct::tell(&made.found, terminal);
    let error = &made.error;
    terminal.say(format!(
        "Against the true face it was made from: median {:.3} mm, 90 % within {:.3} mm, 99 % within {:.3} mm.",
        error.median_mm, error.p90_mm, error.p99_mm
    ));
    terminal
        .say(format!("wrote {0}; look at {0}/report.html and {0}/picture.png", folder.display()));
    if terminal.json {
        let mut facts = output::result_json(&made.found);
        facts["error_mm"] = json!(error);
        terminal.result(&to_json(&facts));
    }
    Ok(())
}
