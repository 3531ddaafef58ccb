//! Figures of one photo.

use crate::data::Gray;
use crate::math::{Vec2, median, percentile};
use crate::stages::detect::Detection;

/// Grey level of the lit parts: the 90th percentile, every third pixel.
pub(super) fn lit_level(image: &Gray) -> f64 {
    let some: Vec<f64> = image.data().iter().step_by(3).map(|v| f64::from(*v)).collect();
    percentile(&some, 0.9).unwrap_or(0.0)
}

/// Share of pixels at or above 253.
pub(super) fn saturated_share(image: &Gray) -> f64 {
    let count = image.data().iter().filter(|v| **v >= 253.0).count();
    count as f64 / image.data().len().max(1) as f64
}

/// Figures of the brighter half of the dots, which is the subject rather than a wall behind it.
pub(super) struct DotFigures {
    /// Median height of a dot above its surroundings, grey levels.
    pub contrast: f64,
    /// Median radius at which a dot has fallen to half its height, in spacings.
    pub half_radius: f64,
    /// Upper left corner of the brightest dots (over six tenths of the 90th percentile), pixels.
    pub bright_low: Vec2,
    /// Lower right corner.
    pub bright_high: Vec2,
    /// Middle column of the bright dots, pixels.
    pub bright_middle: f64,
}

impl DotFigures {
    pub(super) fn measure(image: &Gray, found: &Detection) -> Option<Self> {
        let spacing = found.spacing_px;
        let dots: Vec<(Vec2, f64, f64)> = found
            .dots
            .iter()
            .filter_map(|dot| {
                let (height, radius) = profile(image, dot.position, spacing)?;
                Some((dot.position, height, radius))
            })
            .collect();
        let heights: Vec<f64> = dots.iter().map(|d| d.1).collect();
        let middle = median(&heights)?;
        let bright: Vec<_> = dots.iter().filter(|d| d.1 >= middle).collect();
        let column =
            |f: fn(&(Vec2, f64, f64)) -> f64| bright.iter().map(|d| f(d)).collect::<Vec<_>>();
        let most = 0.6 * percentile(&heights, 0.9)?;
        let brightest = dots.iter().filter(|d| d.1 >= most);
        let (x, y): (Vec<f64>, Vec<f64>) = brightest.map(|d| (d.0.x, d.0.y)).unzip();
        // a few bright specks elsewhere do not count
        let corner = |q| Some(Vec2::new(percentile(&x, q)?, percentile(&y, q)?));
        Some(Self {
            contrast: median(&column(|d| d.1))?,
            half_radius: median(&column(|d| d.2))? / spacing,
            bright_low: corner(0.01)?,
            bright_high: corner(0.99)?,
            bright_middle: median(&x)?,
        })
    }
}

/// Height of a dot over the ring half a spacing around it, and the radius of its half height from
/// the light it holds: a Gaussian of height h and deviation s holds 2 pi s^2 h.
fn profile(image: &Gray, centre: Vec2, spacing: f64) -> Option<(f64, f64)> {
    let radius = (spacing / 2.0).max(1.5);
    let reach = radius.ceil() as isize;
    let (cx, cy) = (centre.x.round() as isize, centre.y.round() as isize);
    let (mut ring, mut inside) = (Vec::new(), Vec::new());
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let value = f64::from(image.get(cx + dx, cy + dy)?);
            let distance = (Vec2::new((cx + dx) as f64, (cy + dy) as f64) - centre).norm();
            if distance < radius {
                inside.push(value);
                if distance > radius - 1.2 {
                    ring.push(value);
                }
            }
        }
    }
    let base = median(&ring)?;
    let peak = percentile(&inside, 0.98)?;
    let height = peak - base;
    let light: f64 = inside.iter().map(|v| (v - base).max(0.0)).sum();
    (height > 1.0).then(|| (height, (light / (std::f64::consts::TAU * height)).sqrt() * 1.177))
}
