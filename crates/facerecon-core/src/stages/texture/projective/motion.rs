//! Did the head move between the photos it was measured from and those it is coloured from?
//!
//! Two witnesses are heard together. The photos with the pattern, smoothed until the dots are gone,
//! show where brows, lips and nostrils were: that fixes the motion across the line of sight. And
//! the plain photos, seen through the right pose, show the same skin at the same place of the
//! surface: that fixes the depth. The rigid motion that satisfies both best is found by
//! Gauss-Newton on locally normalised images, from coarse to fine.

use nalgebra::{Rotation3, SMatrix, SVector};
use rayon::prelude::*;

use super::super::{TextureError, TextureInput};
use super::ProjectiveParams;
use super::bands::blur;
use super::photo::{Sight, Visibility};
use crate::data::{Gray, Mesh, Raster};
use crate::math::{Similarity, Vec2, Vec3, median};
use crate::render::NO_FACE;

/// How the head moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadMotion {
    /// From the mesh as measured to where the head is in the photos, mesh frame.
    pub moved_from_mesh: Similarity,
    /// Mean distance the visible surface moved, mm.
    pub distance_mm: f64,
    /// Rotation, degrees.
    pub angle_deg: f64,
    /// Disagreement of the photos that is left, as a fraction of that without correction.
    pub residual: f64,
}

impl HeadMotion {
    /// For the user.
    pub fn in_words(&self) -> String {
        format!(
            "the head moved by {:.1} mm (turned by {:.1} degrees) between the photos with and without the pattern; corrected for the texture",
            self.distance_mm, self.angle_deg
        )
    }
}

/// Smoothing of the rounds, in thousandths of the photo's width (the stereo comparison's, then that
/// against the patterned photos, which must hide the dots), and the steps in each.
const ROUNDS: [(f64, f64, usize); 3] = [(7.0, 12.0, 15), (3.0, 9.0, 10), (1.5, 9.0, 8)];
/// A round ends when a step makes the photos agree by less than this fraction better.
const SMALL_GAIN: f64 = 1e-4;
/// Window of the local normalisation, thousandths of the photo's width.
const WINDOW: f64 = 22.0;
/// Most points compared.
const POINTS: usize = 20_000;
/// Motions smaller than this are within what skin's shine pretends, mm.
const LEAST_MM: f64 = 0.25;
/// And those that make the photos agree by less than this fraction better.
const LEAST_GAIN: f64 = 0.03;

/// The motion, where there is one to speak of.
pub(super) fn between_photos(
    input: &TextureInput<'_>,
    views: &[Sight],
    params: &ProjectiveParams,
) -> Result<Option<HeadMotion>, TextureError> {
    let (left, right) = (input.photos[0].image, input.photos[1].image);
    let see = |view, size| Visibility::new(input.mesh, view, size, params.edge_px);
    let (a, b) = rayon::join(|| see(&views[0], left.size()), || see(&views[1], right.size()));
    let sight = [a?, b?];
    let points = common_points(input.mesh, views, &sight, params);
    if points.len() < 500 {
        return Ok(None);
    }
    let plain = [left.to_gray(), right.to_gray()];
    let patterned =
        [0, 1].map(|k| input.photos[k].patterned.filter(|p| p.size() == plain[k].size()));
    let centre = points.iter().sum::<Vec3>() / points.len() as f64;
    let mut motion = Similarity::identity();
    let mut cost = [0.0; 2];
    let mut soft = Soft::new(&plain, &patterned, ROUNDS[0].1);
    for (round, (fine, coarse, steps)) in ROUNDS.into_iter().enumerate() {
        if soft.width != coarse {
            soft = Soft::new(&plain, &patterned, coarse);
        }
        let images = both(|k| normalised(&plain[k], fine));
        let mut scene = Scene { points: &points, views, images, soft: &soft, centre, bounds: None };
        let mut present = scene.disagreement(&motion);
        scene.bounds = Some(present.typical.clone());
        let mut damping = 1e-3;
        for _ in 0..steps {
            let Some(step) = present.step(&centre, damping) else { break };
            let next = step.compose(&motion);
            let trial = scene.disagreement(&next);
            let gain = present.cost() - trial.cost();
            if gain > 0.0 {
                (motion, present) = (next, trial);
                damping = (damping * 0.3).max(1e-4);
                if gain < SMALL_GAIN * present.cost() {
                    break;
                }
            } else if damping > 1.0 {
                break;
            } else {
                damping *= 10.0;
            }
        }
        if round + 1 == ROUNDS.len() {
            cost = [scene.disagreement(&Similarity::identity()).cost(), present.cost()];
        }
    }
    let moved: f64 = points.iter().map(|p| (motion.apply(p) - p).norm()).sum();
    let distance_mm = moved / points.len() as f64;
    let residual = cost[1] / cost[0].max(1e-30);
    let angle_deg = motion.angle().to_degrees();
    let plausible = distance_mm < 40.0 && angle_deg < 12.0;
    let found = plausible && distance_mm > LEAST_MM && residual < 1.0 - LEAST_GAIN;
    Ok(found.then_some(HeadMotion { moved_from_mesh: motion, distance_mm, angle_deg, residual }))
}

