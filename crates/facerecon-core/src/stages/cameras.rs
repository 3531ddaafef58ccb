//! Cameras: what the photographs themselves say about cameras nobody has calibrated.
//!
//! Level rows leave two numbers open that decide the shape of the face: the focal length and the
//! disparity of infinity. Their ratio stretches depth against width, their size is perspective.
//! The projector is a third view that closes the gap: dots equally spaced along both directions of
//! the lattice, on a projector of square pixels, look square to one stretch of depth only (the
//! image of the absolute conic, Hartley and Zisserman 2004, section 19.3). How strong the
//! perspective is, photographs of one face hardly say; there the usual lens of a portrait rig
//! stands in, and an error of a third moves the surface by a tenth of a millimetre.

use crate::camera::{RectifiedRig, resect};
use crate::data::Match;
use crate::math::{Mat2, Mat3, Vec2, Vec3, median, percentile};
use crate::observer::{Event, Observer};
use crate::settings;

#[cfg(test)]
mod tests;

settings! {
    /// Estimating the cameras of a capture without calibration.
    pub struct CamerasParams {
        /// Whether unknown cameras are estimated from the pattern's lattice, which must be square
        /// (as `facerecon pattern` makes it); else depth follows from the generic head (thesis Eq. 2.3).
        estimate: bool = true;
        /// Usual focal length, in widths of the photo.
        focal_widths: f64 = 3.0, range 0.3..=30.0;
        /// How far the focal length may well be from it: standard deviation of its logarithm.
        focal_spread: f64 = 0.4, range 0.01..=3.0;
        /// Usual distance of the face, in distances between the cameras.
        distance_baselines: f64 = 8.0, range 1.0..=100.0;
        /// Standard deviation of that ratio's logarithm.
        distance_spread: f64 = 0.35, range 0.01..=3.0;
        /// Departure from a square lattice that lenses and projector bring, relative.
        lattice_error: f64 = 5e-4, range 1e-6..=0.1;
        /// Largest standard deviation of depth against width, relative, at which the estimate is
        /// used.
        max_depth_error: f64 = 0.2, range 0.001..=1.0;
    }
}

/// Cameras estimated from the photographs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatedCameras {
    /// The pair as two equal cameras side by side. Its unit of length is about a millimetre.
    pub rig: RectifiedRig,
    /// Relative standard deviation of depth against width.
    pub depth_error: f64,
    /// Relative standard deviation of the focal length, and with it of the perspective.
    pub focal_error: f64,
}

/// Why the cameras stay unknown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CamerasError {
    /// Too few dots with a place in the lattice.
    #[error("{got} matches have a place in the pattern's lattice, {needed} are needed")]
    TooFewLabels {
        /// Found.
        got: usize,
        /// Needed.
        needed: usize,
    },
    /// Dots that do not determine the projector.
    #[error("the dots do not determine how the projector looked at the face")]
    Degenerate,
    /// A projector that looks along the cameras says nothing about depth.
    #[error(
        "the lattice tells depth only to {found_percent:.0} %, {needed_percent:.0} % is needed: the projector stands too close to the line between the cameras"
    )]
    Uncertain {
        /// Standard deviation found.
        found_percent: f64,
        /// Allowed.
        needed_percent: f64,
    },
}

/// Fewer labelled dots than this say nothing.
const LEAST_LABELS: usize = 60;

/// Estimates focal length and disparity of infinity from matches (rectified pixels) with places in
/// a square lattice, and from what rigs usually are. `size` is that of the rectified pictures,
/// whose middle is taken for the optical axis.
///
/// # Errors
/// [`CamerasError`] where the lattice says too little.
pub fn estimate_cameras(
    matches: &[Match],
    size: (usize, usize),
    params: &CamerasParams,
    observer: &dyn Observer,
) -> Result<EstimatedCameras, CamerasError> {
    let middle = Vec2::new(size.0 as f64 - 1.0, size.1 as f64 - 1.0) / 2.0;
    let labelled: Vec<_> = matches.iter().filter_map(|m| Some((m, m.lattice?))).collect();
    let got = labelled.len();
    if got < LEAST_LABELS {
        return Err(CamerasError::TooFewLabels { got, needed: LEAST_LABELS });
    }
    let disparities: Vec<f64> = labelled.iter().map(|(m, _)| m.disparity()).collect();
    let disparity = median(&disparities).ok_or(CamerasError::Degenerate)?;
    // A view midway between the cameras, so that neither is preferred.
    let midway = |m: &Match| (m.left + m.right) / 2.0 - middle;
    let points: Vec<Vec3> = labelled
        .iter()
        .map(|(m, _)| {
            let p = midway(m);
            Vec3::new(p.x, p.y, EVEN * (m.disparity() - disparity))
        })
        .collect();
    let cells: Vec<Vec2> =
        labelled.iter().map(|(_, [c, r])| Vec2::new(f64::from(*c), f64::from(*r))).collect();
    let (projector, _) = resect(&points, &cells).ok_or(CamerasError::Degenerate)?;
    let odds = Odds {
        across: projector.matrix.column(0).into(),
        down: projector.matrix.column(1).into(),
        ahead: projector.shift,
        parallax: projector.matrix.column(2) * EVEN,
        usual: Vec2::new(
            (params.focal_widths * size.0 as f64).ln(),
            params.distance_baselines.ln(),
        ),
        spread: Vec2::new(params.focal_spread, params.distance_spread),
        lattice_error: params.lattice_error,
    };
    let best = odds.best();
    let covariance = odds.covariance(best).ok_or(CamerasError::Degenerate)?;
    let [focal_error, depth_error] = [0, 1].map(|i| covariance[(i, i)].max(0.0).sqrt());
    if !(depth_error <= params.max_depth_error) {
        return Err(CamerasError::Uncertain {
            found_percent: 100.0 * depth_error,
            needed_percent: 100.0 * params.max_depth_error,
        });
    }

    let focal_px = best.x.exp();
    // the disparity of the face over that of infinity
    let parallax_px = focal_px / best.y.exp();
    let infinity_px = disparity - parallax_px;
    let columns: Vec<f64> = points.iter().map(|p| p.x).collect();
    let edge = |q: f64| percentile(&columns, q).unwrap_or(0.0);
    let width_px = (edge(0.95) - edge(0.05)).max(1.0);
    let rig = RectifiedRig {
        focal_px,
        baseline_mm: FACE_WIDTH * parallax_px / width_px,
        principal_left: middle + Vec2::new(infinity_px / 2.0, 0.0),
        principal_right: middle - Vec2::new(infinity_px / 2.0, 0.0),
        camera_from_rectified: Mat3::identity(),
        metric: false,
    };
    let found = EstimatedCameras { rig, depth_error, focal_error };
    observer.event(&Event::Warning { stage: "cameras", message: &found.in_words() });
    Ok(found)
}

