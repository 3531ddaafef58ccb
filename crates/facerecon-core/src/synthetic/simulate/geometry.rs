//! Where cameras, projector and head stand. The room's frame has its origin in the middle between
//! the cameras, x right, y down, z toward the subject.

use nalgebra::Rotation3;

use super::noise::gaussian;
use super::{SimulateParams, middle};
use crate::camera::{Distortion, Pinhole, StereoRig};
use crate::data::Mesh;
use crate::math::{Mat3, Similarity, Vec2, Vec3};
use crate::synthetic::pattern::Design;

/// Cameras and projector.
pub(super) struct Rig {
    /// As calibrated: what the reconstruction is told.
    pub(super) told: StereoRig,
    /// As it stands, faults included.
    pub(super) true_right_from_left: Similarity,
    /// The projector's own frame, from the left camera's.
    pub(super) projector_from_left: Similarity,
    /// A camera in the projector's place whose pixels are the lattice points of the pattern.
    pub(super) lattice: Pinhole,
    left_from_room: Similarity,
}

/// Rotation about an axis of any length.
fn turn(axis: Vec3, degrees: f64) -> Mat3 {
    let length = axis.norm().max(1e-12);
    Rotation3::from_scaled_axis(axis * (degrees.to_radians() / length)).into_inner()
}

/// The camera at `centre` whose axes, in the room's frame, are the columns of `axes`.
fn standing(axes: &Mat3, centre: Vec3) -> Similarity {
    let rotation = axes.transpose();
    Similarity::rigid(rotation, -(rotation * centre))
}

impl Rig {
    pub(super) fn new(params: &SimulateParams) -> Self {
        let half = params.baseline_mm / 2.0;
        let left_from_room =
            standing(&turn(Vec3::y(), params.toe_in_deg), Vec3::new(-half, 0.0, 0.0));
        let right_from_room =
            standing(&turn(Vec3::y(), -params.toe_in_deg), Vec3::new(half, 0.0, 0.0));
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
        let right_from_left = right_from_room.compose(&left_from_room.inverse());
        let told = StereoRig {
            left,
            right,
            right_from_left,
            image_size: Some((params.width_px, params.height_px)),
        };
        // a camera knocked after the calibration: it looks up, so that the picture sinks
        let up = (params.row_offset_px / right.fy).atan().to_degrees();
        let knock = turn(Vec3::z(), params.row_roll_deg) * turn(Vec3::x(), -up);
        let true_right_from_left =
            Similarity::rigid(knock, Vec3::zeros()).compose(&right_from_left);

        let place = Vec3::new(0.0, -params.projector_above_mm, -20.0);
        let target = Vec3::new(params.shift_x_mm, params.shift_y_mm, params.distance_mm + 40.0);
        let forward = (target - place).normalize();
        let across = Vec3::y().cross(&forward).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let upright = Mat3::from_columns(&[across, forward.cross(&across), forward]);
        let axes = upright * turn(Vec3::z(), params.pattern.rotation_deg);
        let projector_from_room = standing(&axes, place);
        let spacing = params.dot_mm / (target - place).norm();
        let lattice = Pinhole::ideal(1.0 / spacing, Design::new(&params.pattern).middle());
        Self {
            told,
            true_right_from_left,
            projector_from_left: projector_from_room.compose(&left_from_room.inverse()),
            lattice,
            left_from_room,
        }
    }

    /// The right camera itself; a knock turns it but does not change its lens.
    pub(super) fn true_right(&self) -> Pinhole {
        self.told.right
    }

    /// The wall behind the subject, left camera frame; cut fine, so that lens distortion bends it.
    pub(super) fn wall(&self, params: &SimulateParams) -> Mesh {
        const CELLS: u32 = 48;
        let z = params.distance_mm + params.wall_mm;
        let focal = params.focal_px.min(params.focal_px * params.focal_ratio);
        let view = params.width_px.max(params.height_px) as f64 / focal;
        let half = z * view + params.baseline_mm + z * params.toe_in_deg.to_radians().tan();
        let mut wall = Mesh::default();
        for y in 0..=CELLS {
            for x in 0..=CELLS {
                let at = |k: u32| (2.0 * f64::from(k) / f64::from(CELLS) - 1.0) * half;
                wall.vertices.push(self.left_from_room.apply(&Vec3::new(at(x), at(y), z)));
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

    /// Direction from the subject to the large lamp, left camera frame.
    pub(super) fn lamp(&self) -> Vec3 {
        self.left_from_room.rotate(&Vec3::new(-0.55, -0.65, -0.75).normalize())
    }

    /// Pose of the head when the pair with the pattern is taken.
    pub(super) fn camera_from_model(&self, mesh: &Mesh, params: &SimulateParams) -> Similarity {
        // camera axes are y down and z away: the signs below turn as the parameters say
        let rotation = turn(Vec3::z(), params.roll_deg)
            * turn(Vec3::x(), params.pitch_deg)
            * turn(Vec3::y(), -params.yaw_deg)
            * Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
        let centre = middle(mesh);
        let foremost =
            mesh.vertices.iter().map(|v| (rotation * (v - centre)).z).fold(f64::INFINITY, f64::min);
        let place = Vec3::new(params.shift_x_mm, params.shift_y_mm, params.distance_mm - foremost);
        self.left_from_room.compose(&Similarity::rigid(rotation, place - rotation * centre))
    }

    /// Motion of the head until the plain pair, in the left camera's frame, about the head's
    /// middle; in a direction drawn from the seed. `None` when it keeps still.
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
        let centre = camera_from_model.apply(&middle(mesh));
        let rotation = turn(direction(101), params.plain_motion_deg);
        let shift = direction(102) * params.plain_motion_mm;
        Some(Similarity::rigid(rotation, centre + shift - rotation * centre))
    }
}
