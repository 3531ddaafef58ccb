//! The bytes of a GLB file.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::data::Mesh;

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Buffers and their description, growing together.
#[derive(Default)]
struct Buffers {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffers {
    /// Adds a view; each begins on a multiple of four bytes.
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

    fn accessor(&mut self, view: usize, component: u32, kind: &str, count: usize) -> usize {
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count
        }));
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, data: &[[f32; N]], kind: &str) -> usize {
        let bytes: Vec<u8> = data.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        self.accessor(view, FLOAT, kind, data.len())
    }
}

/// The bytes of a GLB file of a valid mesh in millimetres, with an encoded PNG as its texture. glTF
/// has one index a corner, so that a vertex on a seam of the texture stands there more than once;
/// otherwise the order is the mesh's.
pub fn encode(mesh: &Mesh, texture_png: Option<&[u8]>) -> Vec<u8> {
    let (corners, faces) = split_seams(mesh);
    let normals = mesh.vertex_normals();
    let mut buffers = Buffers::default();
    let single = |v: crate::math::Vec3| [v.x as f32, v.y as f32, v.z as f32];
    let positions: Vec<[f32; 3]> =
        corners.iter().map(|&(v, _)| single(mesh.vertices[v as usize])).collect();
    let position = buffers.floats(&positions, "VEC3");
    let bound = |pick: fn(f32, f32) -> f32, start: f32| {
        positions.iter().fold([start; 3], |m, p| [0, 1, 2].map(|k| pick(m[k], p[k])))
    };
    buffers.accessors[position]["min"] = json!(bound(f32::min, f32::INFINITY));
    buffers.accessors[position]["max"] = json!(bound(f32::max, f32::NEG_INFINITY));
    let upward = |n: crate::math::Vec3| if n == n * 0.0 { [0.0, 0.0, 1.0] } else { single(n) };
    let directions: Vec<[f32; 3]> =
        corners.iter().map(|&(v, _)| upward(normals[v as usize])).collect();
    let mut attributes = json!({
        "POSITION": position, "NORMAL": buffers.floats(&directions, "VEC3")
    });
    if mesh.has_uv() {
        // glTF counts v from the top.
        let uvs: Vec<[f32; 2]> = corners
            .iter()
            .map(|&(_, k)| k.and_then(|k| mesh.uvs.get(k as usize)).copied().unwrap_or_default())
            .map(|[u, v]| [u as f32, (1.0 - v) as f32])
            .collect();
        attributes["TEXCOORD_0"] = json!(buffers.floats(&uvs, "VEC2"));
    }
    if !mesh.colors.is_empty() && texture_png.is_none() {
        let linear = |c: [u8; 3]| {
            let [r, g, b] = c.map(|v| to_linear(f32::from(v) / 255.0));
            [r, g, b].map(|v| (v * 255.0).round() as u8)
        };
        let bytes: Vec<u8> = corners
            .iter()
            .map(|&(v, _)| mesh.colors.get(v as usize).copied().unwrap_or_default())
            .flat_map(|c| {
                let [r, g, b] = linear(c);
                [r, g, b, 255]
            })
            .collect();
        let view = buffers.view(&bytes, Some(ARRAY_BUFFER));
        let color = buffers.accessor(view, UNSIGNED_BYTE, "VEC4", corners.len());
        buffers.accessors[color]["normalized"] = json!(true);
        attributes["COLOR_0"] = json!(color);
    }
    let bytes: Vec<u8> = faces.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    let view = buffers.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
    let indices = buffers.accessor(view, UNSIGNED_INT, "SCALAR", 3 * faces.len());
    let mut surface = json!({ "metallicFactor": 0.0, "roughnessFactor": 0.9 });
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "facerecon" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "face", "mesh": 0, "scale": [0.001, 0.001, 0.001] }],
        "meshes": [{ "name": "face", "primitives": [
            { "attributes": attributes, "indices": indices, "material": 0 }
        ]}],
    });
    if let Some(png) = texture_png {
        let view = buffers.view(png, None);
        root["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        root["samplers"] =
            json!([{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }]);
        root["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        surface["baseColorTexture"] = json!({ "index": 0 });
    }
    root["materials"] =
        json!([{ "name": "face", "pbrMetallicRoughness": surface, "doubleSided": true }]);
    root["buffers"] = json!([{ "byteLength": buffers.bytes.len() }]);
    root["bufferViews"] = Value::Array(buffers.views);
    root["accessors"] = Value::Array(buffers.accessors);
    container(root.to_string().into_bytes(), &buffers.bytes)
}

/// A vertex of the file: vertex and texture coordinate of the mesh.
type Corner = (u32, Option<u32>);

/// The vertices of the file, the mesh's own order first, and the
/// triangles that use them.
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

/// sRGB to linear light, as glTF's vertex colours are.
fn to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Header, JSON chunk padded with blanks, binary chunk.
fn container(mut json: Vec<u8>, binary: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut out = Vec::with_capacity(total);
    out.extend(b"glTF");
    for word in [2, total as u32, json.len() as u32] {
        out.extend(word.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}
