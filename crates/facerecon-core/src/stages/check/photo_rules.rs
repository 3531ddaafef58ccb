//! Rules about the photos as a whole: size, brightness, saturation, the plain pair.

use std::ops::RangeInclusive;

use super::CheckParams;
use super::photo_figures::{lit_level, saturated_fraction};
use super::report::CheckReport;
use crate::data::Capture;
use crate::math::median;

/// Grey level of the lit parts of a usable plain pair. Set by hand: below 40 noise and quantisation
/// show in the texture, above 245 hardly anything but saturated skin is left.
const PLAIN_LEVEL: RangeInclusive<f64> = 40.0..=245.0;
/// Maximum fraction of saturated pixels in the plain pair. Set by hand, twice the default of the
/// dotted pair: saturation spoils the colour of a spot, but no measurement.
const PLAIN_SATURATED: f64 = 0.02;

pub(super) fn resolution(capture: &Capture, params: &CheckParams, report: &mut CheckReport) {
    let (width, height) = capture.left.size();
    let CheckParams { min_width, min_height, .. } = *params;
    // photos in portrait format count as well
    let good = width.max(height) >= min_width.max(min_height)
        && width.min(height) >= min_width.min(min_height);
    let message = format!(
        "the photos are {width}x{height} pixels (at least {min_width}x{min_height} expected)"
    );
    report.add("resolution", good, message, "take larger photos, or project a coarser pattern");
    let right = capture.right.size();
    if right != (width, height) {
        let message = format!(
            "the right photo is {}x{} pixels, the left one {width}x{height} (one size expected)",
            right.0, right.1
        );
        report.add("resolution", false, message, "take both photos with the same size");
    }
}

pub(super) fn luminance(capture: &Capture, params: &CheckParams, report: &mut CheckReport) {
    let [left, right] = [&capture.left.gray, &capture.right.gray].map(lit_level);
    let ratio = left.max(right) / left.min(right).max(1.0);
    let message = format!(
        "the lit parts have a grey level of {left:.0} in the left photo and {right:.0} in the right, a ratio of {ratio:.2} (at most {:.2} expected)",
        params.max_luminance_ratio
    );
    let advice = "set both cameras to the same exposure and light the subject from the front";
    report.add("luminance", ratio <= params.max_luminance_ratio, message, advice);
}

pub(super) fn saturation(capture: &Capture, params: &CheckParams, report: &mut CheckReport) {
    let photos = [&capture.left.gray, &capture.right.gray];
    let fraction = photos.map(saturated_fraction).into_iter().fold(0.0, f64::max);
    let message = format!(
        "{:.2} % of the pixels are saturated (at most {:.2} % expected)",
        100.0 * fraction,
        100.0 * params.max_saturated
    );
    let advice = "no flash; less light or a shorter exposure, powder on shiny skin";
    report.add("saturation", fraction <= params.max_saturated, message, advice);
}

pub(super) fn plain_pair(capture: &Capture, report: &mut CheckReport) {
    let Some(pair) = &capture.plain else {
        let message = "there is no plain pair (photos without the pattern), so there is no texture";
        let advice = "take a plain pair from the same place";
        report.add("plain", false, message.to_owned(), advice);
        return;
    };
    let levels = [&pair[0].gray, &pair[1].gray].map(lit_level);
    let saturated = pair.iter().map(|p| saturated_fraction(&p.gray)).fold(0.0, f64::max);
    let level = median(&levels).unwrap_or(0.0);
    let good = PLAIN_LEVEL.contains(&level) && saturated <= PLAIN_SATURATED;
    let message = format!(
        "the plain pair has a grey level of {level:.0} in its lit parts ({:.0} to {:.0} expected) and {:.2} % saturated pixels (at most {:.0} % expected)",
        PLAIN_LEVEL.start(),
        PLAIN_LEVEL.end(),
        100.0 * saturated,
        100.0 * PLAIN_SATURATED
    );
    report.add("plain", good, message, "expose the plain pair for the skin");
}
