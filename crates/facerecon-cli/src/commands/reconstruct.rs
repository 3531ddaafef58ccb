//! `facerecon reconstruct`.

use facerecon_core::Params;
use facerecon_core::data::Capture;
use facerecon_core::observer::Observer;
use facerecon_core::output::{self, report};
use facerecon_core::output::{Record, Recorder};
use facerecon_core::render::Frame;
use facerecon_core::template::Template;
use facerecon_core::{Reconstruction, reconstruct as run_pipeline};

use super::shared::{reconstruction_params, require_folder_path, to_json};
use super::{capture, template};
use crate::args::{FrameArg, ReconstructArgs};
use crate::failure::Failure;
use crate::output::Terminal;
use crate::progress::Progress;

/// Reconstructs a capture and writes the result folder.
pub(super) fn reconstruct(args: &ReconstructArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = reconstruction_params(&args.params, args.shape)?;
    require_folder_path(&args.output)?;
    let loaded = capture::read(&args.capture)?;
    let head = template::load(&args.template, terminal)?;
    let (mut found, record) = run_recorded(&loaded.capture, &head, &params, terminal)?;
    found.warnings.splice(0..0, loaded.warnings);
    output::write_result(
        &args.output,
        &loaded.capture,
        &found,
        &record,
        frame(args.frame),
        args.keep_stages,
    )?;
    print_summary(&found, terminal);
    terminal.message(format!("wrote {}", args.output.display()));
    terminal.message(found.verdict().to_string());
    if terminal.json {
        terminal.result(&to_json(&output::result_json(&found)));
    }
    Ok(())
}

/// Runs the pipeline with a progress display and records the artifacts of the stages.
fn run_recorded(
    capture: &Capture,
    head: &Template,
    params: &Params,
    terminal: &Terminal,
) -> Result<(Reconstruction, Record), Failure> {
    let recorder = Recorder::default();
    let progress = Progress::new(terminal);
    let found = run_pipeline(capture, head, params, &[&progress as &dyn Observer, &recorder])?;
    drop(progress);
    Ok((found, recorder.take()))
}

/// Prints the summary and those warnings that were not printed during the run.
pub(super) fn print_summary(found: &Reconstruction, terminal: &Terminal) {
    for sentence in report::summary(found) {
        terminal.message(sentence);
    }
    for warning in &found.warnings {
        terminal.warning(warning);
    }
}

pub(super) fn frame(frame: FrameArg) -> Frame {
    match frame {
        FrameArg::Model => Frame::Model,
        FrameArg::Camera => Frame::Camera,
    }
}
