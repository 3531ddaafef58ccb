//! One dot: `b + g.(q - c) + a exp(-|q - c|^2 / 2 s^2)` fitted by Levenberg-Marquardt.

use nalgebra::{SMatrix, SVector};

use crate::data::{Dot, Gray};
use crate::math::Vec2;

use super::GaussianParams;

/// Radius of the window in standard deviations, and its maximum in spacings: a wide window measures
/// best; where dots are close together (oblique skin) only a narrow one contains a single dot. Set by
/// hand.
const WIDE_SIGMAS: f64 = 3.4;
const WIDE_SPACINGS: f64 = 0.48;
const NARROW_SIGMAS: f64 = 2.2;
const NARROW_PER_WIDE: f64 = 0.8;
/// Minimum radius of a window, pixels.
const MIN_RADIUS_PX: f64 = 2.0;
/// A fit in a narrow window must have a residual below this fraction of the maximum.
const STRICT: f64 = 0.5;
/// Minimum number of unsaturated pixels: twice the number of parameters.
const MIN_MEASURED: usize = 14;
/// Minimum range of grey levels in a window, as a fraction of the minimum amplitude: windows below
/// cannot give an accepted fit.
const MIN_RANGE: f64 = 0.5;
/// Start of the standard deviation, as a fraction of the expected one.
const START_SIGMA: f64 = 0.9;
/// Minimum standard deviation of a dot, pixels: smaller ones are single hot pixels. Set by hand.
const MIN_SIGMA_PX: f64 = 0.35;
/// Maximum movement of the centre during the fit, in radii of the window.
const MAX_MOVE: f64 = 0.6;
/// Residual that counts as noise in the quality of a fit, grey levels: about the
/// rounding to 8 bit.
const NOISE: f64 = 0.5;

/// Levenberg-Marquardt: steps; start, minimum and maximum of the damping; its factors after a step
/// that is not finite, one that fails, and one that succeeds.
const MAX_STEPS: usize = 15;
const DAMPING: f64 = 1e-3;
const MIN_DAMPING: f64 = 1e-7;
const MAX_DAMPING: f64 = 1e6;
const DAMPING_INVALID: f64 = 10.0;
const DAMPING_FAILED: f64 = 8.0;
const DAMPING_SUCCEEDED: f64 = 0.2;
/// A step is the last when the centre moves less than this (pixels) and the cost falls by less than
/// this fraction.
const CONVERGED_PX: f64 = 1e-3;
const CONVERGED_COST: f64 = 1e-4;
/// Bounds of the standard deviation during the fit: pixels, and radii of the window.
const SIGMA_FLOOR_PX: f64 = 0.3;
const BOUND_RADII: f64 = 2.0;

type Vec7 = SVector<f64, 7>;
type Mat7 = SMatrix<f64, 7, 7>;

/// A fitted dot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub position: Vec2,
    pub amplitude: f64,
    pub sigma_px: f64,
    /// Root mean square residual, grey levels.
    pub residual: f64,
    pub axis_ratio: f64,
}

impl Fit {
    /// Height over residual: of two fits at one position the greater is kept.
    pub(super) fn quality(&self) -> f64 {
        self.amplitude / (self.residual + NOISE)
    }

    /// Residual as a fraction of the height.
    fn relative_residual(&self) -> f64 {
        self.residual / self.amplitude
    }

    /// The dot; its score falls from 1 to 0.5 at the maximum residual.
    pub(super) fn dot(&self, params: &GaussianParams) -> Dot {
        let fraction = self.relative_residual() / params.max_residual;
        Dot {
            position: self.position,
            sigma_px: self.sigma_px,
            amplitude: self.amplitude,
            score: (1.0 - 0.5 * fraction).clamp(0.0, 1.0),
        }
    }
}

/// The pixels a dot is fitted to: offsets from the window's centre, and grey levels.
struct Window {
    samples: Vec<(f64, f64, f64)>,
    radius: f64,
    /// Pixels from this level up are only lower bounds of the profile.
    saturation: f64,
}

impl Window {
    fn new(image: &Gray, at: Vec2, radius: f64, saturation: f64) -> Self {
        let (cx, cy) = (at.x.round() as isize, at.y.round() as isize);
        let r = radius.ceil() as isize;
        let mut samples = Vec::with_capacity(((2 * r + 1) * (2 * r + 1)) as usize);
        for dy in -r..=r {
            for dx in -r..=r {
                let inside = ((dx * dx + dy * dy) as f64) <= (radius + 0.5).powi(2);
                if let (true, Some(level)) = (inside, image.get(cx + dx, cy + dy)) {
                    samples.push((dx as f64, dy as f64, f64::from(level)));
                }
            }
        }
        Self { samples, radius, saturation }
    }
}

/// Fits the dot near `at`, in a wide window if possible, else in a narrow one; `None` where there is
/// no dot.
pub(super) fn fit(
    image: &Gray,
    at: Vec2,
    sigma_px: f64,
    spacing_px: f64,
    params: &GaussianParams,
) -> Option<Fit> {
    let wide = (WIDE_SIGMAS * sigma_px).min(WIDE_SPACINGS * spacing_px).max(MIN_RADIUS_PX);
    let narrow = (NARROW_SIGMAS * sigma_px).min(NARROW_PER_WIDE * wide).max(MIN_RADIUS_PX);
    let strict = STRICT * params.max_residual;
    fit_window(image, at, sigma_px, wide, params).or_else(|| {
        fit_window(image, at, sigma_px, narrow, params).filter(|f| f.relative_residual() < strict)
    })
}

