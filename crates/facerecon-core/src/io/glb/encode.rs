//! The bytes of a GLB file.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::constants::{
    ARRAY_BUFFER, BINARY_CHUNK, CHUNK_HEADER_BYTES, CLAMP_TO_EDGE, ELEMENT_ARRAY_BUFFER, FLOAT,
    HEADER_BYTES, JSON_CHUNK, LINEAR, LINEAR_MIPMAP_LINEAR, MAGIC, MEASURED_ATTRIBUTE,
    METRES_PER_MM, SIGMA_ATTRIBUTE, UNSIGNED_BYTE, UNSIGNED_INT, VERSION,
};
use super::srgb::to_linear;
use crate::data::Mesh;
use crate::math::Vec3;

/// Roughness of the material: skin is dull; it only affects how viewers shade the mesh.
const ROUGHNESS: f64 = 0.9;

/// The bytes of a GLB file of a valid mesh in millimetres, with an encoded PNG as its texture. glTF
/// has one index per corner, so that a vertex on a seam of the texture is repeated; otherwise the
/// order is that of the mesh.
pub fn encode(mesh: &Mesh, texture_png: Option<&[u8]>) -> Vec<u8> {
    let (corners, faces) = split_seams(mesh);
    let mut buffers = Buffers::default();
    let mut attributes = geometry(mesh, &corners, &mut buffers);
    if mesh.has_uv() {
        attributes["TEXCOORD_0"] = json!(texture_coordinates(mesh, &corners, &mut buffers));
    }
    if !mesh.colors.is_empty() && texture_png.is_none() {
        attributes["COLOR_0"] = json!(colors(mesh, &corners, &mut buffers));
    }
    if mesh.has_uncertainty() {
        let [sigma, measured] = uncertainty(mesh, &corners, &mut buffers);
        attributes[SIGMA_ATTRIBUTE] = json!(sigma);
        attributes[MEASURED_ATTRIBUTE] = json!(measured);
    }
    let indices = triangles(&faces, &mut buffers);
    let scale = [METRES_PER_MM; 3];
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "facerecon" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "face", "mesh": 0, "scale": scale }],
        "meshes": [{ "name": "face", "primitives": [
            { "attributes": attributes, "indices": indices, "material": 0 }
        ]}],
    });
    add_material(&mut root, texture_png, &mut buffers);
    root["buffers"] = json!([{ "byteLength": buffers.bytes.len() }]);
    root["bufferViews"] = Value::Array(buffers.views);
    root["accessors"] = Value::Array(buffers.accessors);
    container(root.to_string().into_bytes(), &buffers.bytes)
}

/// The binary chunk and its description.
#[derive(Default)]
struct Buffers {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffers {
    /// Adds a view; each begins at a multiple of four bytes. Returns its index.
    fn view(&mut self, data: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": data.len()
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor and returns its index.
    fn accessor(&mut self, view: usize, component: u32, kind: &str, count: usize) -> usize {
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count
        }));
        self.accessors.len() - 1
    }

    /// Adds rows of numbers and returns the index of their accessor.
    fn floats<const N: usize>(&mut self, data: &[[f32; N]], kind: &str) -> usize {
        let bytes: Vec<u8> = data.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        self.accessor(view, FLOAT, kind, data.len())
    }
}

/// Positions with their bounds, and normals.
fn geometry(mesh: &Mesh, corners: &[Corner], buffers: &mut Buffers) -> Value {
    let single = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
    let positions: Vec<[f32; 3]> =
        corners.iter().map(|&(v, _)| single(mesh.vertices[v as usize])).collect();
    let position = buffers.floats(&positions, "VEC3");
    let bound = |pick: fn(f32, f32) -> f32, start: f32| {
        positions.iter().fold([start; 3], |m, p| [0, 1, 2].map(|k| pick(m[k], p[k])))
    };
    buffers.accessors[position]["min"] = json!(bound(f32::min, f32::INFINITY));
    buffers.accessors[position]["max"] = json!(bound(f32::max, f32::NEG_INFINITY));
    // glTF requires unit normals, also where a vertex has no area.
    let unit = |n: Vec3| if n == n * 0.0 { [0.0, 0.0, 1.0] } else { single(n) };
    let normals = mesh.vertex_normals();
    let normals: Vec<[f32; 3]> = corners.iter().map(|&(v, _)| unit(normals[v as usize])).collect();
    json!({ "POSITION": position, "NORMAL": buffers.floats(&normals, "VEC3") })
}

