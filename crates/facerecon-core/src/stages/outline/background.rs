//! The background's colour at every cell, and its noise.

use crate::data::{Gray, Raster};
use crate::math::median;
use rayon::prelude::*;

use super::Cells;
use super::cell_images::{channel, distance_to};

/// Cells that the smooth model is fitted to, at most: far more than its unknowns need.
const MAX_SAMPLES: usize = 20_000;
/// Rounds of robust fitting.
const FIT_ROUNDS: usize = 10;
/// Width of the robust weights, standard deviations.
const WEIGHT_WIDTH: f64 = 2.0;
/// Least standard deviation of a channel, grey levels: that of 8-bit rounding and coding.
const MIN_SIGMA: f64 = 0.7;
/// The colour around the subject is a mean over this many dot spacings: wide enough to cross the
/// places where the labels are wrong, narrow enough to follow shadows and light on the wall.
const FOLLOW_SPACINGS: f64 = 4.0;
/// Cells so close to the subject are not background for sure, dot spacings.
const MARGIN_SPACINGS: f64 = 0.7;
/// Weight of the smooth model where no background is near, relative to a full neighbourhood.
const SMOOTH_WEIGHT: f32 = 1e-3;
/// Terms of the smooth model: 1, x, y, x^2, xy, y^2.
const TERMS: usize = 6;
/// Added to the diagonal of the normal equations, relative to the number of samples: keeps them
/// solvable where the samples lie on one side.
const RIDGE: f64 = 1e-6;

type Terms = nalgebra::SVector<f64, TERMS>;

/// A model of the background.
pub(super) struct Background {
    /// Expected colour.
    pub colours: Raster<[f32; 3]>,
    /// Standard deviation of each channel, grey levels.
    pub sigma: [f32; 3],
}

fn terms(x: usize, y: usize, size: (usize, usize)) -> Terms {
    let u = 2.0 * x as f64 / size.0 as f64 - 1.0;
    let v = 2.0 * y as f64 / size.1 as f64 - 1.0;
    Terms::from([1.0, u, v, u * u, u * v, v * v])
}

impl Background {
    /// A second-order surface for each channel, fitted robustly to the marked cells.
    pub fn smooth(colours: &Raster<[f32; 3]>, marked: &Raster<bool>) -> Option<Self> {
        let (width, _) = colours.size();
        let cells: Vec<usize> = (0..colours.data().len()).filter(|&i| marked.data()[i]).collect();
        let stride = cells.len().div_ceil(MAX_SAMPLES).max(1);
        let samples: Vec<(Terms, [f32; 3])> = cells
            .iter()
            .step_by(stride)
            .map(|&i| (terms(i % width, i / width, colours.size()), colours.data()[i]))
            .collect();
        let mut weights = vec![1.0; samples.len()];
        let mut fitted = [Terms::zeros(); 3];
        for _ in 0..FIT_ROUNDS {
            fitted = weighted_fit(&samples, &weights)?;
            let residual = |(t, colour): &(Terms, [f32; 3]), c: usize| {
                (f64::from(colour[c]) - t.dot(&fitted[c])).abs()
            };
            let sigma = [0, 1, 2].map(|c| {
                let all: Vec<f64> = samples.iter().map(|s| residual(s, c)).collect();
                (1.4826 * median(&all).unwrap_or(0.0)).max(MIN_SIGMA)
            });
            for (weight, sample) in weights.iter_mut().zip(&samples) {
                let squared: f64 =
                    (0..3).map(|c| (residual(sample, c) / sigma[c]).powi(2)).sum::<f64>() / 3.0;
                *weight = (1.0 + squared / WEIGHT_WIDTH.powi(2)).powi(-2);
            }
        }
        let size = colours.size();
        let model = Raster::par_from_fn(size.0, size.1, |x, y| {
            let t = terms(x, y, size);
            [0, 1, 2].map(|c| t.dot(&fitted[c]) as f32)
        });
        let sigma = noise(colours, &model, marked);
        Some(Self { colours: model, sigma })
    }

    /// The model as the cells around the subject show it: shadows and gradients of the wall.
    pub fn following(&self, cells: &Cells, subject: &Raster<bool>) -> Self {
        let margin = (MARGIN_SPACINGS * cells.spacing).max(2.0) as f32;
        let is_wall = distance_to(subject).map(|d| d > margin);
        let smooth = Self::smooth(&cells.colours, &is_wall);
        let base = smooth.as_ref().map_or(&self.colours, |s| &s.colours);
        let sigma_px = FOLLOW_SPACINGS * cells.spacing;
        let weight = is_wall.map(|w| if w { 1.0 } else { 0.0f32 });
        let total = weight.blurred(sigma_px);
        let near: Vec<Gray> = (0..3)
            .map(|c| {
                let offset = channel(&cells.colours, c).zip_map(&channel(base, c), |a, b| a - b);
                offset.zip_map(&weight, |o, w| o * w).blurred(sigma_px)
            })
            .collect();
        let (width, height) = base.size();
        let colours = Raster::par_from_fn(width, height, |x, y| {
            let (start, total) = (base.at(x, y), total.at(x, y) + SMOOTH_WEIGHT);
            [0, 1, 2].map(|c| start[c] + near[c].at(x, y) / total)
        });
        let sigma = noise(&cells.colours, &colours, &is_wall);
        Self { colours, sigma }
    }
}

fn weighted_fit(samples: &[(Terms, [f32; 3])], weights: &[f64]) -> Option<[Terms; 3]> {
    let mut matrix = nalgebra::SMatrix::<f64, TERMS, TERMS>::identity() * RIDGE;
    matrix *= samples.len() as f64;
    let mut right = [Terms::zeros(); 3];
    for ((t, colour), w) in samples.iter().zip(weights) {
        matrix += t * t.transpose() * *w;
        (0..3).for_each(|c| right[c] += t * (w * f64::from(colour[c])));
    }
    let factor = matrix.cholesky()?;
    Some(right.map(|r| factor.solve(&r)))
}

/// Standard deviation of each channel about the model over the marked cells, robust.
fn noise(colours: &Raster<[f32; 3]>, model: &Raster<[f32; 3]>, marked: &Raster<bool>) -> [f32; 3] {
    let cells: Vec<usize> = (0..colours.data().len()).filter(|&i| marked.data()[i]).collect();
    let stride = cells.len().div_ceil(MAX_SAMPLES).max(1);
    [0, 1, 2].map(|c| {
        let residual = |&i: &usize| f64::from((colours.data()[i][c] - model.data()[i][c]).abs());
        let all: Vec<f64> = cells.par_iter().step_by(stride).map(residual).collect();
        (1.4826 * median(&all).unwrap_or(0.0)).max(MIN_SIGMA) as f32
    })
}
