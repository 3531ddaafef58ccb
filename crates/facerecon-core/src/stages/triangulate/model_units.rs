//! Points relative to the generic face, for photos of unknown cameras (Eq. 2.3 to 2.6).

use super::TriangulateError;
use crate::data::{Cloud, Match, Mesh};
use crate::math::{Vec2, Vec3, percentile};

/// How pixels and disparities become the thesis's points: depth by Eq. 2.3, normalised to the depth
/// bounds of the generic face, height equal to the generic face's, width in the proportion of the
/// photos (Eq. 2.4 to 2.6). In the generic face's frame (x right, y up, z toward the viewer), about
/// its middle.
pub struct ModelUnits {
    /// Top left corner of the matches' means, and their extent: `(fx, fy)` of Eq. 2.5.
    low: Vec2,
    extent: Vec2,
    /// `(w, h)` of Eq. 2.5.
    size: Vec2,
    bounds: Bounds,
    nearness: Nearness,
}

impl ModelUnits {
    /// Sets the scale by the matches of a face and the generic face.
    ///
    /// # Errors
    /// [`TriangulateError::Flat`] or [`TriangulateError::Template`] when there is nothing to scale by.
    pub fn new(matches: &[Match], template: &Mesh) -> Result<Self, TriangulateError> {
        let first = matches.first().map_or_else(Vec2::zeros, mean);
        let bounds_px = |(lo, hi): (Vec2, Vec2), p: Vec2| (lo.inf(&p), hi.sup(&p));
        let (low, high) = matches.iter().map(mean).fold((first, first), bounds_px);
        let extent = high - low;
        if !(extent.x > 1.0 && extent.y > 1.0) {
            return Err(TriangulateError::Flat { width_px: extent.x, height_px: extent.y });
        }
        let bounds = Bounds::of(template)?;
        // Eq. 2.5
        let h = bounds.height;
        let size = Vec2::new(extent.x * h / extent.y, h);
        Ok(Self { low, extent, size, bounds, nearness: Nearness::new(matches) })
    }

    /// The point of a mean of both rectified pixels (Eq. 2.4) and a disparity; `None` where Eq. 2.3
    /// has none.
    pub fn point(&self, mean: Vec2, disparity_px: f64) -> Option<Vec3> {
        let Self { low, extent, size, bounds, nearness } = self;
        // Eq. 2.6; the photo's y runs down, the face's up
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

/// The thesis's points of matches; see [`ModelUnits`].
///
/// # Errors
/// Those of [`ModelUnits::new`].
pub fn model_units(matches: &[Match], template: &Mesh) -> Result<Cloud, TriangulateError> {
    let units = ModelUnits::new(matches, template)?;
    let Nearness { d_min, d_max } = units.nearness;
    // the bounds leave out a hundredth at either end: what lies beyond them lies on them
    let point = |m: &Match| units.point(mean(m), m.disparity().clamp(d_min, d_max));
    // within the bounds Eq. 2.3 always has an answer
    Ok(Cloud::from_points(matches.iter().filter_map(point).collect()))
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

    fn of(&self, disparity: f64) -> Option<f64> {
        let Self { d_min, d_max } = *self;
        if !(d_max > d_min) {
            return Some(0.5);
        }
        if d_min > 0.5 * d_max {
            // Eq. 2.3 is Z = d_min Mz / |x2 - x1|; only d_min / d matters once bounds are matched
            (disparity > 0.5 * d_min).then(|| (1.0 - d_min / disparity) / (1.0 - d_min / d_max))
        } else {
            // Shifted sensors or turned cameras: disparity has no true zero, and its change is
            // nearly proportional to depth over a head.
            Some((disparity - d_min) / (d_max - d_min))
        }
    }
}
