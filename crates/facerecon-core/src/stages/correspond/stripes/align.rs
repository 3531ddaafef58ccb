//! Which edge is which: rows are aligned as sequences, stripes decide over their rows.

use std::collections::BTreeMap;

use super::edges::{Chains, Edge};

/// Edges of one row that were aligned, by index.
pub(super) type Aligned = (usize, usize);

/// A match that its stripe's rows agree on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Settled {
    pub row: usize,
    pub left: usize,
    pub right: usize,
    /// Share of the rows around that agree.
    pub votes: f64,
}

/// Aligns two rows of edges by dynamic programming (Needleman and Wunsch 1970; stripes keep their
/// order): partners cost their unlikeness, an edge without one costs `skip`.
pub(super) fn align(left: &[Edge], right: &[Edge], skip: f64) -> Vec<Aligned> {
    let columns = right.len() + 1;
    let mut best = vec![0.0_f64; (left.len() + 1) * columns];
    for i in 0..=left.len() {
        for j in 0..=right.len() {
            if i + j == 0 {
                continue;
            }
            let mut cost = f64::INFINITY;
            if i > 0 {
                cost = cost.min(best[(i - 1) * columns + j] + skip);
            }
            if j > 0 {
                cost = cost.min(best[i * columns + j - 1] + skip);
            }
            if i > 0 && j > 0 {
                let pair = unlikeness(&left[i - 1], &right[j - 1]);
                cost = cost.min(best[(i - 1) * columns + j - 1] + pair);
            }
            best[i * columns + j] = cost;
        }
    }
    let (mut i, mut j) = (left.len(), right.len());
    let mut aligned = Vec::new();
    while i > 0 && j > 0 {
        let here = best[i * columns + j];
        let pair = unlikeness(&left[i - 1], &right[j - 1]);
        if here == best[(i - 1) * columns + j - 1] + pair {
            aligned.push((i - 1, j - 1));
            (i, j) = (i - 1, j - 1);
        } else if here == best[(i - 1) * columns + j] + skip {
            i -= 1;
        } else {
            j -= 1;
        }
    }
    aligned.reverse();
    aligned
}

/// Unlikeness of two edges: of colour (a few hundredths are noise) and of width (slanted skin
/// shows a stripe wider in one photo).
fn unlikeness(a: &Edge, b: &Edge) -> f64 {
    if a.rising != b.rising {
        return f64::INFINITY;
    }
    let color: f64 = (0..3).map(|c| (a.color[c] - b.color[c]).powi(2)).sum();
    let width = if a.width > 0.0 && b.width > 0.0 { (a.width / b.width).ln() } else { 0.3 };
    color / 0.06_f64.powi(2) + (width / 0.3).powi(2)
}

/// Lets every chain of the left photo decide, over the rows around, which chain of the right photo
/// it is; takes that edge in every row that has it, aligned there or not.
pub(super) fn settle(
    left: &Chains,
    right: &Chains,
    aligned: &[Vec<Aligned>],
    min_votes: f64,
) -> Vec<Settled> {
    const AROUND: usize = 10;
    // For every left chain: (row, chain of the right photo) where aligned.
    let mut said: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    for (row, pairs) in aligned.iter().enumerate() {
        for (i, j) in pairs {
            said.entry(left.ids[row][*i]).or_default().push((row, right.ids[row][*j]));
        }
    }
    let mut settled = Vec::new();
    for row in 0..aligned.len() {
        let mut used = std::collections::BTreeSet::new();
        for (i, id) in left.ids[row].iter().enumerate() {
            let near: Vec<usize> = said
                .get(id)
                .into_iter()
                .flatten()
                .filter(|(r, _)| r.abs_diff(row) <= AROUND)
                .map(|(_, chain)| *chain)
                .collect();
            let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
            near.iter().for_each(|c| *counts.entry(*c).or_default() += 1);
            let Some((chain, count)) =
                counts.into_iter().max_by_key(|(c, n)| (*n, std::cmp::Reverse(*c)))
            else {
                continue;
            };
            let votes = count as f64 / near.len() as f64;
            let sure = count >= 3 && votes >= min_votes;
            let partner = right.ids[row].iter().position(|c| *c == chain).filter(|_| sure);
            if let Some(right) = partner.filter(|j| used.insert(*j)) {
                settled.push(Settled { row, left: i, right, votes });
            }
        }
    }
    settled
}
