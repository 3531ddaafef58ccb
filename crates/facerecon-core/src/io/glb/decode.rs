//! Reading the meshes of a GLB file's scene.

use nalgebra::{Matrix4, UnitQuaternion};
use serde_json::Value;

use super::accessor::{Rows, rows};
use super::constants::{MEASURED_ATTRIBUTE, MM_PER_METRE, SIGMA_ATTRIBUTE, TRIANGLES};
use super::container::{Container, chunks, list, number};
use super::srgb::from_linear;
use crate::data::{Mesh, Rgb};
use crate::io::error::Fault;
use crate::io::image::{ImageFault, decode_photo};
use crate::io::loaded_mesh::LoadedMesh;
use crate::io::unit::LengthUnit;
use crate::math::Vec3;

/// Deepest nesting of nodes; also ends circles.
const MAX_DEPTH: usize = 32;
/// Most nodes; a scan has a handful.
const MAX_NODES: usize = 10_000;
/// Most vertices of all meshes together; a small file may name a large buffer many times.
const MAX_VERTICES: usize = 20_000_000;

/// Reads the bytes of a GLB file: the triangles of its scene as one mesh in millimetres, with the
/// first base-colour texture (PNG or JPEG) that is inside.
///
/// # Errors
/// [`Fault`] with what is wrong.
pub(in crate::io) fn decode(bytes: &[u8]) -> Result<LoadedMesh, Fault> {
    let (json, binary) = chunks(bytes)?;
    let root: Value = serde_json::from_slice(json)
        .map_err(|e| Fault::new(format!("the GLB's JSON is damaged: {e}")))?;
    if let Some(required) = list(&root, "extensionsRequired").first() {
        return Err(Fault::new(format!(
            "the GLB needs the extension {required}, which is not supported; export it without \
             compression"
        )));
    }
    let file = Container { root: &root, binary };
    let mut reader = Reader { file: &file, out: LoadedMesh::default(), nodes: 0, material: None };
    reader.scene()?;
    let texture = file.texture(reader.material);
    Ok(finish(reader.out, texture))
}

/// Keeps texture coordinates, colours and texture only where all meshes have them.
fn finish(mut out: LoadedMesh, texture: Option<Result<Rgb, Fault>>) -> LoadedMesh {
    if out.mesh.face_uvs.len() != out.mesh.faces.len() {
        if !out.mesh.face_uvs.is_empty() {
            out.warnings.push(
                "some meshes have no texture coordinates; all texture coordinates are ignored"
                    .into(),
            );
        }
        out.mesh.uvs.clear();
        out.mesh.face_uvs.clear();
    }
    if out.mesh.colors.len() != out.mesh.vertices.len() {
        out.mesh.colors.clear();
    }
    if !out.mesh.has_uncertainty() {
        out.mesh.sigmas.clear();
        out.mesh.measured.clear();
    }
    match texture {
        Some(Ok(image)) if out.mesh.has_uv() => out.texture = Some(image),
        Some(Err(e)) => out.warnings.push(format!("the texture is not read: {}", e.message)),
        _ => {}
    }
    out.unit = Some(LengthUnit::Millimetre);
    out
}

struct Reader<'a> {
    file: &'a Container<'a>,
    out: LoadedMesh,
    /// Nodes visited.
    nodes: usize,
    /// The first material that a primitive names.
    material: Option<usize>,
}

