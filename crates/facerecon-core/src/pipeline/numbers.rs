//! The landmarks of a face and the distances between them, with their standard deviations.

use crate::data::{DISTANCES, DistanceTerm, LANDMARK_TERMS, LandmarkSource, LandmarkTerm};
use crate::math::Vec3;
use crate::pipeline::Reconstruction;

/// Standard deviation, in each direction, of a landmark that is known from the template alone, mm:
/// without a measured landmark the template slides over the surface by this much. Half of the
/// errors of such landmarks on captures with known truth are larger than 5 to 11 mm.
const TEMPLATE_SIGMA_MM: f64 = 6.0;

crate::settings::choices! {
    /// How a landmark is known.
    pub enum LandmarkStatus {
        /// Found in the photos and on the measured surface.
        Found = "found",
        /// Marked in both photos by the user.
        Marked = "marked",
        /// Known from the template alone: the place of a vertex, not a measurement.
        TemplateOnly = "template only",
    }
}

impl LandmarkStatus {
    /// Whether the position was measured.
    pub fn is_measured(self) -> bool {
        self != Self::TemplateOnly
    }
}

/// One of the 18 landmarks of a result.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceLandmark {
    /// What it is.
    pub term: &'static LandmarkTerm,
    /// How it is known.
    pub status: LandmarkStatus,
    /// Position in the frame of the measured points (left camera), mm when the result is metric.
    pub in_camera: Vec3,
    /// Position in the model frame, in the same unit.
    pub in_model: Vec3,
    /// Standard deviation in each direction, in the same unit.
    pub sigma: f64,
    /// Number of the vertex that has this name; `None` on a measured surface.
    pub vertex: Option<usize>,
}

/// A distance between two landmarks of a metric result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceDistance {
    /// What it is.
    pub term: &'static DistanceTerm,
    /// Length of the straight line, mm.
    pub value_mm: f64,
    /// Its standard deviation, mm: the two ends are independent, and the error of each along the
    /// line counts.
    pub sigma_mm: f64,
    /// Whether both ends were measured; otherwise it is a property of the template.
    pub is_measured: bool,
}

/// Lengths of the face, mm; each is `None` unless both of its landmarks were measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaceSize {
    /// Between the upper ear attachments.
    pub width_mm: Option<f64>,
    /// From the saddle of the nose to the chin.
    pub height_mm: Option<f64>,
}

impl Reconstruction {
    /// The landmarks in the order of `LANDMARK_TERMS`: those that were measured at their measured
    /// positions, the others at their vertices. A landmark without both is left out.
    pub fn face_landmarks(&self) -> Vec<FaceLandmark> {
        let camera_from_model = self.model_from_camera.inverse();
        let of_term = |term: &'static LandmarkTerm| {
            let vertex = self.landmarks.get(term.name).copied();
            if let Some(found) = self.measured_landmarks.iter().find(|m| m.name == term.name) {
                let status = match found.source {
                    LandmarkSource::Marked => LandmarkStatus::Marked,
                    LandmarkSource::Found => LandmarkStatus::Found,
                };
                return Some(FaceLandmark {
                    term,
                    status,
                    in_camera: found.position,
                    in_model: self.model_from_camera.apply(&found.position),
                    sigma: found.sigma_mm,
                    vertex,
                });
            }
            let in_model = *self.mesh.vertices.get(vertex?)?;
            let surface = self.mesh.sigmas.get(vertex?).copied().unwrap_or(0.0);
            Some(FaceLandmark {
                term,
                status: LandmarkStatus::TemplateOnly,
                in_camera: camera_from_model.apply(&in_model),
                in_model,
                sigma: surface.hypot(TEMPLATE_SIGMA_MM),
                vertex,
            })
        };
        LANDMARK_TERMS.iter().filter_map(of_term).collect()
    }

    /// The distances between the landmarks, in the order of `DISTANCES`; none unless the result is
    /// metric.
    pub fn face_distances(&self) -> Vec<FaceDistance> {
        if !self.metric {
            return Vec::new();
        }
        let landmarks = self.face_landmarks();
        let named = |name: &str| landmarks.iter().find(|l| l.term.name == name);
        let of_term = |term: &'static DistanceTerm| {
            let (from, to) = (named(term.from)?, named(term.to)?);
            Some(FaceDistance {
                term,
                value_mm: (from.in_camera - to.in_camera).norm(),
                sigma_mm: from.sigma.hypot(to.sigma),
                is_measured: from.status.is_measured() && to.status.is_measured(),
            })
        };
        DISTANCES.iter().filter_map(of_term).collect()
    }

    /// Width and height of the face; `None` without metric units. A length that rests on a landmark
    /// known from the template alone is not given.
    pub fn face_size(&self) -> Option<FaceSize> {
        if !self.metric {
            return None;
        }
        let distances = self.face_distances();
        let measured = |name: &str| {
            let distance = distances.iter().find(|d| d.term.name == name && d.is_measured);
            distance.map(|d| d.value_mm)
        };
        Some(FaceSize { width_mm: measured("upper_ear_width"), height_mm: measured("face_height") })
    }
}
