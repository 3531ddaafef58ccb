//! Correspond: which dot of the left photo is which of the right (thesis section 2.3).

mod lattice;
mod scan;
mod stripes;
#[cfg(test)]
mod tests;

pub use lattice::LatticeParams;
pub use stripes::{StripesParams, correspond_stripes};

use crate::camera::RectifiedRig;
use crate::data::{Dot, Gray, Match, Pattern, Seeds};
use crate::observer::{Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::{choices, settings};

choices! {
    /// How correspondences are found.
    pub enum CorrespondMethod {
        /// The thesis's scan from three marked pairs.
        Scan = "scan",
        /// The lattice of the dots, nothing marked by hand.
        Lattice = "lattice",
    }
}

settings! {
    /// Correspondence of the dots of both photos.
    pub struct CorrespondParams {
        /// How correspondences are found.
        method: CorrespondMethod = CorrespondMethod::Scan;
        /// The thesis's scan.
        scan: ScanParams = ScanParams::default();
        /// The automatic way.
        lattice: LatticeParams = LatticeParams::default();
        /// Stripes, for captures of that kind.
        stripes: StripesParams = StripesParams::default();
    }
}

settings! {
    /// The thesis's scan from three marked pairs (section 2.3).
    pub struct ScanParams {
        /// Greatest difference of rows between the photos (thesis: 2).
        row_tolerance_px: f64 = 2.0, range 0.0..=50.0, unit "px";
        /// Greatest difference of the distances to the marked neighbour in both photos, in spacings
        /// of the pattern along x.
        distance_tolerance: f64 = 0.4, range 0.01..=2.0;
        /// How far a marked pair may lie from the nearest dots, in spacings.
        seed_tolerance: f64 = 0.6, range 0.0..=10.0;
        /// How far a dot may lie from the nearest marked one to be searched, in spacings.
        reach: f64 = 2.5, range 1.0..=100.0;
        /// Size of the search window about the head, an ellipse set by the marks: the thesis marks
        /// the ears but does not say where the head ends, and the pattern may go on on a wall. 1
        /// holds a head with its hair; 0 searches the whole photo.
        window: f64 = 1.0, range 0.0..=100.0;
        /// Width of the projected picture over its height; with the pattern's columns and rows it
        /// gives the spacing along x from the spacing measured.
        picture_aspect: f64 = 1.333_333_333_333_333_3, range 0.1..=10.0;
    }
}

/// Dots that cannot be matched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CorrespondError {
    /// A photo without dots.
    #[error("the {photo} photo has no dots; check the photos and the detection")]
    NoDots {
        /// `left` or `right`.
        photo: &'static str,
    },
    /// No marked pairs.
    #[error(
        "correspond.method = \"scan\" needs the three marked pairs; add [seeds] with head, left_ear and right_ear to capture.toml"
    )]
    NoSeeds,
    /// A mark that is on no dot.
    #[error(
        "seed {seed} lies {distance_px:.1} px from the nearest dot of the {photo} photo, more than {allowed_px:.1} px; mark the middle of a dot"
    )]
    SeedOffDot {
        /// `head`, `left_ear` or `right_ear`.
        seed: &'static str,
        /// `left` or `right`.
        photo: &'static str,
        /// Distance to the nearest dot, rectified pixels.
        distance_px: f64,
        /// Distance allowed.
        allowed_px: f64,
    },
    /// A marked pair whose rows differ.
    #[error(
        "seed {seed} is {rows_px:.1} px higher or lower in the right photo than in the left, more than {allowed_px:.1} px; mark the same dot in both photos, and see that the photos' rows are level (give the calibration)"
    )]
    SeedRows {
        /// `head`, `left_ear` or `right_ear`.
        seed: &'static str,
        /// Difference of rows, rectified pixels.
        rows_px: f64,
        /// Difference allowed.
        allowed_px: f64,
    },
    /// Too few matches.
    #[error(
        "{got} matches found among {left} dots in the left and {right} in the right photo, at least {needed} are needed; check the marked pairs, and that both photos show the same pattern on the same face"
    )]
    TooFewMatches {
        /// Matches found.
        got: usize,
        /// Matches needed.
        needed: usize,
        /// Dots in the left photo.
        left: usize,
        /// Dots in the right photo.
        right: usize,
    },
    /// A pattern of no dots, or a spacing that is no length.
    #[error(
        "a pattern of {columns} columns, {rows} rows and a spacing of {spacing_px} px cannot be matched"
    )]
    Pattern {
        /// Columns given.
        columns: usize,
        /// Rows given.
        rows: usize,
        /// Spacing measured.
        spacing_px: f64,
    },
    /// Dots in no order.
    #[error(
        "only {labelled} dots of the {photo} photo stand in a lattice; is this the photo with the dot pattern, and is it sharp? A lattice turned by about 45 degrees needs pattern.rotation in capture.toml"
    )]
    NoLattice {
        /// `left` or `right`.
        photo: &'static str,
        /// Dots that do.
        labelled: usize,
    },
    /// The absolute place of the lattice stays open.
    #[error(
        "ambiguous by a lattice period, {means}: the best place fits only {confidence:.2} times better than the next, {needed:.2} is needed; add the pair without the pattern, one marked pair ([seeds]), the calibration, or use a rotated pattern"
    )]
    Ambiguous {
        /// What the wrong choice would mean.
        means: String,
        /// Ratio found.
        confidence: f64,
        /// Ratio needed.
        needed: f64,
    },
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(CorrespondError, "correspond");

