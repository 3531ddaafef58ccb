//! Connected components of dots, and of pairs.

use super::evidence::Evidence;
use super::graph::{Graph, STEPS};
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
    let starts = pairs.iter().map(|p| p.0);
    let components = connected_dots(graph, starts, smooth);
    let pair = |i: usize| partners.of(i).map(|j| (i, j));
    components.into_iter().map(|dots| dots.into_iter().filter_map(pair).collect()).collect()
}

/// Splits the dots of one photo into connected components, in the order of `starts`. Two lattice
/// neighbours are linked when they are one side of a full cell of four dots whose neighbours are all
/// `joined`.
pub(super) fn connected_dots(
    graph: &Graph,
    starts: impl Iterator<Item = usize>,
    joined: impl Fn(usize, usize) -> bool,
) -> Vec<Vec<usize>> {
    // `axis` is the axis from `a` to `b`; the cell is on either side of it
    let linked = |a: usize, b: usize, axis: usize| {
        joined(a, b)
            && [1, -1].iter().any(|side| {
                let beside = |i: usize| graph.neighbour(i, 1 - axis, *side);
                matches!((beside(a), beside(b)), (Some(c), Some(d))
                    if joined(a, c) && joined(b, d) && joined(c, d))
            })
    };
    let mut seen = vec![false; graph.labels.len()];
    let mut components = Vec::new();
    for start in starts {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut component = vec![start];
        let mut next = 0;
        while let Some(i) = component.get(next).copied() {
            next += 1;
            for (axis, sign) in STEPS {
                let neighbour = graph.neighbour(i, axis, sign);
                if let Some(n) = neighbour.filter(|n| !seen[*n] && linked(i, *n, axis)) {
                    seen[n] = true;
                    component.push(n);
                }
            }
        }
        components.push(component);
    }
    components
}
