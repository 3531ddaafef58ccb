//! Rows of uncalibrated cameras: both views rotated until rows are level.

use super::RowsParams;
use super::corners::{CornerPair, MIN_CORNERS, find_corners};
use super::report::{RowCorrection, RowReport};
use super::rotation::{LevellingRotation, transformed};
use crate::camera::{Rectification, View};
use crate::data::Gray;
use crate::math::Vec2;
use crate::stages::rectify::warp::warp;

/// Inlier threshold of the consensus, and widths of the weights of the two fits after it, pixels:
/// from coarse to fine. Set by hand.
const CONSENSUS_PX: f64 = 3.0;
const FIT_PX: [f64; 2] = [1.5, 0.4];
/// Corners are searched again at most this often in pictures that the last rotation made level.
const MAX_REPEATS: usize = 2;
/// Level pictures are searched within one part of this many of their height. Set by hand.
const LEVEL_ROW_PARTS: f64 = 50.0;
/// Corners within this multiple of `rows.residual_px` are inliers.
const INLIER_FACTOR: f64 = 3.0;
/// At least one of this many corners must be an inlier.
const MAX_CORNERS_PER_INLIER: usize = 3;
/// Photos are resampled only when their row residual as taken exceeds the residual after the
/// rotation by this factor, and by this fraction of `rows.least_px`: level photos keep their pixels.
const GAIN_FACTOR: f64 = 1.2;
const GAIN_LEAST: f64 = 0.2;

/// Finds corners in both photos and the rotation that makes their rows level.
pub(super) fn correct(
    rectification: &Rectification,
    dots: Option<[&Gray; 2]>,
    plain: Option<[&Gray; 2]>,
    params: &RowsParams,
) -> RowCorrection {
    let size = rectification.size;
    let mut corners = find_corners(dots, plain, params.offset * size.1 as f64);
    let mut rotation = fitted(size, None, &corners);
    // Windows that are rolled against each other correlate badly: search again in level pictures.
    for _ in 0..MAX_REPEATS {
        let Some(known) = rotation.filter(|t| t.is_large()) else {
            break;
        };
        corners = find_corners_level(dots, plain, &known);
        rotation = fitted(size, Some(known), &corners).or(rotation);
    }
    apply(rectification, rotation, &corners, params)
}

/// The rotation that makes the corners level, from a known one or from none.
fn fitted(
    size: (usize, usize),
    known: Option<LevellingRotation>,
    corners: &[CornerPair],
) -> Option<LevellingRotation> {
    let start = known.or_else(|| LevellingRotation::consensus(size, corners, CONSENSUS_PX))?;
    start.fitted(corners, FIT_PX[0])?.fitted(corners, FIT_PX[1])
}

/// Corners found in pictures that a rotation makes level, in pixels of the photos.
fn find_corners_level(
    dots: Option<[&Gray; 2]>,
    plain: Option<[&Gray; 2]>,
    rotation: &LevellingRotation,
) -> Vec<CornerPair> {
    let homographies = rotation.homographies();
    let [Some(left), Some(right)] = homographies.map(View::plane) else {
        return Vec::new();
    };
    let level = |pair: [&Gray; 2]| {
        [warp(pair[0], &left, pair[0].size()), warp(pair[1], &right, pair[1].size())]
    };
    let (dots, plain) = (dots.map(level), plain.map(level));
    let height = dots.iter().chain(&plain).map(|p| p[0].height()).max().unwrap_or(0);
    let dots = dots.as_ref().map(|p| [&p[0], &p[1]]);
    let plain = plain.as_ref().map(|p| [&p[0], &p[1]]);
    find_corners(dots, plain, height as f64 / LEVEL_ROW_PARTS)
        .into_iter()
        .map(|s| CornerPair { left: left.to_photo(s.left), right: right.to_photo(s.right) })
        .collect()
}

/// The views rotated, unless the rotation is implausible or not needed.
fn apply(
    rectification: &Rectification,
    rotation: Option<LevellingRotation>,
    corners: &[CornerPair],
    params: &RowsParams,
) -> RowCorrection {
    let size = rectification.size;
    let refused = |report: RowReport, reason: String| RowCorrection {
        rectification: None,
        report,
        warning: Some(format!(
            "no calibration is used, and the rows could not be measured from the photos ({reason}); they are assumed to be level"
        )),
    };
    let Some(rotation) = rotation else {
        let reason = format!("{} corners found in both", corners.len());
        return refused(RowReport::default(), reason);
    };
    let inlier_px = INLIER_FACTOR * params.residual_px;
    let (residual, inliers) = rotation.residual(corners, inlier_px);
    let [left, right] = rotation.homographies();
    let middle = Vec2::new((size.0 as f64 - 1.0) / 2.0, (size.1 as f64 - 1.0) / 2.0);
    let mut report = RowReport {
        offset_px: middle.y - transformed(&right, middle).y,
        roll_deg: -rotation.roll_deg(),
        scale: rotation.zoom() - 1.0,
        residual_px: Some(residual),
        corrected: false,
    };
    let bounded = report.roll_deg.abs() <= params.roll_deg
        && rotation.zoom().ln().abs() <= params.scale.ln()
        && report.offset_px.abs() <= params.offset * size.1 as f64;
    let supported = inliers >= MIN_CORNERS
        && MAX_CORNERS_PER_INLIER * inliers >= corners.len()
        && residual <= params.residual_px;
    let found = format!(
        "{inliers} of {} corners agree with residual {residual:.2} px on offset {:+.1} px (positive: right photo lower), roll {:+.2} degrees, scale {:+.3}",
        corners.len(),
        report.offset_px,
        report.roll_deg,
        report.scale
    );
    if !(supported && bounded) {
        return refused(report, found);
    }
    let (as_taken, _) = LevellingRotation::none(size).residual(corners, inlier_px);
    let needed = params.correct && as_taken > GAIN_FACTOR * residual + GAIN_LEAST * params.least_px;
    let views = View::plane(left).zip(View::plane(right)).filter(|_| needed);
    report.corrected = views.is_some();
    let rectification = views.map(|(left, right)| Rectification { left, right, ..*rectification });
    let warning = format!(
        "no calibration is used: rows were measured from the photos ({found}), and lengths are in model units; calibrate for millimetres"
    );
    RowCorrection { rectification, report, warning: Some(warning) }
}
