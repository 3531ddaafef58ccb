//! Corners seen in both photos, matched by normalised cross-correlation from coarse to fine.

use std::borrow::Borrow;

use rayon::prelude::*;

use super::shi_tomasi;
use crate::data::Gray;
use crate::math::Vec2;

/// One corner in both photos, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CornerPair {
    pub left: Vec2,
    pub right: Vec2,
}

/// Fewer corners than this in both photos do not determine the rows: three for each of the four
/// parameters.
pub(super) const MIN_CORNERS: usize = 12;

/// Blur before the first reduction, pixels: against noise.
const BLUR_PX: f64 = 0.8;
/// Photos are halved until they have no more than this width or height, pixels, and are then
/// searched in full. Set by hand: trades the time of the search for the detail of the corners.
const SEARCH_WIDTH: usize = 240;
const SEARCH_HEIGHT: usize = 60;
/// Half the side of the windows of the full search, pixels of the reduced photo.
const SEARCH_RADIUS: usize = 5;
/// Corners searched.
const MAX_CORNERS: usize = 320;
/// Minimum correlation, and its minimum lead over the next best place. Set by hand.
const MIN_CORRELATION: f32 = 0.7;
const MIN_LEAD: f32 = 0.04;
/// Places nearer than this to the best one are not the next best, pixels of the reduced photo.
const APART: usize = 2;
/// Windows with a standard deviation below this count as flat, grey levels.
const FLAT_SIGMA: f64 = 0.3;
/// Half side of the windows and range of the search when a corner is refined at each level, pixels.
const LEVEL_RADIUS: isize = 7;
const LEVEL_REACH: isize = 2;
/// Blur that removes the dots where there is no plain pair: one part of this many of the width.
const DOT_BLUR_PARTS: f64 = 110.0;
/// Refinement on the dotted pair: range and half side of the windows, one part of this many of the
/// width. The range is well below half a row of dots.
const DOT_REACH_PARTS: f64 = 250.0;
const DOT_RADIUS_PARTS: f64 = 75.0;

/// Corners of the plain pair (else of the blurred dotted pair) that are no more than `rows_px`
/// higher or lower in the right photo, refined on the dotted pair.
pub(super) fn find_corners(
    dots: Option<[&Gray; 2]>,
    plain: Option<[&Gray; 2]>,
    rows_px: f64,
) -> Vec<CornerPair> {
    let corners = match (plain, dots) {
        (Some(plain), _) => match_corners(plain, rows_px),
        (None, Some(dots)) => {
            let [left, right] = dots.map(|d| d.blurred(d.width() as f64 / DOT_BLUR_PARTS));
            match_corners([&left, &right], rows_px)
        }
        (None, None) => Vec::new(),
    };
    let Some(dots) = dots else {
        return corners;
    };
    let reach = (dots[0].width() as f64 / DOT_REACH_PARTS).round().max(2.0) as isize;
    let radius = (dots[0].width() as f64 / DOT_RADIUS_PARTS).round() as isize;
    corners.into_par_iter().map(|s| refined(dots, s, 1.0, radius, reach).unwrap_or(s)).collect()
}

/// Matches corners of the left photo that are no more than `rows_px` higher or lower in the right.
fn match_corners(images: [&Gray; 2], rows_px: f64) -> Vec<CornerPair> {
    let mut levels = vec![images.map(|i| i.blurred(BLUR_PX))];
    while levels
        .last()
        .is_some_and(|l| l[0].width() > SEARCH_WIDTH && l[0].height() > SEARCH_HEIGHT)
    {
        let next = levels.last().map(|l| [l[0].halved(), l[1].halved()]);
        levels.extend(next);
    }
    let Some([left, right]) = levels.last() else {
        return Vec::new();
    };
    let factor = (1_usize << (levels.len() - 1)) as f64;
    let reach = (rows_px / factor).ceil() as usize + 1;
    let norms = [left, right].map(|i| norms(i, SEARCH_RADIUS));
    let corners = shi_tomasi::corners(left, SEARCH_RADIUS + 2, MAX_CORNERS);
    let found: Vec<Option<CornerPair>> = corners
        .par_iter()
        .map(|p| {
            let there = search(left, right, &norms, *p, reach, MIN_LEAD)?;
            let back = search(right, left, &[&norms[1], &norms[0]], there, reach, 0.0)?;
            let mutual = back.0.abs_diff(p.0) <= 1 && back.1.abs_diff(p.1) <= 1;
            let full = |q: (usize, usize)| {
                Vec2::new(q.0 as f64, q.1 as f64) * factor + Vec2::repeat((factor - 1.0) / 2.0)
            };
            let mut corner = mutual.then(|| CornerPair { left: full(*p), right: full(there) })?;
            for (n, level) in levels.iter().enumerate().rev() {
                let factor = (1_usize << n) as f64;
                corner =
                    refined([&level[0], &level[1]], corner, factor, LEVEL_RADIUS, LEVEL_REACH)?;
            }
            Some(corner)
        })
        .collect();
    found.into_iter().flatten().collect()
}

