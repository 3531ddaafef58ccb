//! Correspondence by the lattice itself, nothing marked by hand.
//!
//! Each photo's dots are labelled with integer columns and rows ([`graph`]). If the labels are
//! right, a component of the left photo and its image in the right one differ by one integer shift
//! ([`shifts`]); which one, is decided for hundreds of dots at once by the cues ([`cues`]). Dots
//! that no component explains follow their matched neighbours ([`extend`]), and what no neighbour
//! supports, or lies far behind the face, goes ([`prune`]).
//! Compare the grid graphs of Ulusoy et al. 2009 and of Kawasaki et al. 2008.

mod cues;
mod extend;
mod graph;
mod pieces;
mod prune;
mod regions;
mod shifts;

use crate::math::Vec2;
use crate::observer::Observer;
use crate::settings;

use super::{CorrespondError, CorrespondInput, Correspondence};
use crate::data::{Dot, Match};
use cues::{Evidence, Plain};
use graph::{Graph, Growth, grow};
use regions::{Found, Matcher};

settings! {
    /// Automatic correspondence by the lattice (method "lattice").
    pub struct LatticeParams {
        /// Largest distance of a dot from the place its lattice neighbours predict, in spacings.
        max_link_error: f64 = 0.3, range 0.05..=0.5;
        /// Greatest row difference of partners after the rows' tilt is taken out; never less than
        /// 0.08 spacings.
        row_tolerance_px: f64 = 0.6, range 0.05..=20.0, unit "px";
        /// Row fault of the photos that is followed, in spacings; a whole spacing would be the
        /// next row of dots.
        row_slack: f64 = 0.25, range 0.0..=0.45;
        /// Least ratio of the runner-up's badness to the winner's for the lattice's absolute
        /// place to count as known.
        min_confidence: f64 = 1.3, range 1.0..=100.0;
        /// Connected pieces of fewer matches are dropped.
        min_component: usize = 12, range 2.0..=1000.0;
        /// Step of disparity between neighbouring dots that counts as an edge, in spacings.
        max_step: f64 = 0.35, range 0.05..=2.0;
        /// Matches further than this many robust deviations from the plane of their neighbours are
        /// dropped.
        outlier_mads: f64 = 4.0, range 1.0..=20.0;
        /// Nearest depth a subject may have; needs a calibrated rig.
        nearest_mm: f64 = 150.0, range 1.0..=1e6, unit "mm";
        /// Farthest depth a subject may have; needs a calibrated rig.
        farthest_mm: f64 = 6000.0, range 1.0..=1e7, unit "mm";
        /// Matches that lie further behind the subject than this (the wall) are dropped; needs a
        /// calibrated rig.
        behind_mm: f64 = 120.0, range 1.0..=1e6, unit "mm";
    }
}

/// Matches the dots.
///
/// # Errors
/// [`CorrespondError::NoLattice`] where a photo's dots form no lattice,
/// [`CorrespondError::Ambiguous`] where the photos leave the absolute period open.
pub(super) fn lattice(
    input: &CorrespondInput<'_>,
    params: &LatticeParams,
    observer: &dyn Observer,
) -> Result<Correspondence, CorrespondError> {
    let spacing_px = input.spacing_px;
    if !(spacing_px > 0.0 && spacing_px.is_finite()) {
        let (columns, rows) = (input.pattern.columns, input.pattern.rows);
        return Err(CorrespondError::Pattern { columns, rows, spacing_px });
    }
    let growth = Growth {
        rotation: input.pattern.rotation,
        max_link_error: params.max_link_error,
        min_component: params.min_component.div_ceil(2),
    };
    let graph = |dots: &[Dot]| {
        let points: Vec<Vec2> = dots.iter().map(|d| d.position).collect();
        grow(&points, &growth)
    };
    let (left, right) = rayon::join(|| graph(input.left), || graph(input.right));
    for (photo, graph) in [("left", &left), ("right", &right)] {
        let labelled = graph.labels.iter().flatten().count();
        if labelled < params.min_component {
            return Err(CorrespondError::NoLattice { photo, labelled });
        }
    }
    observer.check()?;
    let graphs = [left, right];
    let evidence = Evidence {
        dots: [input.left, input.right],
        graphs: &graphs,
        plain: input.plain.map(|p| Plain::new(p, [input.left, input.right], spacing_px)),
        seeds: input.seeds,
        spacing_px,
        tolerance_px: params.row_tolerance_px.max(0.08 * spacing_px),
    };
    let matcher = Matcher::new(&evidence, input.rig, params);
    let mut found = matcher.regions(observer)?;
    extend::extend(&evidence, &mut found);
    prune::outliers(&evidence, params, &mut found);
    let dropped = prune::background(&evidence, input.rig, params, &mut found);
    let mut warnings = Vec::new();
    if dropped > 0 {
        warnings.push(format!("{dropped} matches far behind the subject (a wall) were left out"));
    }
    Ok(Correspondence { matches: table(&evidence, &graphs, &found), warnings })
}

/// The matches in raster order of their left positions. Labels are those of the component that
/// most matches belong to.
fn table(evidence: &Evidence<'_>, graphs: &[Graph; 2], found: &Found) -> Vec<Match> {
    let mut counts = std::collections::BTreeMap::<usize, usize>::new();
    for label in found.pairs.iter().filter_map(|p| graphs[0].labels[p.left]) {
        *counts.entry(label.component).or_default() += 1;
    }
    let main = counts.iter().max_by_key(|(c, n)| (**n, std::cmp::Reverse(**c))).map(|(c, _)| *c);
    let mut matches: Vec<Match> = found
        .pairs
        .iter()
        .map(|p| {
            let (l, r) = (&evidence.dots[0][p.left], &evidence.dots[1][p.right]);
            Match {
                left: l.position,
                right: r.position,
                lattice: graphs[0].labels[p.left]
                    .filter(|l| Some(l.component) == main)
                    .map(|l| l.cell),
                sigma_px: 0.0,
                score: l.score.min(r.score) * p.confidence,
            }
        })
        .collect();
    matches.sort_by(|a, b| a.left.y.total_cmp(&b.left.y).then(a.left.x.total_cmp(&b.left.x)));
    matches
}

#[cfg(test)]
mod tests;
