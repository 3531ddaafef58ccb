//! Check: whether the photographs of a capture will do, by the thesis's rules (section 6.5.1).
//!
//! Resolution, equal luminance, no shine, sharp dots of good contrast, the subject in both photos,
//! level rows, the plain pair's exposure: each with the figure found, the figure wanted and what to
//! do about it. A capture that fails a rule may still be reconstructed; the rules are warnings.

mod measure;
mod rows;

#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::camera::{Rectification, View};
use crate::data::{Capture, Gray, PatternKind};
use crate::math::{Vec2, median};
use crate::settings;
use crate::stages::detect::{DetectMethod, DetectParams, Detection, detect};
use crate::stages::filter::{FilterParams, filter};
use measure::DotFigures;

settings! {
    /// The rules for a good capture and their limits.
    pub struct CheckParams {
        /// Least width of the photos (thesis: 768).
        min_width: usize = 768, range 1.0..=100000.0, unit "px";
        /// Least height of the photos (thesis: 576).
        min_height: usize = 576, range 1.0..=100000.0, unit "px";
        /// Greatest ratio of the photos' brightness, of the lit parts.
        max_luminance_ratio: f64 = 1.25, range 1.0..=100.0;
        /// Greatest share of saturated pixels.
        max_saturated: f64 = 0.01, range 0.0..=1.0;
        /// Least height of the dots above their surroundings.
        min_contrast: f64 = 25.0, range 0.0..=255.0, unit "grey levels";
        /// Greatest radius at which a dot has fallen to half its height, in dot spacings; dots that
        /// run into each other reach 0.24.
        max_blur: f64 = 0.23, range 0.0..=2.0;
        /// Least distance between neighbouring dots.
        min_spacing_px: f64 = 5.0, range 0.0..=1000.0, unit "px";
        /// Greatest difference of rows between the photos after rectification (the thesis's scan
        /// allows 2).
        max_row_error_px: f64 = 1.0, range 0.0..=100.0, unit "px";
        /// Least share of the dots of one photo that the other shows too, by their number.
        min_dot_ratio: f64 = 0.7, range 0.0..=1.0;
    }
}

/// How a rule was kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Kept.
    Good,
    /// Not kept: the result may suffer.
    Warning,
    /// Could not be measured.
    Unknown,
}

/// One rule with what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the rule: `resolution`, `luminance`, `shine`, `dots`, `contrast`, `sharpness`,
    /// `spacing`, `subject`, `rows` or `plain`.
    pub rule: &'static str,
    /// How it was kept.
    pub verdict: Verdict,
    /// What was found and what is wanted, in words with figures.
    pub message: String,
    /// What to do about it; empty when nothing.
    pub advice: &'static str,
}

/// All rules with what was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CheckReport {
    /// One entry a rule.
    pub findings: Vec<Finding>,
}

impl CheckReport {
    /// Whether no rule is broken.
    pub fn is_good(&self) -> bool {
        self.findings.iter().all(|f| f.verdict != Verdict::Warning)
    }

    /// The broken rules, message and advice.
    pub fn warnings(&self) -> Vec<String> {
        let broken = self.findings.iter().filter(|f| f.verdict == Verdict::Warning);
        broken.map(|f| format!("{}: {}; {}", f.rule, f.message, f.advice)).collect()
    }

    fn add(&mut self, rule: &'static str, good: bool, message: String, advice: &'static str) {
        let verdict = if good { Verdict::Good } else { Verdict::Warning };
        let advice = if good { "" } else { advice };
        self.findings.push(Finding { rule, verdict, message, advice });
    }

    fn unknown(&mut self, rule: &'static str, message: String) {
        self.findings.push(Finding { rule, verdict: Verdict::Unknown, message, advice: "" });
    }
}