/// Measures the right position of a corner again, to a fraction of a pixel: windows of half side
/// `radius`, searched up to `reach` pixels around the known position, in photos reduced by
/// `factor`. `None` where nothing correlates or the best place is at the edge of the search.
fn refined(
    images: [&Gray; 2],
    corner: CornerPair,
    factor: f64,
    radius: isize,
    reach: isize,
) -> Option<CornerPair> {
    let reduced = |p: Vec2| (p - Vec2::repeat((factor - 1.0) / 2.0)) / factor;
    let (l, r) = (reduced(corner.left), reduced(corner.right));
    let (lx, ly) = (l.x.round() as isize, l.y.round() as isize);
    let (rx, ry) =
        ((r.x + lx as f64 - l.x).round() as isize, (r.y + ly as f64 - l.y).round() as isize);
    let template = window(images[0], lx, ly, radius)?;
    let side = (2 * reach + 1) as usize;
    let mut scores = vec![-1.0_f32; side * side];
    for (k, score) in scores.iter_mut().enumerate() {
        let (dx, dy) = ((k % side) as isize - reach, (k / side) as isize - reach);
        if let Some(other) = window(images[1], rx + dx, ry + dy, radius) {
            *score = template.iter().zip(&other).map(|(p, q)| p * q).sum();
        }
    }
    let (best, score) = scores.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    let (bx, by) = (best % side, best / side);
    let inner = bx > 0 && by > 0 && bx + 1 < side && by + 1 < side;
    if *score < MIN_CORRELATION || !inner {
        return None;
    }
    let vertex = |before: f32, after: f32| {
        let curvature = f64::from(before - 2.0 * score + after);
        if curvature < -1e-6 { 0.5 * f64::from(before - after) / curvature } else { 0.0 }
    };
    let sub = Vec2::new(
        vertex(scores[best - 1], scores[best + 1]),
        vertex(scores[best - side], scores[best + side]),
    );
    let at = |x: isize, y: isize| Vec2::new(x as f64, y as f64);
    let full = |p: Vec2| p * factor + Vec2::repeat((factor - 1.0) / 2.0);
    let right = at(rx + bx as isize - reach, ry + by as isize - reach) + sub;
    Some(CornerPair { left: full(at(lx, ly)), right: full(right) })
}

/// The normalised window around a pixel; `None` at the border and for a flat window.
fn window(image: &Gray, x: isize, y: isize, radius: isize) -> Option<Vec<f32>> {
    let inside = x >= radius
        && y >= radius
        && x + radius < image.width() as isize
        && y + radius < image.height() as isize;
    let rows = (-radius..=radius).flat_map(|dy| {
        let start = x - radius;
        let row = image.row((y + dy).clamp(0, image.height() as isize - 1) as usize);
        row.iter().skip(start.max(0) as usize).take((2 * radius + 1) as usize)
    });
    inside.then(|| normalised(rows.copied().collect()))?
}

/// Zero mean, unit length; `None` for a flat window.
fn normalised(mut values: Vec<f32>) -> Option<Vec<f32>> {
    let n = values.len() as f32;
    let mean = values.iter().sum::<f32>() / n;
    values.iter_mut().for_each(|v| *v -= mean);
    let norm = values.iter().map(|v| v * v).sum::<f32>().sqrt();
    (norm > FLAT_SIGMA as f32 * n.sqrt()).then(|| {
        values.iter_mut().for_each(|v| *v /= norm);
        values
    })
}

/// Length of the zero-mean window around every pixel; 0 at the border and where it is flat.
fn norms(image: &Gray, radius: usize) -> Gray {
    let (width, height) = image.size();
    let n = ((2 * radius + 1) * (2 * radius + 1)) as f64;
    Gray::from_fn(width, height, |x, y| {
        if x < radius || y < radius || x + radius >= width || y + radius >= height {
            return 0.0;
        }
        let (mut sum, mut squares) = (0.0, 0.0);
        for row in y - radius..=y + radius {
            for v in &image.row(row)[x - radius..=x + radius] {
                let v = f64::from(*v);
                sum += v;
                squares += v * v;
            }
        }
        let norm = (squares - sum * sum / n).max(0.0).sqrt();
        if norm > FLAT_SIGMA * n.sqrt() { norm as f32 } else { 0.0 }
    })
}

/// The best place of a window of one image in the other; `None` unless it leads by `lead`.
fn search(
    from: &Gray,
    to: &Gray,
    norms: &[impl Borrow<Gray>; 2],
    (px, py): (usize, usize),
    reach: usize,
    lead: f32,
) -> Option<(usize, usize)> {
    let r = SEARCH_RADIUS;
    let (width, height) = to.size();
    let own = norms[0].borrow().get(px as isize, py as isize)?;
    if own == 0.0 {
        return None;
    }
    let mut patch: Vec<f32> =
        (py - r..=py + r).flat_map(|y| from.row(y)[px - r..=px + r].iter().copied()).collect();
    let mean = patch.iter().sum::<f32>() / patch.len() as f32;
    patch.iter_mut().for_each(|v| *v = (*v - mean) / own);
    let inner = width - 2 * r;
    let rows = py.saturating_sub(reach).max(r)..=(py + reach).min(height - 1 - r);
    let mut scores: Vec<(f32, usize, usize)> = Vec::new();
    let mut sums = vec![0.0_f32; inner];
    for y in rows {
        sums.fill(0.0);
        // Whole shifted rows are added, which the compiler vectorises.
        for (k, weight) in patch.iter().enumerate() {
            let (dx, dy) = (k % (2 * r + 1), k / (2 * r + 1));
            let row = &to.row(y + dy - r)[dx..dx + inner];
            sums.iter_mut().zip(row).for_each(|(s, v)| *s += weight * v);
        }
        for (x, sum) in sums.iter().enumerate() {
            let norm = norms[1].borrow().at(x + r, y);
            // far below the minimum correlation: only what may count is kept
            if norm > 0.0 && *sum > 0.5 * norm {
                scores.push((sum / norm, x + r, y));
            }
        }
    }
    let best = scores.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let apart =
        |s: &&(f32, usize, usize)| s.1.abs_diff(best.1) > APART || s.2.abs_diff(best.2) > APART;
    let next = scores.iter().filter(apart).map(|s| s.0).fold(0.0, f32::max);
    (best.0 > MIN_CORRELATION && best.0 > next + lead).then_some((best.1, best.2))
}
