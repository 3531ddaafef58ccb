//! Stage landmarks: finds the landmarks of the face, with nothing marked.
//!
//! 1. The nose tip stands out from everything within a hand's breadth; about it the surface is
//!    symmetric (reflective ICP). Both give the frame of the head, for each of a few candidates.
//! 2. In that frame surface and photos are resampled to a frontal picture in millimetres.
//! 3. Eyes and mouth are found there by colour: lips are redder than skin, the opening of the eye is
//!    less red or darker. The nose is found by the slope of its wings and by the profile.
//! 4. The ears are found by the outline of the subject in the plain photos.
//! 5. Lengths that hardly differ between people complete and check what was found.

mod color_regions;
mod covered;
mod ear_outline;
mod ears;
mod eyes;
mod frontal;
mod head_frame;
mod layout;
mod mouth;
mod nose;
mod nose_tip;
mod surface_points;
mod symmetry;
#[cfg(test)]
mod tests;

use crate::camera::Rectification;
use crate::data::{Cloud, MeasuredLandmark, Outline, Rgb};
use crate::math::{Similarity, Vec3};
use crate::observer::{Artifact, Cancelled, Observer};
use crate::settings::{SettingsError, Value, choices, settings};

pub use covered::CoveredEyes;

use frontal::FrontalPicture;
use head_frame::HeadFrame;
use layout::Face;
use surface_points::SurfacePoints;

choices! {
    /// How landmarks that are not marked are found.
    pub enum LandmarkMethod {
        /// They are not: only marked landmarks count.
        None = "none",
        /// On the measured surface and in the plain photos.
        Auto = "auto",
    }
}

settings! {
    /// Finding the landmarks of the face.
    pub struct LandmarksParams {
        /// How landmarks that are not marked are found.
        method: LandmarkMethod = LandmarkMethod::Auto;
        /// Candidates for the tip of the nose that are tried.
        candidates: usize = 4, range 1.0..=20.0;
        /// Least share of the surface about the nose that must be symmetric.
        min_symmetry: f64 = 0.4, range 0.0..=1.0;
    }
}

/// Landmarks that could not be looked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LandmarksError {
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(LandmarksError, "landmarks");

/// What the landmarks are found on.
#[derive(Clone, Copy, Debug)]
pub struct LandmarksInput<'a> {
    /// The measured surface with normals; left camera frame, mm.
    pub surface: &'a Cloud,
    /// The left and right photos without the pattern.
    pub plain: Option<[&'a Rgb; 2]>,
    /// The subject's outlines in these photos, where they are known: without them no ear is found.
    pub outlines: [Option<&'a Outline>; 2],
    /// How the photos relate to the camera frame; without a rig only the surface is used.
    pub rectification: &'a Rectification,
}

/// The landmarks that were found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundLandmarks {
    /// Positions in the left camera frame, mm.
    pub landmarks: Vec<MeasuredLandmark>,
    /// Where the attachments of the ears are expected from the proportions of heads: not measured,
    /// only a better start than the template's own ears.
    pub expected: Vec<MeasuredLandmark>,
    /// Share of the surface about the nose that is symmetric; 0 where no nose was found.
    pub symmetry: f64,
    /// The frame of the head (x to the viewer's right, y up, z out of the face, origin at the tip of
    /// the nose, mm) from the camera frame, where a nose was found.
    pub head_from_camera: Option<Similarity>,
}

/// Finds the landmarks. Those that are not seen clearly are left out; none at all is a warning.
///
/// # Errors
/// [`LandmarksError`] for parameters out of range, and when the observer cancels.
///
/// ```
/// use facerecon_core::camera::Rectification;
/// use facerecon_core::data::Cloud;
/// use facerecon_core::stages::landmarks::{LandmarksInput, LandmarksParams, find_landmarks};
///
/// // nothing measured: nothing found
/// let surface = Cloud::default();
/// let rectification = Rectification::identity((64, 48));
/// let input = LandmarksInput {
///     surface: &surface,
///     plain: None,
///     outlines: [None, None],
///     rectification: &rectification,
/// };
/// let found = find_landmarks(&input, &LandmarksParams::default(), &())?;
/// assert!(found.landmarks.is_empty());
/// # Ok::<(), facerecon_core::stages::landmarks::LandmarksError>(())
/// ```
pub fn find_landmarks(
    input: &LandmarksInput<'_>,
    params: &LandmarksParams,
    observer: &dyn Observer,
) -> Result<FoundLandmarks, LandmarksError> {
    params.check("landmarks", None)?;
    if params.method == LandmarkMethod::None {
        return Ok(FoundLandmarks::default());
    }
    let surface = SurfacePoints::new(input.surface);
    let mut best: Option<(f64, Face, FrontalPicture, HeadFrame)> = None;
    for tip in nose_tip::candidates(&surface, params.candidates) {
        observer.check()?;
        let Some(frame) = HeadFrame::about(&tip, &surface) else { continue };
        if frame.symmetry < params.min_symmetry {
            continue;
        }
        let Some(picture) = FrontalPicture::new(input, &frame) else { continue };
        let face = layout::find(&picture);
        let score = f64::from(face.parts) + frame.symmetry;
        let complete = face.is_complete();
        if best.as_ref().is_none_or(|b| score > b.0) {
            best = Some((score, face, picture, frame));
        }
        if complete {
            break;
        }
    }
    let mut found = FoundLandmarks::default();
    if let Some((_, face, picture, frame)) = best {
        found.symmetry = frame.symmetry;
        found.head_from_camera = Some(frame.head_from_camera());
        found.landmarks = face.lifted(&picture, &frame);
        if face.bearded {
            observer.warn(
                "landmarks",
                "the chin is much darker than the cheeks (a beard?): its landmark was left out, and \
                 the height of the face is the template's; mark the chin in both photos where it can \
                 be seen",
            );
        }
        if let Some(upright) = face.upright {
            found.landmarks.extend(ears::find(input, upright, &frame));
            found.expected = ears::expected(upright, &frame);
            found.expected.retain(|e| found.landmarks.iter().all(|l| l.name != e.name));
        }
    }
    if found.landmarks.is_empty() {
        observer.warn(
            "landmarks",
            "no face was found on the measured surface: no point stands out like the tip of a nose \
             with a symmetric face about it; mark the landmarks in both photos ([landmarks] of \
             capture.toml)",
        );
    }
    let positions: Vec<Vec3> = found.landmarks.iter().map(|l| l.position).collect();
    observer.artifact("landmarks", "positions", Artifact::Points(&positions));
    Ok(found)
}
