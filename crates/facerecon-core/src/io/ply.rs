//! Stanford PLY: clouds and meshes; ASCII and binary are read, binary little endian is written.

mod read;

use std::path::Path;

use super::atomic;
use super::error::IoError;
use super::image::write_png;
use crate::data::{Cloud, Mesh, Rgb};
use crate::math::Vec3;
pub(super) use read::{decode, decode_cloud};

/// The bytes of a PLY file with the points of a cloud: `x y z` (double), and where the cloud has
/// them `nx ny nz` (float), `red green blue` (uchar), and `sigma quality` (float): the standard
/// deviation in the unit of the points, and `1 / (1 + sigma)`, which viewers show as quality.
///
/// `comment` is written into the header: frame and unit of the points.
fn encode_cloud(cloud: &Cloud, comment: &str) -> Vec<u8> {
    let count = cloud.len();
    let full = |n: usize| n == count && n > 0;
    let (normals, colors, sigmas) =
        (full(cloud.normals.len()), full(cloud.colors.len()), full(cloud.sigmas.len()));
    let mut out = header(comment, count, normals, colors);
    if sigmas {
        out += "property float sigma\nproperty float quality\n";
    }
    let mut out = (out + "end_header\n").into_bytes();
    for (i, point) in cloud.points.iter().enumerate() {
        vertex(&mut out, point);
        if normals {
            for c in cloud.normals[i].iter() {
                out.extend((*c as f32).to_le_bytes());
            }
        }
        if colors {
            out.extend(cloud.colors[i]);
        }
        if sigmas {
            out.extend((cloud.sigmas[i] as f32).to_le_bytes());
            out.extend(((1.0 / (1.0 + cloud.sigmas[i])) as f32).to_le_bytes());
        }
    }
    out
}

/// The bytes of a PLY file with a mesh: `x y z` (double), colours, `sigma_mm` (float) and `measured`
/// (uchar, 0 or 1) where it has them, triangles, and for each triangle its texture coordinates
/// (`texcoord`, six floats) where it has them.
fn encode_mesh(mesh: &Mesh, comment: &str) -> Vec<u8> {
    let colors = !mesh.colors.is_empty() && mesh.colors.len() == mesh.vertices.len();
    let uvs = !mesh.face_uvs.is_empty() && mesh.face_uvs.len() == mesh.faces.len();
    let mut out = header(comment, mesh.vertices.len(), false, colors);
    let uncertainty = mesh.has_uncertainty();
    if uncertainty {
        out += "property float sigma_mm\nproperty uchar measured\n";
    }
    out += &format!("element face {}\n", mesh.faces.len());
    out += "property list uchar uint vertex_indices\n";
    if uvs {
        out += "property list uchar float texcoord\n";
    }
    let mut out = (out + "end_header\n").into_bytes();
    for (i, point) in mesh.vertices.iter().enumerate() {
        vertex(&mut out, point);
        if colors {
            out.extend(mesh.colors[i]);
        }
        if uncertainty {
            out.extend((mesh.sigmas[i] as f32).to_le_bytes());
            out.push(u8::from(mesh.measured[i]));
        }
    }
    for (i, face) in mesh.faces.iter().enumerate() {
        out.push(3);
        face.iter().for_each(|k| out.extend(k.to_le_bytes()));
        if uvs {
            out.push(6);
            for k in mesh.face_uvs[i] {
                let uv = mesh.uvs.get(k as usize).copied().unwrap_or_default();
                uv.iter().for_each(|c| out.extend((*c as f32).to_le_bytes()));
            }
        }
    }
    out
}

fn header(comment: &str, vertices: usize, normals: bool, colors: bool) -> String {
    let mut out = String::from("ply\nformat binary_little_endian 1.0\n");
    for line in comment.lines().filter(|l| !l.trim().is_empty()) {
        out += &format!("comment {line}\n");
    }
    out += &format!("element vertex {vertices}\n");
    out += "property double x\nproperty double y\nproperty double z\n";
    if normals {
        out += "property float nx\nproperty float ny\nproperty float nz\n";
    }
    if colors {
        out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    }
    out
}

fn vertex(out: &mut Vec<u8>, point: &Vec3) {
    point.iter().for_each(|c| out.extend(c.to_le_bytes()));
}

/// Writes a cloud: `x y z` (double), and where the cloud has them `nx ny nz` (float), `red green
/// blue` (uchar), and `sigma quality` (float), standard deviation and `1 / (1 + sigma)`. `comment`
/// (frame and unit of the points) is written into the header.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_cloud(path: &Path, cloud: &Cloud, comment: &str) -> Result<(), IoError> {
    atomic::write(path, &encode_cloud(cloud, comment))
}

/// Writes a mesh: `x y z` (double), colours, `sigma_mm` and `measured` where it has them, triangles
/// and their texture coordinates. A texture is written as `NAME.png` in the same folder, which the
/// header names (`comment TextureFile`).
///
/// # Errors
/// [`IoError::Write`].
pub fn write_mesh(path: &Path, mesh: &Mesh, texture: Option<&Rgb>) -> Result<(), IoError> {
    let mut comment = String::from("facerecon");
    if let Some(texture) = texture {
        let image = path.with_extension("png");
        write_png(&image, texture)?;
        let name = image.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        comment += &format!("\nTextureFile {name}");
    }
    atomic::write(path, &encode_mesh(mesh, &comment))
}

#[cfg(test)]
mod tests;
