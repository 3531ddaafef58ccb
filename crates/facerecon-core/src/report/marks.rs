//! Marks on photographs: dots found, matches coloured by disparity.

use crate::data::{Gray, Rgb};
use crate::math::Vec2;

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
    fn the_ramp_runs_from_blue_to_red() {
        assert_eq!(ramp(0.0, 0.0, 1.0), [49, 54, 149]);
        assert_eq!(ramp(9.0, 0.0, 1.0), [215, 48, 39]);
        assert_eq!(ramp(1.0, 1.0, 1.0), [120, 220, 130]);
    }
}
