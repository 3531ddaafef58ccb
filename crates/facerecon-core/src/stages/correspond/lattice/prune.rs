//! Drops matches that no neighbour supports, and those far from the subject in depth.

use super::disparity_surface::DisparitySurface;
use super::evidence::{Evidence, MAX_STEP, SIMILAR};
use super::graph::{Graph, STEPS};
use super::lattice_matches::LatticeMatches;
use super::pairs::{DotPair, Partners};
use super::params::LatticeParams;
use crate::math::{mad, median};

/// Rounds of dropping outliers: the first removes those that spoil the planes of others.
const ROUNDS: usize = 2;
/// Neighbours, fewest neighbours and radius (in spacings) of the plane of a match.
const PLANE_NEIGHBOURS: usize = 12;
const MIN_PLANE_NEIGHBOURS: usize = 4;
const PLANE_RADIUS: f64 = 3.5;
/// Scale of the residuals in that plane, in spacings.
const PLANE_SCALE: f64 = 0.05;
/// Deviation from the plane that is never an outlier, in spacings: curved skin.
const MIN_LIMIT: f64 = 0.1;
/// Neighbours and radius (in spacings) among which a match off the plane needs support.
const SUPPORT_NEIGHBOURS: usize = 6;
const SUPPORT_RADIUS: f64 = 2.2;
/// Supporting neighbours needed, and their greatest difference of disparity in spacings: where the
/// plain pair confirms the match, and elsewhere.
const CONFIRMED_SUPPORT: (usize, f64) = (2, 0.3);
const UNCONFIRMED_SUPPORT: (usize, f64) = (3, 0.12);
/// Deviation from the plane beyond which a match also needs a lattice neighbour with the same shift,
/// in spacings: about half the period, from which on the dot one period further fits as well.
const NEEDS_SHIFT: f64 = 0.4;
/// Neighbours and radius (in spacings) over which components are connected.
const LINK_NEIGHBOURS: usize = 8;
const LINK_RADIUS: f64 = 2.1;

/// Drops matches off the robust plane of their neighbours unless some of the nearest have about the
/// same disparity (the far side of a depth discontinuity), and far off it unless a lattice neighbour
/// has the same shift; then components that are too small.
pub(super) fn drop_outliers(
    evidence: &Evidence<'_>,
    params: &LatticeParams,
    found: &mut LatticeMatches,
) {
    let spacing = evidence.spacing_px;
    for _ in 0..ROUNDS {
        let surface = DisparitySurface::new(evidence, &found.matches);
        let residuals: Vec<Option<f64>> =
            (0..found.matches.len()).map(|i| residual(&surface, i, spacing)).collect();
        let known: Vec<f64> = residuals.iter().flatten().copied().collect();
        let sigma = mad(&known).unwrap_or(0.0);
        let limit = (params.outlier_mads * sigma).max(MIN_LIMIT * spacing);
        let pairs: Vec<DotPair> = found.matches.iter().map(|m| (m.left, m.right)).collect();
        let partners = Partners::new(evidence.dots[0].len(), &pairs);
        let mut i = 0;
        found.matches.retain(|m| {
            let pair = (m.left, m.right);
            let is_within = |limit: f64| residuals[i].is_some_and(|r| r.abs() <= limit);
            let confirmed = evidence.similarity(&pair) >= SIMILAR;
            let kept = is_within(limit)
                || is_supported(&surface, i, spacing, confirmed)
                    && (is_within(NEEDS_SHIFT * spacing)
                        || shift_is_shared(evidence.graphs, &partners, pair));
            i += 1;
            kept
        });
    }
    let Components { of_match, sizes } = components(evidence, found);
    let mut size = of_match.iter().map(|c| sizes[*c]);
    found.matches.retain(|_| size.next().unwrap_or(0) >= params.min_component);
}

/// Deviation of a match from the plane of its neighbours, pixels; `None` with too few.
fn residual(surface: &DisparitySurface, i: usize, spacing: f64) -> Option<f64> {
    let at = surface.point(i);
    let near = surface.near(at, PLANE_NEIGHBOURS, PLANE_RADIUS * spacing, i);
    if near.len() < MIN_PLANE_NEIGHBOURS {
        return None;
    }
    surface.plane_at(at, &near, PLANE_SCALE * spacing).map(|p| surface.disparity(i) - p)
}

