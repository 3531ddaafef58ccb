//! A verdict as data: level, reasons, figures.

use std::collections::BTreeMap;

use serde::Serialize;

crate::settings::choices! {
    /// How far a result can be trusted.
    pub enum VerdictLevel {
        /// No figure gives cause for doubt.
        Good = "good",
        /// Parts are less certain; the reasons say which.
        Usable = "usable",
        /// It may be wrong as a whole: it must be looked at before it is used.
        Doubtful = "doubtful",
    }
}

impl Default for VerdictLevel {
    /// A result that was not judged must not look good.
    fn default() -> Self {
        Self::Doubtful
    }
}

/// Why a result is not good.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reason {
    /// How grave it is: `usable` or `doubtful`.
    pub level: VerdictLevel,
    /// What was found and what is expected.
    pub text: String,
}

/// The verdict on a result.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FaceVerdict {
    /// The worst level of the reasons.
    pub level: VerdictLevel,
    /// Reasons, gravest first.
    pub reasons: Vec<Reason>,
    /// The figures.
    pub figures: VerdictFigures,
}

/// Figures of a result. A figure that cannot be computed is `None`: most need the landmarks of a
/// template, lengths need calibrated cameras.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct VerdictFigures {
    /// Share of the area of the face (chin to forehead, in front of the temples) that was measured.
    pub measured_share: Option<f64>,
    /// Median distance of the measured points from the mesh by region (eyes, nose, mouth, chin,
    /// forehead, ears: the landmark within 40 mm that is nearest), mm.
    pub residual_mm: BTreeMap<&'static str, f64>,
    /// Landmarks found in the photos.
    pub landmarks_found: usize,
    /// Landmarks marked by the user.
    pub landmarks_marked: usize,
    /// Median distance of the measured landmarks from the vertices of their names, mm.
    pub landmark_offset_mm: Option<f64>,
    /// Median distance of the measured face from its mirror image in the plane of symmetry of the
    /// landmarks, mm.
    pub asymmetry_mm: Option<f64>,
    /// Distance of the nose tip in front of the plane of outer eye corners and mouth corners, mm.
    pub nose_protrusion_mm: Option<f64>,
    /// That distance over the distance of the outer eye corners.
    pub nose_relief: Option<f64>,
    /// Share of the area within 25 mm of the landmarks of a region that was measured, by region.
    pub measured_region: BTreeMap<&'static str, f64>,
    /// Measured landmarks that the mesh does not follow, with the distance of their vertices, mm:
    /// more than 4 mm and more than three standard deviations.
    pub landmarks_off_mm: BTreeMap<&'static str, f64>,
    /// Mean deviation of the measured distances from those of adults, standard deviations; `None`
    /// with fewer than three distances.
    pub size_sd: Option<f64>,
    /// Share of the dots of the photo with fewer dots that were matched.
    pub matched_share: Option<f64>,
    /// Measured distances by name: standard deviations above the mean of adults (positive) or below that of
    /// children of six years (negative); 0 between.
    pub proportions_sd: BTreeMap<&'static str, f64>,
    /// Typical distance of the points from the template after registration, mm.
    pub registration_rms_mm: Option<f64>,
    /// The same after over before registration.
    pub registration_growth: Option<f64>,
    /// Share of the matches that belong to the head.
    pub registration_share: Option<f64>,
    /// Angle between the head's vertical axis and the photo's, degrees.
    pub roll_deg: Option<f64>,
    /// Angle between the direction in which the face looks and that toward the camera, degrees.
    pub turn_deg: Option<f64>,
    /// Median score of the matches, 0 to 1: how clearly the period of the pattern is determined.
    pub match_score: Option<f64>,
    /// Rows by which the photos were out of level against the calibration, pixels.
    pub row_offset_px: f64,
    /// Blur of one dotted photo against the other, standard deviation in distances between dots:
    /// positive where the right photo is less sharp, negative for the left one.
    pub blur_difference: f64,
    /// Dots in front of the eye sockets (glasses) that were left out.
    pub dots_before_eyes: usize,
}

impl VerdictFigures {
    /// Landmarks that were found or marked.
    pub fn landmarks_measured(&self) -> usize {
        self.landmarks_found + self.landmarks_marked
    }
}

impl std::fmt::Display for FaceVerdict {
    /// One sentence: the level, and the reasons or the main figures.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let level = self.level;
        if !self.reasons.is_empty() {
            let reasons: Vec<&str> = self.reasons.iter().map(|r| r.text.as_str()).collect();
            return write!(f, "Verdict: {level}: {}.", reasons.join("; "));
        }
        let share = self.figures.measured_share.unwrap_or(0.0);
        write!(
            f,
            "Verdict: {level}: {:.0} % of the face was measured, {} of 18 landmarks were found or \
             marked.",
            100.0 * share,
            self.figures.landmarks_measured()
        )
    }
}
