//! Points relative to the template, for photos of unknown cameras (Eq. 2.3 to 2.6).

use super::TriangulateError;
use crate::data::{Cloud, Match, Mesh};
use crate::math::{Vec2, Vec3, percentile};

/// Minimum extent of the matches in both directions, pixels.
const MIN_EXTENT_PX: f64 = 1.0;
/// Vertices whose unit normal has at least this z component face the viewer. Set by hand.
const MIN_NORMAL_Z: f64 = 0.2;
/// Percentile of the depths of facing vertices that counts as the furthest. Set by hand.
const BACK_PERCENTILE: f64 = 0.05;
/// Percentiles of the disparities that count as bounds: a single wrong match must not set them.
const BOUND_PERCENTILES: [f64; 2] = [0.01, 0.99];
/// A smallest disparity above this fraction of the largest one is consistent with parallel cameras,
/// for which disparity 0 is infinity: a face is not twice as far away at its back as at its front.
const TRUE_ZERO_RATIO: f64 = 0.5;
/// Disparities below this fraction of the smallest one are too far behind the face.
const MIN_DISPARITY_RATIO: f64 = 0.5;

/// The thesis's points from pixels and disparities: depth by Eq. 2.3, scaled to the depth bounds of
/// the template; height equal to the template's; width in the proportion of the photos (Eq. 2.4 to
/// 2.6). In units and frame of the template (x right, y up, z toward the viewer), about its middle.
pub struct ModelUnits {
    /// Upper left corner of the matches' means, and their extent: `(fx, fy)` of Eq. 2.5.
    low: Vec2,
    extent: Vec2,
    /// `(w, h)` of Eq. 2.5.
    size: Vec2,
    bounds: Bounds,
    nearness: Nearness,
}

impl ModelUnits {
    /// Determines the scale from the matches of a face (rectified pixels) and the template.
    ///
    /// # Errors
    /// [`TriangulateError::Flat`] or [`TriangulateError::Template`] when they do not determine it.
    pub fn new(matches: &[Match], template: &Mesh) -> Result<Self, TriangulateError> {
        let first = matches.first().map_or_else(Vec2::zeros, mean);
        let bounds_px = |(lo, hi): (Vec2, Vec2), p: Vec2| (lo.inf(&p), hi.sup(&p));
        let (low, high) = matches.iter().map(mean).fold((first, first), bounds_px);
        let extent = high - low;
        if !(extent.x > MIN_EXTENT_PX && extent.y > MIN_EXTENT_PX) {
            return Err(TriangulateError::Flat { width_px: extent.x, height_px: extent.y });
        }
        let bounds = Bounds::of(template)?;
        // Eq. 2.5
        let h = bounds.height;
        let size = Vec2::new(extent.x * h / extent.y, h);
        Ok(Self { low, extent, size, bounds, nearness: Nearness::new(matches) })
    }

    /// The point of a mean of both rectified pixels (Eq. 2.4) and a disparity; `None` where Eq. 2.3
    /// has no solution.
    pub fn point(&self, mean: Vec2, disparity_px: f64) -> Option<Vec3> {
        let Self { low, extent, size, bounds, nearness } = self;
        // Eq. 2.6; y points down in the photo and up in the template's frame
        let x = (mean.x - low.x) / extent.x * size.x - size.x / 2.0;
        let y = size.y / 2.0 - (mean.y - low.y) / extent.y * size.y;
        let z = bounds.back + nearness.of(disparity_px)? * (bounds.front - bounds.back);
        Some(Vec3::new(bounds.middle.x + x, bounds.middle.y + y, z))
    }
}

/// Eq. 2.4
fn mean(m: &Match) -> Vec2 {
    (m.left + m.right) / 2.0
}

/// One point for each match; see [`ModelUnits`].
///
/// # Errors
/// Those of [`ModelUnits::new`].
pub(super) fn model_units(matches: &[Match], template: &Mesh) -> Result<Cloud, TriangulateError> {
    let units = ModelUnits::new(matches, template)?;
    let Nearness { d_min, d_max } = units.nearness;
    // matches beyond the percentiles get the depth of the bounds
    let point = |m: &Match| units.point(mean(m), m.disparity().clamp(d_min, d_max));
    // within the bounds Eq. 2.3 always has a solution
    Ok(Cloud::from_points(matches.iter().filter_map(point).collect()))
}

/// Bounds of the template.
struct Bounds {
    height: f64,
    middle: Vec2,
    /// Depth of the nearest vertex.
    front: f64,
    /// Depth of the furthest part that faces the viewer.
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
        // The thesis's deepest vertex is at the back of the head, which no photo shows: the bounds
        // are those of the part that faces the viewer.
        let facing: Vec<f64> = template
            .vertices
            .iter()
            .zip(template.vertex_normals())
            .filter(|(_, n)| n.z > MIN_NORMAL_Z)
            .map(|(v, _)| v.z)
            .collect();
        let back = percentile(&facing, BACK_PERCENTILE).unwrap_or(low.z);
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
        let disparities: Vec<f64> = matches.iter().map(Match::disparity).collect();
        let d_min = percentile(&disparities, BOUND_PERCENTILES[0]).unwrap_or(0.0);
        let d_max = percentile(&disparities, BOUND_PERCENTILES[1]).unwrap_or(0.0);
        Self { d_min, d_max }
    }

    /// `None` where Eq. 2.3 has no solution.
    fn of(&self, disparity: f64) -> Option<f64> {
        let Self { d_min, d_max } = *self;
        if !(d_max > d_min) {
            return Some(0.5);
        }
        if d_min > TRUE_ZERO_RATIO * d_max {
            // Eq. 2.3 is Z = d_min Mz / |x2 - x1|; after scaling to the bounds only d_min / d matters
            (disparity > MIN_DISPARITY_RATIO * d_min)
                .then(|| (1.0 - d_min / disparity) / (1.0 - d_min / d_max))
        } else {
            // Shifted sensors or rotated cameras: disparity has no true zero, and over a head depth
            // is nearly linear in it.
            Some((disparity - d_min) / (d_max - d_min))
        }
    }
}
