//! `facerecon reconstruct`.

use facerecon_core::data::Capture;
use facerecon_core::observer::Observer;
use facerecon_core::output::{self, report};
use facerecon_core::output::{Record, Recorder};
use facerecon_core::pipeline::Params;
use facerecon_core::pipeline::{Reconstruction, reconstruct as run_pipeline};
use facerecon_core::render::Frame;
use facerecon_core::template::Template;

use super::{capture, free_folder, load_params_of, template, to_json};
use crate::args::{FrameArg, ReconstructArgs};
use crate::failure::Failure;
use crate::output::Terminal;
use crate::progress::Progress;

/// Reconstructs a capture and writes the result folder.
pub(super) fn reconstruct(args: &ReconstructArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params_of(&args.params, args.shape)?;
    free_folder(&args.output)?;
    let loaded = capture::read(&args.capture)?;
    let head = template::load(&args.template, terminal)?;
    let (mut found, record) = watched(&loaded.capture, &head, &params, terminal)?;
    found.warnings.splice(0..0, loaded.warnings);
    output::write_result(
        &args.output,
        &loaded.capture,
        &found,
        &record,
        frame(args.frame),
        args.keep_stages,
    )?;
    tell(&found, terminal);
    terminal.say(format!("wrote {}", args.output.display()));
    if terminal.json {
        terminal.result(&to_json(&output::result_json(&found)));
    }
    Ok(())
}

/// Runs the pipeline under a progress display, keeping what the stages showed.
pub(super) fn watched(
    capture: &Capture,
    head: &Template,
    params: &Params,
    terminal: &Terminal,
) -> Result<(Reconstruction, Record), Failure> {
    let recorder = Recorder::default();
    let progress = Progress::new(terminal.quiet);
    let found = run_pipeline(capture, head, params, &[&progress as &dyn Observer, &recorder])?;
    drop(progress);
    Ok((found, recorder.take()))
}

/// Says what was found.
pub(super) fn tell(found: &Reconstruction, terminal: &Terminal) {
    for sentence in report::summary(found) {
        terminal.say(sentence);
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
