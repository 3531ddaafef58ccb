//! `facerecon new`, `facerecon check`, and the reading of captures for all commands.

use std::path::Path;

use facerecon_core::io::capture::{
    CaptureFiles, LoadedCapture, new_capture_toml, read_capture_with,
};
use facerecon_core::io::{IoError, atomic};
use facerecon_core::observer::WarningCollector;
use facerecon_core::stages::check::{CheckReport, Verdict};
use facerecon_core::{Error, Params, check_capture};
use serde_json::json;

use super::shared::to_json;
use crate::args::CaptureArgs;
use crate::failure::Failure;
use crate::output::Terminal;

/// Reads the capture named by the arguments.
pub(super) fn read(args: &CaptureArgs) -> Result<LoadedCapture, Failure> {
    if args.capture.is_none() && args.left.is_none() {
        return Err(Failure::usage(
            "no capture: give a capture folder, or the photographs with --left and --right",
        ));
    }
    let given = CaptureFiles {
        left: args.left.clone(),
        right: args.right.clone(),
        left_plain: args.left_plain.clone(),
        right_plain: args.right_plain.clone(),
        calibration: args.calibration.clone(),
        columns: args.columns,
        rows: args.rows,
        ..CaptureFiles::default()
    };
    Ok(read_capture_with(args.capture.as_deref(), &given)?)
}

/// Writes a commented capture.toml.
pub(super) fn new(folder: &Path, terminal: &Terminal) -> Result<(), Failure> {
    let file = folder.join("capture.toml");
    if file.exists() {
        let path = file.display();
        return Err(Failure::usage(format!(
            "{path} exists already and is not overwritten; choose another folder"
        )));
    }
    atomic::write(&file, new_capture_toml().as_bytes()).map_err(|e: IoError| e)?;
    terminal.message(format!(
        "wrote {}; put the photographs into the same folder, then run: facerecon check {}",
        file.display(),
        folder.display()
    ));
    Ok(())
}

/// An error if the capture cannot be reconstructed.
fn refused(report: &CheckReport) -> Result<(), Failure> {
    match &report.refusal {
        None => Ok(()),
        Some(reason) => {
            Err(Error::Input(format!("the capture cannot be reconstructed: {reason}")).into())
        }
    }
}

/// Checks the photographs of a capture.
pub(super) fn check(args: &CaptureArgs, terminal: &Terminal) -> Result<(), Failure> {
    let loaded = read(args)?;
    // the findings are printed below; what rectify found would be lost without an observer
    let observer = WarningCollector::new(&());
    let report = check_capture(&loaded.capture, &Params::default(), &observer)?;
    let is_finding = |w: &String| w.starts_with("check: ");
    let rectify: Vec<_> = observer.into_warnings().into_iter().filter(|w| !is_finding(w)).collect();
    let warnings: Vec<_> = loaded.warnings.into_iter().chain(rectify).collect();
    if terminal.json {
        terminal.result(&to_json(&json!({
            "good": report.is_good() && warnings.is_empty(),
            "findings": report.findings,
            "refusal": report.refusal,
            "warnings": warnings,
        })));
        return refused(&report);
    }
    for warning in &warnings {
        terminal.warning(warning);
    }
    for finding in &report.findings {
        match finding.verdict {
            Verdict::Good => terminal.result(&format!("good: {}", finding.message)),
            Verdict::Warning | Verdict::Fault => {
                let kind = if finding.verdict == Verdict::Fault { "FAULT" } else { "WARNING" };
                let text = format!("{kind}: {}\n      -> {}", finding.message, finding.advice);
                terminal.result(&text);
            }
            Verdict::Unknown => terminal.result(&format!("unknown: {}", finding.message)),
        }
    }
    refused(&report)?;
    let verdict = if report.is_good() {
        "The photographs are good enough."
    } else if !report.faults().is_empty() {
        "A result of these photographs cannot be trusted; see the faults."
    } else {
        "The photographs can be improved; see the warnings."
    };
    terminal.result(verdict);
    Ok(())
}
