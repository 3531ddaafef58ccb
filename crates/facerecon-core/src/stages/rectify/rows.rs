//! Rows that the photographs themselves show to be off, measured and put right.
//!
//! Corners of the pair without the pattern are matched first: they repeat nowhere, so a fault of a
//! whole row of dots is seen as such. Each match is then measured anew on the pair with the
//! pattern, whose dots give hundredths of a pixel everywhere on the skin.

mod features;
mod model;

use rayon::prelude::*;

use crate::camera::{Pinhole, Rectification, View};
use crate::data::Gray;
use crate::math::Vec2;
use crate::settings;

use super::{RowReport, warp};
use features::{Spot, features, refine};
use model::{Affine, Turn, map};

settings! {
    /// Measuring and levelling the rows of the photographs.
    pub struct RowsParams {
        /// Whether the rows are measured at all.
        measure: bool = true;
        /// Whether a fault that is found is corrected, or only reported.
        correct: bool = true;
        /// Row fault below which a calibrated rig is left alone.
        least_px: f64 = 0.1, range 0.0..=10.0, unit "px";
        /// Largest fault of a calibrated rig that is corrected; more is no knock but another rig.
        largest_px: f64 = 12.0, range 0.0..=200.0, unit "px";
        /// Largest row difference that may remain (median) for a correction to be believed.
        residual_px: f64 = 0.7, range 0.01..=10.0, unit "px";
        /// Largest roll of the right photo against the left, without calibration.
        roll_deg: f64 = 15.0, range 0.0..=45.0, unit "degrees";
        /// Largest ratio of the photos' scales (or its inverse), without calibration.
        scale: f64 = 1.25, range 1.0..=2.0;
        /// Largest offset of the rows, without calibration, as a part of the photo's height.
        offset: f64 = 0.2, range 0.0..=0.5;
    }
}

/// Fewer places than this in both photos say nothing about the rows.
const LEAST_SPOTS: usize = 12;

/// What the photographs say about their rows.
pub(super) struct Levelled {
    /// Corrected views; `None` where the rows are left as they are.
    pub rectification: Option<Rectification>,
    pub report: RowReport,
    pub warnings: Vec<String>,
}

/// Measures the rows of a pair that `rectification` was to level, and corrects the views. `dots`
/// and `plain` are the pairs with and without pattern as the views see them; stripes along the
/// columns say nothing about rows, so that for them there are no `dots`.
pub(super) fn level(
    rectification: &Rectification,
    dots: Option<[&Gray; 2]>,
    plain: Option<[&Gray; 2]>,
    params: &RowsParams,
) -> Levelled {
    match &rectification.rig {
        Some(rig) => {
            let spots = spots(dots, plain, 1.5 * params.largest_px);
            calibrated(rectification, rig.principal_right, &spots, params)
        }
        None => {
            let mut spots = spots(dots, plain, params.offset * rectification.size.1 as f64);
            let mut turn = turned(rectification.size, None, &spots);
            // Windows that are turned against each other correlate badly: look again at the
            // levelled pictures.
            for _ in 0..2 {
                let Some(known) = turn.filter(|t| t.is_large()) else {
                    break;
                };
                spots = again(dots, plain, &known);
                turn = turned(rectification.size, Some(known), &spots).or(turn);
            }
            uncalibrated(rectification, turn, &spots, params)
        }
    }
}

/// The turn that levels the spots, from a known one or from none.
fn turned(size: (usize, usize), known: Option<Turn>, spots: &[Spot]) -> Option<Turn> {
    let start = known.or_else(|| Turn::consensus(size, spots, 3.0))?;
    start.fitted(spots, 1.5)?.fitted(spots, 0.4)
}

/// Places seen in both photos, in pixels of the photos, looked for in pictures that a turn levels.
fn again(dots: Option<[&Gray; 2]>, plain: Option<[&Gray; 2]>, turn: &Turn) -> Vec<Spot> {
    let homographies = turn.homographies();
    let [Some(left), Some(right)] = homographies.map(View::plane) else {
        return Vec::new();
    };
    let see = |pair: [&Gray; 2]| {
        [warp(pair[0], &left, pair[0].size()), warp(pair[1], &right, pair[1].size())]
    };
    let (dots, plain) = (dots.map(see), plain.map(see));
    let height = dots.iter().chain(&plain).map(|p| p[0].height()).max().unwrap_or(0);
    let dots = dots.as_ref().map(|p| [&p[0], &p[1]]);
    let plain = plain.as_ref().map(|p| [&p[0], &p[1]]);
    spots(dots, plain, height as f64 / 50.0)
        .into_iter()
        .map(|s| Spot { left: left.to_photo(s.left), right: right.to_photo(s.right) })
        .collect()
}

/// Places seen in both photos.
fn spots(dots: Option<[&Gray; 2]>, plain: Option<[&Gray; 2]>, rows_px: f64) -> Vec<Spot> {
    let spots = match (plain, dots) {
        (Some(plain), _) => features(plain, rows_px),
        // Without a plain pair, the patterned one with its dots smeared away has to do.
        (None, Some(dots)) => {
            let [left, right] = dots.map(|d| d.blurred(d.width() as f64 / 110.0));
            features([&left, &right], rows_px)
        }
        (None, None) => Vec::new(),
    };
    let Some(dots) = dots else {
        return spots;
    };
    // Well below half a row of dots in any photo they can be told apart in.
    let reach = (dots[0].width() as f64 / 250.0).round().max(2.0) as isize;
    let radius = (dots[0].width() as f64 / 75.0).round() as isize;
    spots.into_par_iter().map(|s| refine(dots, s, 1.0, radius, reach).unwrap_or(s)).collect()
}

