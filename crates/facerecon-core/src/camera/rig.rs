//! The stereo rig: two cameras and the transform between them.

use serde::{Deserialize, Serialize};

use super::pinhole::Pinhole;
use super::rotation::{RotationFault, rotation_fault};
use crate::math::{Mat3, Similarity, Vec2, Vec3};

/// Below this the baseline is zero up to rounding, mm.
const MIN_BASELINE_MM: f64 = 1e-6;

/// A calibrated stereo rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StereoRig {
    /// The left camera; its frame is the camera frame of all results.
    pub left: Pinhole,
    /// The right camera.
    pub right: Pinhole,
    /// `X_right = R X_left + T`, millimetres.
    pub right_from_left: Similarity,
    /// `(width, height)` of the photos of the calibration, where known.
    pub image_size: Option<(usize, usize)>,
}

/// A rig that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RigError {
    /// Focal lengths that are not positive, or numbers that are not finite.
    #[error(
        "the calibration's {camera} camera cannot exist: its focal lengths are {fx} and {fy}; they must be above 0 and all numbers finite"
    )]
    Camera {
        /// `left` or `right`.
        camera: &'static str,
        /// Focal length along x, pixels.
        fx: f64,
        /// Focal length along y, pixels.
        fy: f64,
    },
    /// A matrix that is not a rotation.
    #[error("the calibration's R is not a rotation: {fault}")]
    Rotation {
        /// What was found and what is expected.
        fault: RotationFault,
    },
    /// Both cameras at the same position.
    #[error(
        "the calibration's baseline is {baseline_mm:.3} mm; the cameras must be at different positions"
    )]
    Baseline {
        /// Length of T.
        baseline_mm: f64,
    },
    /// Cameras one above the other.
    #[error(
        "the calibration's baseline is mostly vertical ({x_mm:.1} mm horizontally, {y_mm:.1} mm vertically); place the cameras side by side, or rotate both photos by 90 degrees and calibrate again"
    )]
    VerticalBaseline {
        /// Horizontal component, mm.
        x_mm: f64,
        /// Vertical component, mm.
        y_mm: f64,
    },
    /// Left and right swapped.
    #[error(
        "in the calibration the right camera is {x_mm:.1} mm to the LEFT of the left one; swap the photos, or invert the calibration"
    )]
    Swapped {
        /// Distance to the left, mm.
        x_mm: f64,
    },
    /// Photos of another size than those of the calibration.
    #[error(
        "the rig was calibrated on photos of {calibrated_width}x{calibrated_height} pixels, but these are {width}x{height}; use photos of the calibration's resolution, or calibrate again"
    )]
    ImageSize {
        /// Width of the photos.
        width: usize,
        /// Height of the photos.
        height: usize,
        /// Width in the calibration.
        calibrated_width: usize,
        /// Height in the calibration.
        calibrated_height: usize,
    },
}

impl StereoRig {
    /// A parallel rig: equal focal lengths, no distortion, the same rows in both photos.
    pub fn parallel(
        baseline_mm: f64,
        focal_px: f64,
        principal_left: Vec2,
        principal_right: Vec2,
    ) -> Self {
        Self {
            left: Pinhole::ideal(focal_px, principal_left),
            right: Pinhole::ideal(focal_px, principal_right),
            right_from_left: Similarity::rigid(Mat3::identity(), Vec3::new(-baseline_mm, 0.0, 0.0)),
            image_size: None,
        }
    }

    /// Distance between the cameras, mm.
    pub fn baseline_mm(&self) -> f64 {
        self.right_from_left.translation.norm()
    }

    /// Position of the right camera in the left camera's frame, mm.
    pub fn right_centre(&self) -> Vec3 {
        -(self.right_from_left.rotation.transpose() * self.right_from_left.translation)
    }

    /// Checks that the rig can be used for photos of this size `(width, height)`.
    ///
    /// # Errors
    /// [`RigError`] with the value found.
    pub fn validate(&self, photo_size: (usize, usize)) -> Result<(), RigError> {
        for (name, camera) in [("left", &self.left), ("right", &self.right)] {
            if !camera.is_plausible() {
                return Err(RigError::Camera { camera: name, fx: camera.fx, fy: camera.fy });
            }
        }
        if let Some(fault) = rotation_fault(&self.right_from_left.rotation) {
            return Err(RigError::Rotation { fault });
        }
        let baseline_mm = self.baseline_mm();
        if !(baseline_mm > MIN_BASELINE_MM && baseline_mm.is_finite()) {
            return Err(RigError::Baseline { baseline_mm });
        }
        let centre = self.right_centre();
        if centre.x.abs() < centre.y.abs() {
            return Err(RigError::VerticalBaseline { x_mm: centre.x.abs(), y_mm: centre.y.abs() });
        }
        if centre.x < 0.0 {
            return Err(RigError::Swapped { x_mm: -centre.x });
        }
        match self.image_size {
            Some((calibrated_width, calibrated_height))
                if (calibrated_width, calibrated_height) != photo_size =>
            {
                let (width, height) = photo_size;
                Err(RigError::ImageSize { width, height, calibrated_width, calibrated_height })
            }
            _ => Ok(()),
        }
    }
}
