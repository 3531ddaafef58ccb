//! Sub-pixel dots: blobs of the dots' size, each fitted by a Gaussian on a plane.
//!
//! Size and spacing of the dots are measured in the image: of a stack of difference-of-Gaussian
//! levels (Lowe 2004) the one is used in which most blobs are nodes of a lattice. The fit makes the
//! centre independent of shading and of saturated pixels.

mod fit;
mod scale;

use rayon::prelude::*;

use crate::data::{Dot, Gray};
use crate::math::{Vec2, median};
use crate::settings::settings;
use crate::spatial::PointIndex;

use fit::Fit;
use scale::Scale;

settings! {
    /// Sub-pixel detection by fitting a Gaussian on a plane (method "gaussian").
    pub struct GaussianParams {
        /// Minimum height of a dot above its surroundings.
        min_amplitude: f64 = 3.0, range 0.1..=255.0, unit "grey levels";
        /// Minimum response of a dot as a multiple of the mean response around it.
        contrast: f64 = 1.2, range 0.0..=10.0;
        /// Grey level from which on pixels are saturated: the fitted profile may be higher there.
        saturation: f64 = 253.5, range 1.0..=65535.0, unit "grey levels";
        /// Maximum residual of the fit (root mean square) as a fraction of the dot's height.
        max_residual: f64 = 0.35, range 0.01..=10.0;
        /// Maximum ratio of a dot's long axis to its short one.
        max_axis_ratio: f64 = 2.5, range 1.0..=20.0;
        /// Dots smaller or larger than the median size by more than this factor are dropped.
        size_factor: f64 = 2.1, range 1.0..=10.0;
        /// Spacing of the dots; 0 measures it in the image.
        spacing_px: f64 = 0.0, range 0.0..=1000.0, unit "px";
    }
}

/// Rounds of the fit; the second one only when the windows of the first have the wrong size.
const ROUNDS: usize = 2;
/// Logarithm of the ratio of fitted to expected dot size from which on windows have the wrong size:
/// the levels of the stack are a factor of 1.35 apart. Set by hand.
const WRONG_SIZE: f64 = 0.12;
/// Two fits closer than this, in spacings or in standard deviations of the dots, whichever is
/// larger, are one dot. Set by hand.
const APART_SPACINGS: f64 = 0.3;
const APART_SIGMAS: f64 = 1.2;
/// Number of nearest fits compared with one, itself included.
const NEAREST: usize = 6;

/// The dots of a photo, sorted by row, then column, and the spacing of their lattice in pixels
/// (`params.spacing_px` when no lattice is found).
///
/// Some false dots are expected (hair, teeth, reflections): correspond rejects them by the lattice.
pub(super) fn gaussian(image: &Gray, params: &GaussianParams) -> (Vec<Dot>, f64) {
    let Some(scale) = Scale::find(image, params) else {
        return (Vec::new(), params.spacing_px);
    };
    let mut sigma_px = scale.sigma_px;
    let mut fits = Vec::new();
    for _ in 0..ROUNDS {
        let found: Vec<Option<Fit>> = scale
            .candidates
            .par_iter()
            .map(|p| fit::fit(image, *p, sigma_px, scale.spacing_px, params))
            .collect();
        fits = found.into_iter().flatten().collect();
        let sigmas: Vec<f64> = fits.iter().map(|f| f.sigma_px).collect();
        match median(&sigmas) {
            Some(typical) if (typical / sigma_px).ln().abs() > WRONG_SIZE => sigma_px = typical,
            _ => break,
        }
    }
    let dots = select(fits, scale.spacing_px, params);
    (dots, scale.spacing_px)
}

/// Drops fits of unusual size or shape, and the worse of two fits at one position.
fn select(mut fits: Vec<Fit>, spacing_px: f64, params: &GaussianParams) -> Vec<Dot> {
    let sigmas: Vec<f64> = fits.iter().map(|f| f.sigma_px).collect();
    let Some(typical) = median(&sigmas) else {
        return Vec::new();
    };
    fits.retain(|f| {
        f.sigma_px < typical * params.size_factor
            && f.sigma_px > typical / params.size_factor
            && f.axis_ratio < params.max_axis_ratio
    });
    fits.sort_by(|a, b| {
        b.quality()
            .total_cmp(&a.quality())
            .then(a.position.y.total_cmp(&b.position.y))
            .then(a.position.x.total_cmp(&b.position.x))
    });
    let positions: Vec<Vec2> = fits.iter().map(|f| f.position).collect();
    let Some(index) = PointIndex::<2>::new(&positions) else {
        return Vec::new();
    };
    // Fits are sorted by quality, so the first of a group is kept.
    let apart = (APART_SPACINGS * spacing_px).max(APART_SIGMAS * typical);
    let mut dropped = vec![false; fits.len()];
    let mut dots = Vec::with_capacity(fits.len());
    for (i, f) in fits.iter().enumerate() {
        if dropped[i] {
            continue;
        }
        for n in index.nearest_n(&[f.position.x, f.position.y], NEAREST) {
            if n.index > i && n.distance < apart {
                dropped[n.index] = true;
            }
        }
        dots.push(f.dot(params));
    }
    dots.sort_by(|a, b| {
        a.position.y.total_cmp(&b.position.y).then(a.position.x.total_cmp(&b.position.x))
    });
    dots
}

#[cfg(test)]
mod tests;
