//! Alignment of the edges of one row in both photos.

use super::edges::Edge;

/// Standard deviation of a colour share, by noise and by the colour of the skin.
const COLOR_SIGMA: f64 = 0.06;
/// Standard deviation of the logarithm of a ratio of widths: slanted skin shows a stripe wider in
/// one photo.
const WIDTH_SIGMA: f64 = 0.3;
/// Logarithm of the ratio where a width is unknown: one standard deviation.
const UNKNOWN_LOG_RATIO: f64 = 0.3;

/// Indices of the left and right edge of one row that were aligned.
pub(super) type EdgePair = (usize, usize);

/// Aligns two rows of edges by dynamic programming (Needleman and Wunsch 1970; stripes keep their
/// order). A pair costs its dissimilarity, an edge without a pair costs `skip_cost`.
pub(super) fn align(left: &[Edge], right: &[Edge], skip_cost: f64) -> Vec<EdgePair> {
    let best = cost_table(left, right, skip_cost);
    let columns = right.len() + 1;
    let (mut i, mut j) = (left.len(), right.len());
    let mut aligned = Vec::new();
    while i > 0 && j > 0 {
        let here = best[i * columns + j];
        let pair = dissimilarity(&left[i - 1], &right[j - 1]);
        if here == best[(i - 1) * columns + j - 1] + pair {
            aligned.push((i - 1, j - 1));
            (i, j) = (i - 1, j - 1);
        } else if here == best[(i - 1) * columns + j] + skip_cost {
            i -= 1;
        } else {
            j -= 1;
        }
    }
    aligned.reverse();
    aligned
}

/// Lowest cost of aligning the first `i` left edges with the first `j` right ones, row by row.
fn cost_table(left: &[Edge], right: &[Edge], skip_cost: f64) -> Vec<f64> {
    let columns = right.len() + 1;
    let mut best = vec![0.0_f64; (left.len() + 1) * columns];
    for i in 0..=left.len() {
        for j in 0..=right.len() {
            if i + j == 0 {
                continue;
            }
            let mut cost = f64::INFINITY;
            if i > 0 {
                cost = cost.min(best[(i - 1) * columns + j] + skip_cost);
            }
            if j > 0 {
                cost = cost.min(best[i * columns + j - 1] + skip_cost);
            }
            if i > 0 && j > 0 {
                let pair = dissimilarity(&left[i - 1], &right[j - 1]);
                cost = cost.min(best[(i - 1) * columns + j - 1] + pair);
            }
            best[i * columns + j] = cost;
        }
    }
    best
}

/// Squared differences of colour and width over their variances; infinite for a left edge against a
/// right edge of a stripe.
fn dissimilarity(a: &Edge, b: &Edge) -> f64 {
    if a.rising != b.rising {
        return f64::INFINITY;
    }
    let color: f64 = (0..3).map(|c| (a.color[c] - b.color[c]).powi(2)).sum();
    let both_known = a.width > 0.0 && b.width > 0.0;
    let log_ratio = if both_known { (a.width / b.width).ln() } else { UNKNOWN_LOG_RATIO };
    color / COLOR_SIGMA.powi(2) + (log_ratio / WIDTH_SIGMA).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKIP: f64 = 2.0;

    /// The lowest cost of all alignments, by trying each.
    fn naive(left: &[Edge], right: &[Edge]) -> f64 {
        let (Some((a, left_rest)), Some((b, right_rest))) =
            (left.split_first(), right.split_first())
        else {
            return SKIP * (left.len() + right.len()) as f64;
        };
        (dissimilarity(a, b) + naive(left_rest, right_rest))
            .min(SKIP + naive(left_rest, right))
            .min(SKIP + naive(left, right_rest))
    }

    fn edges(seed: usize, count: usize) -> Vec<Edge> {
        let random = |i: usize| (12.9898 * (i + 31 * seed) as f64).sin().abs();
        (0..count)
            .map(|i| {
                let red = if random(3 * i) > 0.5 { 0.9 } else { 0.1 };
                let color = [red, 1.0 - red, 0.05 * random(3 * i + 1)];
                let rising = (i + seed).is_multiple_of(2);
                Edge { x: i as f64, rising, color, width: 5.0 + 5.0 * random(3 * i + 2) }
            })
            .collect()
    }

    #[test]
    fn the_alignment_costs_as_little_as_the_best_of_all() {
        for (seed, (n, m)) in [(6, 6), (5, 7), (1, 4), (0, 3), (7, 5)].into_iter().enumerate() {
            let (left, right) = (edges(seed, n), edges(seed + 1, m));
            let aligned = align(&left, &right, SKIP);
            assert!(aligned.is_sorted_by(|a, b| a.0 < b.0 && a.1 < b.1));
            let pairs: f64 =
                aligned.iter().map(|(i, j)| dissimilarity(&left[*i], &right[*j])).sum();
            let cost = pairs + SKIP * (n + m - 2 * aligned.len()) as f64;
            assert!((cost - naive(&left, &right)).abs() < 1e-9, "{seed}");
        }
    }
}
