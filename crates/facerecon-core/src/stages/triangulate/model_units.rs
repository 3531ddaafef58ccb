//! Points relative to the generic face, for photos of unknown cameras (Eq. 2.3 to 2.6).

use super::TriangulateError;
use crate::data::{Cloud, Match, Mesh};
use crate::math::{Vec2, Vec3, percentile};

/// The thesis's points: depth by Eq. 2.3, normalised to the depth bounds of the generic face, height
/// equal to the generic face's, width in the proportion of the photos (Eq. 2.4 to 2.6). In the
/// generic face's frame (x right, y up, z toward the viewer), about its middle.
///
/// # Errors
/// [`TriangulateError::Flat`] or [`TriangulateError::Template`] when there is nothing to scale by.
pub fn model_units(matches: &[Match], template: &Mesh) -> Result<Cloud, TriangulateError> {
    // Eq. 2.4
    let means: Vec<Vec2> = matches.iter().map(|m| (m.left + m.right) / 2.0).collect();
    let first = means.first().copied().unwrap_or_else(Vec2::zeros);
    let (low, high) = means.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
    let extent = high - low; // (fx, fy) of Eq. 2.5
    if !(extent.x > 1.0 && extent.y > 1.0) {
        return Err(TriangulateError::Flat { width_px: extent.x, height_px: extent.y });
    }
    let bounds = Bounds::of(template)?;
    // Eq. 2.5
    let h = bounds.height;
    let w = extent.x * h / extent.y;
    let nearness = Nearness::new(matches);
    let points = matches.iter().zip(&means).map(|(m, mean)| {
        // Eq. 2.6; the photo's y runs down, the face's up
        let x = (mean.x - low.x) / extent.x * w - w / 2.0;
        let y = h / 2.0 - (mean.y - low.y) / extent.y * h;
        let z = bounds.back + nearness.of(m.disparity()) * (bounds.front - bounds.back);
        Vec3::new(bounds.middle.x + x, bounds.middle.y + y, z)
    });
    Ok(Cloud::from_points(points.collect()))
}

/// What the thesis takes from the generic face.
struct Bounds {
    height: f64,
    middle: Vec2,
    /// Depth of the nearest vertex.
    front: f64,
    /// Depth of the furthest part that looks at the viewer.
    back: f64,
}

impl Bounds {
    fn of(template: &Mesh) -> Result<Self, TriangulateError> {
        let finite = template.vertices.iter().filter(|v| v.iter().all(|c| c.is_finite()));
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let (low, high) = finite.fold(start, |(lo, hi), v| (lo.inf(v), hi.sup(v)));
        let height = high.y - low.y;
        if !(height > 0.0 && height.is_finite()) {
            return Err(TriangulateError::Template { height });
        }
        // The photos never see the back of the head, which the thesis's deepest vertex is: the
        // bounds are those of what looks at the viewer.
        let seen: Vec<f64> = template
            .vertices
            .iter()
            .zip(template.vertex_normals())
            .filter(|(_, n)| n.z > 0.2)
            .map(|(v, _)| v.z)
            .collect();
        let back = percentile(&seen, 0.05).unwrap_or(low.z);
        let middle = ((low + high) / 2.0).xy();
        Ok(Self { height, middle, front: high.z, back })
    }
}

/// Depth between the furthest (0) and the nearest (1) match, by Eq. 2.3.
struct Nearness {
    d_min: f64,
    d_max: f64,
}

impl Nearness {
    fn new(matches: &[Match]) -> Self {
        // a single wrong match must not set the bounds
        let disparities: Vec<f64> = matches.iter().map(Match::disparity).collect();
        let d_min = percentile(&disparities, 0.01).unwrap_or(0.0);
        let d_max = percentile(&disparities, 0.99).unwrap_or(0.0);
        Self { d_min, d_max }
    }

    fn of(&self, disparity: f64) -> f64 {
        let Self { d_min, d_max } = *self;
        let d = disparity.clamp(d_min, d_max);
        if !(d_max > d_min) {
            return 0.5;
        }
        if d_min > 0.5 * d_max {
            // Eq. 2.3 is Z = d_min Mz / |x2 - x1|; only d_min / d matters once bounds are matched
            (1.0 - d_min / d) / (1.0 - d_min / d_max)
        } else {
            // Shifted sensors or turned cameras: disparity has no true zero, and its change is
            // nearly proportional to depth over a head.
            (d - d_min) / (d_max - d_min)
        }
    }
}