impl EstimatedCameras {
    /// What was found, for the user.
    pub fn in_words(&self) -> String {
        format!(
            "the cameras were estimated from the pattern: focal length {:.0} px (to {:.0} %), depth against width to {:.1} %; calibrate for millimetres",
            self.rig.focal_px,
            100.0 * self.focal_error,
            100.0 * self.depth_error
        )
    }
}

/// Makes a pixel of disparity about as long as one across (usual distance over baseline).
const EVEN: f64 = 8.0;
/// What lies between the outer dots of a face, about, mm: sets the unit of length.
const FACE_WIDTH: f64 = 120.0;

/// How unlikely a focal length and a distance are: `x` is the logarithm of the focal length in
/// pixels, `y` that of the distance over the baseline.
struct Odds {
    /// Columns of the projector's matrix: for pixels across and down, for the constant, and for
    /// pixels of disparity beyond the median.
    across: Vec3,
    down: Vec3,
    ahead: Vec3,
    parallax: Vec3,
    usual: Vec2,
    spread: Vec2,
    lattice_error: f64,
}

impl Odds {
    /// Skew and unequal scale of the projector's pixels, relative. Point `(x, y, f, d - d0)` is
    /// proportional to `(X, Y, Z, B)`, so that the projector's matrix for `(X, Y, Z)` has the
    /// columns `across`, `down` and `(ahead - (d - d0) parallax) / f`; with its transpose it makes
    /// the dual image of the absolute conic.
    fn squareness(&self, at: Vec2) -> Vec2 {
        let focal = at.x.exp();
        let parallax_px = focal / at.y.exp();
        let depth = (self.ahead - self.parallax * parallax_px) / focal;
        let outer = |v: &Vec3| v * v.transpose();
        let conic = outer(&self.across) + outer(&self.down) + outer(&depth);
        let scale = conic[(2, 2)];
        let [xx, yy] = [0, 1].map(|i| conic[(i, i)] - conic[(i, 2)].powi(2) / scale);
        let xy = conic[(0, 1)] - conic[(0, 2)] * conic[(1, 2)] / scale;
        Vec2::new(2.0 * xy, xx - yy) / (xx + yy)
    }

    fn energy(&self, at: Vec2) -> f64 {
        let lattice = self.squareness(at) / self.lattice_error;
        let usual = (at - self.usual).component_div(&self.spread);
        lattice.norm_squared() + usual.norm_squared()
    }

    /// The least energy: a grid over all that is usual, then ever finer ones around the best.
    fn best(&self) -> Vec2 {
        const HALF: i32 = 30;
        let mut centre = self.usual;
        let mut reach = 4.0 * self.spread;
        for _ in 0..8 {
            let grid = (-HALF..=HALF).flat_map(|i| (-HALF..=HALF).map(move |j| (i, j)));
            let at = |(i, j): (i32, i32)| {
                let share = Vec2::new(f64::from(i), f64::from(j)) / f64::from(HALF);
                centre + reach.component_mul(&share)
            };
            let places = grid.map(at).map(|p| (self.energy(p), p));
            if let Some((_, p)) = places.min_by(|a, b| a.0.total_cmp(&b.0)) {
                centre = p;
            }
            reach *= 0.3;
        }
        centre
    }

    /// Covariance of the two logarithms from the energy's slope (Gauss-Newton).
    fn covariance(&self, at: Vec2) -> Option<Mat2> {
        let step = 1e-4;
        let slope = [Vec2::x(), Vec2::y()].map(|axis| {
            (self.squareness(at + axis * step) - self.squareness(at - axis * step))
                / (2.0 * step * self.lattice_error)
        });
        let jacobian = Mat2::from_columns(&slope);
        let prior = Mat2::from_diagonal(&self.spread.map(|s| 1.0 / (s * s)));
        (jacobian.transpose() * jacobian + prior).try_inverse()
    }
}
