//! Wavefront OBJ with MTL and a texture image.
//!
//! The reader keeps the file's vertex order, since templates name vertices by number; `tobj` does
//! not. `tobj` reads the material file, after lines that it cannot read are removed.

mod material;
mod parse;

use std::fmt::Write as _;
use std::path::Path;

use super::atomic;
use super::error::{Fault, IoError};
use super::image::encode_png;
use super::loaded_mesh::LoadedMesh;
use crate::data::{Mesh, Rgb};

/// Reads the bytes of an OBJ file; `folder` has its material files and textures.
///
/// # Errors
/// [`Fault`] with the line.
pub(super) fn decode(bytes: &[u8], folder: &Path) -> Result<LoadedMesh, Fault> {
    let mut parsed = parse::parse(bytes)?;
    let mut warnings = std::mem::take(&mut parsed.warnings);
    let texture =
        if parsed.mesh.has_uv() { material::texture(&parsed, folder, &mut warnings) } else { None };
    Ok(LoadedMesh { mesh: parsed.mesh, texture, unit: None, warnings })
}

/// Average length of a line, for the capacity of the text.
const BYTES_PER_LINE: usize = 64;

/// The text of an OBJ file: six decimal places (nanometres for a mesh in millimetres).
fn encode(mesh: &Mesh, material_file: Option<&str>) -> String {
    let lines = mesh.vertices.len() + mesh.uvs.len() + mesh.faces.len();
    let mut out = String::with_capacity(BYTES_PER_LINE * lines);
    out += "# facerecon\n";
    if let Some(name) = material_file {
        let _ = write!(out, "mtllib {name}\nusemtl face\n");
    }
    for (i, v) in mesh.vertices.iter().enumerate() {
        let _ = write!(out, "v {} {} {}", Fixed(v.x), Fixed(v.y), Fixed(v.z));
        if let Some(color) = mesh.colors.get(i) {
            let [r, g, b] = color.map(|c| f64::from(c) / 255.0);
            let _ = write!(out, " {r:.4} {g:.4} {b:.4}");
        }
        out.push('\n');
    }
    for [u, v] in &mesh.uvs {
        let _ = writeln!(out, "vt {} {}", Fixed(*u), Fixed(*v));
    }
    for (i, face) in mesh.faces.iter().enumerate() {
        let [a, b, c] = face.map(|k| u64::from(k) + 1);
        let _ = match mesh.face_uvs.get(i) {
            Some(uv) => {
                let [p, q, r] = uv.map(|k| u64::from(k) + 1);
                writeln!(out, "f {a}/{p} {b}/{q} {c}/{r}")
            }
            None => writeln!(out, "f {a} {b} {c}"),
        };
    }
    out
}

/// A number with six decimal places, and no minus sign before zero.
struct Fixed(f64);

impl std::fmt::Display for Fixed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = if self.0.abs() < 5e-7 { 0.0 } else { self.0 };
        write!(f, "{value:.6}")
    }
}

/// Writes `NAME.obj`, and with a texture `NAME.mtl` and `NAME.png` in the same folder; the OBJ last,
/// so that the files it names exist.
///
/// # Errors
/// [`IoError::Write`], or [`IoError::Malformed`] for a name that OBJ cannot contain.
pub fn write(path: &Path, mesh: &Mesh, texture: Option<&Rgb>) -> Result<(), IoError> {
    let Some(texture) = texture else {
        return atomic::write(path, encode(mesh, None).as_bytes());
    };
    let png = encode_png(texture).map_err(|e| e.in_file(path))?;
    let image = path.with_extension("png");
    let name = image.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    write_with(path, mesh, &name, &png)
}

/// Writes `NAME.obj`, `NAME.mtl` and an encoded PNG named `texture_name` in the same folder.
///
/// # Errors
/// As [`write()`].
pub fn write_with(path: &Path, mesh: &Mesh, texture_name: &str, png: &[u8]) -> Result<(), IoError> {
    let material = path.with_extension("mtl");
    let name = material.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let bad = |c: char| c.is_control() || matches!(c, '/' | '\\' | '#');
    if [name.as_str(), texture_name].iter().any(|n| n.is_empty() || n.contains(bad)) {
        return Err(IoError::malformed(
            path,
            "an OBJ cannot name files with /, \\, # or control characters; choose another file name",
        ));
    }
    let text = format!(
        "# facerecon\nnewmtl face\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {texture_name}\n"
    );
    atomic::write(&path.with_file_name(texture_name), png)?;
    atomic::write(&material, text.as_bytes())?;
    atomic::write(path, encode(mesh, Some(&name)).as_bytes())
}

#[cfg(test)]
mod tests;
