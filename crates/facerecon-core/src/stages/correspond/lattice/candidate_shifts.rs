//! Shifts of the lattice that many pairs of dots vote for.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use super::evidence::Evidence;
use super::pairs::Shift;
use super::params::LatticeParams;

/// Most shifts returned: beyond some tens only chance pairs vote.
const MAX_SHIFTS: usize = 80;
/// Greatest row error of the photos that is corrected, dot spacings. A whole spacing would be the
/// next row of dots.
const ROW_SLACK: f64 = 0.25;

/// Shifts in order of their votes. Each pair of free dots on about one row and with a disparity in
/// `disparities` votes with its similarity. Shifts of fewer voters than `params.min_component` are
/// left out.
pub(super) fn candidate_shifts(
    evidence: &Evidence<'_>,
    params: &LatticeParams,
    free: &[Vec<bool>; 2],
    disparities: &RangeInclusive<f64>,
) -> Vec<Shift> {
    let (dots, graphs) = (evidence.dots, evidence.graphs);
    let slack_px = ROW_SLACK * evidence.spacing_px;
    let mut by_row: Vec<(f64, usize)> = (0..dots[1].len())
        .filter(|j| free[1][*j] && graphs[1].labels[*j].is_some())
        .map(|j| (dots[1][j].position.y, j))
        .collect();
    by_row.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // Voters and votes. Read through a full sort, so the order of the map does not matter.
    let mut votes: HashMap<Shift, (usize, f64)> = HashMap::new();
    for (i, dot) in dots[0].iter().enumerate().filter(|(i, _)| free[0][*i]) {
        let y = dot.position.y;
        let first = by_row.partition_point(|r| r.0 < y - slack_px);
        for (_, j) in by_row[first..].iter().take_while(|r| r.0 <= y + slack_px) {
            let pair = (i, *j);
            let shift = Shift::of(graphs, &pair);
            if let (Some(shift), true) = (shift, disparities.contains(&evidence.disparity(&pair))) {
                let vote = votes.entry(shift).or_default();
                vote.0 += 1;
                vote.1 += evidence.similarity(&pair);
            }
        }
    }
    let mut ranked: Vec<(f64, Shift)> = votes
        .into_iter()
        .filter(|(_, v)| v.0 >= params.min_component)
        .map(|(s, v)| (v.1, s))
        .collect();
    ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    ranked.truncate(MAX_SHIFTS);
    ranked.into_iter().map(|r| r.1).collect()
}
