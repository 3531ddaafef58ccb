//! Where the descent starts: reliable samples, the pixels they represent, and a first spline.

use rayon::prelude::*;

use super::image::RowSpline;
use super::samples::{self, Sample, agree_with_neighbours, local_plane, thinned};
use super::spline::Spline;
use super::window::match_windows;
use crate::data::{Gray, Raster};

/// A window's disparity is used when its standard deviation is below this, in pitches.
const MAX_WINDOW_SIGMA: f64 = 0.05;
/// Farthest a window may move from its match, in pitches: less than half way to the next dot.
const MAX_WINDOW_SHIFT: f64 = 0.2;
/// Radius around a sample that belongs to the domain, in pitches: more than half a diagonal of a
/// square lattice, so that neighbouring discs overlap.
const SAMPLE_RADIUS: f64 = 0.85;
/// Spacing of the positions tested for gaps in the lattice, in pitches.
const GAP_STEP: f64 = 0.5;
/// A gap has samples in all four quadrants within this radius, in pitches: one missing dot.
const GAP_RADIUS: f64 = 1.6;
/// Radius of the disc that fills a gap, in pitches.
const GAP_FILL_RADIUS: f64 = 0.5;
/// Radius of the samples that a control value of the first spline is taken from, in pitches.
const PLANE_RADIUS: f64 = 2.0;

/// Matches a window at every sample that the pattern needs and writes the measured disparity into
/// the sample. Returns the indices of the samples that agree with their neighbours before and
/// after.
pub(super) fn measure_windows(
    samples: &mut [Sample],
    left: &Gray,
    right: &RowSpline,
    pitch: f64,
    half_width: f64,
) -> Vec<usize> {
    let chosen = thinned(samples, pitch);
    let mut working: Vec<Sample> = chosen.iter().map(|&i| samples[i]).collect();
    // Compare before matching: a window of a wrong match would converge to a neighbouring dot.
    let agree_before = agree_with_neighbours(&working, pitch);
    let fits = match_windows(left, right, &working, half_width, MAX_WINDOW_SHIFT * pitch);
    for (s, fit) in working.iter_mut().zip(&fits) {
        if let Some(fit) = fit.filter(|f| f.sigma_px < MAX_WINDOW_SIGMA * pitch) {
            s.disparity = fit.disparity;
        }
    }
    let agree_after = agree_with_neighbours(&working, pitch);
    let mut reliable = Vec::new();
    for (k, &i) in chosen.iter().enumerate() {
        samples[i] = working[k];
        if agree_before[k] && agree_after[k] {
            reliable.push(i);
        }
    }
    reliable
}

/// Pixels that the samples represent: those near a sample and those in a gap of one missing dot.
pub(super) fn domain(samples: &[Sample], pitch: f64, width: usize, height: usize) -> Raster<bool> {
    let mut domain = Raster::filled(width, height, false);
    samples.iter().for_each(|s| fill_disc(&mut domain, s.x, s.y, SAMPLE_RADIUS * pitch));
    let Some(index) = samples::index(samples) else {
        return domain;
    };
    let step = (GAP_STEP * pitch).max(1.0);
    for j in 0..(height as f64 / step) as usize {
        for i in 0..(width as f64 / step) as usize {
            let (x, y) = ((i as f64 + 0.5) * step, (j as f64 + 0.5) * step);
            let mut quadrants = [false; 4];
            for n in index.within(&[x, y], GAP_RADIUS * pitch) {
                let s = &samples[n.index];
                quadrants[usize::from(s.x > x) + 2 * usize::from(s.y > y)] = true;
            }
            if quadrants == [true; 4] {
                fill_disc(&mut domain, x, y, GAP_FILL_RADIUS * pitch);
            }
        }
    }
    domain
}

/// Sets the pixels within a radius of `(x, y)`.
fn fill_disc(domain: &mut Raster<bool>, x: f64, y: f64, radius: f64) {
    let (width, height) = domain.size();
    let low = |v: f64| (v - radius).ceil().max(0.0) as usize;
    let high = |v: f64, n: usize| (v + radius).floor().min(n as f64 - 1.0);
    if high(x, width) < 0.0 || high(y, height) < 0.0 {
        return;
    }
    for j in low(y)..=high(y, height) as usize {
        for i in low(x)..=high(x, width) as usize {
            if (i as f64 - x).hypot(j as f64 - y) <= radius {
                domain.set(i, j, true);
            }
        }
    }
}

/// A first spline over the domain, with cells of `cell` pixels: each control value comes from the
/// robust plane of the samples around it. `None` when no control value has enough samples.
pub(super) fn spline(
    samples: &[Sample],
    domain: &Raster<bool>,
    pitch: f64,
    cell: f64,
) -> Option<Spline> {
    let index = samples::index(samples)?;
    let mut spline = Spline::over(domain, cell)?;
    let (columns, rows) = (spline.columns, spline.rows);
    let control: Vec<Option<f64>> = (0..columns * rows)
        .into_par_iter()
        .map(|k| {
            let node = spline.node(k % columns, k / columns);
            local_plane(samples, &index, node, PLANE_RADIUS, pitch, None).map(|(d, _)| d)
        })
        .collect();
    spline.control = extrapolated(control, columns, rows)?;
    Some(spline)
}

/// Gives every unknown value the mean of its known neighbours, ring by ring; `None` when no value
/// is known.
fn extrapolated(mut values: Vec<Option<f64>>, columns: usize, rows: usize) -> Option<Vec<f64>> {
    while values.iter().any(Option::is_none) && values.iter().any(Option::is_some) {
        let known = values.clone();
        for (k, value) in values.iter_mut().enumerate().filter(|(_, v)| v.is_none()) {
            let (i, j) = (k % columns, k / columns);
            let mut sum = 0.0;
            let mut count = 0.0;
            for v in j.saturating_sub(1)..(j + 2).min(rows) {
                for u in i.saturating_sub(1)..(i + 2).min(columns) {
                    if let Some(d) = known[v * columns + u] {
                        sum += d;
                        count += 1.0;
                    }
                }
            }
            *value = (count > 0.0).then(|| sum / count);
        }
    }
    values.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::super::samples::tests::lattice;
    use super::*;

    #[test]
    fn a_missing_dot_is_bridged() {
        let mut samples = lattice(9.0, 0.0);
        let middle = samples.remove(40);
        let domain = domain(&samples, 9.0, 160, 160);
        assert!(domain.at(middle.x as usize, middle.y as usize));
        assert!(!domain.at(20, 76) && !domain.at(140, 140));
        let spline = spline(&samples, &domain, 9.0, 4.0).unwrap();
        assert!((spline.value(middle.x, middle.y) - middle.disparity).abs() < 1e-3);
    }
}
