//! What is registered.

use crate::data::{Cloud, CloudFrame, Mesh};
use crate::math::Vec3;

/// Fewest points from which a pose is estimated: four times as many as a similarity needs.
pub(super) const MIN_POINTS: usize = 12;

/// The measured points and the generic head.
#[derive(Clone, Copy, Debug)]
pub struct RegisterInput<'a> {
    /// The measured points, in the unit and frame that `frame` says.
    pub data: &'a Cloud,
    /// The generic head, model frame, millimetres.
    pub model: &'a Mesh,
    /// The same head with fewer vertices.
    pub coarse: Option<&'a Mesh>,
    /// Height of the model's chin: points closest to vertices below it belong to neck and clothing,
    /// which have no fixed position relative to the head, and do not count for the pose (method
    /// Besl). `None`: all count.
    pub chin_y: Option<f64>,
    /// Landmarks as `(measured, on the model)`.
    pub landmarks: &'a [(Vec3, Vec3)],
    /// Frame of the points. Points in millimetres keep their size, others are scaled to the
    /// model's.
    pub frame: CloudFrame,
}
