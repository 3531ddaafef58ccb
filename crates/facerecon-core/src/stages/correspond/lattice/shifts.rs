//! Hypotheses: a component of the left photo is a component of the right one, shifted by whole
//! columns and rows.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use crate::math::{Vec2, median};

use super::cues::Evidence;
use super::graph::{Cell, Graph};

/// A left dot and a right dot, by index.
pub(super) type Pair = (usize, usize);

/// Left component, right component, and `right cell - left cell`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Shift {
    pub left: usize,
    pub right: usize,
    pub cell: Cell,
}

impl Shift {
    /// The shift that pairs two dots; `None` where one has no label.
    pub(super) fn of(graphs: &[Graph; 2], (left, right): &Pair) -> Option<Self> {
        let (a, b) = (graphs[0].labels[*left]?, graphs[1].labels[*right]?);
        let cell = [b.cell[0] - a.cell[0], b.cell[1] - a.cell[1]];
        Some(Self { left: a.component, right: b.component, cell })
    }
}

/// Row difference `yr - yl` of the photos: `offset + along x + down y`, about a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rows {
    centre: Vec2,
    offset: f64,
    along: f64,
    down: f64,
}

impl Rows {
    /// Level rows.
    pub(super) fn level() -> Self {
        Self { centre: Vec2::zeros(), offset: 0.0, along: 0.0, down: 0.0 }
    }

    /// Row difference expected at a left position.
    pub(super) fn at(&self, left: &Vec2) -> f64 {
        let d = left - self.centre;
        self.offset + self.along * d.x + self.down * d.y
    }

    /// Fits row differences robustly (iteratively reweighted, Tukey weights of scale `tolerance`).
    pub(super) fn fit(samples: &[(Vec2, f64)], tolerance: f64) -> Self {
        let differences: Vec<f64> = samples.iter().map(|s| s.1).collect();
        let n = samples.len().max(1) as f64;
        let centre = samples.iter().map(|s| s.0).sum::<Vec2>() / n;
        let offset = median(&differences).unwrap_or(0.0);
        let mut rows = Self { centre, offset, along: 0.0, down: 0.0 };
        for _ in 0..4 {
            let mut normal = crate::math::Mat3::zeros();
            let mut right = crate::math::Vec3::zeros();
            for (p, dy) in samples {
                let u = (dy - rows.at(p)) / (3.0 * tolerance);
                if u.abs() < 1.0 {
                    let weight = (1.0 - u * u).powi(2);
                    let j = crate::math::Vec3::new(1.0, p.x - centre.x, p.y - centre.y);
                    normal += weight * j * j.transpose();
                    right += weight * j * *dy;
                }
            }
            // Slopes are held near zero: a few dots must not tilt the rows.
            for (i, prior) in [(0, 1e-9), (1, 2e4), (2, 2e4)] {
                normal[(i, i)] += prior;
            }
            let Some(solved) = normal.try_inverse().map(|inverse| inverse * right) else {
                break;
            };
            (rows.offset, rows.along, rows.down) = (solved.x, solved.y, solved.z);
        }
        rows
    }
}

/// The pairs of dots a shift proposes, among those the filter lets through.
pub(super) fn pairs(
    graphs: &[Graph; 2],
    members: &[usize],
    shift: Shift,
    free: &[Vec<bool>; 2],
) -> Vec<Pair> {
    members
        .iter()
        .filter(|i| free[0][**i])
        .filter_map(|i| {
            let label = graphs[0].labels[*i].filter(|l| l.component == shift.left)?;
            let cell = [label.cell[0] + shift.cell[0], label.cell[1] + shift.cell[1]];
            let j = graphs[1].dot(shift.right, cell)?;
            free[1][j].then_some((*i, j))
        })
        .collect()
}

/// Shifts in order of their votes: each pair of free dots on about one row (within `slack_px`) and
/// with a disparity in `range` votes, the more alike the more. At most `keep` are returned, each
/// with at least `least` voters.
pub(super) fn candidates(
    evidence: &Evidence<'_>,
    free: &[Vec<bool>; 2],
    slack_px: f64,
    range: &RangeInclusive<f64>,
    least: usize,
    keep: usize,
) -> Vec<Shift> {
    let (dots, graphs) = (evidence.dots, evidence.graphs);
    let mut rows: Vec<(f64, usize)> = (0..dots[1].len())
        .filter(|j| free[1][*j] && graphs[1].labels[*j].is_some())
        .map(|j| (dots[1][j].position.y, j))
        .collect();
    rows.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // Read out by a full sort, so the map's order does not matter.
    let mut votes: HashMap<Shift, (usize, f64)> = HashMap::new();
    for (i, dot) in dots[0].iter().enumerate().filter(|(i, _)| free[0][*i]) {
        let y = dot.position.y;
        let first = rows.partition_point(|r| r.0 < y - slack_px);
        for (_, j) in rows[first..].iter().take_while(|r| r.0 <= y + slack_px) {
            let disparity = dot.position.x - dots[1][*j].position.x;
            let shift = Shift::of(graphs, &(i, *j));
            if let (Some(shift), true) = (shift, range.contains(&disparity)) {
                let vote = votes.entry(shift).or_default();
                vote.0 += 1;
                vote.1 += evidence.alike(&(i, *j));
            }
        }
    }
    let mut ranked: Vec<(f64, Shift)> =
        votes.into_iter().filter(|(_, v)| v.0 >= least).map(|(s, v)| (v.1, s)).collect();
    ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    ranked.truncate(keep);
    ranked.into_iter().map(|r| r.1).collect()
}
