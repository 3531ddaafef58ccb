//! Regions: connected pairs of one shift that are on level rows.

use super::components::connected_components;
use super::evidence::Evidence;
use super::pairs::{DotPair, Partners};
use super::proposal::Proposal;

/// Least mean correlation of the plain pair around a dot that shows the same skin in both photos.
const MIN_CORRELATION: f64 = 0.4;
/// The same for the brightness of the dots, which is noisier.
const MIN_BRIGHTNESS_CORRELATION: f64 = 0.5 * MIN_CORRELATION;
/// Rounds of summation over lattice neighbours: the plain pair averages over about 3 dots in each
/// direction, the noisier brightness over 5.
const PLAIN_ROUNDS: usize = 3;
const BRIGHTNESS_ROUNDS: usize = 5;
/// Weight of a dot without contrast in the plain pair (grey levels): weak evidence against it.
const NO_CONTRAST_WEIGHT: f64 = 0.2;
/// Lattice neighbours in a region that make a dot part of its border.
const BORDER_NEIGHBOURS: usize = 2;

/// The largest connected set of pairs of a proposal that are on level rows and look similar by at
/// least `min_similarity`.
pub(super) fn largest_region(
    evidence: &Evidence<'_>,
    proposal: &Proposal,
    min_similarity: f64,
) -> Vec<DotPair> {
    let level: Vec<DotPair> = proposal
        .pairs
        .iter()
        .filter(|p| {
            let (l, dy) = evidence.row_difference(p);
            let level = (dy - proposal.row_offset.at(&l)).abs() < evidence.tolerance_px;
            level && evidence.similarity(p) >= min_similarity
        })
        .copied()
        .collect();
    let components = connected_components(evidence, &level, f64::INFINITY);
    components.into_iter().max_by_key(Vec::len).unwrap_or_default()
}

/// The left dots of a region and of the pairs at its border that were not on level rows. Without
/// these the cost of a shift would be measured on the pairs it selected itself.
pub(super) fn dots_with_border(
    evidence: &Evidence<'_>,
    region: &[DotPair],
    proposal: &Proposal,
) -> Vec<usize> {
    let partners = Partners::new(evidence.dots[0].len(), region);
    let at_border = |i: usize| {
        let inside = evidence.graphs[0].neighbours(i).filter(|n| partners.of(*n).is_some());
        inside.count() >= BORDER_NEIGHBOURS
    };
    proposal
        .pairs
        .iter()
        .map(|p| p.0)
        .filter(|i| partners.of(*i).is_some() || at_border(*i))
        .collect()
}

/// The pairs around which the photos look similar, on average over the lattice neighbourhood. Drops
/// a bare wall that the labels leaked to. Compares the plain pair, or without it the brightness of
/// the dots.
pub(super) fn pairs_in_similar_surroundings(
    evidence: &Evidence<'_>,
    region: &[DotPair],
) -> Vec<DotPair> {
    let partners = Partners::new(evidence.dots[0].len(), region);
    // Numerator and denominator of a correlation, by left dot.
    let mut sums = vec![(0.0, 0.0); evidence.dots[0].len()];
    let (rounds, least) = match &evidence.plain {
        Some(plain) => {
            for (i, j) in region {
                let (z, w) = plain.correlation(*i, *j).unwrap_or((0.0, NO_CONTRAST_WEIGHT));
                sums[*i] = (z * w, w);
            }
            (PLAIN_ROUNDS, MIN_CORRELATION)
        }
        None => {
            for pair in region {
                let brightness = evidence.relative_brightness(pair, &partners);
                let (a, b) = brightness.unwrap_or((0.0, 0.0));
                sums[pair.0] = (a * b, 0.5 * (a * a + b * b));
            }
            (BRIGHTNESS_ROUNDS, MIN_BRIGHTNESS_CORRELATION)
        }
    };
    for _ in 0..rounds {
        let before = sums.clone();
        for (i, _) in region {
            let neighbours = evidence.graphs[0].neighbours(*i);
            for n in neighbours.filter(|n| partners.of(*n).is_some()) {
                sums[*i].0 += before[n].0;
                sums[*i].1 += before[n].1;
            }
        }
    }
    region.iter().filter(|(i, _)| sums[*i].0 >= least * sums[*i].1).copied().collect()
}
