//! Connected components of pairs.

use super::evidence::Evidence;
use super::graph::STEPS;
use super::pairs::{DotPair, Partners};

/// Splits pairs into connected components. Two lattice neighbours are linked when they are one side
/// of a full cell of four pairs in which disparity steps by less than `step_px`. A single file of
/// pairs is no link: labels that leak from a face to the wall behind it run in single file.
pub(super) fn connected_components(
    evidence: &Evidence<'_>,
    pairs: &[DotPair],
    step_px: f64,
) -> Vec<Vec<DotPair>> {
    let graph = &evidence.graphs[0];
    let partners = Partners::new(evidence.dots[0].len(), pairs);
    let smooth = |a: usize, b: usize| match (partners.of(a), partners.of(b)) {
        (Some(p), Some(q)) => {
            (evidence.disparity(&(a, p)) - evidence.disparity(&(b, q))).abs() < step_px
        }
        _ => false,
    };
    // `axis` is the axis from `a` to `b`; the cell is on either side of it
    let linked = |a: usize, b: usize, axis: usize| {
        smooth(a, b)
            && [1, -1].iter().any(|side| {
                let beside = |i: usize| graph.neighbour(i, 1 - axis, *side);
                matches!((beside(a), beside(b)), (Some(c), Some(d))
                    if smooth(a, c) && smooth(b, d) && smooth(c, d))
            })
    };
    let mut seen = vec![false; evidence.dots[0].len()];
    let mut components = Vec::new();
    for start in pairs {
        if seen[start.0] {
            continue;
        }
        seen[start.0] = true;
        let mut component = vec![*start];
        let mut next = 0;
        while let Some((i, _)) = component.get(next).copied() {
            next += 1;
            for (axis, sign) in STEPS {
                let Some(n) = graph.neighbour(i, axis, sign) else {
                    continue;
                };
                if let (false, true, Some(j)) = (seen[n], linked(i, n, axis), partners.of(n)) {
                    seen[n] = true;
                    component.push((n, j));
                }
            }
        }
        components.push(component);
    }
    components
}
