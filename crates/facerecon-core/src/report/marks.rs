//! Marks on photographs: dots found, matches coloured by disparity; the texture's coverage.

use crate::data::{Gray, Raster, Rgb};
use crate::math::Vec2;
use crate::stages::texture::{FILLED, SEEN_EXTRA, SEEN_LEFT, SEEN_RIGHT};

/// A grey image as colour.
pub fn colored(gray: &Gray) -> Rgb {
    gray.to_u8().map(|v| [v, v, v])
}

/// Draws a small open cross at each position (pixels); what lies outside is left out.
pub fn crosses(image: &mut Rgb, positions: impl IntoIterator<Item = (Vec2, [u8; 3])>) {
    const ARM: isize = 3;
    for (p, color) in positions {
        if !(p.x.is_finite() && p.y.is_finite()) {
            continue;
        }
        let (x, y) = (p.x.round() as isize, p.y.round() as isize);
        for step in 1..=ARM {
            for (dx, dy) in [(step, 0), (-step, 0), (0, step), (0, -step)] {
                let (u, v) = (x.saturating_add(dx), y.saturating_add(dy));
                if image.get(u, v).is_some() {
                    image.set(u as usize, v as usize, color);
                }
            }
        }
    }
}

/// The coverage of a texture as colours: red where the left photo saw it, green the right one
/// (yellow both), blue a further one; dark grey where it was filled.
pub fn coverage(seen: &Raster<u8>) -> Rgb {
    seen.map(|bits| {
        if bits & FILLED != 0 {
            return [48, 48, 48];
        }
        let level = |photo: u8| if bits & photo != 0 { 220 } else { 40 };
        [level(SEEN_LEFT), level(SEEN_RIGHT), level(SEEN_EXTRA)]
    })
}

/// A colour from blue over white-ish green to red for a value in `low..=high`, readable on dark and
/// bright skin alike.
pub fn ramp(value: f64, low: f64, high: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] = [
        [49.0, 54.0, 149.0],
        [69.0, 159.0, 220.0],
        [120.0, 220.0, 130.0],
        [253.0, 190.0, 70.0],
        [215.0, 48.0, 39.0],
    ];
    let t = if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
    let position = if t.is_nan() { 0.0 } else { t * 4.0 };
    let k = (position as usize).min(3);
    let f = position - k as f64;
    std::array::from_fn(|c| (STOPS[k][c] * (1.0 - f) + STOPS[k + 1][c] * f).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stay_on_the_picture() {
        let mut image = Rgb::filled(8, 8, [0, 0, 0]);
        let red = [255, 0, 0];
        let far = Vec2::new(1e30, -1e30);
        crosses(
            &mut image,
            [(Vec2::new(0.0, 0.0), red), (far, red), (Vec2::repeat(f64::NAN), red)],
        );
        assert_eq!(image.at(2, 0), red);
        assert_eq!(image.data().iter().filter(|p| **p == red).count(), 6);
    }

    #[test]
    fn coverage_tells_the_photos_apart() {
        let seen = Raster::from_vec(3, 1, vec![SEEN_LEFT | SEEN_RIGHT, SEEN_EXTRA, FILLED]);
        let colors = coverage(&seen.unwrap());
        assert_eq!(colors.data(), [[220, 220, 40], [40, 40, 220], [48, 48, 48]]);
    }

    #[test]
    fn the_ramp_runs_from_blue_to_red() {
        assert_eq!(ramp(0.0, 0.0, 1.0), [49, 54, 149]);
        assert_eq!(ramp(9.0, 0.0, 1.0), [215, 48, 39]);
        assert_eq!(ramp(1.0, 1.0, 1.0), [120, 220, 130]);
    }
}
