//! `facerecon reconstruct`.

use std::path::Path;

use facerecon_core::observer::Observer;
use facerecon_core::output::{self, report};
use facerecon_core::output::{Record, Recorder, STAGES_FOLDER};
use facerecon_core::render::Frame;
use facerecon_core::{Error, Reconstruction, reconstruct as run_pipeline};

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
    let stages = args.keep_stages.then_some(args.output.as_path());
    let run = |observer: &dyn Observer| run_pipeline(&loaded.capture, &head, &params, observer);
    let (mut found, record) = recorded(run, stages, terminal)?;
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
    terminal.message(found.verdict.to_string());
    if terminal.json {
        terminal.result(&to_json(&output::result_json(&found)));
    }
    Ok(())
}

/// Runs with a progress display and records the artifacts of the stages. When the run fails, those
/// of the stages before the failure are written to `stages/` in the folder `keep`, if given.
pub(super) fn recorded<T>(
    run: impl FnOnce(&dyn Observer) -> Result<T, Error>,
    keep: Option<&Path>,
    terminal: &Terminal,
) -> Result<(T, Record), Failure> {
    let recorder = Recorder::default();
    let progress = Progress::new(terminal);
    let found = run(&[&progress as &dyn Observer, &recorder]);
    drop(progress);
    let record = recorder.take();
    match (found, keep) {
        (Ok(found), _) => Ok((found, record)),
        (Err(error), None) => Err(error.into()),
        (Err(error), Some(folder)) => {
            let folder = folder.join(STAGES_FOLDER);
            match record.write(&folder) {
                Ok(()) => terminal.message(format!(
                    "wrote {} intermediate results of the stages before the failure to {}",
                    record.artifacts.len(),
                    folder.display()
                )),
                Err(fault) => terminal
                    .warning(&format!("the intermediate results could not be written: {fault}")),
            }
            Err(error.into())
        }
    }
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
