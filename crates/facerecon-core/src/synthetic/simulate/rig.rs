//! Poses of cameras, projector and head. The origin of the rig frame is the midpoint between the
//! cameras, x right, y down, z toward the subject.

use nalgebra::Rotation3;

use super::params::SimulateParams;
use super::subject::centre;
use super::viewpoint::Viewpoint;
use crate::camera::{Distortion, Pinhole, StereoRig};
use crate::data::Mesh;
use crate::math::{Mat3, Similarity, Vec2, Vec3};
use crate::synthetic::pattern::Design;
use crate::synthetic::random::gaussian;

/// Position of the projector behind the midpoint between the cameras, mm.
const PROJECTOR_BEHIND_MM: f64 = 20.0;
/// The projector points this far behind the frontmost point of the subject, mm.
const PROJECTOR_TARGET_MM: f64 = 40.0;
/// Direction of the large light from the subject, rig frame.
const LARGE_LIGHT: [f64; 3] = [-0.55, -0.65, -0.75];
/// Cells of the wall in each direction: fine enough that lens distortion bends it.
const WALL_CELLS: u32 = 48;
/// Streams of the random numbers of the motion of the head; photos use the streams 0 to 3.
const ROTATION_STREAM: u64 = 101;
const TRANSLATION_STREAM: u64 = 102;

/// Cameras and projector.
pub(super) struct Rig {
    /// The calibrated rig: what the reconstruction is given.
    pub(super) nominal: StereoRig,
    /// The actual pose, with its deviation from the calibration.
    actual_right_from_left: Similarity,
    /// A camera in place of the projector whose pixels are the lattice points of the pattern.
    pub(super) projector: Viewpoint,
    left_from_rig: Similarity,
}

/// Rotation about an axis of any length.
fn rotation_about(axis: Vec3, degrees: f64) -> Mat3 {
    let length = axis.norm().max(1e-12);
    Rotation3::from_scaled_axis(axis * (degrees.to_radians() / length)).into_inner()
}

/// From the rig frame to the camera at `centre` whose axes, in the rig frame, are the columns of
/// `axes`.
fn camera_from_rig(axes: &Mat3, centre: Vec3) -> Similarity {
    let rotation = axes.transpose();
    Similarity::rigid(rotation, -(rotation * centre))
}

impl Rig {
    pub(super) fn new(params: &SimulateParams) -> Self {
        let half = params.baseline_mm / 2.0;
        let left_from_rig = camera_from_rig(
            &rotation_about(Vec3::y(), params.toe_in_deg),
            Vec3::new(-half, 0.0, 0.0),
        );
        let right_from_rig = camera_from_rig(
            &rotation_about(Vec3::y(), -params.toe_in_deg),
            Vec3::new(half, 0.0, 0.0),
        );
        let centre = Vec2::new(params.width_px as f64 - 1.0, params.height_px as f64 - 1.0) / 2.0;
        let camera = |focal: f64, side: f64| {
            let shift = side * params.sensor_shift * focal * half / params.distance_mm;
            let mut d = [0.0; 8];
            (d[0], d[1]) = (params.distortion_k1, params.distortion_k2);
            Pinhole {
                distortion: Distortion(d),
                ..Pinhole::ideal(focal, centre + Vec2::new(shift, 0.0))
            }
        };
        let left = camera(params.focal_px, -1.0);
        let right = camera(params.focal_px * params.focal_ratio, 1.0);
        let right_from_left = right_from_rig.compose(&left_from_rig.inverse());
        let nominal = StereoRig {
            left,
            right,
            right_from_left,
            image_size: Some((params.width_px, params.height_px)),
        };
        // Rotated after the calibration: upward, so that the photo moves down.
        let up = (params.row_offset_px / right.fy).atan().to_degrees();
        let deviation =
            rotation_about(Vec3::z(), params.row_roll_deg) * rotation_about(Vec3::x(), -up);
        let actual_right_from_left =
            Similarity::rigid(deviation, Vec3::zeros()).compose(&right_from_left);

        let place = Vec3::new(0.0, -params.projector_above_mm, -PROJECTOR_BEHIND_MM);
        let target = Vec3::new(
            params.shift_x_mm,
            params.shift_y_mm,
            params.distance_mm + PROJECTOR_TARGET_MM,
        );
        let forward = (target - place).normalize();
        let across = Vec3::y().cross(&forward).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let upright = Mat3::from_columns(&[across, forward.cross(&across), forward]);
        let axes = upright * rotation_about(Vec3::z(), params.pattern.rotation_deg);
        let projector_from_rig = camera_from_rig(&axes, place);
        let spacing = params.dot_mm / (target - place).norm();
        let lattice = Pinhole::ideal(1.0 / spacing, Design::new(&params.pattern).middle());
        let projector = Viewpoint {
            camera: lattice,
            camera_from_left: projector_from_rig.compose(&left_from_rig.inverse()),
        };
        Self { nominal, actual_right_from_left, projector, left_from_rig }
    }

