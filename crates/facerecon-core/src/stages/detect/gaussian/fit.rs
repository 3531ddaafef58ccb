//! One dot: `b + g.(q - c) + a exp(-|q - c|^2 / 2 s^2)` fitted by Levenberg-Marquardt.

use nalgebra::{SMatrix, SVector};

use crate::data::{Dot, Gray};
use crate::math::Vec2;

use super::GaussianParams;

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
    /// Height over residual: what decides between two fits at one place.
    pub(super) fn quality(&self) -> f64 {
        self.amplitude / (self.residual + 0.5)
    }

    /// Residual as a part of the height.
    fn misfit(&self) -> f64 {
        self.residual / self.amplitude
    }

    /// The dot, with a score from how well the profile fits.
    pub(super) fn dot(&self, params: &GaussianParams) -> Dot {
        let misfit = self.misfit() / params.max_residual;
        Dot {
            position: self.position,
            sigma_px: self.sigma_px,
            amplitude: self.amplitude,
            score: (1.0 - 0.5 * misfit).clamp(0.0, 1.0),
        }
    }
}

/// The pixels a dot is fitted to: offsets from the window's centre, and grey levels.
struct Window {
    samples: Vec<(f64, f64, f64)>,
    radius: f64,
    /// From this level up a pixel only says that it is at least so bright.
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

/// Fits the dot near `at`; `None` where there is none. A wide window measures best; where dots crowd
/// (slanted skin) only a narrow one sees a single dot.
pub(super) fn fit(
    image: &Gray,
    at: Vec2,
    sigma_px: f64,
    spacing_px: f64,
    params: &GaussianParams,
) -> Option<Fit> {
    let wide = (3.4 * sigma_px).min(0.48 * spacing_px).max(2.0);
    let narrow = (2.2 * sigma_px).min(0.8 * wide).max(2.0);
    let strict = 0.5 * params.max_residual;
    fit_window(image, at, sigma_px, wide, params)
        .or_else(|| fit_window(image, at, sigma_px, narrow, params).filter(|f| f.misfit() < strict))
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
    if measured < 14 || !(highest - lowest > 0.5 * params.min_amplitude) {
        return None;
    }
    let begin = Vec7::from([highest - lowest, start.x, start.y, 0.9 * sigma_px, lowest, 0.0, 0.0]);
    let (p, cost) = minimise(&window, begin)?;
    let [amplitude, x, y, sigma, ..]: [f64; 7] = p.into();
    let residual = (cost / window.samples.len() as f64).sqrt();
    let moved = Vec2::new(x, y) - start;
    let good = amplitude > params.min_amplitude
        && sigma > 0.35
        && sigma < window.radius
        && moved.norm() < 0.6 * radius
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
    let mut damping = 1e-3;
    for _ in 0..15 {
        let mut damped: Mat7 = normal;
        for i in 0..7 {
            damped[(i, i)] += damping * normal[(i, i)] + 1e-9;
        }
        let step = damped.cholesky()?.solve(&gradient);
        let mut trial = p + step;
        trial[3] = trial[3].clamp(0.3, 2.0 * window.radius);
        if !trial.iter().all(|v| v.is_finite()) || trial[1].hypot(trial[2]) > 2.0 * window.radius {
            damping *= 10.0;
            continue;
        }
        let (n, g, c) = equations(window, &trial);
        if c < cost {
            let small = step[1].hypot(step[2]) < 1e-3 && cost - c < 1e-4 * cost;
            (p, normal, gradient, cost) = (trial, n, g, c);
            damping = (damping * 0.2).max(1e-7);
            if small {
                break;
            }
        } else {
            damping *= 8.0;
            if damping > 1e6 {
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

/// Ratio of the axes of the dot's second moments, background taken off.
fn axis_ratio(window: &Window, p: &Vec7) -> f64 {
    let [a, x, y, s, b, gx, gy]: [f64; 7] = (*p).into();
    let (mut sum, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0);
    for &(qx, qy, level) in &window.samples {
        let (dx, dy) = (qx - x, qy - y);
        // The weight keeps noise at the rim out of the moments.
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
