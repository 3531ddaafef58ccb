//! What the simulator knows about a capture.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::geometry::Rig;
use super::lamps::Lamps;
use super::{SimulateError, SimulateParams, Subject};
use crate::camera::{Pinhole, StereoRig};
use crate::data::{LandmarkPairs, Mesh, Pair, Raster, Seeds};
use crate::math::{Similarity, Vec2, Vec3};
use crate::render::{Buffers, NO_FACE, rasterize};

/// A surface this near to a dot, along the line of sight, is the one that carries it.
const VISIBLE_MM: f64 = 0.4;

/// One dot of the pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DotTruth {
    /// Column in the pattern, 0 at the left.
    pub column: usize,
    /// Row in the pattern, 0 at the top.
    pub row: usize,
    /// Whether it falls on the subject; else the following say nothing.
    pub lit: bool,
    /// Whether it falls on the face.
    pub on_face: bool,
    /// Where it falls, left camera frame, mm.
    pub point: Vec3,
    /// Its centre in the left and the right photo, pixels.
    pub pixel: [Vec2; 2],
    /// Whether the left and the right camera see it.
    pub visible: [bool; 2],
}

/// The truth behind a simulated capture.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The subject in the left camera's frame, mm, when the pair with the pattern was taken.
    pub mesh: Mesh,
    /// From the model frame to [`Truth::mesh`].
    pub camera_from_model: Similarity,
    /// The rig as it stood, faults included.
    pub rig: StereoRig,
    /// Depth of the subject at each pixel centre of the left photo, mm; NaN beside it.
    pub depth_mm: Raster<f32>,
    /// Whether each of those pixels shows the face (all of the subject where none was named).
    pub face: Raster<bool>,
    /// All dots of the pattern, row by row.
    pub dots: Vec<DotTruth>,
    /// The features in both photos (pixels), where the subject came with landmarks.
    pub features: LandmarkPairs,
    /// The features in space, left camera frame, mm.
    pub feature_points: BTreeMap<String, Vec3>,
    /// Motion of the head until the plain pair, left camera frame.
    pub plain_from_dots: Similarity,
}

/// Collects the truth of the pair with the pattern.
pub(super) fn gather(
    subject: &Subject<'_>,
    lamps: &Lamps<'_>,
    rig: &Rig,
    plain_from_dots: Option<Similarity>,
    params: &SimulateParams,
) -> Result<Truth, SimulateError> {
    let size = (params.width_px, params.height_px);
    let cameras =
        [(rig.told.left, Similarity::identity()), (rig.true_right(), rig.true_right_from_left)];
    let seen = [
        rasterize(&lamps.mesh, &cameras[0].0, &cameras[0].1, size)?,
        rasterize(&lamps.mesh, &cameras[1].0, &cameras[1].1, size)?,
    ];
    let is_face = |corners: &[u32; 3]| {
        subject.face.is_none_or(|face| corners.iter().all(|&i| face[i as usize]))
    };
    let face = Raster::from_fn(size.0, size.1, |x, y| {
        let hit = seen[0].face.at(x, y) as usize;
        hit < lamps.subject_faces && is_face(&lamps.mesh.faces[hit])
    });
    let depth_mm = Raster::from_fn(size.0, size.1, |x, y| {
        let on = (seen[0].face.at(x, y) as usize) < lamps.subject_faces;
        if on { seen[0].depth_mm.at(x, y) } else { f32::NAN }
    });
    let count = subject.mesh.vertices.len();
    let mesh = subject.mesh.with_vertices(lamps.mesh.vertices[..count].to_vec());

    let look = |point: Vec3| -> ([Vec2; 2], [bool; 2]) {
        let mut pixel = [Vec2::repeat(f64::NAN); 2];
        let mut visible = [false; 2];
        for side in 0..2 {
            let (camera, camera_from_left) = &cameras[side];
            let here = camera_from_left.apply(&point);
            if let Some(p) = camera.project(&here) {
                pixel[side] = p;
                visible[side] = is_seen(&seen[side], &lamps.mesh, camera, camera_from_left, &here);
            }
        }
        (pixel, visible)
    };
    let (columns, rows) = (params.pattern.columns, params.pattern.rows);
    // the projector as a camera with one pixel a dot: its rays are the dots
    let falls = rasterize(&lamps.mesh, &rig.lattice, &rig.projector_from_left, (columns, rows))?;
    let dots = (0..columns * rows)
        .into_par_iter()
        .map(|i| {
            let (column, row) = (i % columns, i / columns);
            let face = falls.face.at(column, row) as usize;
            let mut dot = DotTruth {
                column,
                row,
                lit: face < lamps.subject_faces,
                on_face: false,
                point: Vec3::repeat(f64::NAN),
                pixel: [Vec2::repeat(f64::NAN); 2],
                visible: [false; 2],
            };
            if dot.lit {
                let w = falls.barycentric.at(column, row);
                let corners = lamps.mesh.corners(face);
                dot.point = (0..3).map(|k| corners[k] * f64::from(w[k])).sum();
                (dot.pixel, dot.visible) = look(dot.point);
                let corners = lamps.mesh.faces[face];
                dot.on_face =
                    subject.face.is_none_or(|mask| corners.iter().all(|c| mask[*c as usize]));
            }
            dot
        })
        .collect();
    let mut features = LandmarkPairs::new();
    let mut feature_points = BTreeMap::new();
    for (name, vertex) in subject.landmarks.into_iter().flatten() {
        let point = mesh.vertices[*vertex];
        let [left, right] = look(point).0;
        features.insert(name.clone(), Pair { left, right });
        feature_points.insert(name.clone(), point);
    }
    let true_rig = StereoRig {
        right: rig.true_right(),
        right_from_left: rig.true_right_from_left,
        ..rig.told
    };
    // the lamps hold the subject where it was photographed
    let camera_from_model = rig.camera_from_model(subject.mesh, params);
    Ok(Truth {
        mesh,
        camera_from_model,
        rig: true_rig,
        depth_mm,
        face,
        dots,
        features,
        feature_points,
        plain_from_dots: plain_from_dots.unwrap_or_else(Similarity::identity),
    })
}

