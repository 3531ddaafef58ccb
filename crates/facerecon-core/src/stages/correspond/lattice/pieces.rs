//! Connected sets of pairs.

use super::cues::Partners;
use super::graph::STEPS;
use super::regions::{Matcher, Proposal};
use super::shifts::Pair;

/// Mean correlation of the plain pair around a dot that surely shows the same skin.
const CONVINCING: f64 = 0.4;

impl Matcher<'_> {
    /// The largest connected set of pairs on level rows that look alike by at least `alike`.
    pub(super) fn region(&self, proposal: &Proposal, alike: f64) -> Option<Vec<Pair>> {
        let level: Vec<Pair> = proposal
            .pairs
            .iter()
            .filter(|p| {
                let (l, dy) = self.row_difference(p);
                let level = (dy - proposal.rows.at(&l)).abs() < self.evidence.tolerance_px;
                level && self.evidence.alike(p) >= alike
            })
            .copied()
            .collect();
        let pieces = self.pieces(&level, f64::INFINITY);
        pieces.into_iter().max_by_key(Vec::len).filter(|p| !p.is_empty())
    }

    /// Splits pairs into connected pieces. Two lattice neighbours are linked when they are one side
    /// of a full cell of four pairs in which disparity steps by less than `step_px`: single file is
    /// no link, as labels that leak from a face to the wall behind it run in single file.
    pub(super) fn pieces(&self, pairs: &[Pair], step_px: f64) -> Vec<Vec<Pair>> {
        let graph = &self.evidence.graphs[0];
        let partners = Partners::new(self.evidence.dots[0].len(), pairs);
        let smooth = |a: usize, b: usize| match (partners.of(a), partners.of(b)) {
            (Some(p), Some(q)) => {
                (self.disparity(&(a, p)) - self.disparity(&(b, q))).abs() < step_px
            }
            _ => false,
        };
        let linked = |a: usize, b: usize, step: usize| {
            smooth(a, b)
                && [1, -1].iter().any(|side| {
                    let beside = |i: usize| graph.beside(i, 1 - step / 2, *side);
                    matches!((beside(a), beside(b)), (Some(c), Some(d))
                        if smooth(a, c) && smooth(b, d) && smooth(c, d))
                })
        };
        let mut seen = vec![false; self.evidence.dots[0].len()];
        let mut pieces = Vec::new();
        for start in pairs {
            if seen[start.0] {
                continue;
            }
            seen[start.0] = true;
            let mut piece = vec![*start];
            let mut next = 0;
            while let Some((i, _)) = piece.get(next).copied() {
                next += 1;
                for (step, (axis, sign)) in STEPS.iter().enumerate() {
                    let Some(n) = graph.beside(i, *axis, *sign) else {
                        continue;
                    };
                    if let (false, true, Some(j)) = (seen[n], linked(i, n, step), partners.of(n)) {
                        seen[n] = true;
                        piece.push((n, j));
                    }
                }
            }
            pieces.push(piece);
        }
        pieces
    }

    /// The left dots of a region, and the pairs around it that its rows did not fit: without these
    /// a shift would be judged by its own selection.
    pub(super) fn with_rim(&self, region: &[Pair], proposal: &Proposal) -> Vec<usize> {
        let partners = Partners::new(self.evidence.dots[0].len(), region);
        let touches = |i: usize| {
            self.evidence.graphs[0].neighbours(i).filter(|n| partners.of(*n).is_some()).count() >= 2
        };
        proposal
            .pairs
            .iter()
            .map(|p| p.0)
            .filter(|i| partners.of(*i).is_some() || touches(*i))
            .collect()
    }

    /// The pairs around which the photos look alike, on average over the lattice neighbours and
    /// theirs: leaves out a bare wall that the labels leaked to. What is compared is the plain
    /// pair, or without it the brightness of the dots.
    pub(super) fn convincing(&self, region: &[Pair]) -> Vec<Pair> {
        let partners = Partners::new(self.evidence.dots[0].len(), region);
        // Numerator and denominator of a correlation.
        let mut sums = vec![(0.0, 0.0); self.evidence.dots[0].len()];
        let (passes, least) = match &self.evidence.plain {
            Some(plain) => {
                for (i, j) in region {
                    // No contrast is weak evidence against.
                    let (z, w) = plain.likeness(*i, *j).unwrap_or((0.0, 0.2));
                    sums[*i] = (z * w, w);
                }
                (3, CONVINCING)
            }
            None => {
                for pair in region {
                    let (a, b) =
                        self.evidence.relative_brightness(pair, &partners).unwrap_or((0.0, 0.0));
                    sums[pair.0] = (a * b, 0.5 * (a * a + b * b));
                }
                (5, 0.5 * CONVINCING)
            }
        };
        for _ in 0..passes {
            let before = sums.clone();
            for (i, _) in region {
                let beside = self.evidence.graphs[0].neighbours(*i);
                for n in beside.filter(|n| partners.of(*n).is_some()) {
                    sums[*i].0 += before[n].0;
                    sums[*i].1 += before[n].1;
                }
            }
        }
        region.iter().filter(|(i, _)| sums[*i].0 >= least * sums[*i].1).copied().collect()
    }
}
