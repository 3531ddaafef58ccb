//! Sub-pixel dots: blobs of the image's own dot size, each fitted by a Gaussian on a plane.
//!
//! The scale of the dots and their spacing are read from the image: of a stack of difference-of-
//! Gaussian levels (Lowe 2004) the one counts in which most blobs sit in a lattice. The fit of the
//! profile makes the centre independent of shading ramps and of saturated pixels.

mod fit;
mod scale;

use rayon::prelude::*;

use crate::data::{Dot, Gray};
use crate::math::{Vec2, median};
use crate::settings;
use crate::spatial::PointIndex;

use fit::Fit;
use scale::Scale;

settings! {
    /// Sub-pixel detection by fitting a Gaussian on a plane (method "gaussian").
    pub struct GaussianParams {
        /// Least height of a dot above its surroundings.
        min_amplitude: f64 = 3.0, range 0.1..=255.0, unit "grey levels";
        /// Least response of a dot as a multiple of the mean response around it.
        contrast: f64 = 1.2, range 0.0..=10.0;
        /// Pixels from this level up are saturated: the fit may pass above them.
        saturation: f64 = 253.5, range 1.0..=65535.0, unit "grey levels";
        /// Largest residual of the fit (root mean square) as a part of the dot's height.
        max_residual: f64 = 0.35, range 0.01..=10.0;
        /// Largest ratio of a dot's long axis to its short one.
        max_axis_ratio: f64 = 2.5, range 1.0..=20.0;
        /// Dots smaller or larger than the median by more than this factor are dropped.
        size_factor: f64 = 2.1, range 1.0..=10.0;
        /// Spacing of the dots; 0 finds it from the image.
        spacing_px: f64 = 0.0, range 0.0..=1000.0, unit "px";
    }
}

/// The dots of a photo and the spacing of their lattice (pixels; 0 when no lattice is seen).
///
/// Dots come sorted by row, then column, of their centre. False ones among them are expected (hair,
/// teeth, glints): the lattice sorts them out.
pub fn gaussian(image: &Gray, params: &GaussianParams) -> (Vec<Dot>, f64) {
    let Some(scale) = Scale::find(image, params) else {
        return (Vec::new(), params.spacing_px);
    };
    let mut sigma_px = scale.sigma_px;
    let mut fits = Vec::new();
    for _ in 0..2 {
        let found: Vec<Option<Fit>> = scale
            .candidates
            .par_iter()
            .map(|p| fit::fit(image, *p, sigma_px, scale.spacing_px, params))
            .collect();
        fits = found.into_iter().flatten().collect();
        let sigmas: Vec<f64> = fits.iter().map(|f| f.sigma_px).collect();
        // The levels of the stack are coarse: a window far from the dots' own size is made anew.
        match median(&sigmas) {
            Some(typical) if (typical / sigma_px).ln().abs() > 0.12 => sigma_px = typical,
            _ => break,
        }
    }
    let dots = keep_likely(fits, scale.spacing_px, params);
    (dots, scale.spacing_px)
}

/// Drops fits of unusual size or shape, and of two at one place the worse one.
fn keep_likely(mut fits: Vec<Fit>, spacing_px: f64, params: &GaussianParams) -> Vec<Dot> {
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
    // Fits are in order of quality, so the first of a crowd stays.
    let apart = (0.3 * spacing_px).max(1.2 * typical);
    let mut dropped = vec![false; fits.len()];
    let mut dots = Vec::with_capacity(fits.len());
    for (i, f) in fits.iter().enumerate() {
        if dropped[i] {
            continue;
        }
        for n in index.nearest_n(&[f.position.x, f.position.y], 6) {
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
