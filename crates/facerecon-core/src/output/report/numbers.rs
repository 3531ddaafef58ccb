//! The landmarks and distances as rows of the page.

use super::page::{DistanceRow, LandmarkRow};
use crate::pipeline::Reconstruction;

pub(super) fn landmarks(result: &Reconstruction) -> Vec<LandmarkRow> {
    let row = |l: &crate::pipeline::FaceLandmark| LandmarkRow {
        name: l.term.name,
        term: l.term.term,
        side: l.term.side.anatomical(),
        status: l.status.to_string(),
        position: l.in_model.iter().map(|c| format!("{c:.1}")).collect::<Vec<_>>().join(", "),
        sigma: format!("{:.1}", l.sigma),
    };
    result.face_landmarks().iter().map(row).collect()
}

/// The measured distances.
pub(super) fn distances(result: &Reconstruction) -> Vec<DistanceRow> {
    let measured = |d: &crate::pipeline::FaceDistance| {
        d.is_measured.then(|| DistanceRow {
            term: d.term.term,
            abbreviation: d.term.abbreviation,
            value: format!("{:.1}", d.value_mm),
            sigma: format!("{:.1}", d.sigma_mm),
        })
    };
    result.face_distances().iter().filter_map(measured).collect()
}
