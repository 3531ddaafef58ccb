//! Chains of edges decide over neighbouring rows which chains they match.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use super::align::EdgePair;
use super::chains::Chains;

/// Rows above and below whose alignments vote.
const VOTING_ROWS: usize = 10;
/// Fewest rows that must agree.
const MIN_VOTERS: usize = 3;

/// A match on which the rows around agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdgeMatch {
    pub row: usize,
    /// Index of the left edge in its row.
    pub left: usize,
    /// Index of the right edge in its row.
    pub right: usize,
    /// Share of the rows around that agree.
    pub votes: f64,
}

/// Matches every left chain, in every row, with the right chain that most alignments of the rows
/// around pair it with. The edge of that chain is taken whether it was aligned in this row or not.
pub(super) fn vote(
    left: &Chains,
    right: &Chains,
    aligned: &[Vec<EdgePair>],
    min_votes: f64,
) -> Vec<EdgeMatch> {
    // For every left chain: rows and right chains it was aligned with.
    let mut alignments: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    for (row, pairs) in aligned.iter().enumerate() {
        for (i, j) in pairs {
            alignments.entry(left.ids[row][*i]).or_default().push((row, right.ids[row][*j]));
        }
    }
    let mut matches = Vec::new();
    for row in 0..aligned.len() {
        let mut used = BTreeSet::new();
        for (i, id) in left.ids[row].iter().enumerate() {
            let own = alignments.get(id).map_or(&[][..], Vec::as_slice);
            let Some((chain, votes)) = elect(own, row, min_votes) else {
                continue;
            };
            let edge = right.ids[row].iter().position(|c| *c == chain);
            if let Some(right) = edge.filter(|j| used.insert(*j)) {
                matches.push(EdgeMatch { row, left: i, right, votes });
            }
        }
    }
    matches
}

/// The right chain with the most votes in the rows around `row`, and its share of them; `None`
/// without a sufficient majority. The lower number wins a tie.
fn elect(alignments: &[(usize, usize)], row: usize, min_votes: f64) -> Option<(usize, f64)> {
    let near: Vec<usize> = alignments
        .iter()
        .filter(|(r, _)| r.abs_diff(row) <= VOTING_ROWS)
        .map(|(_, chain)| *chain)
        .collect();
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    near.iter().for_each(|chain| *counts.entry(*chain).or_default() += 1);
    let (chain, count) = counts.into_iter().max_by_key(|(chain, n)| (*n, Reverse(*chain)))?;
    let votes = count as f64 / near.len() as f64;
    (count >= MIN_VOTERS && votes >= min_votes).then_some((chain, votes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_majority_of_the_rows_around_decides() {
        let rows = |chains: &[usize]| chains.iter().copied().enumerate().collect::<Vec<_>>();
        assert_eq!(elect(&rows(&[4, 4, 7, 4, 4]), 2, 0.6), Some((4, 0.8)));
        assert_eq!(elect(&rows(&[4, 4, 7, 7, 4]), 2, 0.7), None, "no clear majority");
        assert_eq!(elect(&rows(&[4, 4]), 0, 0.6), None, "too few rows");
        assert_eq!(elect(&rows(&[7, 7, 7, 4, 4, 4]), 2, 0.5), Some((4, 0.5)), "a tie");
        assert_eq!(elect(&rows(&[4, 4, 4]), 13, 0.6), None, "too far away");
        assert_eq!(elect(&[], 0, 0.6), None);
    }
}
