//! Reading the meshes of a GLB file's scene.

use nalgebra::{Matrix4, UnitQuaternion};
use serde_json::Value;

use crate::data::{Mesh, Rgb};
use crate::io::image::decode_photo;
use crate::io::{Fault, LengthUnit, LoadedMesh};
use crate::math::Vec3;

/// Deepest nesting of nodes, and most of them: what names itself ends here.
const MAX_DEPTH: usize = 32;
const MAX_NODES: usize = 10_000;
/// Most corners all meshes together may have.
const MAX_VERTICES: usize = 20_000_000;
const MM_PER_METRE: f64 = 1000.0;

/// Reads the bytes of a GLB file: the triangles of its scene in one mesh, millimetres, with the
/// first base-colour texture (PNG or JPEG) that is inside.
///
/// # Errors
/// [`Fault`] with what is wrong.
pub fn decode(bytes: &[u8]) -> Result<LoadedMesh, Fault> {
    let (json, binary) = chunks(bytes)?;
    let root: Value = serde_json::from_slice(json)
        .map_err(|e| Fault::new(format!("the GLB's JSON is damaged: {e}")))?;
    let mut reader =
        Reader { root: &root, binary, out: LoadedMesh::default(), nodes: 0, material: None };
    if let Some(required) = list(&root, "extensionsRequired").first() {
        return Err(Fault::new(format!(
            "the GLB needs the extension {required}, which is not read; export it without compression"
        )));
    }
    let scene = &list(&root, "scenes").get(number(&root["scene"]).unwrap_or(0));
    match scene.map(|s| list(s, "nodes")) {
        Some(nodes) => {
            for node in nodes {
                reader.node(node, &Matrix4::identity(), 0)?;
            }
        }
        None => {
            for mesh in 0..list(&root, "meshes").len() {
                reader.mesh(mesh, &Matrix4::identity())?;
            }
        }
    }
    let texture = reader.texture();
    let mut out = reader.out;
    if out.mesh.face_uvs.len() != out.mesh.faces.len() {
        if !out.mesh.face_uvs.is_empty() {
            out.warnings.push("some parts have no texture coordinates; they are left out".into());
        }
        out.mesh.uvs.clear();
        out.mesh.face_uvs.clear();
    }
    if out.mesh.colors.len() != out.mesh.vertices.len() {
        out.mesh.colors.clear();
    }
    match texture {
        Some(Ok(picture)) if out.mesh.has_uv() => out.texture = Some(picture),
        Some(Err(e)) => out.warnings.push(format!("the texture is left out: {}", e.message)),
        _ => {}
    }
    out.unit = Some(LengthUnit::Millimetre);
    Ok(out)
}

/// The JSON and the binary chunk.
fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), Fault> {
    let word = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|b| <[u8; 4]>::try_from(b).ok());
        four.map(u32::from_le_bytes)
    };
    if !bytes.starts_with(b"glTF") {
        return Err(Fault::new("this is no GLB; it does not begin with \"glTF\""));
    }
    if word(4) != Some(2) {
        return Err(Fault::new(format!(
            "the GLB is version {:?}; 2 is read",
            word(4).unwrap_or(0)
        )));
    }
    let mut parts: [&[u8]; 2] = [&[], &[]];
    let mut at = 12;
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let end = at.checked_add(8).and_then(|s| s.checked_add(length as usize));
        let data = end.and_then(|end| bytes.get(at + 8..end)).ok_or_else(|| {
            Fault::new(format!("the GLB breaks off: a part of {length} bytes is not there"))
        })?;
        match &kind.to_le_bytes() {
            b"JSON" => parts[0] = data,
            b"BIN\0" => parts[1] = data,
            _ => {}
        }
        at += 8 + data.len();
    }
    Ok((parts[0], parts[1]))
}

fn list<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().map_or(&[], Vec::as_slice)
}

fn number(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|n| usize::try_from(n).ok())
}

fn floats<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let values: Vec<f64> = value.as_array()?.iter().map(Value::as_f64).collect::<Option<_>>()?;
    values.try_into().ok()
}

/// A part of the binary chunk as rows of numbers.
struct Rows {
    values: Vec<f64>,
    width: usize,
}

