//! Robust non-rigid ICP: bends the generic head to dense measured points.
//!
//! Each measured point is matched to its closest point on the surface; the residuals are measured
//! along the surface normals, a thin plate regularises the displacements, and robust weights
//! suppress outliers (after Amberg et al. 2007). In three steps the head takes the subject's size,
//! bends from stiff to flexible, and, subdivided where there are data, moves along its normals to
//! the detail that the noise allows.

mod detail;
mod landmark_surface;
mod landmark_warp;
mod laplacian;
mod matching;
mod measured_points;
mod outline;
mod plate;
mod small_components;
mod subdivide;
mod subject_size;
mod surface_match;
mod thin_parts;
mod unmatched_components;
mod vertices_in_front;

use crate::data::Mesh;
use crate::math::{Similarity, Vec3};
use crate::observer::{Event, Observer};

use super::{DeformError, DeformInput, DeformParams, Deformed, LandmarkTarget};
use matching::{MatchLimits, Matcher, max_local_spread_mm, require_matches};
use measured_points::{MeasuredPoint, thin_over_list, thin_over_space};
use outline::OutlineMatcher;
use plate::{Plate, PlateData};
use surface_match::{area_per_match, rms_on};
use vertices_in_front::FrontMatcher;

crate::settings::settings! {
    /// Robust non-rigid ICP.
    pub struct NicpParams {
        /// Stiffness from first to last: the displacement follows waves longer than about six
        /// times this length.
        stiffness_mm: Vec<f64> = vec![30.0, 20.0, 14.0, 10.0, 7.0, 5.0, 3.0], range 0.2..=1000.0, unit "mm";
        /// Rounds of matching and solving at each stiffness.
        rounds: usize = 1, range 1.0..=50.0;
        /// Points used while bending; the detail step uses more.
        points: usize = 6000, range 100.0..=1000000.0;
        /// Whether the head takes the subject's size before it bends.
        resize: bool = true;
        /// Whether faces are split where there are data. Without it the mesh keeps the vertices and
        /// faces of the template; with it the vertices of the template come first, and those that
        /// splitting adds differ from subject to subject.
        subdivide: bool = true;
        /// Where there are data, faces are split until their edges are about this long.
        edge_mm: f64 = 1.6, range 0.2..=1000.0, unit "mm";
        /// Most vertices after splitting.
        max_vertices: usize = 60000, range 100.0..=10000000.0;
        /// Smoothing length of the detail step; 0 leaves the step out.
        detail_mm: f64 = 0.8, range 0.0..=100.0, unit "mm";
        /// Most points used in the detail step.
        detail_points: usize = 60000, range 100.0..=10000000.0;
        /// Standard deviation of points without a known one.
        sigma_mm: f64 = 0.25, range 0.001..=100.0, unit "mm";
        /// Points farther than this from the surface are not matched.
        reach_mm: f64 = 30.0, range 0.1..=1000.0, unit "mm";
        /// Points whose normal differs from that of the surface by more are not matched.
        normal_gate_deg: f64 = 60.0, range 1.0..=180.0, unit "deg";
        /// Points whose closest point is within so many rings of the template's open border are not
        /// matched.
        border_rings: usize = 3, range 0.0..=100.0;
    }
}

/// Greatest distance of a match while bending, in stiffnesses: the plate of one round leaves
/// residuals below it.
const REACH_PER_STIFFNESS: f64 = 3.0;
/// Faces are split only where the spread of the points is below this, mm: on skin, hardly on hair.
const MAX_SPLIT_SPREAD_MM: f64 = 0.5;

