//! What the matches alone say: the pattern's pitch, outliers among them, and a first surface.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::surface::Surface;
use crate::data::Raster;
use crate::math::{Vec2, median};
use crate::spatial::{self, PointIndex};

/// A match as the matching sees it: position in the left picture and disparity, working pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) disparity: f64,
}

/// Distance between neighbouring features of the pattern: between dots, or between stripes where
/// the samples run along lines. `None` when there are fewer than three samples.
pub(super) fn pitch(samples: &[Sample]) -> Option<f64> {
    spatial::pitch(&places(samples))
}

fn index(samples: &[Sample]) -> Option<PointIndex<2>> {
    (samples.len() >= 3).then(|| PointIndex::<2>::new(&places(samples))).flatten()
}

fn places(samples: &[Sample]) -> Vec<Vec2> {
    samples.iter().map(|s| Vec2::new(s.x, s.y)).collect()
}

/// Indices of samples no denser than the pitch needs.
pub(super) fn thinned(samples: &[Sample], pitch: f64) -> Vec<usize> {
    spatial::thinned(&places(samples), pitch)
}

/// A plane `c0 + c1 dx + c2 dy` through `(dx, dy, value, weight)`, robust (Geman-McClure), with
/// the scale of its residuals (at least `floor`); `None` with fewer than four points.
pub(super) fn robust_plane(points: &[[f64; 4]], floor: f64) -> Option<(Vector3<f64>, f64)> {
    if points.len() < 4 {
        return None;
    }
    let values: Vec<f64> = points.iter().map(|p| p[2]).collect();
    let mut plane = Vector3::new(median(&values)?, 0.0, 0.0);
    let mut scale = f64::INFINITY;
    for _ in 0..5 {
        let mut normal = Matrix3::zeros();
        let mut right = Vector3::zeros();
        for &[dx, dy, value, weight] in points {
            let row = Vector3::new(1.0, dx, dy);
            let r = (value - plane.dot(&row)) / scale;
            let w = weight / (1.0 + r * r).powi(2);
            normal += row * row.transpose() * w;
            right += row * (w * value);
        }
        // without samples on a side the slope stays 0 there instead of running away
        normal[(1, 1)] += 1e-3 * normal[(0, 0)];
        normal[(2, 2)] += 1e-3 * normal[(0, 0)];
        plane = normal.cholesky()?.solve(&right);
        let residuals: Vec<f64> = points
            .iter()
            .map(|&[dx, dy, value, _]| (value - plane.dot(&Vector3::new(1.0, dx, dy))).abs())
            .collect();
        scale = (3.0 * median(&residuals)?).max(floor);
    }
    Some((plane, scale))
}

/// The plane of the neighbours within `reach` at a place, without sample `skip`.
fn local_plane(
    samples: &[Sample],
    index: &PointIndex<2>,
    at: [f64; 2],
    reach: f64,
    skip: Option<usize>,
) -> Option<(f64, f64)> {
    let near = index.within(&at, reach);
    let points: Vec<[f64; 4]> = near
        .iter()
        .filter(|n| Some(n.index) != skip)
        .map(|n| {
            let s = &samples[n.index];
            let bell = (-n.distance * n.distance / (0.3 * reach * reach)).exp();
            [s.x - at[0], s.y - at[1], s.disparity, bell]
        })
        .collect();
    robust_plane(&points, 0.1).map(|(plane, scale)| (plane[0], scale))
}

/// Which samples agree with the plane of their neighbours; lonely ones do not.
pub(super) fn consistent(samples: &[Sample], pitch: f64) -> Vec<bool> {
    let Some(index) = index(samples) else {
        return vec![false; samples.len()];
    };
    let agrees = |(i, s): (usize, &Sample)| {
        local_plane(samples, &index, [s.x, s.y], 2.3 * pitch, Some(i))
            .is_some_and(|(d, scale)| (s.disparity - d).abs() < (2.5 * scale).max(0.1 * pitch))
    };
    samples.par_iter().enumerate().map(agrees).collect()
}

