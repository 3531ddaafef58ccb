//! Size and spacing of the dots, measured in the image.

use rayon::prelude::*;

use crate::data::Gray;
use crate::math::{Vec2, median};
use crate::spatial::PointIndex;

use super::GaussianParams;

/// Ratio of the smoothing of neighbouring levels of the stack. Set by hand: 2.3 levels an octave.
const STEP: f64 = 1.35;
/// Standard deviation of the finest level, pixels.
const FINEST_PX: f64 = 0.8;
/// Minimum number of lattice nodes for a level to be used. Set by hand.
const MIN_NODES: usize = 12;
/// Levels smoother than this, in pixels of the level, are stored at half the size.
const HALVED_FROM_PX: f64 = 5.0;
/// A lattice is distinct when at least this fraction of the blobs are its nodes. In a large photo
/// thousands of blobs of noise are nodes by chance, but only a few of a hundred. Set by hand.
const DISTINCT_FRACTION: f64 = 0.25;
/// A distinct lattice has at least this many times the minimum number of nodes.
const DISTINCT_NODES: usize = 4;
/// The search ends this many levels after a distinct lattice, when the level has less than one part
/// of this many of its nodes.
const LEVELS_AFTER: usize = 2;
const NODES_AFTER: usize = 2;
/// The coarsest level: the smaller side of the photo over this.
const COARSEST_PARTS: f64 = 24.0;
/// Candidates closer than this, in spacings, are one. Set by hand, as in the fit.
const APART_SPACINGS: f64 = 0.3;
/// Number of nearest candidates compared with one, itself included.
const NEAREST: usize = 8;
/// Radius of the window of the mean response, in standard deviations of the level.
const AROUND_SIGMAS: f64 = 4.0;
/// Blobs are kept from this fraction of the response of the faintest dot on: the fit decides.
const RESPONSE_MARGIN: f64 = 0.8;
/// Lattice nodes: nearest blobs considered (itself and 8 neighbours), the maximum relative deviation
/// of opposite neighbours, and the minimum sine of the angle between the two directions. Set by hand.
const NEIGHBOURS: usize = 9;
const OPPOSITE: f64 = 0.25;
const MIN_SINE: f64 = 0.6;
/// A given spacing excludes levels whose spacing differs by more than this factor.
const SPACING_FACTOR: f64 = 0.5;

/// Size and spacing of the dots, and where they may be.
pub(crate) struct Scale {
    /// Typical standard deviation of a dot's profile, pixels.
    pub sigma_px: f64,
    /// Typical distance of neighbouring dots, pixels.
    pub spacing_px: f64,
    /// Positions of possible dots, pixels.
    pub candidates: Vec<Vec2>,
}

/// One level of the stack: its blobs, and the lattice among them.
struct Level {
    sigma_px: f64,
    /// Position and response.
    blobs: Vec<(Vec2, f64)>,
    /// Number of blobs that are nodes of a lattice.
    nodes: usize,
    spacing_px: f64,
}

impl Scale {
    /// Searches the levels from fine to coarse; `None` when no level has a lattice.
    pub(crate) fn find(image: &Gray, params: &GaussianParams) -> Option<Self> {
        let (width, height) = image.size();
        let coarsest = width.min(height) as f64 / COARSEST_PARTS;
        let mut levels: Vec<Level> = Vec::new();
        let mut best = 0;
        let mut sigma_px = FINEST_PX;
        let mut smooth = image.blurred(sigma_px);
        // side of the level's pixels in pixels of the photo
        let mut pixel = 1.0;
        while sigma_px <= coarsest {
            if sigma_px / pixel > HALVED_FROM_PX {
                (smooth, pixel) = (smooth.halved(), 2.0 * pixel);
            }
            let next = smooth.blurred(sigma_px / pixel * (STEP * STEP - 1.0).sqrt());
            levels.push(Level::new(&smooth, &next, sigma_px / pixel, params).enlarged(pixel));
            let last = levels.len() - 1;
            if levels[last].score(params) > levels[best].score(params) {
                best = last;
            }
            let found = &levels[best];
            let distinct = found.nodes >= DISTINCT_NODES * MIN_NODES
                && found.node_fraction() >= DISTINCT_FRACTION;
            let fewer = NODES_AFTER * levels[last].nodes < levels[best].nodes;
            if distinct && last >= best + LEVELS_AFTER && fewer {
                break;
            }
            (smooth, sigma_px) = (next, sigma_px * STEP);
        }
        let chosen = levels.get(best).filter(|l| l.nodes >= MIN_NODES)?;
        let spacing_px =
            if params.spacing_px > 0.0 { params.spacing_px } else { chosen.spacing_px };
        // The response of a blob is greatest at the level of its size; the neighbouring levels add
        // dots that are sharper or softer than most.
        let around = best.saturating_sub(1)..(best + 2).min(levels.len());
        let mut all: Vec<(Vec2, f64)> =
            levels[around].iter().flat_map(|l| l.blobs.iter().copied()).collect();
        all.sort_by(|a, b| {
            b.1.total_cmp(&a.1).then(a.0.y.total_cmp(&b.0.y)).then(a.0.x.total_cmp(&b.0.x))
        });
        let candidates = thin_out(&all, APART_SPACINGS * spacing_px)?;
        Some(Self { sigma_px: levels[best].sigma_px, spacing_px, candidates })
    }
}