    /// The left and the right camera in their actual poses.
    pub(super) fn viewpoints(&self) -> [Viewpoint; 2] {
        let StereoRig { left, right, .. } = self.nominal;
        [
            Viewpoint { camera: left, camera_from_left: Similarity::identity() },
            Viewpoint { camera: right, camera_from_left: self.actual_right_from_left },
        ]
    }

    /// The actual rig.
    pub(super) fn actual(&self) -> StereoRig {
        StereoRig { right_from_left: self.actual_right_from_left, ..self.nominal }
    }

    /// The wall behind the subject, left camera frame.
    pub(super) fn wall(&self, params: &SimulateParams) -> Mesh {
        const CELLS: u32 = WALL_CELLS;
        let z = params.distance_mm + params.wall_mm;
        let focal = params.focal_px.min(params.focal_px * params.focal_ratio);
        let view = params.width_px.max(params.height_px) as f64 / focal;
        let half = z * view + params.baseline_mm + z * params.toe_in_deg.to_radians().tan();
        let mut wall = Mesh::default();
        for y in 0..=CELLS {
            for x in 0..=CELLS {
                let at = |k: u32| (2.0 * f64::from(k) / f64::from(CELLS) - 1.0) * half;
                wall.vertices.push(self.left_from_rig.apply(&Vec3::new(at(x), at(y), z)));
            }
        }
        for y in 0..CELLS {
            for x in 0..CELLS {
                let i = y * (CELLS + 1) + x;
                wall.faces.push([i, i + CELLS + 1, i + 1]);
                wall.faces.push([i + 1, i + CELLS + 1, i + CELLS + 2]);
            }
        }
        wall
    }

    /// Direction from the subject to the large light, left camera frame.
    pub(super) fn large_light(&self) -> Vec3 {
        self.left_from_rig.rotate(&Vec3::from(LARGE_LIGHT).normalize())
    }

    /// Pose of the head when the dotted pair is taken.
    pub(super) fn camera_from_model(&self, mesh: &Mesh, params: &SimulateParams) -> Similarity {
        // Camera axes are y down and z forward; the signs follow the parameters.
        let rotation = rotation_about(Vec3::z(), params.roll_deg)
            * rotation_about(Vec3::x(), params.pitch_deg)
            * rotation_about(Vec3::y(), -params.yaw_deg)
            * Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
        let middle = centre(mesh);
        let frontmost =
            mesh.vertices.iter().map(|v| (rotation * (v - middle)).z).fold(f64::INFINITY, f64::min);
        let place = Vec3::new(params.shift_x_mm, params.shift_y_mm, params.distance_mm - frontmost);
        self.left_from_rig.compose(&Similarity::rigid(rotation, place - rotation * middle))
    }

    /// Motion of the head from the dotted pair to the plain pair, in the frame of the left camera,
    /// about the centre of the head, in a direction drawn from the seed. `None` if it does not move.
    pub(super) fn plain_from_dots(
        &self,
        camera_from_model: &Similarity,
        mesh: &Mesh,
        params: &SimulateParams,
    ) -> Option<Similarity> {
        if params.plain_motion_mm == 0.0 && params.plain_motion_deg == 0.0 {
            return None;
        }
        let direction = |stream| {
            let draw = |k| gaussian(params.seed, stream, k);
            Vec3::new(draw(0), draw(1), draw(2)).try_normalize(1e-9).unwrap_or_else(Vec3::x)
        };
        let centre = camera_from_model.apply(&centre(mesh));
        let rotation = rotation_about(direction(ROTATION_STREAM), params.plain_motion_deg);
        let shift = direction(TRANSLATION_STREAM) * params.plain_motion_mm;
        Some(Similarity::rigid(rotation, centre + shift - rotation * centre))
    }
}
