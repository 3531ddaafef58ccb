//! Motion of the head between the dotted photos, in which it was measured, and the plain ones, from
//! which it is coloured.
//!
//! Two comparisons determine it. The dotted photos, smoothed until the dots vanish, show where
//! brows, lips and nostrils were: this fixes the motion across the viewing direction. The two plain
//! photos show the same skin at the same point of the surface only in the right pose: this fixes
//! the depth. The rigid motion that satisfies both best is found by Gauss-Newton steps on locally
//! normalised images, from coarse to fine.

mod comparison;
mod equations;
mod images;

use super::super::error::TextureError;
use super::super::input::TextureInput;
use super::super::output::HeadMotion;
use super::super::params::ProjectiveParams;
use super::posed_camera::PosedCamera;
use super::visibility::Visibility;
use crate::data::Mesh;
use crate::math::{Similarity, Vec3, interpolate};
use crate::render::NO_FACE;
use comparison::Comparison;
use equations::NormalEquations;
use images::{DottedAndPlain, both, normalised};

/// Smoothing and effort of one round of the search.
struct Round {
    /// Smoothing of the plain photos for their comparison, thousandths of the photo's width.
    stereo_width: f64,
    /// Smoothing for the comparison with the dotted photos, thousandths of the photo's width; it
    /// must hide the dots.
    dotted_width: f64,
    /// Most Gauss-Newton steps.
    steps: usize,
}

/// From coarse, which finds large motions, to fine.
const ROUNDS: [Round; 3] = [
    Round { stereo_width: 7.0, dotted_width: 12.0, steps: 15 },
    Round { stereo_width: 3.0, dotted_width: 9.0, steps: 10 },
    Round { stereo_width: 1.5, dotted_width: 9.0, steps: 8 },
];
/// A round ends when a step lowers the cost by less than this fraction.
const SMALL_GAIN: f64 = 1e-4;
/// Levenberg-Marquardt damping: at the start, its least value, the value at which a round gives up,
/// and the factors after a good and a bad step.
const DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-4;
const MOST_DAMPING: f64 = 1.0;
const LESS_DAMPING: f64 = 0.3;
const MORE_DAMPING: f64 = 10.0;

/// Fewer common points than this do not determine a motion.
const LEAST_POINTS: usize = 500;
/// Most points compared: more cost time and no longer change the result noticeably.
const MOST_POINTS: usize = 20_000;
/// A point is visible in the second photo within this distance of the visible surface, mm.
const VISIBLE_MM: f64 = 3.0;
/// Points keep this much more distance from depth discontinuities than the blending does, pixels,
/// so that they stay on the surface while the head moves.
const EDGE_MARGIN_PX: f64 = 4.0;

/// Smaller motions are not distinguished from moving highlights on the skin, mm.
const LEAST_MM: f64 = 0.25;
/// Nor are those that lower the cost by less than this fraction.
const LEAST_GAIN: f64 = 0.03;
/// A larger motion is taken for a wrong minimum.
const MOST_MM: f64 = 40.0;
const MOST_DEG: f64 = 12.0;

/// The motion of the head; `None` where none is found.
pub(super) fn between_photos(
    input: &TextureInput<'_>,
    cameras: &[PosedCamera],
    params: &ProjectiveParams,
) -> Result<Option<HeadMotion>, TextureError> {
    let (left, right) = (input.photos[0].image, input.photos[1].image);
    let see = |camera, size| Visibility::new(input.mesh, camera, size, params.edge_px);
    let (a, b) = rayon::join(|| see(&cameras[0], left.size()), || see(&cameras[1], right.size()));
    let points = common_points(input.mesh, cameras, &[a?, b?], params);
    if points.len() < LEAST_POINTS {
        return Ok(None);
    }
    let plain = [left.to_gray(), right.to_gray()];
    let dotted = [0, 1].map(|k| input.photos[k].patterned.filter(|p| p.size() == plain[k].size()));
    let centre = points.iter().sum::<Vec3>() / points.len() as f64;
    let mut motion = Similarity::identity();
    let (mut cost, mut cost_without) = (0.0, 0.0);
    let mut smooth = DottedAndPlain::new(&plain, &dotted, ROUNDS[0].dotted_width);
    for (number, round) in ROUNDS.iter().enumerate() {
        if smooth.width != round.dotted_width {
            smooth = DottedAndPlain::new(&plain, &dotted, round.dotted_width);
        }
        let images = both(|k| normalised(&plain[k], round.stereo_width));
        let mut comparison =
            Comparison { points: &points, cameras, images, smooth: &smooth, centre, bounds: None };
        let start = comparison.equations(&motion);
        comparison.bounds = Some(start.typical.clone());
        (motion, cost) = minimise(&comparison, motion, start, round.steps);
        if number + 1 == ROUNDS.len() {
            cost_without = comparison.equations(&Similarity::identity()).cost();
        }
    }
    let moved: f64 = points.iter().map(|p| (motion.apply(p) - p).norm()).sum();
    let distance_mm = moved / points.len() as f64;
    let residual = cost / cost_without.max(1e-30);
    let angle_deg = motion.angle().to_degrees();
    let plausible = distance_mm < MOST_MM && angle_deg < MOST_DEG;
    let found = plausible && distance_mm > LEAST_MM && residual < 1.0 - LEAST_GAIN;
    Ok(found.then_some(HeadMotion { moved_from_mesh: motion, distance_mm, angle_deg, residual }))
}

/// Damped Gauss-Newton steps from a motion with its normal equations; returns the motion and its
/// cost.
fn minimise(
    comparison: &Comparison<'_>,
    mut motion: Similarity,
    mut present: NormalEquations,
    steps: usize,
) -> (Similarity, f64) {
    let mut damping = DAMPING;
    for _ in 0..steps {
        let Some(step) = present.step(&comparison.centre, damping) else { break };
        let next = step.compose(&motion);
        let trial = comparison.equations(&next);
        let gain = present.cost() - trial.cost();
        if gain > 0.0 {
            (motion, present) = (next, trial);
            damping = (damping * LESS_DAMPING).max(LEAST_DAMPING);
            if gain < SMALL_GAIN * present.cost() {
                break;
            }
        } else if damping > MOST_DAMPING {
            break;
        } else {
            damping *= MORE_DAMPING;
        }
    }
    (motion, present.cost())
}

/// Points of the surface that both photos see well, mesh frame.
fn common_points(
    mesh: &Mesh,
    cameras: &[PosedCamera],
    visibility: &[Visibility; 2],
    params: &ProjectiveParams,
) -> Vec<Vec3> {
    let margin_px = params.edge_px + EDGE_MARGIN_PX;
    let [left, right] = visibility;
    let (w, h) = left.face.size();
    let mut points = Vec::new();
    for index in 0..w * h {
        let face = left.face.data()[index];
        if face == NO_FACE || f64::from(left.edge_px.data()[index]) < margin_px {
            continue;
        }
        let weights = left.barycentric.data()[index].map(f64::from);
        let point = interpolate(mesh.corners(face as usize), weights);
        let Some((pixel, depth)) = cameras[1].project(&point) else { continue };
        let Some((behind, edge_px)) = right.behind(pixel, depth) else { continue };
        if behind.abs() < VISIBLE_MM && edge_px > margin_px {
            points.push(point);
        }
    }
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    points.into_iter().step_by(step).collect()
}
