//! The same places in two photos: corners matched by normalised cross-correlation, coarse to fine.

use rayon::prelude::*;

use crate::data::Gray;
use crate::math::Vec2;

/// The same place in both photos, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub left: Vec2,
    pub right: Vec2,
}

/// Photos are searched in full at about this width.
const COARSE_WIDTH: usize = 240;
/// Half the side of the windows of the full search, pixels of the coarse photo.
const COARSE_RADIUS: usize = 5;
/// Corners looked for.
const CORNERS: usize = 320;
/// Least correlation of the full search, and how far it must stand above the next best place.
const LEAST: f32 = 0.7;
const LEAD: f32 = 0.04;

/// Matches corners of the left photo that lie no more than `rows_px` higher or lower in the right.
pub(super) fn features(images: [&Gray; 2], rows_px: f64) -> Vec<Spot> {
    let mut levels = vec![images.map(|i| i.blurred(0.8))];
    while levels.last().is_some_and(|l| l[0].width() > COARSE_WIDTH && l[0].height() > 60) {
        let next = levels.last().map(|l| [l[0].halved(), l[1].halved()]);
        levels.extend(next);
    }
    let Some([left, right]) = levels.last() else {
        return Vec::new();
    };
    let factor = (1_usize << (levels.len() - 1)) as f64;
    let reach = (rows_px / factor).ceil() as usize + 1;
    let norms = [left, right].map(|i| norms(i, COARSE_RADIUS));
    let corners = corners(left);
    let found: Vec<Option<Spot>> = corners
        .par_iter()
        .map(|p| {
            let there = search(left, right, &norms, *p, reach, LEAD)?;
            let back = search(right, left, &[&norms[1], &norms[0]], there, reach, 0.0)?;
            let mutual = back.0.abs_diff(p.0) <= 1 && back.1.abs_diff(p.1) <= 1;
            let full = |q: (usize, usize)| {
                Vec2::new(q.0 as f64, q.1 as f64) * factor + Vec2::repeat((factor - 1.0) / 2.0)
            };
            let mut spot = mutual.then(|| Spot { left: full(*p), right: full(there) })?;
            for (n, level) in levels.iter().enumerate().rev() {
                spot = refine([&level[0], &level[1]], spot, (1_usize << n) as f64, 7, 2)?;
            }
            Some(spot)
        })
        .collect();
    found.into_iter().flatten().collect()
}

/// Finds the right place of a spot anew, to a fraction of a pixel: windows of half side `radius`,
/// searched up to `reach` pixels about the place known, in photos reduced by `factor`. `None` where
/// nothing correlates or the best lies at the edge of the search.
pub(super) fn refine(
    images: [&Gray; 2],
    spot: Spot,
    factor: f64,
    radius: isize,
    reach: isize,
) -> Option<Spot> {
    let reduced = |p: Vec2| (p - Vec2::repeat((factor - 1.0) / 2.0)) / factor;
    let (l, r) = (reduced(spot.left), reduced(spot.right));
    let (lx, ly) = (l.x.round() as isize, l.y.round() as isize);
    let (rx, ry) =
        ((r.x + lx as f64 - l.x).round() as isize, (r.y + ly as f64 - l.y).round() as isize);
    let window = |image: &Gray, x: isize, y: isize| -> Option<Vec<f32>> {
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
    };
    let a = window(images[0], lx, ly)?;
    let side = (2 * reach + 1) as usize;
    let mut scores = vec![-1.0_f32; side * side];
    for (k, score) in scores.iter_mut().enumerate() {
        let (dx, dy) = ((k % side) as isize - reach, (k / side) as isize - reach);
        if let Some(b) = window(images[1], rx + dx, ry + dy) {
            *score = a.iter().zip(&b).map(|(p, q)| p * q).sum();
        }
    }
    let (best, score) = scores.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    let (bx, by) = (best % side, best / side);
    let inner = bx > 0 && by > 0 && bx + 1 < side && by + 1 < side;
    if *score < LEAST || !inner {
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
    Some(Spot { left: full(at(lx, ly)), right: full(right) })
}

/// Zero mean, unit length; `None` for a flat window.
fn normalised(mut values: Vec<f32>) -> Option<Vec<f32>> {
    let n = values.len() as f32;
    let mean = values.iter().sum::<f32>() / n;
    values.iter_mut().for_each(|v| *v -= mean);
    let norm = values.iter().map(|v| v * v).sum::<f32>().sqrt();
    (norm > 0.3 * n.sqrt()).then(|| {
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
        if norm > 0.3 * n.sqrt() { norm as f32 } else { 0.0 }
    })
}

/// The best place of a window of one image in the other; `None` unless it stands out by `lead`.
fn search(
    from: &Gray,
    to: &Gray,
    norms: &[impl std::borrow::Borrow<Gray>; 2],
    (px, py): (usize, usize),
    reach: usize,
    lead: f32,
) -> Option<(usize, usize)> {
    let r = COARSE_RADIUS;
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
        // Whole shifted rows are added, which the compiler turns into vector code.
        for (k, weight) in patch.iter().enumerate() {
            let (dx, dy) = (k % (2 * r + 1), k / (2 * r + 1));
            let row = &to.row(y + dy - r)[dx..dx + inner];
            sums.iter_mut().zip(row).for_each(|(s, v)| *s += weight * v);
        }
        for (x, sum) in sums.iter().enumerate() {
            let norm = norms[1].borrow().at(x + r, y);
            if norm > 0.0 && *sum > 0.5 * norm {
                scores.push((sum / norm, x + r, y));
            }
        }
    }
    let best = scores.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let apart = |s: &&(f32, usize, usize)| s.1.abs_diff(best.1) > 2 || s.2.abs_diff(best.2) > 2;
    let next = scores.iter().filter(apart).map(|s| s.0).fold(0.0, f32::max);
    (best.0 > LEAST && best.0 > next + lead).then_some((best.1, best.2))
}

/// Corners (Shi and Tomasi 1994), the best of every small cell, the best of all first.
fn corners(image: &Gray) -> Vec<(usize, usize)> {
    const CELL: usize = 5;
    let (width, height) = image.size();
    let margin = COARSE_RADIUS + 2;
    let gradient = |x: usize, y: usize| {
        (image.at(x + 1, y) - image.at(x - 1, y), image.at(x, y + 1) - image.at(x, y - 1))
    };
    let strength = |x: usize, y: usize| {
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for v in y - 2..=y + 2 {
            for u in x - 2..=x + 2 {
                let (gx, gy) = gradient(u, v);
                (xx, xy, yy) = (xx + gx * gx, xy + gx * gy, yy + gy * gy);
            }
        }
        0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt()
    };
    let mut found: Vec<(f32, usize, usize)> = Vec::new();
    for cell_y in (margin..height.saturating_sub(margin)).step_by(CELL) {
        for cell_x in (margin..width.saturating_sub(margin)).step_by(CELL) {
            let ys = cell_y..(cell_y + CELL).min(height - margin);
            let best = ys
                .flat_map(|y| (cell_x..(cell_x + CELL).min(width - margin)).map(move |x| (x, y)))
                .map(|(x, y)| (strength(x, y), x, y))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            found.extend(best.filter(|b| b.0 > 20.0));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.2, a.1).cmp(&(b.2, b.1))));
    found.truncate(CORNERS);
    found.into_iter().map(|f| (f.1, f.2)).collect()
}
