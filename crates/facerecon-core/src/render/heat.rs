//! The colours of heat maps and their legend.

use super::font::{GLYPH_HEIGHT, draw_text, text_width};
use crate::data::Rgb;
use crate::math::percentile;

/// Values to show on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heat<'a> {
    /// One value a vertex, at least 0; NaN where unknown (drawn grey).
    pub values: &'a [f64],
    /// Value at the end of the scale; by default the 95th percentile, rounded up to a plain number.
    pub limit: Option<f64>,
    /// Unit, written at the legend.
    pub unit: &'a str,
}

impl Heat<'_> {
    /// Value at the end of the scale.
    pub fn limit(&self) -> f64 {
        let limit = self.limit.or_else(|| percentile(self.values, 0.95)).unwrap_or(1.0);
        let limit = if self.limit.is_some() { limit } else { nice_ceiling(limit) };
        if limit > 0.0 && limit.is_finite() { limit } else { 1.0 }
    }
}

/// The least of 1, 2, 2.5, 5 times a power of ten that is not below a value.
pub fn nice_ceiling(value: f64) -> f64 {
    if !(value > 0.0) || !value.is_finite() {
        return 1.0;
    }
    let power = 10f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0];
    steps.iter().map(|s| s * power).find(|s| *s >= value * (1.0 - 1e-12)).unwrap_or(10.0 * power)
}

/// Stops of the scale: lightness rises all the way from deep blue to yellow and red and green
/// never stand against each other, so that it reads in grey and with colour-blind eyes.
const STOPS: [[f64; 3]; 6] = [
    [32.0, 38.0, 110.0],
    [44.0, 86.0, 150.0],
    [78.0, 128.0, 150.0],
    [148.0, 160.0, 128.0],
    [220.0, 186.0, 84.0],
    [255.0, 231.0, 92.0],
];

/// Colour (sRGB) of a value between 0 and 1; grey for NaN, clipped beyond the ends.
pub fn heat_color(fraction: f64) -> [u8; 3] {
    if fraction.is_nan() {
        return [150, 150, 150];
    }
    let position = fraction.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let low = (position as usize).min(STOPS.len() - 2);
    let t = position - low as f64;
    [0, 1, 2].map(|i| (STOPS[low][i] * (1.0 - t) + STOPS[low + 1][i] * t).round() as u8)
}

/// Draws the scale with its numbers into the lower part of a picture.
pub(super) fn draw_legend(image: &mut Rgb, limit: f64, unit: &str) {
    let (width, height) = image.size();
    let zoom = (width / 320).clamp(1, 4);
    let bar_width = (width * 3 / 5).max(1);
    let bar_height = 6 * zoom;
    let below = (GLYPH_HEIGHT + 5) * zoom;
    if height < bar_height + below + 4 || width < 60 {
        return; // no room
    }
    let (left, top) = ((width - bar_width) / 2, height - bar_height - below);
    for y in 0..bar_height {
        for x in 0..bar_width {
            let color = heat_color(x as f64 / (bar_width.max(2) - 1) as f64);
            image.set(left + x, top + y, color);
        }
    }
    for (fraction, last) in [(0.0, false), (0.25, false), (0.5, false), (0.75, false), (1.0, true)]
    {
        let mut text = plain_number(limit * fraction);
        if last {
            text = format!("{text} {unit}");
        }
        let x = left + (fraction * (bar_width - 1) as f64).round() as usize;
        for y in top + bar_height..(top + bar_height + 2 * zoom).min(height) {
            image.set(x, y, [60, 60, 60]);
        }
        // the unit hangs to the right, so that the number stays under its tick
        let shown = text_width(if last { text.trim_end_matches(unit).trim_end() } else { &text });
        let start = x.saturating_sub(shown * zoom / 2);
        draw_text(image, start, top + bar_height + 3 * zoom, &text, zoom, [40, 40, 40]);
    }
}

fn plain_number(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
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
    fn limits_are_plain_numbers() {
        for (value, wanted) in [(0.0013, 0.002), (0.23, 0.25), (1.0, 1.0), (3.1, 5.0), (7.0, 10.0)]
        {
            assert!((nice_ceiling(value) - wanted).abs() < 1e-12, "{value}");
        }
        assert_eq!(nice_ceiling(f64::NAN), 1.0);
        assert_eq!(plain_number(2.50), "2.5");
    }
}