/// Points of the surface that both photos see well.
fn common_points(
    mesh: &Mesh,
    views: &[Sight],
    sight: &[Visibility; 2],
    params: &ProjectiveParams,
) -> Vec<Vec3> {
    let (w, h) = sight[0].face.size();
    let mut points = Vec::new();
    for index in 0..w * h {
        let face = sight[0].face.data()[index];
        if face == NO_FACE || f64::from(sight[0].edge_px.data()[index]) < params.edge_px + 4.0 {
            continue;
        }
        let weights = sight[0].barycentric.data()[index];
        let corners = mesh.corners(face as usize);
        let point: Vec3 = (0..3).map(|k| corners[k] * f64::from(weights[k])).sum();
        let placed = views[1].place(&point);
        let Some(pixel) = views[1].camera.project(&placed) else { continue };
        let Some((behind, edge)) = sight[1].behind(pixel, placed.z) else { continue };
        if behind.abs() < 3.0 && edge > params.edge_px + 4.0 {
            points.push(point);
        }
    }
    let step = points.len().div_ceil(POINTS).max(1);
    points.into_iter().step_by(step).collect()
}

/// Smooth grey values less their local mean, by their local spread: exposure and shading drop
/// out, and dots are gone before they could count as spread.
fn normalised(gray: &Gray, width: f64) -> Gray {
    let soft = blur(&gray.map(|v| [v]), thousandths(gray.width(), width));
    let local = blur(&soft.map(|[v]| [v, v * v]), thousandths(gray.width(), WINDOW));
    let data = soft.data().iter().zip(local.data()).map(|([v], l)| {
        let spread = (l[1] - l[0] * l[0]).max(0.0).sqrt();
        (v - l[0]) / (spread + 1.0)
    });
    Raster::from_vec(gray.width(), gray.height(), data.collect())
        .unwrap_or_else(|| Raster::filled(gray.width(), gray.height(), 0.0))
}

fn thousandths(length: usize, part: f64) -> usize {
    ((length as f64 * part / 1000.0).round() as usize).max(1)
}

/// Normal equations of one Gauss-Newton step.
#[derive(Default)]
struct Disagreement {
    matrix: SMatrix<f64, 6, 6>,
    right: SVector<f64, 6>,
    sum: f64,
    count: f64,
    /// Typical miss of each kind of comparison.
    typical: Vec<f64>,
}

impl Disagreement {
    /// Adds one kind of comparison: rows and misses in units of their bound, with Geman-McClure
    /// weights; in order, so that sums are equal for any number of threads.
    fn add(&mut self, rows: &[(SVector<f64, 6>, f64)], bounds: Option<&Vec<f64>>) {
        let kind = self.typical.len();
        let typical = match bounds.and_then(|b| b.get(kind)) {
            Some(given) => *given,
            None => median(&rows.iter().map(|r| r.1.abs()).collect::<Vec<_>>()).unwrap_or(1.0),
        };
        self.typical.push(typical);
        let bound = (2.0 * typical).max(1e-6);
        for (row, miss) in rows {
            let t = (miss / bound).powi(2);
            let weight = (1.0 + t).powi(-2) / bound.powi(2);
            self.matrix += row * row.transpose() * weight;
            self.right += row * (miss * weight);
            self.sum += t / (1.0 + t);
        }
        self.count += rows.len() as f64;
    }