fn fit_window(
    image: &Gray,
    at: Vec2,
    sigma_px: f64,
    radius: f64,
    params: &GaussianParams,
) -> Option<Fit> {
    let window = Window::new(image, at, radius, params.saturation);
    let origin = Vec2::new(at.x.round(), at.y.round());
    let start = at - origin;
    let lowest = window.samples.iter().map(|s| s.2).fold(f64::INFINITY, f64::min);
    let highest = window.samples.iter().map(|s| s.2).fold(f64::NEG_INFINITY, f64::max);
    let measured = window.samples.iter().filter(|s| s.2 < params.saturation).count();
    if measured < MIN_MEASURED || !(highest - lowest > MIN_RANGE * params.min_amplitude) {
        return None;
    }
    let sigma = START_SIGMA * sigma_px;
    let begin = Vec7::from([highest - lowest, start.x, start.y, sigma, lowest, 0.0, 0.0]);
    let (p, cost) = minimise(&window, begin)?;
    let [amplitude, x, y, sigma, ..]: [f64; 7] = p.into();
    let residual = (cost / window.samples.len() as f64).sqrt();
    let moved = Vec2::new(x, y) - start;
    let good = amplitude > params.min_amplitude
        && sigma > MIN_SIGMA_PX
        && sigma < window.radius
        && moved.norm() < MAX_MOVE * radius
        && residual < params.max_residual * amplitude;
    good.then(|| Fit {
        position: origin + Vec2::new(x, y),
        amplitude,
        sigma_px: sigma,
        residual,
        axis_ratio: axis_ratio(&window, &p),
    })
}

/// Levenberg-Marquardt; returns the parameters `a, x, y, s, b, gx, gy` and the sum of squares.
fn minimise(window: &Window, mut p: Vec7) -> Option<(Vec7, f64)> {
    let (mut normal, mut gradient, mut cost) = equations(window, &p);
    let mut damping = DAMPING;
    let bound = BOUND_RADII * window.radius;
    for _ in 0..MAX_STEPS {
        let mut damped: Mat7 = normal;
        for i in 0..7 {
            damped[(i, i)] += damping * normal[(i, i)] + 1e-9;
        }
        let step = damped.cholesky()?.solve(&gradient);
        let mut trial = p + step;
        trial[3] = trial[3].clamp(SIGMA_FLOOR_PX, bound);
        if !trial.iter().all(|v| v.is_finite()) || trial[1].hypot(trial[2]) > bound {
            damping *= DAMPING_INVALID;
            continue;
        }
        let (n, g, c) = equations(window, &trial);
        if c < cost {
            let small = step[1].hypot(step[2]) < CONVERGED_PX && cost - c < CONVERGED_COST * cost;
            (p, normal, gradient, cost) = (trial, n, g, c);
            damping = (damping * DAMPING_SUCCEEDED).max(MIN_DAMPING);
            if small {
                break;
            }
        } else {
            damping *= DAMPING_FAILED;
            if damping > MAX_DAMPING {
                break;
            }
        }
    }
    Some((p, cost))
}

/// Normal equations of the Gauss-Newton step and the sum of squares at `p`.
fn equations(window: &Window, p: &Vec7) -> (Mat7, Vec7, f64) {
    let [a, x, y, s, b, gx, gy]: [f64; 7] = (*p).into();
    let mut normal = Mat7::zeros();
    let mut gradient = Vec7::zeros();
    let mut cost = 0.0;
    let w = 1.0 / (s * s);
    for &(qx, qy, level) in &window.samples {
        let (dx, dy) = (qx - x, qy - y);
        let r2 = dx * dx + dy * dy;
        let e = (-0.5 * w * r2).exp();
        let ae = a * e;
        let error = level - (b + gx * qx + gy * qy + ae);
        if level >= window.saturation && error < 0.0 {
            continue;
        }
        let j = [e, ae * dx * w, ae * dy * w, ae * r2 * w / s, 1.0, qx, qy];
        cost += error * error;
        for row in 0..7 {
            gradient[row] += j[row] * error;
            for column in 0..=row {
                normal[(row, column)] += j[row] * j[column];
            }
        }
    }
    for row in 0..7 {
        for column in 0..row {
            normal[(column, row)] = normal[(row, column)];
        }
    }
    (normal, gradient, cost)
}

/// Ratio of the axes of the dot's second moments, without the background.
fn axis_ratio(window: &Window, p: &Vec7) -> f64 {
    let [a, x, y, s, b, gx, gy]: [f64; 7] = (*p).into();
    let (mut sum, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0);
    for &(qx, qy, level) in &window.samples {
        let (dx, dy) = (qx - x, qy - y);
        // The weight suppresses noise at the border of the window.
        let weight = (-0.25 * (dx * dx + dy * dy) / (s * s)).exp();
        let height = ((level - b - gx * qx - gy * qy) / a).max(0.0) * weight;
        sum += height;
        xx += height * dx * dx;
        xy += height * dx * dy;
        yy += height * dy * dy;
    }
    let mean = 0.5 * (xx + yy);
    let spread = (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    if sum > 0.0 && mean > spread { ((mean + spread) / (mean - spread)).sqrt() } else { f64::MAX }
}
