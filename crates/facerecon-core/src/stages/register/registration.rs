//! The result of the stage.

use super::mask::border_of_mask;
use crate::data::{Cloud, Mesh};
use crate::math::{Similarity, Vec3};
use crate::spatial::{Termination, eliminate_multiple};

/// Greatest distance of a point from its vertex, in RMS distances of the registration: wrong
/// matches are farther.
const MAX_DISTANCE_RMS: f64 = 4.0;

/// The pose of the measured points on the generic head.
#[derive(Clone, Debug, PartialEq)]
pub struct Registration {
    /// Brings measured points into the model frame. With `scale` the model keeps its own size:
    /// lengths in the model frame are then `scale` times the measured ones.
    pub model_from_data: Similarity,
    /// Steps taken. Besl: all of them, for a start, on the coarse mesh and on the detailed one;
    /// robust: those of the pose that was chosen.
    pub iterations: usize,
    /// Of these, steps spent on finding a start; 0 with landmarks.
    pub start_iterations: usize,
    /// Of these, steps on the coarse mesh.
    pub coarse_iterations: usize,
    /// Besl: error (Eq. 3.8) at the start and after each step on the detailed mesh. Robust: RMS
    /// distance along the normals before each step of the last round. Model units.
    pub history: Vec<f64>,
    /// Why the last iteration ended.
    pub termination: Termination,
    /// Whether landmarks gave the start.
    pub from_landmarks: bool,
    /// Typical distance from the model at the start, model units. Besl: root mean square of the
    /// closest 80 %; robust: root mean square, each distance at most 12.
    pub rms_before: f64,
    /// The same at the end.
    pub rms_after: f64,
    /// Indices of the points that belong to the head and were used.
    pub inliers: Vec<usize>,
}

impl Registration {
    /// The used points in the model frame, one for each vertex they are closest to (thesis section
    /// 3.2), as `(vertex, position)`: the `assignments` of the deformation.
    pub fn assignments(&self, data: &Cloud, model: &Mesh) -> Vec<(usize, Vec3)> {
        let points: Vec<Vec3> = self
            .inliers
            .iter()
            .filter_map(|&i| data.points.get(i))
            .map(|p| self.model_from_data.apply(p))
            .collect();
        let max_distance = MAX_DISTANCE_RMS * self.rms_after.max(1e-12);
        let targets = eliminate_multiple(&points, &model.vertices, Some(max_distance));
        let border = border_of_mask(model);
        targets.into_iter().filter(|(vertex, _)| !border[*vertex]).collect()
    }
}