    /// Mean bounded squared difference.
    fn cost(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    fn step(&self, centre: &Vec3, damping: f64) -> Option<Similarity> {
        let mut a = self.matrix;
        for i in 0..6 {
            a[(i, i)] *= 1.0 + damping;
        }
        let s = a.cholesky()?.solve(&self.right);
        if !s.iter().all(|v| v.is_finite()) {
            return None;
        }
        let turn = Vec3::new(s[0], s[1], s[2]) / ARM_MM;
        let rotation = Rotation3::from_scaled_axis(turn).into_inner();
        let shift = Vec3::new(s[3], s[4], s[5]);
        Some(Similarity::rigid(rotation, centre - rotation * centre + shift))
    }
}

/// Turns are counted in mm at this distance, so that all unknowns have like sizes.
const ARM_MM: f64 = 80.0;

/// The photos with the pattern and the plain ones in the same smoothness.
struct Soft {
    /// Smoothing, thousandths of the photo's width.
    width: f64,
    then: [Option<Gray>; 2],
    now: [Gray; 2],
}

impl Soft {
    fn new(plain: &[Gray; 2], patterned: &[Option<&Gray>; 2], width: f64) -> Self {
        let (then, now) = rayon::join(
            || both(|k| patterned[k].map(|i| normalised(i, width))),
            || both(|k| normalised(&plain[k], width)),
        );
        Self { width, then, now }
    }
}

/// The same for the left and the right photo, at once.
fn both<T: Send>(one: impl Fn(usize) -> T + Sync) -> [T; 2] {
    rayon::join(|| one(0), || one(1)).into()
}

/// All that is compared in one round.
struct Scene<'a> {
    points: &'a [Vec3],
    views: &'a [Sight],
    /// The plain pair.
    images: [Gray; 2],
    soft: &'a Soft,
    centre: Vec3,
    /// Typical misses by which the comparisons are weighed; `None`: those found.
    bounds: Option<Vec<f64>>,
}

impl Scene<'_> {
    fn disagreement(&self, motion: &Similarity) -> Disagreement {
        let middle = motion.apply(&self.centre);
        let row = |arm: &Vec3, gradient: &Vec3| {
            let turn = arm.cross(gradient) / ARM_MM;
            let g = gradient;
            SVector::<f64, 6>::from([turn.x, turn.y, turn.z, g.x, g.y, g.z])
        };
        let across = |p: &Vec3| -> Option<(SVector<f64, 6>, f64)> {
            let moved = motion.apply(p);
            let (left, at_left) = look(&self.images[0], &self.views[0], &moved)?;
            let (right, at_right) = look(&self.images[1], &self.views[1], &moved)?;
            Some((row(&(moved - middle), &(at_left - at_right)), right - left))
        };
        let bounds = self.bounds.as_ref();
        let mut total = Disagreement::default();
        total.add(&self.points.par_iter().filter_map(across).collect::<Vec<_>>(), bounds);
        for k in 0..2 {
            let Some(then) = &self.soft.then[k] else { continue };
            let since = |p: &Vec3| -> Option<(SVector<f64, 6>, f64)> {
                let moved = motion.apply(p);
                let pixel = self.views[k].camera.project(&self.views[k].place(p))?;
                let before = f64::from(then.bilinear(pixel.x, pixel.y)?);
                let (after, gradient) = look(&self.soft.now[k], &self.views[k], &moved)?;
                Some((row(&(moved - middle), &gradient), before - after))
            };
            total.add(&self.points.par_iter().filter_map(since).collect::<Vec<_>>(), bounds);
        }
        total
    }
}

/// Value of an image at a point of the mesh frame, and its gradient by the point's position.
fn look(image: &Raster<f32>, view: &Sight, point: &Vec3) -> Option<(f64, Vec3)> {
    let placed = view.place(point);
    let pixel: Vec2 = view.camera.project(&placed)?;
    let at = |dx: f64, dy: f64| image.bilinear(pixel.x + dx, pixel.y + dy).map(f64::from);
    let value = at(0.0, 0.0)?;
    let gx = (at(1.0, 0.0)? - at(-1.0, 0.0)?) / 2.0;
    let gy = (at(0.0, 1.0)? - at(0.0, -1.0)?) / 2.0;
    // the lens' distortion hardly changes over a step and is left out of the gradient
    let (fx, fy) = (view.camera.fx / placed.z, view.camera.fy / placed.z);
    let in_camera =
        Vec3::new(gx * fx, gy * fy, -(gx * fx * placed.x + gy * fy * placed.y) / placed.z);
    Some((value, view.matrix.transpose() * in_camera))
}
