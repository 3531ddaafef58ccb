//! Rules about photos that must belong together: left and right differ, the pair with the pattern
//! and the one without it show the same subject from the same cameras, and only one of them shows
//! the pattern.

use super::agreement::{agreement, pattern_remains, same_picture};
use super::input::CheckInput;
use super::report::CheckReport;
use crate::data::Gray;

/// Least agreement of the two photos of one camera. Above 0.88 on captures of one person, even with
/// light from one side; below 0.4 for another person and for photos of different cameras.
const LEAST_AGREEMENT: f64 = 0.5;
/// Below this the subject probably moved between the two photos: a shift by 1.5 dot spacings
/// leaves 0.6 to 0.72.
const SURE_AGREEMENT: f64 = 0.75;
/// Greatest height of the dots in the plain photo, relative to that in the dotted photo. At most
/// 0.02 on good captures; 1 if both show the pattern; 0.2 to 0.8 if the pairs are interchanged.
const MOST_PATTERN: f64 = 0.15;

/// Checks all rules about photos that belong together.
pub(super) fn all(input: &CheckInput<'_>, report: &mut CheckReport) {
    let capture = input.capture;
    let dotted = [&capture.left.gray, &capture.right.gray];
    let plain = capture.plain.as_ref().map(|pair| [&pair[0].gray, &pair[1].gray]);
    different("with the pattern", dotted, report);
    let Some(plain) = plain else { return };
    different("without the pattern", plain, report);
    let [Some(left), Some(right)] = &input.dots else { return };
    let remains = [
        pattern_remains([dotted[0], plain[0]], left.dots, left.spacing_px),
        pattern_remains([dotted[1], plain[1]], right.dots, right.spacing_px),
    ];
    let remaining = remains.into_iter().flatten().fold(0.0, f64::max);
    if remaining > MOST_PATTERN {
        let message = format!(
            "the photos without the pattern show {:.0} % of the pattern's contrast (at most {:.0} % expected)",
            100.0 * remaining,
            100.0 * MOST_PATTERN
        );
        let advice = "switch the projector off for the plain pair; do not interchange the pairs";
        report.add_fault("pairs", message, advice);
        return;
    }
    same_subject(dotted, plain, left.spacing_px.max(right.spacing_px), report);
}

/// The two photos of a pair must differ.
fn different(pair: &str, [left, right]: [&Gray; 2], report: &mut CheckReport) {
    if same_picture(left, right) {
        let message = format!("the left and the right photo {pair} are the same picture");
        report.add_fault("pairs", message, "give the photos of two cameras");
    }
}

/// Both photos of a camera must show the same.
fn same_subject(dotted: [&Gray; 2], plain: [&Gray; 2], spacing_px: f64, report: &mut CheckReport) {
    let compare = |i: usize, k: usize| agreement(dotted[i], plain[k], spacing_px);
    let ((left, right), (left_right, right_left)) = rayon::join(
        || rayon::join(|| compare(0, 0), || compare(1, 1)),
        || rayon::join(|| compare(0, 1), || compare(1, 0)),
    );
    let (Some(left), Some(right)) = (left, right) else { return };
    let least = left.min(right);
    let crossed = left_right.zip(right_left).map_or(f64::NEG_INFINITY, |(a, b)| a.min(b));
    if least < LEAST_AGREEMENT && crossed > SURE_AGREEMENT {
        let message = format!(
            "left and right look interchanged in one of the two pairs: each photo with the pattern agrees with the plain photo of the other camera by {crossed:.2}, with that of its own by {least:.2} (at least {LEAST_AGREEMENT:.2} expected)"
        );
        return report.add_fault("pairs", message, "interchange left and right of one pair");
    }
    let which = match (left < LEAST_AGREEMENT, right < LEAST_AGREEMENT) {
        (true, false) => "of the left camera",
        (false, true) => "of the right camera",
        _ => "of each camera",
    };
    let message = format!(
        "the photos {which} with and without the pattern agree by {least:.2} (at least {LEAST_AGREEMENT:.2} expected, 1 is the most)"
    );
    if least < LEAST_AGREEMENT {
        let advice = "give photos of the same person, taken from the same place; check their order";
        report.add_fault("pairs", message, advice);
    } else {
        let advice = "hold still between the two pairs";
        report.add("pairs", least >= SURE_AGREEMENT, message, advice);
    }
}
