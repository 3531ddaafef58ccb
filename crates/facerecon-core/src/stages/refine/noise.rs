//! Noise of the residuals by brightness.

use crate::data::Gray;

/// Classes of brightness in which noise is measured.
const CLASSES: usize = 8;
/// Smallest noise, grey levels: the quantisation of 8 bit photos (1 / sqrt(12)).
const MIN_NOISE: f32 = 0.3;
/// Noise where nothing was measured, grey levels.
const DEFAULT_NOISE: f32 = 1.0;
/// A class with fewer residuals takes the noise of the next one.
const MIN_RESIDUALS: u32 = 200;
/// Steps of the histogram that the median is read from.
const STEPS: usize = 512;
/// Width of a step, grey levels: less than half of [`MIN_NOISE`].
const STEP: f32 = 0.125;
/// Standard deviation of normal data over its median absolute value.
const SIGMA_OF_MEDIAN: f32 = 1.4826;

/// Standard deviation of the residuals in every class of brightness, grey levels. Shot noise,
/// interpolation error and what the model leaves out all grow with brightness.
pub(super) struct Noise([f32; CLASSES]);

impl Noise {
    /// Measures the noise by the median absolute residual of every class; NaN are ignored.
    pub(super) fn of(residual: &Gray, brightness: &Gray) -> Self {
        let mut counts = vec![[0u32; STEPS]; CLASSES];
        let pixels = residual.data().iter().zip(brightness.data());
        for (r, v) in pixels.filter(|(r, _)| r.is_finite()) {
            counts[class(*v).0][((r.abs() / STEP) as usize).min(STEPS - 1)] += 1;
        }
        let known: Vec<Option<f32>> = counts.iter().map(sigma_of).collect();
        Self(std::array::from_fn(|k| {
            let below = known[..=k].iter().rev().flatten().next();
            let above = known[k..].iter().flatten().next();
            below.or(above).copied().unwrap_or(DEFAULT_NOISE)
        }))
    }

    /// Noise at a brightness, linear between the centres of the classes.
    pub(super) fn at(&self, brightness: f32) -> f32 {
        let noise = &self.0;
        let (k, t) = class(brightness);
        let (other, share) = if t < 0.5 {
            (k.saturating_sub(1), 0.5 - t)
        } else {
            ((k + 1).min(CLASSES - 1), t - 0.5)
        };
        noise[k] + (noise[other] - noise[k]) * share
    }
}

/// Standard deviation of the residuals in a histogram; `None` for too few.
fn sigma_of(counts: &[u32; STEPS]) -> Option<f32> {
    let total: u32 = counts.iter().sum();
    let mut seen = 0;
    let middle = counts.iter().position(|c| {
        seen += c;
        2 * seen >= total
    });
    (total >= MIN_RESIDUALS).then(|| {
        let median = middle.map_or(0.0, |i| (i as f32 + 0.5) * STEP);
        (SIGMA_OF_MEDIAN * median).max(MIN_NOISE)
    })
}

/// Class of a brightness, and the position in it (0 to 1).
fn class(brightness: f32) -> (usize, f32) {
    let t = brightness.clamp(0.0, 255.0) * CLASSES as f32 / 256.0;
    (t as usize, t - t.floor())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_measured_by_brightness_and_filled_in() {
        // residuals of 2 grey levels in the dark half, 6 in the bright one; NaN in between
        let brightness = Gray::from_fn(100, 10, |x, _| if x < 50 { 40.0 } else { 200.0 });
        let residual = Gray::from_fn(100, 10, |x, y| match x {
            0..50 if y % 2 == 0 => 2.0,
            0..50 => -2.0,
            50..60 => f32::NAN,
            _ => 6.0,
        });
        let noise = Noise::of(&residual, &brightness);
        assert!((noise.at(48.0) - 2.0 * SIGMA_OF_MEDIAN).abs() < 0.1, "{}", noise.at(48.0));
        assert!((noise.at(208.0) - 6.0 * SIGMA_OF_MEDIAN).abs() < 0.1, "{}", noise.at(208.0));
        // classes without residuals take the next darker one, else the next brighter one
        assert_eq!(noise.at(0.0), noise.at(48.0));
        assert_eq!(noise.at(112.0), noise.at(48.0));
        assert_eq!(Noise::of(&residual.map(|_| f32::NAN), &brightness).at(10.0), DEFAULT_NOISE);
    }
}
