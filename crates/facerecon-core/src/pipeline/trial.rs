//! The check of a capture: the rules on its photos, then a trial reconstruction.

use super::photo_check::check_photos;
use super::reconstruct::reconstruct_untextured;
use super::verdict::VerdictLevel;
use super::{Error, Params};
use crate::data::Capture;
use crate::observer::Observer;
use crate::stages::check::CheckReport;
use crate::template;

/// Passes on only the wish to cancel.
struct Quiet<'a>(&'a dyn Observer);

impl Observer for Quiet<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Checks a capture: its photographs by the thesis's rules (section 6.5.1), then whether a
/// reconstruction with the built-in head, without texture, succeeds and can be trusted. What is
/// wrong is a finding, not an error.
///
/// # Errors
/// A parameter out of its range, or a cancelled run.
pub fn check_capture(
    capture: &Capture,
    params: &Params,
    observer: &dyn Observer,
) -> Result<CheckReport, Error> {
    let mut report = check_photos(capture, params, observer)?;
    let rule = "reconstruction";
    match reconstruct_untextured(capture, &template::built_in(), params, &Quiet(observer)) {
        Ok(found) => {
            let verdict = &found.verdict;
            let known = report.faults();
            let reasons: Vec<&str> = verdict.reasons.iter().map(|r| r.text.as_str()).collect();
            let new: Vec<&str> =
                reasons.into_iter().filter(|r| known.iter().all(|k| k != r)).collect();
            let mut message = format!("a trial reconstruction is {}", verdict.level);
            if !new.is_empty() {
                message = format!("{message}: {}", new.join("; "));
            }
            match verdict.level {
                VerdictLevel::Doubtful => {
                    let advice = "check the photos, their order and the calibration";
                    report.add_fault(rule, message, advice);
                }
                level => {
                    let advice = "take the photos again where these parts matter";
                    report.add(rule, level == VerdictLevel::Good, message, advice);
                }
            }
        }
        Err(error) if error.is_cancelled() || error.is_usage() => return Err(error),
        Err(error) => {
            let message = format!("a trial reconstruction failed: {error}");
            let advice = "check the photos, their order and the calibration";
            report.add_fault(rule, message, advice);
            report.refusal = Some(error.to_string());
        }
    }
    Ok(report)
}