/// Measures a capture against the rules. Never fails: what cannot be measured is `Unknown`.
pub fn check(capture: &Capture, params: &CheckParams) -> CheckReport {
    let mut report = CheckReport::default();
    resolution(capture, params, &mut report);
    luminance(capture, params, &mut report);
    shine(capture, params, &mut report);
    if capture.pattern.kind == PatternKind::Dots {
        match rayon::join(|| dots_of(&capture.left.gray), || dots_of(&capture.right.gray)) {
            (Some(left), Some(right)) => {
                dots(capture, [&left, &right], params, &mut report);
                row_levels(capture, [&left, &right], params, &mut report);
            }
            (left, _) => {
                let which = if left.is_none() { "left" } else { "right" };
                let message = format!("no dot pattern was found in the {which} photo");
                report.add("dots", false, message, "is it the photo with the pattern, in focus?");
            }
        }
    }
    plain(capture, &mut report);
    report
}

fn resolution(capture: &Capture, params: &CheckParams, report: &mut CheckReport) {
    let (width, height) = capture.left.size();
    let CheckParams { min_width, min_height, .. } = *params;
    // a photo may stand upright
    let good = width.max(height) >= min_width.max(min_height)
        && width.min(height) >= min_width.min(min_height);
    let message = format!(
        "the photos are {width}x{height} pixels; at least {min_width}x{min_height} are wanted"
    );
    report.add("resolution", good, message, "take larger photos, or a coarser pattern");
    let right = capture.right.size();
    if right != (width, height) {
        let message = format!(
            "the right photo is {}x{} pixels, the left one {width}x{height}",
            right.0, right.1
        );
        report.add("resolution", false, message, "both photos must have one size");
    }
}

fn luminance(capture: &Capture, params: &CheckParams, report: &mut CheckReport) {
    let [left, right] = [&capture.left.gray, &capture.right.gray].map(measure::lit_level);
    let ratio = left.max(right) / left.min(right).max(1.0);
    let message = format!(
        "the lit parts have a grey level of {left:.0} in the left photo and {right:.0} in the right; a ratio of up to {:.2} is wanted, found {ratio:.2}",
        params.max_luminance_ratio
    );
    let advice = "give both cameras the same exposure and light the subject from the front";
    report.add("luminance", ratio <= params.max_luminance_ratio, message, advice);
}

fn shine(capture: &Capture, params: &CheckParams, report: &mut CheckReport) {
    let photos = [&capture.left.gray, &capture.right.gray];
    let share = photos.map(measure::saturated_share).into_iter().fold(0.0, f64::max);
    let message = format!(
        "{:.2} % of the pixels are saturated; up to {:.2} % are wanted",
        100.0 * share,
        100.0 * params.max_saturated
    );
    let advice = "no flash; less light or a shorter exposure, powder on shining skin";
    report.add("shine", share <= params.max_saturated, message, advice);
}

fn dots_of(image: &Gray) -> Option<Detection> {
    let params =
        DetectParams { method: DetectMethod::Thin, round: false, ..DetectParams::default() };
    let binary = filter(image, &FilterParams::default(), &()).ok()?.binary;
    detect(&binary, &params, &()).ok()
}

fn dots(capture: &Capture, found: [&Detection; 2], params: &CheckParams, report: &mut CheckReport) {
    let [left, right] = found;
    let (few, many) =
        (left.dots.len().min(right.dots.len()), left.dots.len().max(right.dots.len()));
    let ratio = few as f64 / many.max(1) as f64;
    let message = format!(
        "{} dots in the left photo, {} in the right; of the more numerous at least {:.0} % should be seen by both, found {:.0} %",
        left.dots.len(),
        right.dots.len(),
        100.0 * params.min_dot_ratio,
        100.0 * ratio
    );
    let advice = "place the subject in the middle of both photos, and aim both cameras at it";
    report.add("dots", ratio >= params.min_dot_ratio, message, advice);

    let photos = [&capture.left.gray, &capture.right.gray];
    let measure = |i: usize| DotFigures::measure(photos[i], found[i]);
    if let (Some(l), Some(r)) = rayon::join(|| measure(0), || measure(1)) {
        let contrast = l.contrast.min(r.contrast);
        let message = format!(
            "the brighter half of the dots stands {contrast:.0} grey levels above its surroundings; at least {:.0} are wanted",
            params.min_contrast
        );
        let advice = "a brighter projector, less room light, or a longer exposure";
        report.add("contrast", contrast >= params.min_contrast, message, advice);
        let blur = l.half_radius.max(r.half_radius);
        let message = format!(
            "the dots fall to half their height within {blur:.2} spacings; up to {:.2} are wanted",
            params.max_blur
        );
        let advice = "focus projector and cameras on the face, close the apertures, hold still";
        report.add("sharpness", blur <= params.max_blur, message, advice);
        subject(photos, [&l, &r], report);
    }
    let spacing = left.spacing_px.min(right.spacing_px);
    let message = format!(
        "neighbouring dots are {spacing:.1} px apart; at least {:.1} are wanted",
        params.min_spacing_px
    );
    let advice = "take larger photos, come closer, or project a coarser pattern";
    report.add("spacing", spacing >= params.min_spacing_px, message, advice);
}