/// Whether a camera sees a point of the surface: one of the four faces drawn around its pixel,
/// continued as a plane, passes through it.
fn is_seen(
    buffers: &Buffers,
    mesh: &Mesh,
    camera: &Pinhole,
    camera_from_left: &Similarity,
    point: &Vec3,
) -> bool {
    let Some(pixel) = camera.project(point) else { return false };
    let (width, height) = buffers.face.size();
    let inside = pixel.x >= -0.5
        && pixel.y >= -0.5
        && pixel.x <= width as f64 - 0.5
        && pixel.y <= height as f64 - 0.5;
    if !inside {
        return false;
    }
    let (x0, y0) = (pixel.x.floor() as isize, pixel.y.floor() as isize);
    [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|(dx, dy)| {
        let face = buffers.face.get(x0 + dx, y0 + dy).unwrap_or(NO_FACE);
        if face == NO_FACE {
            return false;
        }
        let [a, b, c] = mesh.corners(face as usize).map(|v| camera_from_left.apply(&v));
        let normal = (b - a).cross(&(c - a));
        let along = normal.dot(point);
        // the plane is met at `point * t`
        along.abs() > 1e-12 * normal.norm() * point.norm()
            && ((normal.dot(&a) / along - 1.0) * point.z).abs() < VISIBLE_MM
    })
}

impl Truth {
    /// The three dots that the thesis has marked by hand (section 2.3): one on the nose saddle or
    /// forehead and one on each ear, all seen by both cameras. `None` without landmarks.
    pub fn seeds(&self) -> Option<Seeds> {
        let near = |names: &[&str]| {
            let points: Vec<&Vec3> =
                names.iter().filter_map(|n| self.feature_points.get(*n)).collect();
            let target = points.iter().copied().sum::<Vec3>() / points.len().max(1) as f64;
            let candidates = self.dots.iter().filter(|d| d.lit && d.visible == [true; 2]);
            let best = candidates
                .min_by(|a, b| (a.point - target).norm().total_cmp(&(b.point - target).norm()))?;
            (!points.is_empty() && (best.point - target).norm() < 30.0)
                .then_some(Pair { left: best.pixel[0], right: best.pixel[1] })
        };
        Some(Seeds {
            head: near(&["forehead"])?,
            left_ear: near(&["ear_left_upper", "ear_left_lower"])?,
            right_ear: near(&["ear_right_upper", "ear_right_lower"])?,
        })
    }
}
