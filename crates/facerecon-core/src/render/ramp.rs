//! Colour ramps.

/// Heat maps: lightness rises all the way from deep blue to yellow, and red and green never
/// distinguish two values, so that the scale is readable in grey and with colour-blind eyes.
const HEAT: [[f64; 3]; 6] = [
    [32.0, 38.0, 110.0],
    [44.0, 86.0, 150.0],
    [78.0, 128.0, 150.0],
    [148.0, 160.0, 128.0],
    [220.0, 186.0, 84.0],
    [255.0, 231.0, 92.0],
];
/// Marks on photographs: from blue over light green to red, visible on dark and bright skin alike.
const MARKS: [[f64; 3]; 5] = [
    [49.0, 54.0, 149.0],
    [69.0, 159.0, 220.0],
    [120.0, 220.0, 130.0],
    [253.0, 190.0, 70.0],
    [215.0, 48.0, 39.0],
];
/// Colour of unknown values in heat maps.
const UNKNOWN: [u8; 3] = [150; 3];

/// Colour (sRGB) of a value between 0 and 1 in a heat map; grey for NaN, clipped beyond the ends.
pub fn heat_color(fraction: f64) -> [u8; 3] {
    if fraction.is_nan() { UNKNOWN } else { interpolated(&HEAT, fraction) }
}

/// Colour (sRGB) of a disparity in `low..=high` for marks on a photograph; clipped beyond the ends,
/// the first colour for NaN, the middle one for an empty range.
pub(crate) fn disparity_color(value: f64, low: f64, high: f64) -> [u8; 3] {
    let fraction = if high > low { (value - low) / (high - low) } else { 0.5 };
    interpolated(&MARKS, if fraction.is_nan() { 0.0 } else { fraction })
}

/// Linear interpolation between evenly spaced stops.
fn interpolated(stops: &[[f64; 3]], fraction: f64) -> [u8; 3] {
    let position = fraction.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let low = (position as usize).min(stops.len() - 2);
    let t = position - low as f64;
    [0, 1, 2].map(|i| (stops[low][i] * (1.0 - t) + stops[low + 1][i] * t).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lightness_rises_along_the_scale() {
        let luma = |f: f64| {
            let [r, g, b] = heat_color(f).map(f64::from);
            0.299 * r + 0.587 * g + 0.114 * b
        };
        for k in 0..50 {
            assert!(luma(f64::from(k + 1) / 50.0) > luma(f64::from(k) / 50.0));
        }
        assert_eq!(heat_color(f64::NAN), [150, 150, 150]);
        assert_eq!(heat_color(7.0), heat_color(1.0));
    }

    #[test]
    fn disparities_run_from_blue_to_red() {
        assert_eq!(disparity_color(0.0, 0.0, 1.0), [49, 54, 149]);
        assert_eq!(disparity_color(9.0, 0.0, 1.0), [215, 48, 39]);
        assert_eq!(disparity_color(1.0, 1.0, 1.0), [120, 220, 130]);
        assert_eq!(disparity_color(f64::NAN, 0.0, 1.0), [49, 54, 149]);
    }
}
