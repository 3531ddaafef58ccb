//! `NAME.landmarks.toml`: unit, axes, parts and features of a template's mesh file.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::axis;
use crate::data::{LANDMARKS, Landmarks, Mesh, unknown_landmark};
use crate::io::{IoError, LengthUnit, atomic, read_text};
use crate::math::Mat3;

/// What a sidecar says; a missing file says nothing.
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

/// Where the sidecar of a mesh file lies: `NAME.landmarks.toml` beside it.
pub fn sidecar_path(mesh: &Path) -> PathBuf {
    mesh.with_extension("landmarks.toml")
}

impl Sidecar {
    /// Reads a sidecar; feature names are checked.
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
                "{} (it may have name, unit, up, front, keep, top_mm and [landmarks])",
                e.message()
            ),
        })?;
        if let Some(name) = side.landmarks.keys().find(|n| !LANDMARKS.contains(&n.as_str())) {
            return Err(IoError::malformed(path, unknown_landmark(name)));
        }
        Ok(side)
    }

    /// Turns a mesh with other axes into the model frame: y up, the face looking along z.
    pub(super) fn turn(&self, mesh: &mut Mesh) -> Result<(), String> {
        let (up, front) = (self.up.as_deref().unwrap_or("y"), self.front.as_deref().unwrap_or("z"));
        let get = |name: &str, value: &str| {
            axis(value)
                .ok_or_else(|| format!("{name} is {value:?}; x, y, z, -x, -y or -z is wanted"))
        };
        let (u, f) = (get("up", up)?, get("front", front)?);
        if u.dot(&f) != 0.0 {
            return Err(format!("up ({up}) and front ({front}) must be different axes"));
        }
        if (up, front) != ("y", "z") {
            let model_from_file =
                Mat3::from_rows(&[u.cross(&f).transpose(), u.transpose(), f.transpose()]);
            mesh.vertices.iter_mut().for_each(|v| *v = model_from_file * *v);
        }
        Ok(())
    }
}

/// The text of a sidecar in millimetres.
pub fn landmarks_toml(name: &str, landmarks: &Landmarks) -> String {
    let mut out = format!(
        "# Features of the mesh beside this file: vertex numbers, counted from 0.\n\
         # left and right as seen by someone who faces the head.\n\
         name = {}\nunit = \"mm\"\nup = \"y\"\nfront = \"z\"\n\n[landmarks]\n",
        toml::Value::from(name)
    );
    let known = LANDMARKS.iter().filter_map(|f| landmarks.get(*f).map(|i| (f, i)));
    known.for_each(|(feature, i)| out += &format!("{feature} = {i}\n"));
    out
}

/// Writes the sidecar of a mesh file in millimetres, whole or not at all; returns its path.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_landmarks(mesh: &Path, name: &str, landmarks: &Landmarks) -> Result<PathBuf, IoError> {
    let path = sidecar_path(mesh);
    atomic::write(&path, landmarks_toml(name, landmarks).as_bytes())?;
    Ok(path)
}
