//! `NAME.landmarks.toml`: unit, axes, kept vertices and landmarks of the mesh file of a template.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::data::{LANDMARKS, Landmarks, Mesh, unknown_landmark};
use crate::io::{IoError, LengthUnit, atomic, read_text};
use crate::math::{Mat3, Vec3};

/// The content of a sidecar; empty if there is no file.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Sidecar {
    pub name: Option<String>,
    pub unit: Option<LengthUnit>,
    up: Option<String>,
    front: Option<String>,
    pub keep: Vec<[usize; 2]>,
    pub top_mm: Option<f64>,
    pub landmarks: Landmarks,
}

/// Path of the sidecar of a mesh file: `NAME.landmarks.toml` in the same folder.
pub fn sidecar_path(mesh: &Path) -> PathBuf {
    mesh.with_extension("landmarks.toml")
}

impl Sidecar {
    /// Reads a sidecar and checks the names of its landmarks.
    pub(super) fn read(path: &Path) -> Result<Self, IoError> {
        if !path.exists() {
            return Ok(Self::default());
        }
        let text = read_text(path, "landmarks file")?;
        let side: Self = toml::from_str(&text).map_err(|e| IoError::Malformed {
            path: path.to_owned(),
            line: e
                .span()
                .map(|s| 1 + text.get(..s.start).unwrap_or_default().matches('\n').count()),
            message: format!(
                "{} (known keys: name, unit, up, front, keep, top_mm, [landmarks])",
                e.message()
            ),
        })?;
        if let Some(name) = side.landmarks.keys().find(|n| !LANDMARKS.contains(&n.as_str())) {
            return Err(IoError::malformed(path, unknown_landmark(name)));
        }
        Ok(side)
    }

    /// Rotates a mesh with other axes to the model frame: y up, z in front of the face.
    pub(super) fn turn(&self, mesh: &mut Mesh) -> Result<(), String> {
        let (up, front) = (self.up.as_deref().unwrap_or("y"), self.front.as_deref().unwrap_or("z"));
        let get = |name: &str, value: &str| {
            axis(value).ok_or_else(|| format!("{name} is {value:?}; set x, y, z, -x, -y or -z"))
        };
        let (u, f) = (get("up", up)?, get("front", front)?);
        if u.dot(&f) != 0.0 {
            return Err(format!(
                "up ({up}) and front ({front}) are the same axis; set different axes"
            ));
        }
        if (up, front) != ("y", "z") {
            let model_from_file =
                Mat3::from_rows(&[u.cross(&f).transpose(), u.transpose(), f.transpose()]);
            mesh.vertices.iter_mut().for_each(|v| *v = model_from_file * *v);
        }
        Ok(())
    }
}

/// The direction of an axis name such as `y` or `-z`.
fn axis(name: &str) -> Option<Vec3> {
    let (sign, name) = name.strip_prefix('-').map_or((1.0, name), |n| (-1.0, n));
    let axis = match name {
        "x" => Vec3::x(),
        "y" => Vec3::y(),
        "z" => Vec3::z(),
        _ => return None,
    };
    Some(axis * sign)
}

/// The text of a sidecar of a mesh in millimetres, whose axes `[up, front]` are such as `["y", "z"]`
/// (the model frame) or `["-y", "-z"]` (the camera frame).
pub fn landmarks_toml(name: &str, landmarks: &Landmarks, [up, front]: [&str; 2]) -> String {
    let mut out = format!(
        "# Landmarks of the mesh of the same name: vertex indices, counted from 0.\n\
         # left and right as seen by someone who faces the head.\n\
         name = {}\nunit = \"mm\"\nup = \"{up}\"\nfront = \"{front}\"\n\n[landmarks]\n",
        toml::Value::from(name)
    );
    let known = LANDMARKS.iter().filter_map(|f| landmarks.get(*f).map(|i| (f, i)));
    known.for_each(|(landmark, i)| out += &format!("{landmark} = {i}\n"));
    out
}

/// Writes the sidecar of a mesh file in millimetres and the model frame, completely or not at all; returns its path.
///
/// # Errors
/// [`IoError::Write`] if the file cannot be written.
pub fn write_landmarks(mesh: &Path, name: &str, landmarks: &Landmarks) -> Result<PathBuf, IoError> {
    let path = sidecar_path(mesh);
    atomic::write(&path, landmarks_toml(name, landmarks, ["y", "z"]).as_bytes())?;
    Ok(path)
}
