//! Two cameras and the motion between them.

use serde::{Deserialize, Serialize};

use super::Pinhole;
use crate::math::{Similarity, Vec2, Vec3};

/// A calibrated stereo rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StereoRig {
    /// The left camera; its frame is the camera frame of all results.
    pub left: Pinhole,
    /// The right camera.
    pub right: Pinhole,
    /// `X_right = R X_left + T`, millimetres.
    pub right_from_left: Similarity,
    /// `(width, height)` of the photos it was calibrated on, where the file says.
    pub image_size: Option<(usize, usize)>,
}

/// A rig that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RigError {
    /// Numbers that no camera has.
    #[error(
        "the calibration's {camera} camera is not a camera: focal lengths must be above 0 and all numbers finite"
    )]
    Camera {
        /// `left` or `right`.
        camera: &'static str,
    },
    /// A matrix that is not a rotation.
    #[error(
        "the calibration's R is not a rotation: R R^T differs from the identity by {deviation:.2e}"
    )]
    Rotation {
        /// Largest deviation found.
        deviation: f64,
    },
    /// Cameras at one place.
    #[error("the calibration's baseline is {baseline_mm:.3} mm; the cameras must stand apart")]
    Baseline {
        /// Length of T.
        baseline_mm: f64,
    },
    /// Cameras above each other.
    #[error(
        "the calibration's baseline runs mostly vertically ({x_mm:.1} mm across, {y_mm:.1} mm up or down); stand the cameras side by side, or turn both photos by 90 degrees and calibrate anew"
    )]
    VerticalBaseline {
        /// Component across.
        x_mm: f64,
        /// Component up or down.
        y_mm: f64,
    },
    /// Left and right swapped.
    #[error(
        "in the calibration the right camera stands {x_mm:.1} mm to the LEFT of the left one; swap the photos, or invert the calibration"
    )]
    Swapped {
        /// How far.
        x_mm: f64,
    },
    /// Photos of another size than calibrated.
    #[error(
        "the rig was calibrated on photos of {calibrated_width}x{calibrated_height}, but these are {width}x{height}; use the calibration's own resolution"
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
    /// A parallel rig: equal focal lengths, no distortion, level rows.
    pub fn parallel(
        baseline_mm: f64,
        focal_px: f64,
        principal_left: Vec2,
        principal_right: Vec2,
    ) -> Self {
        Self {
            left: Pinhole::ideal(focal_px, principal_left),
            right: Pinhole::ideal(focal_px, principal_right),
            right_from_left: Similarity::rigid(
                crate::math::Mat3::identity(),
                Vec3::new(-baseline_mm, 0.0, 0.0),
            ),
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

    /// Checks that the rig can be used on photos of this size.
    ///
    /// # Errors
    /// [`RigError`] with the figure found.
    pub fn validate(&self, photo_size: (usize, usize)) -> Result<(), RigError> {
        if !self.left.is_plausible() {
            return Err(RigError::Camera { camera: "left" });
        }
        if !self.right.is_plausible() {
            return Err(RigError::Camera { camera: "right" });
        }
        let r = self.right_from_left.rotation;
        let deviation = (r * r.transpose() - crate::math::Mat3::identity()).amax();
        if !(deviation < 1e-4 && r.determinant() > 0.0) {
            return Err(RigError::Rotation { deviation });
        }
        let baseline_mm = self.baseline_mm();
        if !(baseline_mm > 1e-6 && baseline_mm.is_finite()) {
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
