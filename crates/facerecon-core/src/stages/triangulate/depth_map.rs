//! Grey depth maps of both photos (thesis Fig. 2.5).

use crate::camera::Rectification;
use crate::data::{Gray, Match};
use crate::math::{Vec2, percentile};
use crate::spatial::median_spacing;

/// Grey level of the furthest match; black means that nothing was measured.
const DARKEST: f64 = 40.0;
/// Percentiles of the disparities that the grey levels span: a few wrong matches do not change them.
const RANGE_PERCENTILES: [f64; 2] = [0.005, 0.995];
/// Interpolation radius around a match in median spacings: closes a gap of one missing match.
const RADIUS_SPACINGS: f64 = 1.5;
/// Maximum spacing that sets the radius, pixels: bounds the time for few scattered matches.
const MAX_SPACING_PX: f64 = 200.0;

/// Depth maps `[left, right]` in pixels of the original photos of `photo_size` (width, height),
/// grey levels 0 to 255: lighter is nearer, black is unknown. Around the matches (rectified pixels)
/// the grey is interpolated (modified Shepard) up to one and a half spacings from the nearest one.
pub fn depth_maps(
    matches: &[Match],
    rectification: &Rectification,
    photo_size: (usize, usize),
) -> [Gray; 2] {
    let disparities: Vec<f64> = matches.iter().map(Match::disparity).collect();
    let low = percentile(&disparities, RANGE_PERCENTILES[0]).unwrap_or(0.0);
    let high = percentile(&disparities, RANGE_PERCENTILES[1]).unwrap_or(0.0);
    let range = (high - low).max(1e-9);
    let greys: Vec<f64> = disparities
        .iter()
        .map(|d| DARKEST + (255.0 - DARKEST) * ((d - low) / range).clamp(0.0, 1.0))
        .collect();
    let left = matches.iter().map(|m| rectification.left.to_photo(m.left)).collect::<Vec<_>>();
    let right = matches.iter().map(|m| rectification.right.to_photo(m.right)).collect::<Vec<_>>();
    let map = |positions| interpolate(positions, &greys, photo_size);
    rayon::join(|| map(&left), || map(&right)).into()
}

/// Modified Shepard interpolation of grey levels at scattered positions.
fn interpolate(positions: &[Vec2], greys: &[f64], (width, height): (usize, usize)) -> Gray {
    let mut sums = vec![(0.0_f64, 0.0_f64); width * height];
    let radius =
        RADIUS_SPACINGS * median_spacing(positions).unwrap_or(1.0).clamp(1.0, MAX_SPACING_PX);
    for (p, grey) in positions.iter().zip(greys) {
        if !(p.x.is_finite() && p.y.is_finite()) {
            continue;
        }
        let first = |c: f64| (c - radius).ceil().max(0.0) as usize;
        let last =
            |c: f64, size: usize| ((c + radius).floor() + 1.0).clamp(0.0, size as f64) as usize;
        for y in first(p.y)..last(p.y, height) {
            for x in first(p.x)..last(p.x, width) {
                let distance = (Vec2::new(x as f64, y as f64) - p).norm();
                if distance < radius {
                    let weight = ((radius - distance) / (radius * distance.max(0.1))).powi(2);
                    let sum = &mut sums[y * width + x];
                    *sum = (sum.0 + weight * grey, sum.1 + weight);
                }
            }
        }
    }
    Gray::from_fn(width, height, |x, y| {
        let (sum, weight) = sums[y * width + x];
        if weight > 0.0 { (sum / weight) as f32 } else { 0.0 }
    })
}
