//! Wavefront OBJ with MTL and a texture picture.
//!
//! The reader keeps the file's vertex order (templates name vertices by number), so it is our own;
//! the material file is read by `tobj`, on lines that cannot trip it.

mod material;
mod parse;

use std::fmt::Write as _;
use std::path::Path;

use super::{Fault, IoError, LoadedMesh, atomic, encode_png};
use crate::data::{Mesh, Rgb};
pub(super) use material::find_beside;

/// Reads the bytes of an OBJ file; `folder` is where its materials and textures lie.
///
/// # Errors
/// [`Fault`] with the line.
pub fn decode(bytes: &[u8], folder: &Path) -> Result<LoadedMesh, Fault> {
    let mut parsed = parse::parse(bytes)?;
    let mut warnings = std::mem::take(&mut parsed.warnings);
    let texture =
        if parsed.mesh.has_uv() { material::texture(&parsed, folder, &mut warnings) } else { None };
    Ok(LoadedMesh { mesh: parsed.mesh, texture, unit: None, warnings })
}

/// The text of an OBJ file: six digits after the point (nanometres for a mesh in millimetres).
pub fn encode(mesh: &Mesh, material_file: Option<&str>) -> String {
    // About what a vertex, a texture coordinate and a face take.
    let mut out =
        String::with_capacity(64 * (mesh.vertices.len() + mesh.uvs.len() + mesh.faces.len()));
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

/// A number with six digits after the point and no minus before zero.
struct Fixed(f64);

impl std::fmt::Display for Fixed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = if self.0.abs() < 5e-7 { 0.0 } else { self.0 };
        write!(f, "{value:.6}")
    }
}

/// Writes `NAME.obj`, and with a texture `NAME.mtl` and `NAME.png` beside it; the OBJ last, so that
/// what it names is there.
///
/// # Errors
/// [`IoError::Write`], or [`IoError::Malformed`] for a name that OBJ cannot hold.
pub fn write(path: &Path, mesh: &Mesh, texture: Option<&Rgb>) -> Result<(), IoError> {
    let Some(texture) = texture else {
        return atomic::write(path, encode(mesh, None).as_bytes());
    };
    let png = encode_png(texture).map_err(|e| e.in_file(path))?;
    let picture = path.with_extension("png");
    let name = picture.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    write_with(path, mesh, &name, &png)
}

/// Writes `NAME.obj` and `NAME.mtl` with an encoded PNG under a name of its own beside them.
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
            "an OBJ cannot name files with /, \\, # or control characters; choose another name",
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