/// A calibrated rig whose right camera was knocked: a small offset, roll or change of scale.
fn calibrated(
    rectification: &Rectification,
    centre: Vec2,
    spots: &[Spot],
    params: &RowsParams,
) -> Levelled {
    let unknown = Levelled { rectification: None, report: RowReport::default(), warnings: vec![] };
    let Some(fit) =
        Affine::fit(spots, centre, params.least_px).filter(|_| spots.len() >= LEAST_SPOTS)
    else {
        return unknown;
    };
    let fault = spots.iter().map(|s| fit.at(s.right).abs()).fold(0.0, f64::max);
    let residual = fit.residual(spots);
    let mut report = RowReport {
        offset_px: fit.offset,
        roll_deg: fit.roll.atan().to_degrees(),
        scale: fit.scale,
        residual_px: Some(residual),
        corrected: false,
    };
    let found = format!(
        "{:+.2} px, roll {:+.3} degrees, scale {:+.4}, measured at {} places to {residual:.2} px",
        report.offset_px,
        report.roll_deg,
        report.scale,
        spots.len()
    );
    if residual > params.residual_px || fault > params.largest_px {
        let warning = format!(
            "the rows of the photographs do not fit the calibration (right photo lower by {found}); calibrate again, or check that photos and calibration belong together"
        );
        return Levelled { rectification: None, report, warnings: vec![warning] };
    }
    if fault < params.least_px {
        return Levelled { report, ..unknown };
    }
    let turned = knocked(&rectification.right, &fit).filter(|_| params.correct);
    report.corrected = turned.is_some();
    let done = if report.corrected { "corrected in the right view" } else { "left as it is" };
    let warnings = if fault >= 3.0 * params.least_px {
        vec![format!(
            "the rows of the photographs disagree with the calibration: the right photo is lower by {found}; {done}. A camera may have been knocked: calibrate again"
        )]
    } else {
        Vec::new()
    };
    let rectification = turned.map(|right| Rectification { right, ..*rectification });
    Levelled { rectification, report, warnings }
}

/// The right view with the fault taken out: rolled about its axis, zoomed, moved up.
fn knocked(view: &View, fit: &Affine) -> Option<View> {
    let View::Camera { camera, rectified_from_camera, rectified } = view else {
        return None;
    };
    let roll = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), -fit.roll.atan());
    let zoom = 1.0 + fit.scale;
    Some(View::Camera {
        camera: *camera,
        rectified_from_camera: roll.into_inner() * rectified_from_camera,
        rectified: Pinhole {
            fx: rectified.fx / zoom,
            fy: rectified.fy / zoom,
            cy: rectified.cy - fit.offset,
            ..*rectified
        },
    })
}

/// Cameras of which nothing is known: turned until rows are level.
fn uncalibrated(
    rectification: &Rectification,
    turn: Option<Turn>,
    spots: &[Spot],
    params: &RowsParams,
) -> Levelled {
    let size = rectification.size;
    let refused = |report: RowReport, why: String| Levelled {
        rectification: None,
        report,
        warnings: vec![format!(
            "no calibration is used, and the rows could not be measured from the photographs ({why}); they are taken as level"
        )],
    };
    let Some(turn) = turn else {
        let why = format!("{} places found in both", spots.len());
        return refused(RowReport::default(), why);
    };
    let (residual, agreeing) = turn.residual(spots, 3.0 * params.residual_px);
    let [left, right] = turn.homographies();
    let middle = Vec2::new((size.0 as f64 - 1.0) / 2.0, (size.1 as f64 - 1.0) / 2.0);
    let mut report = RowReport {
        offset_px: middle.y - map(&right, middle).y,
        roll_deg: -turn.roll_deg(),
        scale: turn.zoom() - 1.0,
        residual_px: Some(residual),
        corrected: false,
    };
    let bounded = report.roll_deg.abs() <= params.roll_deg
        && turn.zoom().ln().abs() <= params.scale.ln()
        && report.offset_px.abs() <= params.offset * size.1 as f64;
    if agreeing < LEAST_SPOTS
        || 3 * agreeing < spots.len()
        || residual > params.residual_px
        || !bounded
    {
        let why = format!(
            "{agreeing} of {} places agree to {residual:.2} px on {:+.1} px, roll {:+.2} degrees, scale {:+.3}",
            spots.len(),
            report.offset_px,
            report.roll_deg,
            report.scale
        );
        return refused(report, why);
    }
    // Photos whose rows are level already keep their pixels.
    let (level, _) = Turn::none(size).residual(spots, 3.0 * params.residual_px);
    let wanted = params.correct && level > 1.2 * residual + 0.2 * params.least_px;
    let views = View::plane(left).zip(View::plane(right)).filter(|_| wanted);
    report.corrected = views.is_some();
    let rectification = views.map(|(left, right)| Rectification { left, right, ..*rectification });
    let warnings = vec![format!(
        "no calibration is used: rows were measured from the photographs at {agreeing} places to {residual:.2} px (right photo lower by {:+.1} px, roll {:+.2} degrees, scale {:+.3}), and lengths are in model units",
        report.offset_px, report.roll_deg, report.scale
    )];
    Levelled { rectification, report, warnings }
}

#[cfg(test)]
mod tests;