/// What the correspondence is found from; all in rectified pixels.
#[derive(Clone, Copy, Debug)]
pub struct CorrespondInput<'a> {
    /// Dots of the left photo.
    pub left: &'a [Dot],
    /// Dots of the right photo.
    pub right: &'a [Dot],
    /// Usual distance between neighbouring dots, pixels.
    pub spacing_px: f64,
    /// The rectified photos with the pattern, `[left, right]`.
    pub images: [&'a Gray; 2],
    /// The rectified photos without the pattern.
    pub plain: Option<[&'a Gray; 2]>,
    /// The projected pattern.
    pub pattern: &'a Pattern,
    /// The three marked pairs, RECTIFIED pixels.
    pub seeds: Option<Seeds>,
    /// Metric facts of the rectified pair.
    pub rig: Option<&'a RectifiedRig>,
}

/// The table of matches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correspondence {
    /// In raster order of the left positions; each dot is in one match at most.
    pub matches: Vec<Match>,
    /// What the user should know, in words.
    pub warnings: Vec<String>,
}

/// Fewer matches than this make no face.
const LEAST_MATCHES: usize = 12;

/// Finds the correspondences of the dots.
///
/// # Errors
/// [`CorrespondError`] for photos without dots, seeds off any dot, or too few matches.
pub fn correspond(
    input: &CorrespondInput<'_>,
    params: &CorrespondParams,
    observer: &dyn Observer,
) -> Result<Correspondence, CorrespondError> {
    params.check("correspond", None)?;
    for (photo, dots) in [("left", input.left), ("right", input.right)] {
        if dots.is_empty() {
            return Err(CorrespondError::NoDots { photo });
        }
    }
    let found = match params.method {
        CorrespondMethod::Scan => scan::scan(input, &params.scan, observer)?,
        CorrespondMethod::Lattice => lattice::lattice(input, &params.lattice, observer)?,
    };
    observer.event(&Event::Count {
        stage: "correspond",
        what: "matches",
        count: found.matches.len(),
    });
    for message in &found.warnings {
        observer.event(&Event::Warning { stage: "correspond", message });
    }
    if found.matches.len() < LEAST_MATCHES {
        return Err(CorrespondError::TooFewMatches {
            got: found.matches.len(),
            needed: LEAST_MATCHES,
            left: input.left.len(),
            right: input.right.len(),
        });
    }
    Ok(found)
}
