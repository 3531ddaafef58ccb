//! Unit, vertices to keep and landmarks of well known templates. Users bring the meshes themselves.

use crate::io::LengthUnit;

/// A known template.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Name on the command line.
    pub name: &'static str,
    /// Full name, origin and licence.
    pub title: &'static str,
    /// Unit of its files.
    pub unit: LengthUnit,
    /// Vertex counts of its files.
    pub vertices: &'static [usize],
    /// Ranges of vertices that are kept, ends included; empty keeps all.
    pub keep: &'static [[usize; 2]],
    /// Only vertices less than this below the highest one are kept, mm.
    pub top_mm: Option<f64>,
    /// Vertices of landmarks in the file, counted from 0: fewer than 18 for a mesh without ears, none if
    /// they are not known.
    pub landmarks: &'static [(&'static str, usize)],
    /// A remark for the user.
    pub note: &'static str,
}

/// All presets.
pub const PRESETS: [Preset; 8] = [
    Preset {
        name: "ict",
        title: "ICT-FaceKit light, USC ICT (MIT licence), generic_neutral_mesh.obj",
        unit: LengthUnit::Centimetre,
        vertices: &[26_719],
        keep: &[[0, 11_247]],
        top_mm: None,
        landmarks: &[
            ("eye_left_outer", 1507),
            ("eye_left_inner", 1528),
            ("eye_right_inner", 3742),
            ("eye_right_outer", 3721),
            ("ear_left_upper", 8155),
            ("ear_left_lower", 7846),
            ("ear_right_upper", 7428),
            ("ear_right_lower", 7119),
            ("mouth_left", 5708),
            ("mouth_right", 6213),
            ("mouth_up", 0),
            ("mouth_down", 5518),
            ("ala_left", 4852),
            ("ala_right", 5311),
            ("nose_saddle", 1358),
            ("nose_tip", 4857),
            ("chin", 962),
            ("forehead", 973),
        ],
        note: "face, head and neck are kept; eyeballs, teeth, lashes and the other parts are left out",
    },
    Preset {
        name: "mediapipe",
        title: "MediaPipe canonical face model (Apache-2.0), canonical_face_model.obj",
        unit: LengthUnit::Centimetre,
        vertices: &[468],
        keep: &[],
        top_mm: None,
        landmarks: &[
            ("eye_left_outer", 33),
            ("eye_left_inner", 133),
            ("eye_right_inner", 362),
            ("eye_right_outer", 263),
            ("mouth_left", 61),
            ("mouth_right", 291),
            ("mouth_up", 0),
            ("mouth_down", 17),
            ("ala_left", 48),
            ("ala_right", 278),
            ("nose_saddle", 168),
            ("nose_tip", 4),
            ("chin", 199),
            ("forehead", 10),
        ],
        note: "a mask of 468 vertices without ears: coarse; vertex indices are those of MediaPipe",
    },
    Preset {
        name: "meshmonk",
        title: "MeshMonk face template (Apache-2.0), Template.obj",
        unit: LengthUnit::Millimetre,
        vertices: &[7_160],
        keep: &[],
        top_mm: None,
        landmarks: &[
            ("eye_left_outer", 1290),
            ("eye_left_inner", 2544),
            ("eye_right_inner", 4615),
            ("eye_right_outer", 5869),
            ("mouth_left", 2244),
            ("mouth_right", 4915),
            ("mouth_up", 3572),
            ("mouth_down", 3561),
            ("ala_left", 2622),
            ("ala_right", 4537),
            ("nose_saddle", 3610),
            ("nose_tip", 3589),
            ("chin", 3546),
            ("forehead", 3632),
        ],
        note: "a mask without ears",
    },
    Preset {
        name: "flame",
        title: "FLAME, MPI for Intelligent Systems (research licence; 2023 Open: CC BY)",
        unit: LengthUnit::Metre,
        vertices: &[5_023],
        keep: &[[0, 3_930]],
        top_mm: None,
        landmarks: &[],
        note: "the skin is kept, the two eyeballs (3931 to 5022) are left out; mark the landmarks in a NAME.landmarks.toml",
    },
    Preset {
        name: "bfm2009",
        title: "Basel Face Model 2009, University of Basel (research licence)",
        unit: LengthUnit::Micrometre,
        vertices: &[53_490],
        keep: &[],
        top_mm: None,
        landmarks: &[],
        note: "mark the landmarks in a NAME.landmarks.toml",
    },
    Preset {
        name: "bfm2017",
        title: "Basel Face Model 2017, University of Basel (research licence)",
        unit: LengthUnit::Millimetre,
        vertices: &[53_149, 28_588],
        keep: &[],
        top_mm: None,
        landmarks: &[],
        note: "whole (53149 vertices) or face12 (28588); mark the landmarks in a NAME.landmarks.toml",
    },
    Preset {
        name: "surrey",
        title: "Surrey Face Model (non-commercial licence)",
        unit: LengthUnit::Millimetre,
        vertices: &[845, 3_448],
        keep: &[],
        top_mm: None,
        landmarks: &[],
        note: "mark the landmarks in a NAME.landmarks.toml",
    },
    Preset {
        name: "makehuman",
        title: "MakeHuman base mesh (CC0), base.obj",
        unit: LengthUnit::Decimetre,
        vertices: &[19_158, 13_380],
        keep: &[[0, 13_379]],
        top_mm: Some(320.0),
        landmarks: &[],
        note: "the uppermost 320 mm of the body are kept; mark the landmarks in a NAME.landmarks.toml",
    },
];

/// The preset of a name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|p| p.name == name.to_lowercase())
}

/// The presets whose files have this many vertices.
pub fn presets_with(vertices: usize) -> impl Iterator<Item = &'static Preset> {
    PRESETS.iter().filter(move |p| p.vertices.contains(&vertices))
}
