//! Named views and the camera that frames a mesh in them.

use std::str::FromStr;

use nalgebra::Rotation3;

use super::error::RenderError;
use crate::camera::Pinhole;
use crate::data::Mesh;
use crate::math::{Mat3, Similarity, Vec2, Vec3};
use crate::settings::choices;

choices! {
    /// Direction from which a picture is taken.
    pub enum View {
        /// From the front.
        Front = "front",
        /// From 35 degrees at the right of the picture: the nose points to the left.
        ThreeQuarter = "three-quarter",
        /// From 35 degrees at the left of the picture: the nose points to the right.
        ThreeQuarterRight = "three-quarter-right",
        /// From the side, the nose pointing to the left.
        Profile = "profile",
        /// From the side, the nose pointing to the right.
        ProfileRight = "profile-right",
        /// From below the chin.
        Below = "below",
        /// From above the forehead.
        Above = "above",
        /// From behind.
        Back = "back",
    }
}

choices! {
    /// Axes of a mesh.
    pub enum Frame {
        /// Model frame: x right, y up, z toward the viewer.
        Model = "model",
        /// Camera frame: x right, y down, z away from the viewer.
        Camera = "camera",
    }
}

impl View {
    /// All views.
    pub const ALL: [Self; 8] = [
        Self::Front,
        Self::ThreeQuarter,
        Self::ThreeQuarterRight,
        Self::Profile,
        Self::ProfileRight,
        Self::Below,
        Self::Above,
        Self::Back,
    ];

    /// Yaw and pitch, degrees.
    fn angles(self) -> (f64, f64) {
        match self {
            Self::Front => (0.0, 0.0),
            Self::ThreeQuarter => (-35.0, 4.0),
            Self::ThreeQuarterRight => (35.0, 4.0),
            Self::Profile => (-90.0, 0.0),
            Self::ProfileRight => (90.0, 0.0),
            Self::Below => (0.0, -42.0),
            Self::Above => (0.0, 42.0),
            Self::Back => (180.0, 0.0),
        }
    }

    /// Camera axes from the mesh's axes.
    pub(super) fn rotation(self, frame: Frame) -> Mat3 {
        let (yaw, pitch) = self.angles();
        let turn = Rotation3::from_axis_angle(&Vec3::x_axis(), pitch.to_radians())
            * Rotation3::from_axis_angle(&Vec3::y_axis(), yaw.to_radians());
        let camera_from_model = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
        let upright = camera_from_model * turn.into_inner();
        match frame {
            Frame::Model => upright,
            Frame::Camera => upright * camera_from_model,
        }
    }
}

impl FromStr for View {
    type Err = RenderError;

    fn from_str(name: &str) -> Result<Self, RenderError> {
        Self::ALL.into_iter().find(|v| v.to_string() == name).ok_or_else(|| RenderError::View {
            got: name.to_owned(),
            names: Self::ALL.map(|v| v.to_string()).join(", "),
        })
    }
}

/// Pose of a camera, and the part of its image that the mesh fills, in normalised coordinates.
pub(super) struct Framing {
    pub(super) camera_from_mesh: Similarity,
    low: Vec2,
    high: Vec2,
}

/// Free border around the mesh, as a fraction of the picture.
const BORDER: f64 = 0.05;
/// Distance of the camera in radii of the mesh; about 0.9 m for a head.
const DISTANCE: f64 = 6.0;

impl Framing {
    /// The pose from which `view` shows the whole mesh.
    pub(super) fn new(mesh: &Mesh, view: View, frame: Frame) -> Self {
        let mut used = vec![false; mesh.vertices.len()];
        for &i in mesh.faces.iter().flatten() {
            used[i as usize] = true;
        }
        let points: Vec<&Vec3> =
            mesh.vertices.iter().zip(&used).filter_map(|(v, u)| u.then_some(v)).collect();
        let mut low = Vec3::repeat(f64::INFINITY);
        let mut high = -low;
        for p in &points {
            low = low.inf(p);
            high = high.sup(p);
        }
        let centre = (low + high) / 2.0;
        let radius = ((high - low).norm() / 2.0).max(1e-9);
        let rotation = view.rotation(frame);
        let translation = Vec3::new(0.0, 0.0, DISTANCE * radius) - rotation * centre;
        let camera_from_mesh = Similarity::rigid(rotation, translation);
        let mut framing = Self {
            camera_from_mesh,
            low: Vec2::repeat(f64::INFINITY),
            high: Vec2::repeat(f64::NEG_INFINITY),
        };
        for p in points {
            let c = camera_from_mesh.apply(p);
            let n = Vec2::new(c.x / c.z, c.y / c.z);
            framing.low = framing.low.inf(&n);
            framing.high = framing.high.sup(&n);
        }
        framing
    }

    /// Largest focal length at which the mesh fits into the picture.
    pub(super) fn focal_px(&self, (width, height): (usize, usize)) -> f64 {
        let extent = (self.high - self.low).sup(&Vec2::repeat(1e-9));
        let room = 1.0 - 2.0 * BORDER;
        (room * width as f64 / extent.x).min(room * height as f64 / extent.y)
    }

    /// The camera of a focal length with the mesh in the middle of its picture.
    pub(super) fn camera(&self, focal_px: f64, (width, height): (usize, usize)) -> Pinhole {
        let middle = Vec2::new((width as f64 - 1.0) / 2.0, (height as f64 - 1.0) / 2.0);
        Pinhole::ideal(focal_px, middle - (self.low + self.high) / 2.0 * focal_px)
    }
}
