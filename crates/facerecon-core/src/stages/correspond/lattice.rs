//! Correspondence by the lattice of the dots, without marked pairs.
//!
//! The dots of each photo are labelled with integer columns and rows ([`label`]). If the labels are
//! right, a component of the left photo and its image in the right one differ by one integer shift
//! ([`candidate_shifts`], [`proposal`]). Which one is decided for hundreds of dots at once by the
//! cues ([`cues`], [`decision`]). Dots that no component explains follow their matched neighbours
//! ([`extend`]). Matches that no neighbour supports, or that are far behind the subject, are dropped
//! ([`prune`]). Compare the grid graphs of Ulusoy et al. 2009 and of Kawasaki et al. 2008.

mod candidate_shifts;
mod components;
mod cues;
mod decision;
mod disparity_surface;
mod evidence;
mod extend;
mod graph;
mod label;
mod lattice_matches;
mod pairs;
mod params;
mod patches;
mod pieces;
mod proposal;
mod prune;
mod region;
mod regions;
mod row_offset;
#[cfg(test)]
mod tests;

pub use params::LatticeParams;

use super::error::CorrespondError;
use super::input::CorrespondInput;
use super::matches::sort_in_raster_order;
use crate::data::{Dot, Match};
use crate::math::Vec2;
use crate::observer::{Event, Observer};
use evidence::Evidence;
use graph::Graph;
use label::{LabelOptions, label_dots};
use lattice_matches::LatticeMatches;
use patches::PlainPatches;

/// Least row tolerance, pixels: positions of small dots are limited by the pixels.
const MIN_ROW_TOLERANCE_PX: f64 = 0.4;

/// More dots left out as ambiguous than this share of the matches are worth a warning.
const MANY_LEFT_OUT: f64 = 0.05;

/// Matches the dots.
///
/// # Errors
/// [`CorrespondError::NoLattice`] where the dots of a photo form no lattice,
/// [`CorrespondError::Ambiguous`] where more than one shift of the lattice fits the photos.
pub(super) fn match_by_lattice(
    input: &CorrespondInput<'_>,
    params: &LatticeParams,
    observer: &dyn Observer,
) -> Result<Vec<Match>, CorrespondError> {
    let spacing_px = input.spacing_px;
    if !(spacing_px > 0.0 && spacing_px.is_finite()) {
        let (columns, rows) = (input.pattern.columns, input.pattern.rows);
        return Err(CorrespondError::Pattern { columns, rows, spacing_px });
    }
    let graphs = label_photos(input, params)?;
    observer.check()?;
    let evidence = Evidence {
        dots: [input.left, input.right],
        graphs: &graphs,
        plain: input.plain.map(|p| PlainPatches::new(p, [input.left, input.right], spacing_px)),
        seeds: input.seeds,
        rig: input.rig,
        spacing_px,
        tolerance_px: (params.row_tolerance * spacing_px).max(MIN_ROW_TOLERANCE_PX),
    };
    let mut found = regions::match_regions(&evidence, params, observer)?;
    let left_out = extend::extend(&evidence, params, &mut found);
    report_left_out(left_out, found.matches.len(), observer);
    prune::drop_outliers(&evidence, params, &mut found);
    let dropped = prune::drop_background(&evidence, params, &mut found);
    if dropped > 0 {
        let warning = format!(
            "{dropped} matches far behind or in front of the subject (probably a wall) were left out"
        );
        observer.warn("correspond", &warning);
    }
    Ok(to_matches(&evidence, &found))
}

/// Reports the dots whose shift of the lattice could not be decided.
fn report_left_out(left_out: usize, matches: usize, observer: &dyn Observer) {
    let what = "dots left out as ambiguous";
    observer.event(&Event::Count { stage: "correspond", what, count: left_out });
    if left_out as f64 > MANY_LEFT_OUT * matches as f64 {
        let warning = format!(
            "{left_out} dots beside the {matches} matched ones were left out: they belong to regions of the pattern (hair, a wall) in which more than one shift of the lattice fits the photos; give the plain pair, or light the subject more evenly"
        );
        observer.warn("correspond", &warning);
    }
}

/// Labels the dots of both photos.
fn label_photos(
    input: &CorrespondInput<'_>,
    params: &LatticeParams,
) -> Result<[Graph; 2], CorrespondError> {
    let options = LabelOptions {
        rotation: input.pattern.rotation,
        max_link_error: params.max_link_error,
        // a component of one photo may be two in the other
        min_component: params.min_component.div_ceil(2),
    };
    let graph = |dots: &[Dot]| {
        let points: Vec<Vec2> = dots.iter().map(|d| d.position).collect();
        label_dots(&points, &options)
    };
    let (left, right) = rayon::join(|| graph(input.left), || graph(input.right));
    for (photo, graph) in [("left", &left), ("right", &right)] {
        let (labelled, needed) = (graph.labels.iter().flatten().count(), params.min_component);
        if labelled < needed {
            return Err(CorrespondError::NoLattice { photo, labelled, needed });
        }
    }
    Ok([left, right])
}

/// The matches in raster order of their left positions. Lattice labels are those of the component
/// that most matches belong to.
fn to_matches(evidence: &Evidence<'_>, found: &LatticeMatches) -> Vec<Match> {
    let labels = &evidence.graphs[0].labels;
    let mut counts = std::collections::BTreeMap::<usize, usize>::new();
    for label in found.matches.iter().filter_map(|m| labels[m.left]) {
        *counts.entry(label.component).or_default() += 1;
    }
    let main = counts.iter().max_by_key(|(c, n)| (**n, std::cmp::Reverse(**c))).map(|(c, _)| *c);
    let mut matches: Vec<Match> = found
        .matches
        .iter()
        .map(|m| {
            let (l, r) = (&evidence.dots[0][m.left], &evidence.dots[1][m.right]);
            Match {
                left: l.position,
                right: r.position,
                lattice: labels[m.left].filter(|l| Some(l.component) == main).map(|l| l.cell),
                sigma_px: 0.0,
                score: l.score.min(r.score) * m.score,
            }
        })
        .collect();
    sort_in_raster_order(&mut matches);
    matches
}