struct Reader<'a> {
    root: &'a Value,
    binary: &'a [u8],
    out: LoadedMesh,
    nodes: usize,
    material: Option<usize>,
}

impl Reader<'_> {
    fn node(&mut self, index: &Value, parent: &Matrix4<f64>, depth: usize) -> Result<(), Fault> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(Fault::new("the GLB's nodes are nested too deeply or in a circle"));
        }
        let root = self.root;
        let Some(node) = number(index).and_then(|i| list(root, "nodes").get(i)) else {
            return Err(Fault::new(format!("the GLB names node {index}, which is not there")));
        };
        let matrix = parent * local(node);
        if let Some(mesh) = number(&node["mesh"]) {
            self.mesh(mesh, &matrix)?;
        }
        for child in list(node, "children") {
            self.node(child, &matrix, depth + 1)?;
        }
        Ok(())
    }

    fn mesh(&mut self, index: usize, matrix: &Matrix4<f64>) -> Result<(), Fault> {
        let root = self.root;
        let Some(mesh) = list(root, "meshes").get(index) else {
            return Err(Fault::new(format!("the GLB names mesh {index}, which is not there")));
        };
        for primitive in list(mesh, "primitives") {
            if number(&primitive["mode"]).unwrap_or(4) != 4 {
                self.out.warnings.push("strips, fans, lines and points are left out".into());
                continue;
            }
            self.primitive(primitive, matrix)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Value, matrix: &Matrix4<f64>) -> Result<(), Fault> {
        let attributes = &primitive["attributes"];
        let positions = self.rows(&attributes["POSITION"], 3, "positions")?;
        let base = self.out.mesh.vertices.len();
        let count = positions.values.len() / 3;
        if base + count > MAX_VERTICES {
            return Err(Fault::new("the GLB has more vertices than can be held"));
        }
        let faces: Vec<[u32; 3]> = match &primitive["indices"] {
            Value::Null => (0..count as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
            accessor => {
                let indices = self.rows(accessor, 1, "indices")?;
                let inside = |v: f64| (v < count as f64).then_some(v as u32);
                indices
                    .values
                    .chunks_exact(3)
                    .map(|f| Some([inside(f[0])?, inside(f[1])?, inside(f[2])?]))
                    .collect::<Option<_>>()
                    .ok_or_else(|| {
                        Fault::new(format!(
                            "the GLB's triangles name vertices beyond the {count} there are"
                        ))
                    })?
            }
        };
        let uvs = match &attributes["TEXCOORD_0"] {
            Value::Null => None,
            accessor => Some(self.rows(accessor, 2, "texture coordinates")?),
        };
        let colors = match &attributes["COLOR_0"] {
            Value::Null => None,
            accessor => Some(self.rows(accessor, 3, "colours")?),
        };
        if self.material.is_none() {
            self.material = number(&primitive["material"]);
        }
        let mesh: &mut Mesh = &mut self.out.mesh;
        let moved = positions.values.chunks_exact(3).map(|p| {
            matrix.transform_point(&nalgebra::Point3::new(p[0], p[1], p[2])).coords * MM_PER_METRE
        });
        // Undoing the writer's scale leaves an error in the last digit of 64 bit: round it away, to
        // what the 32 bit of the file can hold.
        mesh.vertices.extend(moved.map(|p: Vec3| p.map(|c| f64::from(c as f32))));
        let offset = base as u32;
        mesh.faces.extend(faces.iter().map(|f| f.map(|i| i + offset)));
        if let Some(uvs) = uvs.filter(|rows| rows.values.len() / rows.width == count) {
            let first = mesh.uvs.len() as u32;
            mesh.uvs.extend(uvs.values.chunks_exact(uvs.width).map(|uv| [uv[0], 1.0 - uv[1]]));
            mesh.face_uvs.extend(faces.iter().map(|f| f.map(|i| i + first)));
        }
        if let Some(colors) = colors.filter(|rows| rows.values.len() / rows.width == count) {
            let srgb = |v: f64| {
                let v = v.clamp(0.0, 1.0);
                let v =
                    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
                (v * 255.0).round() as u8
            };
            mesh.colors.extend(
                colors
                    .values
                    .chunks_exact(colors.width)
                    .map(|c| [srgb(c[0]), srgb(c[1]), srgb(c[2])]),
            );
        }
        Ok(())
    }

    /// Reads an accessor with at least `least` numbers a row.
    fn rows(&self, accessor: &Value, least: usize, what: &str) -> Result<Rows, Fault> {
        let fault = |message: String| Fault::new(format!("the GLB's {what}: {message}"));
        let accessor = number(accessor)
            .and_then(|i| list(self.root, "accessors").get(i))
            .ok_or_else(|| fault(format!("accessor {accessor} is not there")))?;
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            other => return Err(fault(format!("the type {other:?} is not known"))),
        };
        let component = number(&accessor["componentType"]).unwrap_or(0);
        let (size, scale) = match component {
            5120 => (1, 127.0),
            5121 => (1, 255.0),
            5122 => (2, 32767.0),
            5123 => (2, 65535.0),
            5125 => (4, 1.0),
            5126 => (4, 1.0),
            other => return Err(fault(format!("the component type {other} is not known"))),
        };
        let scale = if accessor["normalized"].as_bool() == Some(true) { scale } else { 1.0 };
        if width < least || !accessor["sparse"].is_null() {
            return Err(fault(format!("{width} numbers a row (or a sparse list) cannot be read")));
        }
        let count = number(&accessor["count"]).unwrap_or(0);
        let view = number(&accessor["bufferView"])
            .and_then(|i| list(self.root, "bufferViews").get(i))
            .ok_or_else(|| fault("the buffer view is not there".into()))?;
        let data =
            self.view(view).ok_or_else(|| fault("the buffer view leaves the file".into()))?;
        let stride = number(&view["byteStride"]).unwrap_or(width * size);
        let data = number(&accessor["byteOffset"]).map_or(Some(data), |at| data.get(at..));
        let short = || fault(format!("{count} rows do not fit into the buffer"));
        let data = data.ok_or_else(short)?;
        let needed = count.checked_sub(1).map_or(Some(0), |last| {
            last.checked_mul(stride).and_then(|n| n.checked_add(width * size))
        });
        if needed.is_none_or(|n| n > data.len()) || stride < width * size {
            return Err(short());
        }
        let mut values = Vec::with_capacity(count * width);
        for row in 0..count {
            for column in 0..width {
                let at = row * stride + column * size;
                let value = component_value(component, &data[at..at + size]) / scale;
                if !value.is_finite() {
                    return Err(fault(format!("row {row} holds {value}")));
                }
                values.push(value);
            }
        }
        Ok(Rows { values, width })
    }

    fn view(&self, view: &Value) -> Option<&[u8]> {
        if number(&view["buffer"]) != Some(0) {
            return None;
        }
        let start = number(&view["byteOffset"]).unwrap_or(0);
        let length = number(&view["byteLength"])?;
        self.binary.get(start..start.checked_add(length)?)
    }

    /// The picture of the first material.
    fn texture(&self) -> Option<Result<Rgb, Fault>> {
        let at = |name: &str, i: usize| list(self.root, name).get(i);
        let material = at("materials", self.material?)?;
        let texture = &material["pbrMetallicRoughness"]["baseColorTexture"]["index"];
        let texture = at("textures", number(texture)?)?;
        let image = at("images", number(&texture["source"])?)?;
        let Some(view) = number(&image["bufferView"]).and_then(|i| at("bufferViews", i)) else {
            return Some(Err(Fault::new("it lies outside the file")));
        };
        let Some(bytes) = self.view(view) else {
            return Some(Err(Fault::new("its bytes are not in the file")));
        };
        Some(decode_photo(bytes).map(|p| p.rgb).map_err(|e| match e {
            crate::io::image::ImageFault::Content(fault) => fault,
            crate::io::image::ImageFault::Size { width, height } => {
                Fault::new(format!("{width}x{height} pixels are too many"))
            }
        }))
    }
}

fn component_value(component: usize, bytes: &[u8]) -> f64 {
    match (component, bytes) {
        (5120, &[a]) => f64::from(a as i8),
        (5121, &[a]) => f64::from(a),
        (5122, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (5123, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (5125, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (5126, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN,
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
