//! The dense disparity as a cloud.

use crate::camera::RectifiedRig;
use crate::data::Cloud;
use crate::math::{Vec2, Vec3};
use crate::stages::refine::Refined;

/// Points of the cloud from one dot to the next: enough for all detail that the pattern carries.
const POINTS_PER_PITCH: f64 = 5.0;

/// The measured surface as points of the left camera frame, mm, on an even grid of rectified
/// pixels, with normals from the neighbouring pixels and standard deviations along the line of
/// sight.
pub(super) fn cloud(dense: &Refined, rig: &RectifiedRig) -> Cloud {
    let (width, height) = dense.disparity.size();
    let step = (dense.pitch_px / POINTS_PER_PITCH).round().max(1.0) as usize;
    let at = |x: usize, y: usize| -> Option<Vec3> {
        let d = f64::from(dense.disparity.at(x, y));
        d.is_finite().then(|| rig.point(Vec2::new(x as f64, y as f64), d)).flatten()
    };
    let mut cloud = Cloud::default();
    for y in (1..height.saturating_sub(1)).step_by(step) {
        for x in (1..width.saturating_sub(1)).step_by(step) {
            let Some(point) = at(x, y) else { continue };
            let neighbours = (at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1));
            let (Some(w), Some(e), Some(n), Some(s)) = neighbours else { continue };
            // x right, y down, z away: toward the camera is (s - n) x (e - w)
            let Some(normal) = (s - n).cross(&(e - w)).try_normalize(1e-12) else { continue };
            let sigma_px = f64::from(dense.sigma_px.at(x, y));
            let slope = point.norm() * point.z / (rig.focal_px * rig.baseline_mm);
            cloud.points.push(point);
            cloud.normals.push(normal);
            cloud.sigmas.push(sigma_px * slope);
        }
    }
    cloud
}