impl Level {
    /// Finds the blobs of difference-of-Gaussians `smooth - next`.
    fn new(smooth: &Gray, next: &Gray, sigma_px: f64, params: &GaussianParams) -> Self {
        let (width, height) = smooth.size();
        let mut response = smooth.clone();
        response.data_mut().iter_mut().zip(next.data()).for_each(|(a, b)| *a -= b);
        let around = local_mean_abs(&response, (AROUND_SIGMAS * sigma_px).ceil() as usize);
        // response of a dot of the level's size and unit height
        let unit = 0.5 - 1.0 / (1.0 + STEP * STEP);
        let least = (unit * params.min_amplitude * RESPONSE_MARGIN) as f32;
        let contrast = params.contrast as f32;
        let mut blobs = Vec::new();
        for y in 1..height.saturating_sub(1) {
            let (above, row, below) = (response.row(y - 1), response.row(y), response.row(y + 1));
            for x in 1..width.saturating_sub(1) {
                let v = row[x];
                let peak = v > least
                    && v > contrast * around.at(x, y)
                    && v > row[x - 1]
                    && v >= row[x + 1]
                    && above[x - 1..=x + 1].iter().all(|a| v > *a)
                    && below[x - 1..=x + 1].iter().all(|b| v >= *b);
                if peak {
                    let dx = vertex(row[x - 1], v, row[x + 1]);
                    let dy = vertex(above[x], v, below[x]);
                    blobs.push((Vec2::new(x as f64 + dx, y as f64 + dy), f64::from(v)));
                }
            }
        }
        let (nodes, spacing_px) = lattice_nodes(&blobs);
        Self { sigma_px, blobs, nodes, spacing_px }
    }

    /// How distinct the lattice of this level is; 0 when its spacing differs from a given one.
    fn score(&self, params: &GaussianParams) -> f64 {
        let wrong = params.spacing_px > 0.0
            && (self.spacing_px / params.spacing_px).ln().abs() > SPACING_FACTOR.ln().abs();
        // Few blobs of noise are nodes by chance, nearly all blobs of a true lattice are.
        if wrong { 0.0 } else { self.nodes as f64 * self.node_fraction().sqrt() }
    }

    /// The fraction of the blobs that are nodes.
    fn node_fraction(&self) -> f64 {
        self.nodes as f64 / self.blobs.len().max(1) as f64
    }

    /// The level in pixels of the photo; its own pixels have a side of `pixel` of them.
    fn enlarged(mut self, pixel: f64) -> Self {
        self.sigma_px *= pixel;
        self.spacing_px *= pixel;
        // pixel centres are at integers, so the corner of the picture is at -0.5
        self.blobs.iter_mut().for_each(|(p, _)| *p = p.map(|c| (c + 0.5) * pixel - 0.5));
        self
    }
}

/// Offset of a parabola's vertex through three samples, -0.5 to 0.5.
fn vertex(before: f32, at: f32, after: f32) -> f64 {
    let curvature = f64::from(before - 2.0 * at + after);
    if curvature < 0.0 {
        (0.5 * f64::from(before - after) / curvature).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

/// Mean absolute value over a square window, by running sums.
fn local_mean_abs(image: &Gray, radius: usize) -> Gray {
    let (width, height) = image.size();
    let stride = width + 1;
    let mut sums = vec![0.0_f64; stride * (height + 1)];
    for y in 0..height {
        let mut line = 0.0;
        for x in 0..width {
            line += f64::from(image.at(x, y).abs());
            sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + line;
        }
    }
    Gray::par_from_fn(width, height, |x, y| {
        let (x0, y0) = (x.saturating_sub(radius), y.saturating_sub(radius));
        let (x1, y1) = ((x + radius + 1).min(width), (y + radius + 1).min(height));
        let sum = sums[y1 * stride + x1] + sums[y0 * stride + x0]
            - sums[y0 * stride + x1]
            - sums[y1 * stride + x0];
        (sum / ((x1 - x0) * (y1 - y0)) as f64) as f32
    })
}

/// Number of blobs between two pairs of opposite neighbours, as nodes of a lattice are, and the
/// median spacing there.
fn lattice_nodes(blobs: &[(Vec2, f64)]) -> (usize, f64) {
    let points: Vec<Vec2> = blobs.iter().map(|b| b.0).collect();
    let Some(index) = PointIndex::<2>::new(&points) else {
        return (0, 0.0);
    };
    let spacing = |p: &Vec2| {
        let near: Vec<Vec2> = index
            .nearest_n(&[p.x, p.y], NEIGHBOURS)
            .iter()
            .skip(1)
            .map(|n| points[n.index] - p)
            .collect();
        let opposite = |a: &Vec2| near.iter().any(|b| (a + b).norm() < OPPOSITE * a.norm());
        let u = near.first().filter(|u| opposite(u))?;
        let across = |v: &&Vec2| (u.x * v.y - u.y * v.x).abs() > MIN_SINE * u.norm() * v.norm();
        let v = near.iter().filter(across).find(|v| opposite(v))?;
        Some((u.norm() * v.norm()).sqrt())
    };
    let found: Vec<Option<f64>> = points.par_iter().map(spacing).collect();
    let spacings: Vec<f64> = found.into_iter().flatten().collect();
    (spacings.len(), median(&spacings).unwrap_or(0.0))
}

/// Keeps the strongest of each group; `points` are sorted by strength, strongest first.
fn thin_out(points: &[(Vec2, f64)], apart: f64) -> Option<Vec<Vec2>> {
    let positions: Vec<Vec2> = points.iter().map(|p| p.0).collect();
    let index = PointIndex::<2>::new(&positions)?;
    let mut dropped = vec![false; positions.len()];
    let mut kept = Vec::new();
    for (i, p) in positions.iter().enumerate() {
        if dropped[i] {
            continue;
        }
        for n in index.nearest_n(&[p.x, p.y], NEAREST) {
            if n.index > i && n.distance < apart {
                dropped[n.index] = true;
            }
        }
        kept.push(*p);
    }
    Some(kept)
}
