//! The shape of the face: the template deformed to the points, or the measured surface itself.

use super::inputs;
use super::measured::{Measured, Points};
use super::run::Run;
use crate::data::{CloudFrame, Landmarks, Mesh};
use crate::math::{Mat3, Similarity, Vec2, Vec3, median};
use crate::observer::{Artifact, Observer};
use crate::pipeline::Error;
use crate::pipeline::Params;
use crate::spatial::SurfaceIndex;
use crate::stages::deform::{DeformInput, OutlineView, deform};
use crate::stages::register::{RegisterError, Registration};
use crate::stages::surface::{Surface, SurfaceInput, surface};
use crate::stages::triangulate::ModelUnits;
use crate::template::Template;

/// A shape in the model frame, before it is smoothed.
pub(super) struct Shape {
    pub(super) mesh: Mesh,
    pub(super) landmarks: Landmarks,
    /// Points whose bounds smoothing keeps; empty for those of the mesh.
    pub(super) reference: Vec<Vec3>,
    /// Numbers of the matches that lie on it.
    pub(super) on_mesh: Vec<usize>,
    /// `None` where the points did not come to the generic head.
    pub(super) registration: Option<Registration>,
    pub(super) model_from_camera: Similarity,
}

/// The template, deformed to the registered points.
pub(super) fn deformed(
    run: &Run<'_>,
    template: &Template,
    points: &Points,
    pose: Registration,
    metric: bool,
    params: &Params,
) -> Result<Shape, Error> {
    let (head, model_from_camera) = inputs::to_scale(template, &pose, metric);
    let registered = points.all.transformed(&model_from_camera);
    run.artifact("register", "head", Artifact::Mesh(&head));
    run.artifact("register", "cloud", Artifact::Points(&registered.points));
    let mut landmarks = inputs::landmark_targets(&points.landmarks, template, &model_from_camera);
    landmarks.extend(inputs::landmark_targets(&points.expected, template, &model_from_camera));
    let camera_from_model = model_from_camera.inverse();
    let outlines: Vec<_> = (points.outlines.iter())
        .map(|o| OutlineView {
            camera: o.camera,
            camera_from_mesh: o.camera_from_points.compose(&camera_from_model),
            outline: &o.outline,
        })
        .collect();
    let input = DeformInput {
        template: &head,
        data: &registered,
        assignments: &inputs::assignments(&pose, &points.dots, &head, &model_from_camera),
        landmarks: &landmarks,
        outlines: &outlines,
    };
    let fitted = run.stage("deform", |o| deform(&input, &params.deform, o))?;
    run.artifact("deform", "mesh", Artifact::Mesh(&fitted.mesh));
    Ok(Shape {
        mesh: fitted.mesh,
        landmarks: template.landmarks.clone(),
        reference: input.assignments.iter().map(|a| a.1).collect(),
        on_mesh: pose.inliers.clone(),
        registration: Some(pose),
        model_from_camera,
    })
}

/// The measured surface in the frame of the points.
fn mesh_surface(
    measured: &Measured<'_>,
    template: &Template,
    on_subject: &[usize],
    params: &Params,
    observer: &dyn Observer,
) -> Result<Surface, Error> {
    let middle = |p: Vec2, d: f64| p - Vec2::new(0.5 * d, 0.0);
    let units = match measured.rig {
        None => Some(ModelUnits::new(measured.all_matches, &template.mesh)?),
        Some(_) => None,
    };
    let input = SurfaceInput {
        disparity: measured.dense.map(|d| &d.disparity),
        matches: measured.matches,
        on_subject,
        unproject: &|p, d| match (measured.rig, &units) {
            (Some(rig), _) => rig.point(p, d),
            (None, units) => units.as_ref()?.point(middle(p, d), d),
        },
    };
    Ok(surface(&input, &params.surface, observer)?)
}

/// The measured surface. Without a registration it is in the camera frame, turned to the viewer.
pub(super) fn measured(
    run: &Run<'_>,
    template: &Template,
    points: &Points,
    pose: Result<Registration, Error>,
    measured: &Measured<'_>,
    params: &Params,
) -> Result<Shape, Error> {
    let pose = match pose {
        Ok(pose) => Some(pose),
        Err(error) if error.stage_error::<RegisterError>().is_some() && !error.is_cancelled() => {
            run.warn(
                "register",
                &format!(
                    "the surface is not in the model frame: it faces the viewer as the left camera \
                     sees it, with its centre at the origin ({error})"
                ),
            );
            None
        }
        Err(error) => return Err(error),
    };
    let metric = measured.frame.is_metric();
    let on_subject = pose.as_ref().map_or(&[][..], |p| &p.inliers);
    let found =
        run.stage("surface", |o| mesh_surface(measured, template, on_subject, params, o))?;
    let model_from_camera = match &pose {
        Some(pose) => inputs::to_scale(template, pose, metric).1,
        None if measured.frame != CloudFrame::Model => turned_to_viewer(&found.mesh),
        // model units lie about the generic head already
        None => Similarity::identity(),
    };
    let mesh = found.mesh.transformed(&model_from_camera);
    let dots = points.dots.transformed(&model_from_camera);
    Ok(Shape {
        on_mesh: near_mesh(&dots.points, &mesh),
        mesh,
        landmarks: Landmarks::default(),
        reference: Vec::new(),
        registration: pose,
        model_from_camera,
    })
}

/// The camera's axes (y down, z away) turned to the model's, the mesh's middle at the origin.
fn turned_to_viewer(mesh: &Mesh) -> Similarity {
    let turn = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
    let middle = mesh.bounds().map_or(Vec3::zeros(), |(low, high)| (low + high) / 2.0);
    Similarity::rigid(turn, -(turn * middle))
}

/// Numbers of the points within three edges' length of a mesh.
fn near_mesh(points: &[Vec3], mesh: &Mesh) -> Vec<usize> {
    let edges: Vec<f64> = (0..mesh.faces.len())
        .map(|face| mesh.corners(face))
        .map(|[a, b, _]| (b - a).norm())
        .collect();
    let reach = 3.0 * median(&edges).unwrap_or(0.0);
    let index = SurfaceIndex::new(mesh);
    let close = |p: &Vec3| index.as_ref().is_some_and(|i| i.closest_within(p, reach).is_some());
    (0..points.len()).filter(|&i| close(&points[i])).collect()
}
