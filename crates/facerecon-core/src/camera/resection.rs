//! Resection: the projection of an image from points and their pixels.

use nalgebra::{SMatrix, SVector};

use crate::math::{Mat3, Vec2, Vec3, median};

/// Fewest pairs: twice the six that determine a projection, so that outliers show.
const MIN_PAIRS: usize = 12;
/// Rounds of reweighted least squares; the weights settle in about five.
const ROUNDS: usize = 8;
/// Spread of points or pixels below which they are one point.
const MIN_SPREAD: f64 = 1e-9;
/// Smallest norm of a row, or depth of the centre, of a projection that is not degenerate.
const MIN_SCALE: f64 = 1e-12;
/// Points nearer than this to the plane of the camera are not projected.
const MIN_DEPTH: f64 = 1e-9;
/// Scale of the weights in median residuals: beyond it a pair counts as an outlier.
const SCALE_IN_MEDIANS: f64 = 3.0;
/// Smallest scale of the weights, pixels: the accuracy of a marked or detected point.
const MIN_SCALE_PX: f64 = 0.2;
/// RMS over median of two-dimensional normal residuals: 1.41 sigma / 1.18 sigma.
const RMS_PER_MEDIAN: f64 = 1.2;

/// A general projection: `pixel ~ matrix * point + shift`, depth in the unit of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Homogeneous pixel per unit of the point.
    pub matrix: Mat3,
    /// Homogeneous pixel of the origin.
    pub shift: Vec3,
}

impl Projection {
    /// Pixel of a point; `None` behind the camera.
    pub fn pixel(&self, point: &Vec3) -> Option<Vec2> {
        let q = self.matrix * point + self.shift;
        (q.z > MIN_DEPTH).then(|| Vec2::new(q.x / q.z, q.y / q.z))
    }
}

/// Direct linear transform (Hartley and Zisserman 2004, section 7.1) on normalised points, with
/// robust weights. Returns the projection and its robust RMS residual in pixels; `None` when the
/// points do not determine one.
pub fn resect(points: &[Vec3], pixels: &[Vec2]) -> Option<(Projection, f64)> {
    if points.len() < MIN_PAIRS || points.len() != pixels.len() {
        return None;
    }
    let n = points.len() as f64;
    let centre = points.iter().sum::<Vec3>() / n;
    let spread = (points.iter().map(|p| (p - centre).norm_squared()).sum::<f64>() / n).sqrt();
    let middle = pixels.iter().sum::<Vec2>() / n;
    let extent = (pixels.iter().map(|p| (p - middle).norm_squared()).sum::<f64>() / n).sqrt();
    if !(spread > MIN_SPREAD && extent > MIN_SPREAD && spread.is_finite() && extent.is_finite()) {
        return None;
    }
    let mut weights = vec![1.0; points.len()];
    let mut best = None;
    for _ in 0..ROUNDS {
        let mut normal = SMatrix::<f64, 12, 12>::zeros();
        for ((p, q), w) in points.iter().zip(pixels).zip(&weights) {
            let x = (p - centre) / spread;
            let u = (q - middle) / extent;
            let h = [x.x, x.y, x.z, 1.0];
            let mut rows = [SVector::<f64, 12>::zeros(); 2];
            for k in 0..4 {
                rows[0][k] = h[k];
                rows[0][8 + k] = -u.x * h[k];
                rows[1][4 + k] = h[k];
                rows[1][8 + k] = -u.y * h[k];
            }
            for row in rows {
                normal += row * row.transpose() * *w;
            }
        }
        let eigen = normal.symmetric_eigen();
        let smallest = eigen.eigenvalues.imin();
        let s = eigen.eigenvectors.column(smallest);
        // Invert the normalisations.
        let pixel_from_normalised =
            Mat3::new(extent, 0.0, middle.x, 0.0, extent, middle.y, 0.0, 0.0, 1.0);
        let m = Mat3::new(s[0], s[1], s[2], s[4], s[5], s[6], s[8], s[9], s[10]) / spread;
        let t = Vec3::new(s[3], s[7], s[11]);
        let mut projection = Projection {
            matrix: pixel_from_normalised * m,
            shift: pixel_from_normalised * (t - m * centre),
        };
        let depth = (projection.matrix * centre + projection.shift).z;
        let unit = projection.matrix.row(2).norm();
        if !(unit > MIN_SCALE && depth.abs() > MIN_SCALE) {
            return None;
        }
        let scale = depth.signum() / unit;
        projection.matrix *= scale;
        projection.shift *= scale;
        let residuals: Vec<f64> = points
            .iter()
            .zip(pixels)
            .map(|(p, q)| projection.pixel(p).map_or(f64::INFINITY, |r| (r - q).norm()))
            .collect();
        let typical = median(&residuals)?;
        let width = (SCALE_IN_MEDIANS * typical).max(MIN_SCALE_PX);
        weights = residuals.iter().map(|r| (1.0 + (r / width).powi(2)).powi(-2)).collect();
        best = Some((projection, typical * RMS_PER_MEDIAN));
    }
    best
}