/// Whether enough of the nearest matches have about the same disparity.
fn is_supported(surface: &DisparitySurface, i: usize, spacing: f64, confirmed: bool) -> bool {
    let near = surface.near(surface.point(i), SUPPORT_NEIGHBOURS, SUPPORT_RADIUS * spacing, i);
    let (needed, step) = if confirmed { CONFIRMED_SUPPORT } else { UNCONFIRMED_SUPPORT };
    let close = |n: &&usize| (surface.disparity(**n) - surface.disparity(i)).abs() < step * spacing;
    near.iter().filter(close).count() >= needed
}

/// Whether a lattice neighbour of a matched dot is matched by the same shift of the lattice.
fn shift_is_shared(graphs: &[Graph; 2], partners: &Partners, (left, right): DotPair) -> bool {
    STEPS.iter().any(|(axis, sign)| {
        let [a, b] = [(&graphs[0], left), (&graphs[1], right)]
            .map(|(graph, dot)| graph.neighbour(dot, *axis, *sign));
        b.is_some() && a.and_then(|k| partners.of(k)) == b
    })
}

/// Components of matches without a step of disparity.
struct Components {
    /// Component of every match.
    of_match: Vec<usize>,
    /// Matches of every component.
    sizes: Vec<usize>,
}

fn components(evidence: &Evidence<'_>, found: &LatticeMatches) -> Components {
    let surface = DisparitySurface::new(evidence, &found.matches);
    let n = found.matches.len();
    let step = MAX_STEP * evidence.spacing_px;
    let radius = LINK_RADIUS * evidence.spacing_px;
    let mut of_match = vec![usize::MAX; n];
    let mut sizes = Vec::new();
    for start in 0..n {
        if of_match[start] != usize::MAX {
            continue;
        }
        of_match[start] = sizes.len();
        let mut open = vec![start];
        let mut size = 0;
        while let Some(i) = open.pop() {
            size += 1;
            for k in surface.near(surface.point(i), LINK_NEIGHBOURS, radius, i) {
                let smooth = (surface.disparity(k) - surface.disparity(i)).abs() < step;
                if smooth && of_match[k] == usize::MAX {
                    of_match[k] = sizes.len();
                    open.push(k);
                }
            }
        }
        sizes.push(size);
    }
    Components { of_match, sizes }
}

/// Drops the components far behind the subject or in front of it; returns the number of matches
/// dropped.
pub(super) fn drop_background(
    evidence: &Evidence<'_>,
    params: &LatticeParams,
    found: &mut LatticeMatches,
) -> usize {
    let range = found.subject_range(evidence, params);
    let Components { of_match, sizes } = components(evidence, found);
    let surface = DisparitySurface::new(evidence, &found.matches);
    let mut disparities = vec![Vec::new(); sizes.len()];
    for (i, component) in of_match.iter().enumerate() {
        disparities[*component].push(surface.disparity(i));
    }
    let middle: Vec<f64> = disparities.iter().map(|d| median(d).unwrap_or(f64::NAN)).collect();
    let before = found.matches.len();
    let mut keep = of_match.iter().map(|component| range.contains(&middle[*component]));
    found.matches.retain(|_| keep.next().unwrap_or(false));
    before - found.matches.len()
}

#[cfg(test)]
mod tests {
    use super::super::graph::Label;
    use super::*;
    use crate::math::Vec2;

    #[test]
    fn a_shift_is_shared_with_a_neighbour_in_the_same_direction_only() {
        // three dots in a row, the same in both photos
        let graphs = [(); 2].map(|()| {
            let mut graph = Graph::new(3);
            let basis = [Vec2::new(8.0, 0.0), Vec2::new(0.0, 8.0)];
            (0..3).for_each(|i| {
                graph.set_label(i, Label { component: 0, cell: [i as i32, 0] }, basis)
            });
            graph
        });
        let shared =
            |pairs: &[DotPair], pair| shift_is_shared(&graphs, &Partners::new(3, pairs), pair);
        assert!(shared(&[(0, 0), (1, 1)], (1, 1)));
        // the neighbour is a period off
        assert!(!shared(&[(0, 1), (1, 1)], (1, 1)));
        // the right dot is a neighbour of that of the neighbour, but on the other side
        assert!(!shared(&[(0, 2), (1, 1)], (1, 1)));
        // nothing beside it is matched
        assert!(!shared(&[(1, 1)], (1, 1)));
    }
}
