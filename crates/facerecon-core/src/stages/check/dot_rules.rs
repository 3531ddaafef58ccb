//! Rules about the projected dots: number, contrast, sharpness, spacing, the subject's place, rows.

use std::ops::RangeInclusive;

use super::dot_figures::DotFigures;
use super::input::{CheckInput, PhotoDots};
use super::report::CheckReport;
use super::{CheckParams, row_offset};
use crate::camera::View;
use crate::data::Gray;
use crate::math::Vec2;

/// Dots nearer to a side of the photo than this fraction of its width count as cut off there. Set
/// by hand.
const SIDE_MARGIN: f64 = 0.02;
/// Where the middle of the subject may be, as fractions of the photo's width. Set by hand: a face
/// further out is probably cut off at one side.
const MIDDLE: RangeInclusive<f64> = 0.2..=0.8;

/// Checks all rules about dots.
pub(super) fn all(input: &CheckInput<'_>, params: &CheckParams, report: &mut CheckReport) {
    match &input.dots {
        [Some(left), Some(right)] => {
            let photos = [&input.capture.left.gray, &input.capture.right.gray];
            number(left, right, params, report);
            profiles(photos, [left, right], params, report);
            spacing(left.spacing_px.min(right.spacing_px), params, report);
            rows(input, [left, right], params, report);
        }
        [left, _] => {
            let which = if left.is_none() { "left" } else { "right" };
            let message = format!("no dot pattern was found in the {which} photo");
            let advice = "check that it is the photo with the pattern, and in focus";
            report.add("dots", false, message, advice);
        }
    }
}

fn number(
    left: &PhotoDots<'_>,
    right: &PhotoDots<'_>,
    params: &CheckParams,
    report: &mut CheckReport,
) {
    let (left, right) = (left.dots.len(), right.dots.len());
    let ratio = left.min(right) as f64 / left.max(right).max(1) as f64;
    let message = format!(
        "{left} dots in the left photo, {right} in the right: {:.0} % of the larger number (at least {:.0} % expected)",
        100.0 * ratio,
        100.0 * params.min_dot_ratio
    );
    let advice = "place the subject in the middle of both photos, and aim both cameras at it";
    report.add("dots", ratio >= params.min_dot_ratio, message, advice);
}

/// Contrast, sharpness and the subject's place.
fn profiles(
    photos: [&Gray; 2],
    found: [&PhotoDots<'_>; 2],
    params: &CheckParams,
    report: &mut CheckReport,
) {
    let measure = |i: usize| DotFigures::measure(photos[i], found[i]);
    let (Some(left), Some(right)) = rayon::join(|| measure(0), || measure(1)) else { return };
    let contrast = left.contrast.min(right.contrast);
    let message = format!(
        "the brighter half of the dots is {contrast:.0} grey levels above its surroundings (at least {:.0} expected)",
        params.min_contrast
    );
    let advice = "use a brighter projector, less room light, or a longer exposure";
    report.add("contrast", contrast >= params.min_contrast, message, advice);
    let blur = left.half_radius.max(right.half_radius);
    let message = format!(
        "the dots fall to half their height within {blur:.2} spacings (at most {:.2} expected)",
        params.max_blur
    );
    let advice = "focus projector and cameras on the face, close the apertures, hold still";
    report.add("sharpness", blur <= params.max_blur, message, advice);
    for (i, figures) in [left, right].iter().enumerate() {
        subject(["left", "right"][i], photos[i].size(), figures, report);
    }
}

fn subject(
    photo: &str,
    (width, height): (usize, usize),
    figures: &DotFigures,
    report: &mut CheckReport,
) {
    let (low, high) = (figures.bright_low, figures.bright_high);
    let cut_left = low.x < SIDE_MARGIN * width as f64;
    let cut_right = high.x > (1.0 - SIDE_MARGIN) * width as f64;
    let middle = figures.bright_middle / width as f64;
    // A pattern that is cut off at both sides is on a wall as well. Crown and chin may be cut off.
    let good = cut_left == cut_right && MIDDLE.contains(&middle);
    let message = format!(
        "in the {photo} photo the brightest dots span columns {:.0} to {:.0} of {width} and rows {:.0} to {:.0} of {height}, with their middle at {:.0} % of the width ({:.0} % to {:.0} % expected, cut off at neither side)",
        low.x,
        high.x,
        low.y,
        high.y,
        100.0 * middle,
        100.0 * MIDDLE.start(),
        100.0 * MIDDLE.end()
    );
    let advice = "place the whole face in both photos, near the middle";
    report.add("subject", good, message, advice);
}

fn spacing(spacing_px: f64, params: &CheckParams, report: &mut CheckReport) {
    let message = format!(
        "neighbouring dots are {spacing_px:.1} px apart (at least {:.1} px expected)",
        params.min_spacing_px
    );
    let advice = "take larger photos, move closer, or project a coarser pattern";
    report.add("spacing", spacing_px >= params.min_spacing_px, message, advice);
}

fn rows(
    input: &CheckInput<'_>,
    found: [&PhotoDots<'_>; 2],
    params: &CheckParams,
    report: &mut CheckReport,
) {
    let views = match &input.views {
        Ok(views) => views,
        Err(reason) => {
            return report.add("rows", false, reason.clone(), "correct the photos or calibration");
        }
    };
    let rectified = |view: &View, found: &PhotoDots<'_>| -> Vec<Vec2> {
        found.dots.iter().map(|d| view.to_rectified(d.position)).collect()
    };
    let (left, right) = (rectified(&views.left, found[0]), rectified(&views.right, found[1]));
    let spacing = found[0].spacing_px;
    let Some(offset) = row_offset::offset(&left, &right, spacing) else {
        let message = "the rows of dots are not distinct enough to compare";
        return report.add_unknown("rows", message.to_owned());
    };
    let state = match (views.rig.is_some(), input.rows_corrected) {
        (true, true) => "rectified by the calibration, rows corrected by the photos",
        (true, false) => "rectified by the calibration",
        (false, true) => "no calibration, rows corrected by the photos",
        (false, false) => "no calibration, as taken",
    };
    let message = format!(
        "rows are {:.2} px {} in the right photo than in the left ({state}; at most {:.1} px expected; whole multiples of the dot spacing, {spacing:.1} px, cannot be distinguished from 0)",
        offset.abs(),
        if offset < 0.0 { "higher" } else { "lower" },
        params.max_row_error_px
    );
    let advice = "level both cameras, or calibrate the rig again";
    report.add("rows", offset.abs() <= params.max_row_error_px, message, advice);
}
