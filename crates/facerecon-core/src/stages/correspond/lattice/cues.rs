//! The cost of one shift of the lattice: the cues that resolve the lattice period.
//!
//! Every cue is a factor above 0, about 1 where it gives no information. The ratio of the costs of
//! the second-best and the best shift is the confidence.
//!
//! The thresholds are choices; docs/accuracy.md lists how many dots are matched with them, also in
//! noisy, dim and defocused photos.

use super::evidence::Evidence;
use super::pairs::{DotPair, Partners};
use super::row_offset::RowOffset;
use crate::math::Vec2;

/// Row difference at which a pair has its full cost, in row tolerances: single outliers must not
/// decide.
const MAX_ROW_DIFFERENCE: f64 = 4.0;
/// Row difference caused by noise, in spacings (0.15 px at 10 px): smaller ones are equally good.
const ROW_NOISE: f64 = 0.015;
/// Pairs at which the row cue and the plain-pair cue have half their weight: fewer pairs agree by
/// chance (the standard error of a correlation of `n` samples is about `1 / sqrt(n)`: 0.3).
const HALF_WEIGHT_PAIRS: f64 = 10.0;
/// The same for the brightness cue: one noisy value per pair, hence more pairs (standard error
/// 0.16).
const BRIGHTNESS_HALF_WEIGHT_PAIRS: f64 = 40.0;
/// A correlation `r` costs this minus `r`: 0.1 at best, so that no cue alone outweighs all others.
const CORRELATION_COST: f64 = 1.1;
/// Pairs added to the denominator of the share of holes: a few dots give no reliable share.
const HOLE_PRIOR_PAIRS: f64 = 40.0;
/// Share of holes that costs nothing: dots that one photo lacks by chance.
const HOLE_SHARE: f64 = 0.1;
/// Paired lattice neighbours that make an unpaired dot a hole: both sides of it.
const HOLE_NEIGHBOURS: usize = 2;
/// Factor for every seed that the shift pairs as marked, or its inverse for one it pairs otherwise:
/// three seeds outweigh any photo cue.
const SEED_FACTOR: f64 = 4.0;
/// Greatest distance of a seed from a dot, in spacings (as `correspond.scan.seed_tolerance`).
const SEED_RADIUS: f64 = 0.6;
/// Product of both photo cues below which they favour a shift: one correlation of 0.35 suffices.
const INFORMATIVE_COST: f64 = 0.75;

/// The cost of a shift, cue by cue.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShiftCost {
    pub rows: f64,
    pub plain: f64,
    pub brightness: f64,
    pub holes: f64,
    pub seeds: f64,
}

impl ShiftCost {
    /// The cost of pairing `pairs`, out of the left dots `candidates`.
    pub(super) fn new(
        evidence: &Evidence<'_>,
        candidates: &[usize],
        pairs: &[DotPair],
        row_offset: &RowOffset,
    ) -> Self {
        let partners = Partners::new(evidence.dots[0].len(), pairs);
        Self {
            rows: row_cost(evidence, pairs, row_offset),
            plain: plain_cost(evidence, pairs),
            brightness: brightness_cost(evidence, pairs, &partners),
            holes: hole_cost(evidence, candidates, &partners, pairs.len()),
            seeds: seed_cost(evidence, &partners),
        }
    }

    /// All cues together.
    pub(super) fn total(&self) -> f64 {
        self.rows * self.plain * self.brightness * self.holes * self.seeds
    }

    /// Whether the photos or the seeds favour the shift, not the rows alone.
    pub(super) fn is_informative(&self) -> bool {
        self.plain * self.brightness < INFORMATIVE_COST || self.seeds < 1.0
    }
}

/// A dot and its match are on one row; with a wrong shift they differ as the lattice's rows bend
/// over the face. Root mean square difference over that of noise.
fn row_cost(evidence: &Evidence<'_>, pairs: &[DotPair], row_offset: &RowOffset) -> f64 {
    let limit = (MAX_ROW_DIFFERENCE * evidence.tolerance_px).powi(2);
    let sum: f64 = pairs
        .iter()
        .map(|pair| {
            let (l, dy) = evidence.row_difference(pair);
            (dy - row_offset.at(&l)).powi(2).min(limit)
        })
        .sum();
    let noise = ROW_NOISE * evidence.spacing_px;
    let n = pairs.len() as f64;
    ((sum / n.max(1.0)).sqrt().max(noise) / noise).powf(n / (n + HALF_WEIGHT_PAIRS))
}

/// The plain pair is similar around a dot and its match: weighted mean of the correlations.
fn plain_cost(evidence: &Evidence<'_>, pairs: &[DotPair]) -> f64 {
    let Some(plain) = &evidence.plain else {
        return 1.0;
    };
    let (mut sum, mut weights, mut n) = (0.0, 0.0, 0.0);
    for (z, w) in pairs.iter().filter_map(|(i, j)| plain.correlation(*i, *j)) {
        sum += w * z;
        weights += w;
        n += 1.0;
    }
    if weights > 0.0 {
        CORRELATION_COST - sum / weights * (n / (n + HALF_WEIGHT_PAIRS))
    } else {
        1.0
    }
}

/// Dots on dark skin are dim in both photos: correlation of the relative brightness.
fn brightness_cost(evidence: &Evidence<'_>, pairs: &[DotPair], partners: &Partners) -> f64 {
    let (mut ab, mut aa, mut bb, mut n) = (0.0, 0.0, 0.0, 0.0);
    for (a, b) in pairs.iter().filter_map(|p| evidence.relative_brightness(p, partners)) {
        (ab, aa, bb, n) = (ab + a * b, aa + a * a, bb + b * b, n + 1.0);
    }
    let correlation = if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 };
    CORRELATION_COST - correlation * n / (n + BRIGHTNESS_HALF_WEIGHT_PAIRS)
}

/// Holes of the lattice (eyes, nostrils, brows) are the same in both photos: share of the candidates
/// that are unpaired although their lattice neighbours are paired.
fn hole_cost(
    evidence: &Evidence<'_>,
    candidates: &[usize],
    partners: &Partners,
    paired: usize,
) -> f64 {
    let is_hole = |i: &usize| {
        let paired = evidence.graphs[0].neighbours(*i).filter(|n| partners.of(*n).is_some());
        partners.of(*i).is_none() && paired.count() >= HOLE_NEIGHBOURS
    };
    let holes = candidates.iter().filter(|i| is_hole(i)).count() as f64;
    let n = paired as f64;
    ((HOLE_SHARE + holes / (n + holes + HOLE_PRIOR_PAIRS)) / HOLE_SHARE).sqrt()
}

/// Seeds that the shift pairs as marked, or otherwise.
fn seed_cost(evidence: &Evidence<'_>, partners: &Partners) -> f64 {
    let Some(seeds) = &evidence.seeds else {
        return 1.0;
    };
    let nearest_dot = |side: usize, p: Vec2| {
        (0..evidence.dots[side].len())
            .map(|i| ((evidence.dots[side][i].position - p).norm(), i))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|n| n.0 < SEED_RADIUS * evidence.spacing_px)
            .map(|n| n.1)
    };
    let mut cost: f64 = 1.0;
    for seed in [seeds.head, seeds.left_ear, seeds.right_ear] {
        if let (Some(i), Some(j)) = (nearest_dot(0, seed.left), nearest_dot(1, seed.right)) {
            match partners.of(i) {
                Some(p) if p == j => cost /= SEED_FACTOR,
                Some(_) => cost *= SEED_FACTOR,
                None => {}
            }
        }
    }
    cost
}
