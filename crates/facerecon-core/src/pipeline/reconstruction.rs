//! What a run found out.

use crate::camera::Rectification;
use crate::data::{Cloud, Gray, Landmarks, Match, MeasuredLandmark, Mesh, PatternKind};
use crate::math::{Similarity, Vec3};
use crate::pipeline::{FaceVerdict, Params};
use crate::render::Frame;
use crate::stages::rectify::RowReport;
use crate::stages::register::Registration;
use crate::stages::texture::Texture;

/// Everything a run found out.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// The face: the template's topology, or the measured surface itself; model frame, millimetres
    /// when `metric`. Each vertex has a standard deviation and a measured flag.
    pub mesh: Mesh,
    /// Vertex numbers of the features on `mesh`; none on the measured surface.
    pub landmarks: Landmarks,
    /// Its colours; `None` without a pair without the pattern.
    pub texture: Option<Texture>,
    /// The measured points, camera frame in millimetres when `metric`, else model units.
    pub cloud: Cloud,
    /// The matches, in rectified pixels.
    pub matches: Vec<Match>,
    /// Landmarks that were marked or found, in the frame of `cloud`.
    pub measured_landmarks: Vec<MeasuredLandmark>,
    /// For each match its point in the frame of `cloud`; `None` where it has none.
    pub match_points: Vec<Option<Vec3>>,
    /// How photo and rectified pixels belong together.
    pub rectification: Rectification,
    /// How level the photos' rows were found.
    pub rows: RowReport,
    /// Kind of the projected pattern.
    pub pattern: PatternKind,
    /// Dots found in the left and the right photo; for stripes, the edges matched.
    pub dots: [usize; 2],
    /// Depth maps of both photos, rectified, lighter is nearer (thesis Fig. 2.5).
    pub depth: [Gray; 2],
    /// How the points came to the generic head; `None` for a measured surface that did not.
    pub registration: Option<Registration>,
    /// Model frame from the frame of `cloud`.
    pub model_from_camera: Similarity,
    /// Whether lengths are millimetres.
    pub metric: bool,
    /// Blur of one dotted photo against the other (standard deviation, in distances between dots):
    /// positive where the right photo is less sharp, negative for the left one.
    pub blur_difference: f64,
    /// Dots that lay in front of the eye sockets (glasses) and were left out.
    pub dots_before_eyes: usize,
    /// Milliseconds each stage took, in order.
    pub timings_ms: Vec<(String, f64)>,
    /// Whether the result can be trusted, and why not.
    pub verdict: FaceVerdict,
    /// What the user should know, in words.
    pub warnings: Vec<String>,
    /// The parameters it was made with.
    pub params: Params,
}

impl Reconstruction {
    /// The face in a frame.
    pub fn mesh_in(&self, frame: Frame) -> Mesh {
        match frame {
            Frame::Model => self.mesh.clone(),
            Frame::Camera => self.mesh.transformed(&self.model_from_camera.inverse()),
        }
    }
}