/// glTF counts v from the top.
fn texture_coordinates(mesh: &Mesh, corners: &[Corner], buffers: &mut Buffers) -> usize {
    let uvs: Vec<[f32; 2]> = corners
        .iter()
        .map(|&(_, k)| k.and_then(|k| mesh.uvs.get(k as usize)).copied().unwrap_or_default())
        .map(|[u, v]| [u as f32, (1.0 - v) as f32])
        .collect();
    buffers.floats(&uvs, "VEC2")
}

/// Vertex colours in linear light, opaque.
fn colors(mesh: &Mesh, corners: &[Corner], buffers: &mut Buffers) -> usize {
    let linear = |v: u8| (to_linear(f32::from(v) / 255.0) * 255.0).round() as u8;
    let bytes: Vec<u8> = corners
        .iter()
        .map(|&(v, _)| mesh.colors.get(v as usize).copied().unwrap_or_default())
        .flat_map(|[r, g, b]| [linear(r), linear(g), linear(b), 255])
        .collect();
    let view = buffers.view(&bytes, Some(ARRAY_BUFFER));
    let color = buffers.accessor(view, UNSIGNED_BYTE, "VEC4", corners.len());
    buffers.accessors[color]["normalized"] = json!(true);
    color
}

/// Standard deviations in mm, and measured flags (1 or 0). Both are 32-bit floats, which every
/// reader of custom attributes accepts.
fn uncertainty(mesh: &Mesh, corners: &[Corner], buffers: &mut Buffers) -> [usize; 2] {
    let sigma = |v: u32| mesh.sigmas.get(v as usize).map_or(0.0, |s| *s as f32);
    let measured = |v: u32| mesh.measured.get(v as usize).map_or(0.0, |m| f32::from(u8::from(*m)));
    let sigmas: Vec<[f32; 1]> = corners.iter().map(|&(v, _)| [sigma(v)]).collect();
    let flags: Vec<[f32; 1]> = corners.iter().map(|&(v, _)| [measured(v)]).collect();
    [buffers.floats(&sigmas, "SCALAR"), buffers.floats(&flags, "SCALAR")]
}

fn triangles(faces: &[[u32; 3]], buffers: &mut Buffers) -> usize {
    let bytes: Vec<u8> = faces.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    let view = buffers.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
    buffers.accessor(view, UNSIGNED_INT, "SCALAR", 3 * faces.len())
}

/// The material, and the texture where there is one.
fn add_material(root: &mut Value, texture_png: Option<&[u8]>, buffers: &mut Buffers) {
    let mut surface = json!({ "metallicFactor": 0.0, "roughnessFactor": ROUGHNESS });
    if let Some(png) = texture_png {
        let view = buffers.view(png, None);
        root["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        root["samplers"] = json!([{
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR,
            "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE
        }]);
        root["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        surface["baseColorTexture"] = json!({ "index": 0 });
    }
    root["materials"] =
        json!([{ "name": "face", "pbrMetallicRoughness": surface, "doubleSided": true }]);
}

/// A vertex of the file: vertex and texture coordinate of the mesh.
type Corner = (u32, Option<u32>);

/// The vertices of the file, those of the mesh first and in its order, and the triangles of them.
fn split_seams(mesh: &Mesh) -> (Vec<Corner>, Vec<[u32; 3]>) {
    let mut corners: Vec<Corner> = (0..mesh.vertices.len() as u32).map(|v| (v, None)).collect();
    let mut copies: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut faces = mesh.faces.clone();
    for (face, uvs) in faces.iter_mut().zip(&mesh.face_uvs) {
        for (corner, &uv) in face.iter_mut().zip(uvs) {
            let vertex = *corner;
            let first = &mut corners[vertex as usize].1;
            match *first {
                None => *first = Some(uv),
                Some(own) if own == uv => {}
                Some(_) => {
                    *corner = *copies.entry((vertex, uv)).or_insert_with(|| {
                        corners.push((vertex, Some(uv)));
                        corners.len() as u32 - 1
                    });
                }
            }
        }
    }
    (corners, faces)
}

/// Header, JSON chunk padded with blanks, binary chunk.
fn container(mut json: Vec<u8>, binary: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json.len() + binary.len();
    let mut out = Vec::with_capacity(total);
    out.extend(MAGIC);
    for word in [VERSION, total as u32, json.len() as u32] {
        out.extend(word.to_le_bytes());
    }
    out.extend(JSON_CHUNK);
    out.extend(&json);
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(BINARY_CHUNK);
    out.extend(binary);
    out
}
