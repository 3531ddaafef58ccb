//! Stripes of random width and colour on a curved surface, photographed by two level cameras.

use super::*;
use crate::math::median;
use crate::observer::WarningCollector;

const SIZE: (usize, usize) = (420, 120);
const COLORS: [[f64; 3]; 7] = [
    [1.0, 1.0, 1.0],
    [1.0, 0.1, 0.1],
    [0.1, 1.0, 0.1],
    [0.2, 0.2, 1.0],
    [1.0, 1.0, 0.1],
    [1.0, 0.1, 1.0],
    [0.1, 1.0, 1.0],
];

fn random(i: usize) -> f64 {
    ((i as f64 * 12.9898 + 4.1).sin() * 43_758.545_3).rem_euclid(1.0)
}

/// Begin, end and colour of the stripes along the projected coordinate.
fn stripes() -> Vec<(f64, f64, [f64; 3])> {
    let mut at = -40.0;
    (0..40)
        .map(|i| {
            let begin = at + 5.0;
            at = begin + 5.0 + 8.0 * random(3 * i);
            (begin, at, COLORS[(7.0 * random(3 * i + 1)) as usize])
        })
        .collect()
}

/// Disparity of the surface at column `x`, row `y` midway between the photos.
fn disparity(x: f64, y: f64, wall: bool) -> f64 {
    let (u, v) = ((x - 210.0) / 110.0, (y - 60.0) / 90.0);
    let r2 = u * u + v * v;
    if wall && r2 > 1.0 { -40.0 } else { 24.0 * (1.0 - r2.min(1.5)).max(-0.5) }
}

/// One photo; `side` is 0.5 (left) or -0.5 (right) of the disparity.
fn photo(side: f64, wall: bool, noise: f64) -> Rgb {
    let stripes = stripes();
    let mut image = Rgb::filled(SIZE.0, SIZE.1, [0; 3]);
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            let mut sum = [0.0; 3];
            for sub in 0..4 {
                let seen = x as f64 + (f64::from(sub) - 1.5) / 4.0;
                // solves x + side * disparity(x) = seen for the position midway between the photos
                let mut middle = seen;
                for _ in 0..30 {
                    middle = seen - side * disparity(middle, y as f64, wall);
                }
                let lit = stripes.iter().find(|s| middle >= s.0 && middle < s.1);
                let color = lit.map_or([0.05; 3], |s| s.2);
                (0..3).for_each(|c| sum[c] += color[c] * 45.0);
            }
            let grain = |c: usize| {
                noise * (random(3 * (y * SIZE.0 + x) + c + 77 * (side > 0.0) as usize) - 0.5)
            };
            let pixel = [0, 1, 2].map(|c| (sum[c] + grain(c)).clamp(0.0, 255.0).round() as u8);
            image.set(x, y, pixel);
        }
    }
    image
}

/// Median and greatest error of the disparities, and how many matches there are.
fn errors(found: &Correspondence, wall: bool) -> (f64, f64, usize) {
    let errors: Vec<f64> = found
        .matches
        .iter()
        .map(|m| {
            let middle = (m.left.x + m.right.x) / 2.0;
            (m.disparity() - disparity(middle, m.left.y, wall)).abs()
        })
        .collect();
    (median(&errors).unwrap(), errors.iter().copied().fold(0.0, f64::max), errors.len())
}

#[test]
fn stripes_on_a_curved_surface_are_matched_to_a_tenth_of_a_pixel() {
    for (noise, exact) in [(2.0, 0.06), (40.0, 0.15)] {
        let images = [photo(0.5, false, noise), photo(-0.5, false, noise)];
        let params = StripesParams::default();
        let found = correspond_stripes([&images[0], &images[1]], None, &params, &()).unwrap();
        let (middle, worst, count) = errors(&found, false);
        // 40 rows with about 60 edges each
        assert!(count > 1500, "noise {noise}: {count}");
        assert!(middle < exact && worst < 1.5, "noise {noise}: {middle} {worst}");
    }
}

#[test]
fn stripes_on_a_wall_behind_the_surface_are_left_out() {
    let images = [photo(0.5, true, 4.0), photo(-0.5, true, 4.0)];
    let warnings = WarningCollector::new(&());
    let params = StripesParams::default();
    let found = correspond_stripes([&images[0], &images[1]], None, &params, &warnings).unwrap();
    assert!(found.matches.iter().all(|m| m.disparity() > -15.0));
    let (middle, _, count) = errors(&found, true);
    assert!(count > 600 && middle < 0.1, "{count} {middle}");
    let warnings = warnings.into_warnings();
    assert!(warnings.len() == 1 && warnings[0].contains("wall"), "{warnings:?}");
}

#[test]
fn photos_without_stripes_are_refused() {
    for size in [(0, 0), (3, 2), (64, 48)] {
        let flat = Rgb::filled(size.0, size.1, [90; 3]);
        let error = correspond_stripes([&flat, &flat], None, &StripesParams::default(), &());
        assert!(matches!(error, Err(CorrespondError::TooFewMatches { got: 0, .. })), "{error:?}");
    }
}
