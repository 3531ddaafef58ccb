//! Collects the truth when the dotted pair is taken.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::error::SimulateError;
use super::lit_scene::LitScene;
use super::params::SimulateParams;
use super::rig::Rig;
use super::subject::Subject;
use super::truth::{DotTruth, Truth};
use super::viewpoint::Viewpoint;
use crate::data::{LandmarkPairs, Mesh, Pair, Raster};
use crate::math::{Similarity, Vec2, Vec3};
use crate::render::Buffers;

/// The truth of the dotted pair, and the motion of the head after it.
pub(super) fn ground_truth(
    subject: &Subject<'_>,
    scene: &LitScene<'_>,
    rig: &Rig,
    plain_from_dots: Option<Similarity>,
    params: &SimulateParams,
) -> Result<Truth, SimulateError> {
    let cameras = Cameras::new(scene, rig, params)?;
    let (depth_mm, face) = surface_in_left_photo(subject, scene, &cameras.buffers[0]);
    let count = subject.mesh.vertices.len();
    let mesh = subject.mesh.with_vertices(scene.mesh.vertices[..count].to_vec());
    let (landmarks, landmark_points) = landmarks(subject, &mesh, &cameras);
    Ok(Truth {
        camera_from_model: rig.camera_from_model(subject.mesh, params),
        rig: rig.actual(),
        depth_mm,
        face,
        dots: dots(subject, scene, rig, &cameras, params)?,
        landmarks,
        landmark_points,
        plain_from_dots: plain_from_dots.unwrap_or_else(Similarity::identity),
        mesh,
    })
}

/// Both cameras and their depth buffers of the scene.
struct Cameras<'a> {
    mesh: &'a Mesh,
    viewpoints: [Viewpoint; 2],
    buffers: [Buffers; 2],
}

impl<'a> Cameras<'a> {
    fn new(
        scene: &'a LitScene<'_>,
        rig: &Rig,
        params: &SimulateParams,
    ) -> Result<Self, SimulateError> {
        let (mesh, viewpoints) = (&scene.mesh, rig.viewpoints());
        let size = (params.width_px, params.height_px);
        let [left, right] = viewpoints;
        let buffers = [left.rasterize(mesh, size)?, right.rasterize(mesh, size)?];
        Ok(Self { mesh, viewpoints, buffers })
    }

    /// Pixel of a surface point in each photo, and whether it is visible there.
    fn observe(&self, point: &Vec3) -> ([Vec2; 2], [bool; 2]) {
        let [left, right] =
            [0, 1].map(|k| self.viewpoints[k].observe(&self.buffers[k], self.mesh, point));
        ([left.0, right.0], [left.1, right.1])
    }
}

/// Depth of the subject in the left photo, and whether each pixel shows the face.
fn surface_in_left_photo(
    subject: &Subject<'_>,
    scene: &LitScene<'_>,
    left: &Buffers,
) -> (Raster<f32>, Raster<bool>) {
    let (width, height) = left.face.size();
    let face = Raster::from_fn(width, height, |x, y| {
        let hit = left.face.at(x, y) as usize;
        hit < scene.subject_faces && subject.is_face(&scene.mesh.faces[hit])
    });
    let depth_mm = Raster::from_fn(width, height, |x, y| {
        let on_subject = (left.face.at(x, y) as usize) < scene.subject_faces;
        if on_subject { left.depth_mm.at(x, y) } else { f32::NAN }
    });
    (depth_mm, face)
}

/// All dots of the pattern, row by row.
fn dots(
    subject: &Subject<'_>,
    scene: &LitScene<'_>,
    rig: &Rig,
    cameras: &Cameras<'_>,
    params: &SimulateParams,
) -> Result<Vec<DotTruth>, SimulateError> {
    let (columns, rows) = (params.pattern.columns, params.pattern.rows);
    // The projector as a camera with one pixel per dot.
    let projected = rig.projector.rasterize(&scene.mesh, (columns, rows))?;
    let dots = (0..columns * rows).into_par_iter().map(|i| {
        let (column, row) = (i % columns, i / columns);
        let face = projected.face.at(column, row) as usize;
        let mut dot = DotTruth {
            column,
            row,
            lit: face < scene.subject_faces,
            on_face: false,
            point: Vec3::repeat(f64::NAN),
            pixel: [Vec2::repeat(f64::NAN); 2],
            visible: [false; 2],
        };
        if dot.lit {
            let w = projected.barycentric.at(column, row);
            let corners = scene.mesh.corners(face);
            dot.point = (0..3).map(|k| corners[k] * f64::from(w[k])).sum();
            (dot.pixel, dot.visible) = cameras.observe(&dot.point);
            dot.on_face = subject.is_face(&scene.mesh.faces[face]);
        }
        dot
    });
    Ok(dots.collect())
}

/// The landmarks in both photos and in space.
fn landmarks(
    subject: &Subject<'_>,
    mesh: &Mesh,
    cameras: &Cameras<'_>,
) -> (LandmarkPairs, BTreeMap<String, Vec3>) {
    let mut pairs = LandmarkPairs::new();
    let mut points = BTreeMap::new();
    for (name, vertex) in subject.landmarks.into_iter().flatten() {
        let point = mesh.vertices[*vertex];
        let [left, right] = cameras.observe(&point).0;
        pairs.insert(name.clone(), Pair { left, right });
        points.insert(name.clone(), point);
    }
    (pairs, points)
}
