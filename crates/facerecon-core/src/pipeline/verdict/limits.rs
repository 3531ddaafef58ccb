//! Limits of the figures of a verdict, with their reasons.

/// Limits of a figure: beyond the first a result is usable, beyond the second doubtful.
pub(super) struct Limits {
    pub(super) usable: f64,
    pub(super) doubtful: f64,
}

/// Share of the face that was measured: 0.76 to 0.95 on captures with known truth.
pub(super) const MEASURED_SHARE: Limits = Limits { usable: 0.70, doubtful: 0.45 };
/// Distance of the points from the mesh, mm: below 0.1 where the fit follows the points.
pub(super) const RESIDUAL_MM: Limits = Limits { usable: 0.8, doubtful: 2.0 };
/// Landmarks that were found or marked, of 18: 14 to 18 on faces (fewer without ears in sight), 4 or 5
/// on a face that is upside down.
pub(super) const LANDMARKS_MEASURED: Limits = Limits { usable: 11.5, doubtful: 8.5 };
/// Distance of measured landmarks from their vertices, mm.
pub(super) const LANDMARK_OFFSET_MM: Limits = Limits { usable: 3.0, doubtful: 6.0 };
/// Asymmetry, mm: 0.5 to 1.4 for heads in their right place, above 2.2 for a head turned by 35
/// degrees against the face.
pub(super) const ASYMMETRY_MM: Limits = Limits { usable: 1.6, doubtful: 2.0 };
/// Least protrusion of the nose, mm: adults 30 to 47; a head of 0.7 times the size of an adult's has
/// at least 21. An upside-down face and a flattened one have less.
pub(super) const NOSE_PROTRUSION_MM: Limits = Limits { usable: 24.0, doubtful: 21.0 };
/// Greatest protrusion of the nose, mm.
pub(super) const NOSE_PROTRUSION_MAX_MM: Limits = Limits { usable: 55.0, doubtful: 65.0 };
/// Protrusion of the nose over the distance of the outer eye corners: 0.33 to 0.52 on captures with
/// known truth. Depth over width grows with the focal length that the calibration states.
pub(super) const NOSE_RELIEF: Limits = Limits { usable: 0.27, doubtful: 0.24 };
/// Greatest relief of the nose.
pub(super) const NOSE_RELIEF_MAX: Limits = Limits { usable: 0.56, doubtful: 0.60 };
/// Mean deviation of the measured distances from those of adults, standard deviations: -1 to 1.2 on
/// captures of adults. Distances of one face are correlated, so that the mean has a standard
/// deviation of about 0.65 among adults.
pub(super) const LARGE_SD: Limits = Limits { usable: 1.6, doubtful: 2.1 };
/// The same for small faces. A child of six years has about -2.1.
pub(super) const SMALL_SD: Limits = Limits { usable: -1.35, doubtful: -2.7 };
/// Share of a region of the face (within 25 mm of its landmarks) that was measured: at least 0.7 on
/// captures with known truth, at most 0.42 where the photos end.
pub(super) const REGION_SHARE: Limits = Limits { usable: 0.65, doubtful: 0.5 };
/// Share of the dots of the photo with fewer dots that were matched: 0.33 to 0.47 on captures with
/// known truth (dots on a wall are not matched), below 0.05 for photos that do not belong together.
pub(super) const MATCHED_SHARE: Limits = Limits { usable: 0.15, doubtful: 0.06 };
/// Deviation of a distance from the norms, standard deviations.
pub(super) const PROPORTION_SD: Limits = Limits { usable: 3.5, doubtful: 4.5 };
/// Distances beyond the limit that make a result doubtful: a single one may be a landmark out of
/// place.
pub(super) const PROPORTIONS_OFF: usize = 2;
/// Distance of the points from the template after registration, mm: 3.4 to 7.9 when it is right.
pub(super) const REGISTRATION_RMS_MM: Limits = Limits { usable: 8.5, doubtful: 9.5 };
/// Residual after over before registration: it falls when the registration is right.
pub(super) const REGISTRATION_GROWTH: Limits = Limits { usable: 1.02, doubtful: 1.08 };
/// Share of the matches that belong to the head: 0.73 to 0.99 when the registration is right.
pub(super) const REGISTRATION_SHARE: Limits = Limits { usable: 0.65, doubtful: 0.55 };
/// Roll of the head in the photo, degrees.
pub(super) const ROLL_DEG: Limits = Limits { usable: 35.0, doubtful: 60.0 };
/// Turn of the face away from the camera, degrees: one cheek is hidden beyond the first.
pub(super) const TURN_DEG: Limits = Limits { usable: 35.0, doubtful: 60.0 };
/// Blur of one photo against the other, standard deviation in distances between dots: 0 on captures
/// with both cameras in focus. With 0.17 and 0.28 the surface of captures with known truth was 1.4
/// and 2 times as far off, and with the latter a third of the dots of dark skin was lost.
pub(super) const BLUR_DIFFERENCE: Limits = Limits { usable: 0.13, doubtful: 0.4 };
/// Dots in front of the eyes that were left out: a few may be lashes or hair.
pub(super) const DOTS_BEFORE_EYES: Limits = Limits { usable: 5.0, doubtful: f64::INFINITY };
/// Rows out of level against the calibration, pixels: a calibration of other cameras, or cameras
/// that were moved.
pub(super) const ROW_OFFSET_PX: Limits = Limits { usable: 3.0, doubtful: 8.0 };
