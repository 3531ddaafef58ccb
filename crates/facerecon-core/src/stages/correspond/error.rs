//! Errors of the stage.

use crate::observer::Cancelled;
use crate::settings::SettingsError;

/// Why no correspondences were found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CorrespondError {
    /// A photo without dots.
    #[error(
        "no dots were found in the {photo} photo; check the photo and the parameters of detect"
    )]
    NoDots {
        /// `left` or `right`.
        photo: &'static str,
    },
    /// No marked pairs.
    #[error(
        "correspond.method = \"scan\" needs the three marked pairs and the capture has none; add [seeds] with head, left_ear and right_ear to capture.toml, or set correspond.method = \"lattice\""
    )]
    NoSeeds,
    /// A seed that is too far from any dot.
    #[error(
        "seed {seed} is {distance_px:.1} px from the nearest dot of the {photo} photo (at most {allowed_px:.1} px allowed); mark the centre of a dot"
    )]
    SeedOffDot {
        /// `head`, `left_ear` or `right_ear`.
        seed: &'static str,
        /// `left` or `right`.
        photo: &'static str,
        /// Distance to the nearest dot, rectified pixels.
        distance_px: f64,
        /// Greatest distance allowed, rectified pixels.
        allowed_px: f64,
    },
    /// A seed whose dots are on different rows.
    #[error(
        "seed {seed} is {rows_px:.1} px higher or lower in the right photo than in the left (at most {allowed_px:.1} px allowed); mark the same dot in both photos, and give the calibration if the rows of the photos are not level"
    )]
    SeedRows {
        /// `head`, `left_ear` or `right_ear`.
        seed: &'static str,
        /// Difference of rows, rectified pixels.
        rows_px: f64,
        /// Greatest difference allowed, rectified pixels.
        allowed_px: f64,
    },
    /// Too few matches.
    #[error(
        "{got} matches found among {left} {candidates} in the left photo and {right} in the right (at least {needed} needed); check that both photos show the same pattern on the same subject, and check the marked pairs if there are any"
    )]
    TooFewMatches {
        /// What is matched: `dots` or `stripe edges`.
        candidates: &'static str,
        /// Matches found.
        got: usize,
        /// Matches needed.
        needed: usize,
        /// Candidates in the left photo.
        left: usize,
        /// Candidates in the right photo.
        right: usize,
    },
    /// A pattern without dots, or a spacing that is not a positive length.
    #[error(
        "a pattern of {columns} columns and {rows} rows with {spacing_px} px between its dots cannot be matched (all three must be above 0); check [pattern] in capture.toml and the detected dots"
    )]
    Pattern {
        /// Columns of the pattern.
        columns: usize,
        /// Rows of the pattern.
        rows: usize,
        /// Spacing measured, pixels.
        spacing_px: f64,
    },
    /// A photo whose dots form no lattice.
    #[error(
        "only {labelled} dots of the {photo} photo form a lattice (at least {needed} needed); check that this is the photo with the dot pattern and that it is sharp; a lattice rotated by about 45 degrees needs pattern.rotation in capture.toml"
    )]
    NoLattice {
        /// `left` or `right`.
        photo: &'static str,
        /// Dots that are part of a lattice.
        labelled: usize,
        /// Dots needed.
        needed: usize,
    },
    /// More than one shift of the lattice fits the photos.
    #[error(
        "ambiguous by a lattice period ({difference}): the best shift fits only {confidence:.2} times better than the next (at least {needed:.2} needed); check that left and right are not interchanged and the photos not mirrored or upside down; else add the pair without the pattern, one marked pair ([seeds]) or the calibration, or project a rotated pattern"
    )]
    Ambiguous {
        /// Difference between the two best shifts, mm of depth or pixels of disparity.
        difference: String,
        /// Ratio of the costs of the second-best and the best shift.
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

crate::stages::stage_error!(CorrespondError, "correspond");