/// Bends the template to the data, which are registered roughly. Landmarks move the head before it
/// bends, and stay terms of each round.
pub(super) fn deform(
    input: &DeformInput<'_>,
    params: &DeformParams,
    observer: &dyn Observer,
) -> Result<Deformed, DeformError> {
    let (template, own) = (input.template, &params.nicp);
    let mut points = MeasuredPoint::from_cloud(input.data, own.sigma_mm);
    let small_share = match input.outlines.is_empty() {
        true => small_components::SMALL_SHARE,
        false => small_components::SMALL_SHARE_OF_SUBJECT,
    };
    small_components::label_small_components(&mut points, small_share);
    let few = thin_over_space(&points, own.points);
    let limits = MatchLimits::new(template, own);
    let mut step = 0;
    let mut report = |error: f64| {
        step += 1;
        observer.event(&Event::Iteration { stage: "deform", step, error });
        observer.check()?;
        Ok(error)
    };

    let max_spread_mm = max_local_spread_mm(own.reach_mm);
    let matches = Matcher::new(template, &limits)?.find(&few, own.reach_mm, max_spread_mm);
    let rms_before = rms_on(template, &matches);
    let landmarks = if params.use_landmarks { input.landmarks } else { &[] };
    let landmarks = landmark_surface::onto_surface(landmarks, &points);
    let data_from_template = match own.resize {
        true => subject_size::match_size(template, &few, &landmarks, &limits, own)?,
        false => Similarity::identity(),
    };
    let (rest, landmarks) = rest_by_landmarks(template, &landmarks, &data_from_template);
    let outlines = OutlineMatcher::new(input.outlines, own.border_rings);
    let fixed = Fixed { landmarks: &landmarks, outlines: &outlines };
    let mut bent = bend(&rest, &few, &limits, &fixed, own, &mut report)?;

    let matches = Matcher::new(&bent, &limits)?.find(&few, own.reach_mm, MAX_SPLIT_SPREAD_MM);
    let centres = require_matches(&matches)?;
    unmatched_components::move_unmatched_components(&rest, &mut bent, &matches);
    let mut rms_after = rms_on(&bent, &matches);

    if own.detail_mm > 0.0 {
        if own.subdivide {
            bent = subdivide::subdivide_measured(&bent, &matches, own.edge_mm, own.max_vertices);
        }
        let limits = MatchLimits::new(&bent, own);
        let many = thin_over_list(&points, own.detail_points);
        rms_after = detail::refine_detail(&mut bent, &many, &limits, own, &mut report)?;
    }
    outlines.bound(&mut bent, own.reach_mm);
    Ok(Deformed { mesh: bent, centres, rms_before, rms_after })
}

/// The template in the size and position of the data, moved by the landmarks, and the landmarks
/// with their standard deviations after comparison.
fn rest_by_landmarks(
    template: &Mesh,
    landmarks: &[LandmarkTarget],
    data_from_template: &Similarity,
) -> (Mesh, Vec<LandmarkTarget>) {
    let moved = |l: &LandmarkTarget, by: &Similarity| LandmarkTarget {
        vertex: l.vertex,
        position: by.apply(&l.position),
        sigma_mm: l.sigma_mm * by.scale,
    };
    // in the template's frame, where its plane of symmetry is known
    let template_from_data = data_from_template.inverse();
    let own: Vec<_> = landmarks.iter().map(|l| moved(l, &template_from_data)).collect();
    let (warped, own) = landmark_warp::warp_by_landmarks(template, &own);
    let landmarks = own.iter().map(|l| moved(l, data_from_template)).collect();
    (warped.transformed(data_from_template), landmarks)
}

/// What holds the head beside the points.
struct Fixed<'a> {
    landmarks: &'a [LandmarkTarget],
    outlines: &'a OutlineMatcher<'a>,
}

/// Bends the vertices of the mesh at rest to the points, from stiff to flexible.
fn bend(
    rest: &Mesh,
    points: &[MeasuredPoint],
    limits: &MatchLimits,
    fixed: &Fixed<'_>,
    params: &NicpParams,
    report: &mut dyn FnMut(f64) -> Result<f64, DeformError>,
) -> Result<Mesh, DeformError> {
    let front = FrontMatcher::new(points);
    let plate = Plate::new(rest)?;
    let mut displacements = vec![Vec3::zeros(); rest.vertices.len()];
    let mut bent = rest.clone();
    for &stiffness_mm in &params.stiffness_mm {
        for _ in 0..params.rounds {
            let reach_mm = (REACH_PER_STIFFNESS * stiffness_mm).min(params.reach_mm);
            let max_spread_mm = max_local_spread_mm(stiffness_mm);
            let mut matches = Matcher::new(&bent, limits)?.find(points, reach_mm, max_spread_mm);
            require_matches(&matches)?;
            let area_mm2 = area_per_match(rest, &matches);
            matches.extend(front.find(&bent, reach_mm));
            matches.extend(fixed.outlines.find(&bent, reach_mm, area_mm2));
            let data = PlateData { matches: &matches, landmarks: fixed.landmarks };
            plate.bend(rest, &mut displacements, &data, stiffness_mm)?;
            let moved = rest.vertices.iter().zip(&displacements).map(|(p, d)| p + d);
            bent = bent.with_vertices(moved.collect());
            report(rms_on(&bent, &matches))?;
        }
    }
    Ok(bent)
}

#[cfg(test)]
mod tests;
