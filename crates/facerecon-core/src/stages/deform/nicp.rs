//! Robust non-rigid ICP: the generic head bends to dense measured points.
//!
//! Data-to-model, to barycentric points of the surface, along its normals, with a thin plate on
//! the displacements and weights that forget outliers (after Amberg et al. 2007). Three steps:
//! the head takes the subject's size, it bends from stiff to supple, and last, subdivided where
//! there is data, it moves along its normals into the detail the noise allows.

mod detail;
mod front;
mod islands;
mod layers;
mod matching;
mod parts;
mod plate;
mod subdivide;

use crate::data::Mesh;
use crate::math::{Similarity, Vec3, fit_to_planes};
use crate::observer::{Event, Observer};

use super::{DeformError, DeformInput, DeformParams, Deformed};
use front::Front;
use matching::{Gate, Matcher, Point};
use plate::Plate;

crate::settings! {
    /// Robust non-rigid ICP.
    pub struct NicpParams {
        /// Stiffness from first to last: the displacement follows waves longer than about six
        /// times this length.
        stiffness_mm: Vec<f64> = vec![30.0, 20.0, 14.0, 10.0, 7.0, 5.0, 3.0], range 0.2..=1000.0, unit "mm";
        /// Rounds of matching and solving at each stiffness.
        rounds: usize = 1, range 1.0..=50.0;
        /// Points used while bending; the detail step uses them all.
        points: usize = 6000, range 100.0..=1000000.0;
        /// Whether the head takes the subject's size before it bends.
        resize: bool = true;
        /// Where there is data, faces are split until their edges are about this long.
        edge_mm: f64 = 1.6, range 0.2..=1000.0, unit "mm";
        /// Most vertices after splitting.
        max_vertices: usize = 60000, range 100.0..=10000000.0;
        /// Smoothing length of the detail step; 0 leaves the step out.
        detail_mm: f64 = 0.8, range 0.0..=100.0, unit "mm";
        /// Most points used in the detail step.
        detail_points: usize = 60000, range 100.0..=10000000.0;
        /// Standard deviation taken for points that bring none.
        sigma_mm: f64 = 0.25, range 0.001..=100.0, unit "mm";
        /// Points farther than this from the surface are not of this head.
        reach_mm: f64 = 30.0, range 0.1..=1000.0, unit "mm";
        /// Points whose normal differs by more are of another part of the head.
        normal_gate_deg: f64 = 60.0, range 1.0..=180.0, unit "deg";
        /// Points that fall within so many rings of the template's open border do not count.
        border_rings: usize = 3, range 0.0..=100.0;
    }
}

/// Bends the template to the data (roughly registered). Marked features guide the stiff rounds and
/// then let go.
pub(super) fn deform(
    input: &DeformInput<'_>,
    params: &DeformParams,
    obs: &dyn Observer,
) -> Result<Deformed, DeformError> {
    let (template, own) = (input.template, &params.nicp);
    let features = if params.use_features { input.features } else { &[] };
    let points = Point::all(input.data, own.sigma_mm);
    let few = matching::thin(&points, own.points);
    let gate = Gate::new(template, own);
    let front = Front::new(&few);
    let mut step = 0;
    let mut note = |error: f64| {
        step += 1;
        obs.event(&Event::Iteration { stage: "deform", step, error });
        obs.check()?;
        Ok(error)
    };

    let found = Matcher::new(template, &gate)?.find(&few, own.reach_mm, calm(own.reach_mm));
    let rms_before = matching::plane_rms(&found, template);
    let rest = if own.resize { resize(template, &few, &gate, own)? } else { template.clone() };

    // From stiff to supple, on the template's own vertices.
    let plate = Plate::new(&rest)?;
    let mut moved = vec![Vec3::zeros(); rest.vertices.len()];
    let mut bent = rest.clone();
    let levels = own.stiffness_mm.len() as f64;
    for (level, &stiffness) in own.stiffness_mm.iter().enumerate() {
        let fade = 1.0 - level as f64 / levels;
        for _ in 0..own.rounds {
            let reach = (3.0 * stiffness).min(own.reach_mm);
            let mut found = Matcher::new(&bent, &gate)?.find(&few, reach, calm(stiffness));
            enough(found.len())?;
            found.extend(front.find(&bent, reach));
            plate.bend(&rest, &mut moved, &found, features, fade, stiffness)?;
            let vertices = rest.vertices.iter().zip(&moved).map(|(p, d)| p + d).collect();
            bent = bent.with_vertices(vertices);
            note(matching::plane_rms(&found, &bent))?;
        }
    }

    let found = Matcher::new(&bent, &gate)?.find(&few, own.reach_mm, CALM_SPLIT_MM);
    let centres = enough(found.len())?;
    parts::carry_along(&rest, &mut bent, &found);
    let mut rms_after = matching::plane_rms(&found, &bent);

    // Finer, where there is something to measure.
    if own.detail_mm > 0.0 {
        bent = subdivide::where_measured(&bent, &found, own.edge_mm, own.max_vertices);
        let gate = Gate::new(&bent, own);
        let many = matching::thin_evenly(&points, own.detail_points);
        rms_after = detail::refine(&mut bent, &many, &gate, own, &mut note)?;
    }
    Ok(Deformed { mesh: bent, centres, rms_before, rms_after })
}

/// What disagreement within a neighbourhood a plate of some stiffness can still resolve, mm.
fn calm(stiffness: f64) -> f64 {
    1.0 + 0.25 * stiffness
}

/// Faces are split only where the points agree this well: on skin, hardly on hair. mm
const CALM_SPLIT_MM: f64 = 0.5;

fn enough(got: usize) -> Result<usize, DeformError> {
    let needed = 50;
    if got < needed { Err(DeformError::TooFew { got, needed }) } else { Ok(got) }
}

/// The template in the subject's size: a few point-to-plane steps with scale, data to model, then
/// turned round so that the data stay where they are.
fn resize(
    template: &Mesh,
    points: &[Point],
    gate: &Gate,
    params: &NicpParams,
) -> Result<Mesh, DeformError> {
    let matcher = Matcher::new(template, gate)?;
    let few = matching::thin_evenly(points, 1500);
    let mut template_from_data = Similarity::identity();
    for _ in 0..12 {
        let placed: Vec<Point> = few.iter().map(|p| p.transformed(&template_from_data)).collect();
        let found = matcher.find(&placed, params.reach_mm, calm(params.reach_mm));
        enough(found.len())?;
        let Some(step) = fit_to_planes(&matching::planes(&found), 0.02, true) else { break };
        let next = step.compose(&template_from_data);
        // heads of children and of giants, but no others
        if !(0.7..1.4).contains(&next.scale) {
            break;
        }
        template_from_data = next;
    }
    let data_from_template = template_from_data.inverse();
    Ok(template.transformed(&data_from_template))
}

#[cfg(test)]
mod tests;
