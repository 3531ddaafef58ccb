//! The poses from which the robust registration starts.

use nalgebra::Rotation3;

use super::super::start::model_axes_from_data;
use super::RobustParams;
use super::samples::{Sample, median_position};
use crate::data::CloudFrame;
use crate::math::{Similarity, Vec3, fit_similarity};

/// Rotations about the vertical and about the axis through the ears, in units of the largest.
const YAWS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
const PITCHES: [f64; 3] = [-1.0, 0.0, 1.0];
/// Shifts upward, mm: the dots may cover more of the forehead or more of the neck.
const RISES_MM: [f64; 2] = [-25.0, 15.0];

/// The head looking straight at the camera, with the median position of the points at `front`.
pub(super) fn frontal_start(samples: &[Sample], front: Vec3, frame: CloudFrame) -> Similarity {
    let rotation = model_axes_from_data(frame).rotation;
    Similarity::rigid(rotation, front - rotation * median_position(samples))
}

/// The frontal pose, the pose of the landmarks, and turned and shifted poses.
pub(super) fn starts(
    samples: &[Sample],
    frontal: Similarity,
    landmarks: &[(Vec3, Vec3)],
    frame: CloudFrame,
    params: &RobustParams,
) -> Vec<Similarity> {
    let centre = frontal.apply(&median_position(samples));
    let mut list = vec![frontal];
    let (source, target): (Vec<Vec3>, Vec<Vec3>) = landmarks.iter().copied().unzip();
    list.extend(fit_similarity(&source, &target, &[], !frame.is_metric()));
    for yaw in YAWS {
        for pitch in PITCHES {
            for rise in RISES_MM {
                let rotation = Rotation3::from_euler_angles(
                    pitch * params.pitch_deg.to_radians(),
                    yaw * params.yaw_deg.to_radians(),
                    0.0,
                );
                let rotation = rotation.into_inner();
                let shift = centre - rotation * centre + Vec3::new(0.0, rise, 0.0);
                list.push(Similarity::rigid(rotation, shift).compose(&frontal));
            }
        }
    }
    list
}