fn subject(photos: [&Gray; 2], figures: [&DotFigures; 2], report: &mut CheckReport) {
    let names = ["left", "right"];
    for ((image, figures), name) in photos.into_iter().zip(figures).zip(names) {
        let (width, height) = image.size();
        let (low, high) = (figures.bright_low, figures.bright_high);
        let edge = (0.02 * width as f64, 0.98 * width as f64);
        let (cut_left, cut_right) = (low.x < edge.0, high.x > edge.1);
        let middle = figures.bright_middle / width as f64;
        // A pattern that runs out of both sides is on a wall as well; crown and chin may be cut.
        let good = cut_left == cut_right && (0.2..=0.8).contains(&middle);
        let message = format!(
            "in the {name} photo the brightest dots span columns {:.0} to {:.0} of {width} and rows {:.0} to {:.0} of {height}, their middle at {:.0} % of the width",
            low.x,
            high.x,
            low.y,
            high.y,
            100.0 * middle
        );
        let advice = "the whole face must be in both photos, near the middle";
        report.add("subject", good, message, advice);
    }
}

fn row_levels(
    capture: &Capture,
    found: [&Detection; 2],
    params: &CheckParams,
    report: &mut CheckReport,
) {
    let size = capture.left.size();
    let rectification = match &capture.rig {
        None => Rectification::identity(size),
        Some(rig) => match rig.validate(size) {
            Ok(()) => Rectification::from_rig(rig, size),
            Err(error) => {
                return report.add("rows", false, error.to_string(), "see to the calibration");
            }
        },
    };
    let level = |view: &View, found: &Detection| -> Vec<Vec2> {
        found.dots.iter().map(|d| view.to_rectified(d.position)).collect()
    };
    let (left, right) =
        (level(&rectification.left, found[0]), level(&rectification.right, found[1]));
    let spacing = found[0].spacing_px;
    match rows::offset(&left, &right, spacing) {
        Some(offset) => {
            let message = format!(
                "a row lies {:.2} px {} in the right photo than in the left ({}); up to {:.1} px are wanted, and whole multiples of the dots' spacing ({spacing:.1} px) cannot be told from 0",
                offset.abs(),
                if offset < 0.0 { "higher" } else { "lower" },
                if capture.rig.is_some() { "rectified by the calibration" } else { "as taken" },
                params.max_row_error_px
            );
            let advice = "level both cameras, or calibrate the rig anew";
            report.add("rows", offset.abs() <= params.max_row_error_px, message, advice);
        }
        None => report.unknown("rows", "the dots' rows are not clear enough to compare".to_owned()),
    }
}

fn plain(capture: &Capture, report: &mut CheckReport) {
    let Some(pair) = &capture.plain else {
        let message = "there is no pair without the pattern, so there will be no texture";
        let advice = "take a pair without the pattern from the same place";
        report.add("plain", false, message.to_owned(), advice);
        return;
    };
    let levels = [&pair[0].gray, &pair[1].gray].map(measure::lit_level);
    let saturated = pair.iter().map(|p| measure::saturated_share(&p.gray)).fold(0.0, f64::max);
    let level = median(&levels).unwrap_or(0.0);
    let good = (40.0..=245.0).contains(&level) && saturated <= 0.02;
    let message = format!(
        "the pair without the pattern has a grey level of {level:.0} in its lit parts and {:.2} % saturated pixels; 40 to 245 and up to 2 % are wanted",
        100.0 * saturated
    );
    report.add("plain", good, message, "expose the pair without the pattern for the skin");
}
