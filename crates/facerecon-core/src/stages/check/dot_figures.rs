//! Figures of the dots of one photo.

use super::input::PhotoDots;
use crate::data::Gray;
use crate::math::{Vec2, median, percentile};

/// The brightest dots have at least this fraction of the height that nine tenths of the dots do not
/// exceed. Set by hand: separates the subject from a wall that the projector lights as well.
const BRIGHT_FRACTION: f64 = 0.6;
/// Percentiles that bound the brightest dots: a few bright specks elsewhere do not count.
const BOUND_PERCENTILES: [f64; 2] = [0.01, 0.99];
/// Width of the ring around a dot that gives its base level, in spacings; at least one pixel.
const RING: f64 = 0.13;
/// Percentile of the grey levels around a dot that counts as its peak, robust to single hot pixels.
const PEAK_PERCENTILE: f64 = 0.98;
/// Minimum height of a dot above its base level to be measured, grey levels.
const MIN_HEIGHT: f64 = 1.0;
/// Radius at half the height of a Gaussian over its standard deviation, sqrt(2 ln 2).
const HALF_RADIUS_PER_SIGMA: f64 = 1.177;

/// Figures of the brighter half of the dots, which is the subject rather than a wall behind it.
pub(super) struct DotFigures {
    /// Median height of a dot above its surroundings, grey levels.
    pub contrast: f64,
    /// Median radius at which a dot falls to half its height, in spacings.
    pub half_radius: f64,
    /// Upper left corner of the brightest dots, pixels.
    pub bright_low: Vec2,
    /// Lower right corner of the brightest dots, pixels.
    pub bright_high: Vec2,
    /// Median column of the brightest dots, pixels.
    pub bright_middle: f64,
}

/// One dot in its photo.
struct Profile {
    position: Vec2,
    height: f64,
    half_radius_px: f64,
}

impl DotFigures {
    /// `None` when no dot can be measured.
    pub(super) fn measure(image: &Gray, found: &PhotoDots<'_>) -> Option<Self> {
        let spacing = found.spacing_px;
        let dots: Vec<Profile> =
            found.dots.iter().filter_map(|dot| profile(image, dot.position, spacing)).collect();
        let heights: Vec<f64> = dots.iter().map(|d| d.height).collect();
        let middle = median(&heights)?;
        let bright: Vec<_> = dots.iter().filter(|d| d.height >= middle).collect();
        let median_of =
            |f: fn(&Profile) -> f64| median(&bright.iter().map(|d| f(d)).collect::<Vec<_>>());
        let brightest_from = BRIGHT_FRACTION * percentile(&heights, 0.9)?;
        let brightest = dots.iter().filter(|d| d.height >= brightest_from);
        let (x, y): (Vec<f64>, Vec<f64>) = brightest.map(|d| (d.position.x, d.position.y)).unzip();
        let corner = |q| Some(Vec2::new(percentile(&x, q)?, percentile(&y, q)?));
        Some(Self {
            contrast: median_of(|d| d.height)?,
            half_radius: median_of(|d| d.half_radius_px)? / spacing,
            bright_low: corner(BOUND_PERCENTILES[0])?,
            bright_high: corner(BOUND_PERCENTILES[1])?,
            bright_middle: median(&x)?,
        })
    }
}

/// Height of a dot over the ring half a spacing around it, and the radius of its half height from
/// the sum of its grey levels: a Gaussian of height h and deviation s sums to 2 pi s^2 h. `None`
/// at the border and where there is no dot.
fn profile(image: &Gray, centre: Vec2, spacing: f64) -> Option<Profile> {
    let radius = (spacing / 2.0).max(1.5);
    let reach = radius.ceil() as isize;
    let (cx, cy) = (centre.x.round() as isize, centre.y.round() as isize);
    let ring_width = (RING * spacing).max(1.0);
    let (mut ring, mut inside) = (Vec::new(), Vec::new());
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let value = f64::from(image.get(cx + dx, cy + dy)?);
            let distance = (Vec2::new((cx + dx) as f64, (cy + dy) as f64) - centre).norm();
            if distance < radius {
                inside.push(value);
                if distance > radius - ring_width {
                    ring.push(value);
                }
            }
        }
    }
    let base = median(&ring)?;
    let peak = percentile(&inside, PEAK_PERCENTILE)?;
    let height = peak - base;
    if !(height > MIN_HEIGHT) {
        return None;
    }
    let sum: f64 = inside.iter().map(|v| (v - base).max(0.0)).sum();
    let sigma = (sum / (std::f64::consts::TAU * height)).sqrt();
    Some(Profile { position: centre, height, half_radius_px: sigma * HALF_RADIUS_PER_SIGMA })
}