/// Pixels that the samples stand for: near one, or surrounded by them (a single missing dot).
pub(super) fn domain(samples: &[Sample], pitch: f64, width: usize, height: usize) -> Raster<bool> {
    let mut domain = Raster::filled(width, height, false);
    let mut disc = |x: f64, y: f64, radius: f64| {
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
    };
    samples.iter().for_each(|s| disc(s.x, s.y, 0.85 * pitch));
    let Some(index) = index(samples) else {
        return domain;
    };
    // a gap of one dot: its middle has neighbours in every quadrant
    let step = (0.5 * pitch).max(1.0);
    for j in 0..(height as f64 / step) as usize {
        for i in 0..(width as f64 / step) as usize {
            let (x, y) = ((i as f64 + 0.5) * step, (j as f64 + 0.5) * step);
            let mut quadrants = [false; 4];
            for n in index.within(&[x, y], 1.6 * pitch) {
                let s = &samples[n.index];
                quadrants[usize::from(s.x > x) + 2 * usize::from(s.y > y)] = true;
            }
            if quadrants == [true; 4] {
                disc(x, y, 0.5 * pitch);
            }
        }
    }
    domain
}

/// A first surface over the domain: the robust plane of the samples around each knot.
pub(super) fn first_surface(
    samples: &[Sample],
    domain: &Raster<bool>,
    pitch: f64,
    knot: f64,
) -> Option<Surface> {
    let index = index(samples)?;
    let mut surface = Surface::over(domain, knot)?;
    let (columns, rows) = (surface.columns, surface.rows);
    let mut control: Vec<Option<f64>> = (0..columns * rows)
        .into_par_iter()
        .map(|k| {
            let at = surface.node(k % columns, k / columns);
            local_plane(samples, &index, at, 2.0 * pitch, None).map(|(d, _)| d)
        })
        .collect();
    // knots beyond the reach of any plane take the mean of their neighbours, ring by ring
    while control.iter().any(Option::is_none) && control.iter().any(Option::is_some) {
        let known = control.clone();
        for (k, value) in control.iter_mut().enumerate().filter(|(_, v)| v.is_none()) {
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
    surface.control = control.into_iter().collect::<Option<_>>()?;
    Some(surface)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(step: f64, skew: f64) -> Vec<Sample> {
        let at = |i: i32, j: i32| {
            let (u, v) = (f64::from(i) * step, f64::from(j) * step);
            Sample { x: 40.0 + u - skew * v, y: 40.0 + v + skew * u, disparity: 5.0 + 0.1 * u }
        };
        (0..9).flat_map(|j| (0..9).map(move |i| at(i, j))).collect()
    }

    #[test]
    fn pitch_of_lattices_and_of_stripes() {
        assert!((pitch(&lattice(9.0, 0.0)).unwrap() - 9.0).abs() < 1e-9);
        let turned = pitch(&lattice(9.0, 0.3)).unwrap();
        assert!((turned - 9.0 * 1.09f64.sqrt()).abs() < 1e-9);
        let stripe = |k: i32| (0..60).map(move |y| (12.0 * f64::from(k), f64::from(y)));
        let stripes: Vec<Sample> =
            (0..6).flat_map(stripe).map(|(x, y)| Sample { x, y, disparity: 0.0 }).collect();
        assert!((pitch(&stripes).unwrap() - 12.0).abs() < 0.5);
        assert!(pitch(&stripes[..2]).is_none());
    }

    #[test]
    fn an_outlier_is_seen_and_a_missing_dot_bridged() {
        let mut samples = lattice(9.0, 0.0);
        samples[40].disparity += 4.0;
        let agree = consistent(&samples, 9.0);
        assert_eq!(agree.iter().filter(|a| !**a).count(), 1);
        assert!(!agree[40]);
        let middle = samples.remove(40);
        let domain = domain(&samples, 9.0, 160, 160);
        assert!(domain.at(middle.x as usize, middle.y as usize));
        assert!(!domain.at(20, 76) && !domain.at(140, 140));
        let surface = first_surface(&samples, &domain, 9.0, 4.0).unwrap();
        assert!((surface.value(middle.x, middle.y) - (middle.disparity - 4.0)).abs() < 1e-3);
    }
}