impl Reader<'_> {
    /// Reads the default scene, or all meshes of a file without scenes.
    fn scene(&mut self) -> Result<(), Fault> {
        let root = self.file.root;
        let scene = list(root, "scenes").get(number(&root["scene"]).unwrap_or(0));
        match scene.map(|s| list(s, "nodes")) {
            Some(nodes) => nodes.iter().try_for_each(|n| self.node(n, &Matrix4::identity(), 0)),
            None => {
                let count = list(root, "meshes").len();
                (0..count).try_for_each(|mesh| self.mesh(mesh, &Matrix4::identity()))
            }
        }
    }

    fn node(&mut self, index: &Value, parent: &Matrix4<f64>, depth: usize) -> Result<(), Fault> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(Fault::new("the GLB's nodes are nested too deeply or in a circle"));
        }
        let root = self.file.root;
        let Some(node) = number(index).and_then(|i| list(root, "nodes").get(i)) else {
            return Err(Fault::new(format!("the GLB names node {index}, which does not exist")));
        };
        let matrix = parent * local(node);
        if let Some(mesh) = number(&node["mesh"]) {
            self.mesh(mesh, &matrix)?;
        }
        list(node, "children").iter().try_for_each(|child| self.node(child, &matrix, depth + 1))
    }

    fn mesh(&mut self, index: usize, matrix: &Matrix4<f64>) -> Result<(), Fault> {
        let root = self.file.root;
        let Some(mesh) = list(root, "meshes").get(index) else {
            return Err(Fault::new(format!("the GLB names mesh {index}, which does not exist")));
        };
        for primitive in list(mesh, "primitives") {
            if number(&primitive["mode"]).unwrap_or(TRIANGLES) != TRIANGLES {
                self.out.warnings.push("strips, fans, lines and points are not read".into());
                continue;
            }
            self.primitive(primitive, matrix)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Value, matrix: &Matrix4<f64>) -> Result<(), Fault> {
        let attributes = &primitive["attributes"];
        let positions = rows(self.file, &attributes["POSITION"], 3, "positions")?;
        let count = positions.values.len() / 3;
        if self.out.mesh.vertices.len() + count > MAX_VERTICES {
            return Err(Fault::new(format!(
                "the GLB has more than {MAX_VERTICES} vertices; simplify the mesh"
            )));
        }
        let faces = self.faces(&primitive["indices"], count)?;
        let optional = |name: &str, least: usize, what: &str| match &attributes[name] {
            Value::Null => Ok(None),
            accessor => rows(self.file, accessor, least, what).map(Some),
        };
        let uvs = optional("TEXCOORD_0", 2, "texture coordinates")?;
        let colors = optional("COLOR_0", 3, "colours")?;
        let sigmas = optional(SIGMA_ATTRIBUTE, 1, "standard deviations")?;
        let measured = optional(MEASURED_ATTRIBUTE, 1, "measured flags")?;
        if self.material.is_none() {
            self.material = number(&primitive["material"]);
        }
        let complete = |rows: &Rows| rows.values.len() / rows.width == count;
        let mesh = &mut self.out.mesh;
        add_geometry(mesh, &positions, &faces, matrix);
        if let Some(uvs) = uvs.filter(complete) {
            let first = mesh.uvs.len() as u32;
            mesh.uvs.extend(uvs.values.chunks_exact(uvs.width).map(|uv| [uv[0], 1.0 - uv[1]]));
            mesh.face_uvs.extend(faces.iter().map(|f| f.map(|i| i + first)));
        }
        if let Some(colors) = colors.filter(complete) {
            let rgb = |c: &[f64]| [from_linear(c[0]), from_linear(c[1]), from_linear(c[2])];
            mesh.colors.extend(colors.values.chunks_exact(colors.width).map(rgb));
        }
        let is_sigma = |rows: &Rows| rows.values.iter().all(|s| s.is_finite() && *s >= 0.0);
        if let Some(sigmas) = sigmas.filter(complete).filter(is_sigma) {
            mesh.sigmas.extend(sigmas.values.chunks_exact(sigmas.width).map(|s| s[0]));
        }
        if let Some(flags) = measured.filter(complete) {
            mesh.measured.extend(flags.values.chunks_exact(flags.width).map(|f| f[0] > 0.5));
        }
        Ok(())
    }

    /// The triangles of a primitive with `count` vertices.
    fn faces(&self, indices: &Value, count: usize) -> Result<Vec<[u32; 3]>, Fault> {
        if indices.is_null() {
            return Ok((0..count as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect());
        }
        let indices = rows(self.file, indices, 1, "indices")?;
        let inside = |v: f64| (v < count as f64).then_some(v as u32);
        indices
            .values
            .chunks_exact(3)
            .map(|f| Some([inside(f[0])?, inside(f[1])?, inside(f[2])?]))
            .collect::<Option<_>>()
            .ok_or_else(|| {
                Fault::new(format!("the GLB's triangles name vertices beyond the last of {count}"))
            })
    }
}

fn add_geometry(mesh: &mut Mesh, positions: &Rows, faces: &[[u32; 3]], matrix: &Matrix4<f64>) {
    let offset = mesh.vertices.len() as u32;
    let moved = positions.values.chunks_exact(3).map(|p| {
        matrix.transform_point(&nalgebra::Point3::new(p[0], p[1], p[2])).coords * MM_PER_METRE
    });
    // Inverting the writer's scale leaves a rounding error in 64 bit; rounding to the 32 bit of the
    // file removes it.
    mesh.vertices.extend(moved.map(|p: Vec3| p.map(|c| f64::from(c as f32))));
    mesh.faces.extend(faces.iter().map(|f| f.map(|i| i + offset)));
}

impl Container<'_> {
    /// The base-colour texture of a material.
    fn texture(&self, material: Option<usize>) -> Option<Result<Rgb, Fault>> {
        let at = |name: &str, i: usize| list(self.root, name).get(i);
        let material = at("materials", material?)?;
        let texture = &material["pbrMetallicRoughness"]["baseColorTexture"]["index"];
        let texture = at("textures", number(texture)?)?;
        let image = at("images", number(&texture["source"])?)?;
        let Some(view) = number(&image["bufferView"]).and_then(|i| at("bufferViews", i)) else {
            return Some(Err(Fault::new("it is in another file")));
        };
        let Some(bytes) = self.view(view) else {
            return Some(Err(Fault::new("its bytes are beyond the end of the file")));
        };
        Some(decode_photo(bytes).map(|p| p.rgb).map_err(ImageFault::into_fault))
    }
}

/// A node's own transform.
fn local(node: &Value) -> Matrix4<f64> {
    if let Some(matrix) = floats::<16>(&node["matrix"]) {
        return Matrix4::from_column_slice(&matrix);
    }
    let [tx, ty, tz] = floats(&node["translation"]).unwrap_or_default();
    let [x, y, z, w] = floats(&node["rotation"]).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale: [f64; 3] = floats(&node["scale"]).unwrap_or([1.0; 3]);
    let rotation =
        UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-9).unwrap_or_default();
    Matrix4::new_translation(&Vec3::new(tx, ty, tz))
        * rotation.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&Vec3::from(scale))
}

fn floats<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let values: Vec<f64> = value.as_array()?.iter().map(Value::as_f64).collect::<Option<_>>()?;
    values.try_into().ok()
}
