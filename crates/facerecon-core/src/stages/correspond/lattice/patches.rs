//! The surroundings of the dots in the plain pair.

use rayon::prelude::*;

use crate::data::{Dot, Gray};
use crate::math::Vec2;

/// Samples along each side of a patch.
const SIDE: usize = 6;
/// Length of a patch's side, in spacings: reaches to the next dots, so that patches of neighbours
/// differ.
const EXTENT: f64 = 1.2;
/// Blur of the photos before sampling, in spacings (standard deviation): about the distance of the
/// samples.
const BLUR: f64 = 0.22;
/// Displacements along the row at which a right patch is sampled, in spacings: the subject may have
/// moved between dotted and plain pair.
const DISPLACEMENTS: [f64; 3] = [-0.22, 0.0, 0.22];
/// Least contrast of a patch (standard deviation), grey levels; below it there is only noise.
const MIN_CONTRAST: f32 = 0.2;
/// Contrast beyond which a patch has no more weight, grey levels.
const MAX_CONTRAST: f64 = 8.0;

/// Samples of zero mean and unit length.
type Samples = [f32; SIDE * SIDE];

/// Samples around a point, and their contrast.
struct Patch {
    samples: Samples,
    /// Standard deviation before scaling, grey levels.
    contrast: f64,
}

/// The surroundings of every dot in the plain pair, at half size.
pub(super) struct PlainPatches {
    left: Vec<Option<Patch>>,
    /// One for each of [`DISPLACEMENTS`].
    right: Vec<[Option<Patch>; 3]>,
}

impl PlainPatches {
    /// Samples the rectified plain pair around the dots.
    pub(super) fn new(images: [&Gray; 2], dots: [&[Dot]; 2], spacing_px: f64) -> Self {
        let half_spacing = spacing_px / 2.0;
        let [left, right] = images.map(|i| i.halved().blurred(BLUR * half_spacing));
        let step = half_spacing / SIDE as f64 * EXTENT;
        let at_half_size = |dot: &Dot| (dot.position - Vec2::new(0.5, 0.5)) / 2.0;
        let displaced = |dot: &Dot| {
            DISPLACEMENTS
                .map(|d| patch(&right, at_half_size(dot) + Vec2::new(d * half_spacing, 0.0), step))
        };
        Self {
            left: dots[0].par_iter().map(|d| patch(&left, at_half_size(d), step)).collect(),
            right: dots[1].par_iter().map(displaced).collect(),
        }
    }

    /// Correlation of the surroundings of two dots (zero-mean normalised cross-correlation, the best
    /// of the displacements), and its weight: the contrast. `None` at the border of the photo and
    /// where there is no contrast.
    pub(super) fn correlation(&self, left: usize, right: usize) -> Option<(f64, f64)> {
        let a = self.left[left].as_ref()?;
        let product = |b: &Patch| a.samples.iter().zip(&b.samples).map(|(p, q)| p * q).sum::<f32>();
        let best = self.right[right]
            .iter()
            .flatten()
            .map(|b| f64::from(product(b)))
            .max_by(f64::total_cmp)?;
        Some((best, a.contrast.min(MAX_CONTRAST)))
    }
}

/// Samples an image around a point, `step` pixels apart.
fn patch(image: &Gray, at: Vec2, step: f64) -> Option<Patch> {
    let mut samples = [0.0; SIDE * SIDE];
    for (k, s) in samples.iter_mut().enumerate() {
        let offset = |i: usize| (i as f64 - (SIDE - 1) as f64 / 2.0) * step;
        *s = image.bilinear(at.x + offset(k % SIDE), at.y + offset(k / SIDE))?;
    }
    let n = samples.len() as f32;
    let mean = samples.iter().sum::<f32>() / n;
    samples.iter_mut().for_each(|v| *v -= mean);
    let norm = samples.iter().map(|v| v * v).sum::<f32>().sqrt();
    (norm > MIN_CONTRAST * n.sqrt()).then(|| {
        samples.iter_mut().for_each(|v| *v /= norm);
        Patch { samples, contrast: f64::from(norm / n.sqrt()) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_surroundings_correlate_and_flat_ones_are_left_out() {
        let wave = |x: f64, y: f64| (90.0 + 40.0 * (0.31 * x).sin() * (0.23 * y).cos()) as f32;
        let textured = Gray::from_fn(120, 80, |x, y| wave(x as f64, y as f64));
        let moved = Gray::from_fn(120, 80, |x, y| wave(x as f64 + 20.0, y as f64));
        let dot = |x: f64| {
            [Dot { position: Vec2::new(x, 40.0), sigma_px: 1.5, amplitude: 50.0, score: 1.0 }]
        };
        let correlation = |right: &Gray, x: f64| {
            let dots: [&[Dot]; 2] = [&dot(70.0), &dot(x)];
            PlainPatches::new([&textured, right], dots, 10.0).correlation(0, 0)
        };
        assert!(correlation(&moved, 50.0).unwrap().0 > 0.99);
        assert!(correlation(&moved, 60.0).unwrap().0 < 0.5);
        assert_eq!(correlation(&Gray::filled(120, 80, 90.0), 50.0), None);
        assert_eq!(correlation(&moved, 1.0), None, "at the border");
    }
}
