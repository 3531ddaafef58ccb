//! Heat maps: their scale and legend.

use super::font::{GLYPH_HEIGHT, draw_text, text_width};
use super::ramp::heat_color;
use crate::data::Rgb;
use crate::math::percentile;

/// Values to show on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heat<'a> {
    /// One value per vertex, at least 0; NaN where unknown (drawn grey).
    pub values: &'a [f64],
    /// Value at the end of the scale; by default the 95th percentile, rounded up by
    /// [`nice_ceiling`].
    pub limit: Option<f64>,
    /// Unit, written beside the legend.
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

/// The least of 1, 2, 2.5 or 5 times a power of ten that is not below a value; 1 for values that
/// are not positive.
pub fn nice_ceiling(value: f64) -> f64 {
    if !(value > 0.0) || !value.is_finite() {
        return 1.0;
    }
    let power = 10f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0];
    steps.iter().map(|s| s * power).find(|s| *s >= value * (1.0 - 1e-12)).unwrap_or(10.0 * power)
}

/// Draws the scale with its numbers into the lower part of a picture, where it fits.
pub(super) fn draw_legend(image: &mut Rgb, limit: f64, unit: &str) {
    let (width, height) = image.size();
    let zoom = (width / 320).clamp(1, 4);
    let bar_width = (width * 3 / 5).max(1);
    let bar_height = 6 * zoom;
    let below = (GLYPH_HEIGHT + 5) * zoom;
    if height < bar_height + below + 4 || width < 60 {
        return; // it does not fit
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
        // the number is centred below its tick, the unit follows
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
    fn limits_are_plain_numbers() {
        for (value, expected) in
            [(0.0013, 0.002), (0.23, 0.25), (1.0, 1.0), (3.1, 5.0), (7.0, 10.0)]
        {
            assert!((nice_ceiling(value) - expected).abs() < 1e-12, "{value}");
        }
        assert_eq!(nice_ceiling(f64::NAN), 1.0);
        assert_eq!(plain_number(2.50), "2.5");
    }
}
