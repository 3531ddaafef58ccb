//! Reading PLY with `ply-rs-bw`, and the meaning of its elements.

use std::io::Cursor;
use std::path::Path;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use crate::data::{Cloud, Mesh};
use crate::io::error::Fault;
use crate::io::image::read_rgb;
use crate::io::loaded_mesh::LoadedMesh;
use crate::io::source::find_beside;
use crate::math::Vec3;

#[derive(Default)]
struct Vertex {
    position: [Option<f64>; 3],
    normal: [Option<f64>; 3],
    color: [Option<u8>; 3],
    uv: [Option<f64>; 2],
    sigma: Option<f64>,
    sigma_mm: Option<f64>,
    measured: Option<f64>,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let number = scalar(&property);
        match name {
            "x" => self.position[0] = number,
            "y" => self.position[1] = number,
            "z" => self.position[2] = number,
            "nx" => self.normal[0] = number,
            "ny" => self.normal[1] = number,
            "nz" => self.normal[2] = number,
            "red" | "diffuse_red" | "r" => self.color[0] = color(&property),
            "green" | "diffuse_green" | "g" => self.color[1] = color(&property),
            "blue" | "diffuse_blue" | "b" => self.color[2] = color(&property),
            "s" | "u" | "texture_u" | "tx" => self.uv[0] = number,
            "t" | "v" | "texture_v" | "ty" => self.uv[1] = number,
            "sigma" => self.sigma = number,
            "sigma_mm" => self.sigma_mm = number,
            "measured" => self.measured = number,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

#[derive(Default)]
struct Face {
    corners: Vec<i64>,
    uvs: Vec<f64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "vertex_indices" | "vertex_index" => self.corners = integers(property),
            "texcoord" => self.uvs = floats(property),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// An element that is ignored.
struct Other;

impl PropertyAccess for Other {
    fn new() -> Self {
        Self
    }
}

fn scalar(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(v) => f64::from(v),
        Property::UChar(v) => f64::from(v),
        Property::Short(v) => f64::from(v),
        Property::UShort(v) => f64::from(v),
        Property::Int(v) => f64::from(v),
        Property::UInt(v) => f64::from(v),
        Property::Float(v) => f64::from(v),
        Property::Double(v) => v,
        _ => return None,
    })
}

/// Colours are 0 to 255 as integers, 0 to 1 as floating-point numbers.
fn color(property: &Property) -> Option<u8> {
    let scale =
        if matches!(property, Property::Float(_) | Property::Double(_)) { 255.0 } else { 1.0 };
    scalar(property).map(|v| (v * scale).round().clamp(0.0, 255.0) as u8)
}

fn integers(property: Property) -> Vec<i64> {
    match property {
        Property::ListChar(v) => v.into_iter().map(i64::from).collect(),
        Property::ListUChar(v) => v.into_iter().map(i64::from).collect(),
        Property::ListShort(v) => v.into_iter().map(i64::from).collect(),
        Property::ListUShort(v) => v.into_iter().map(i64::from).collect(),
        Property::ListInt(v) => v.into_iter().map(i64::from).collect(),
        Property::ListUInt(v) => v.into_iter().map(i64::from).collect(),
        _ => Vec::new(),
    }
}

fn floats(property: Property) -> Vec<f64> {
    match property {
        Property::ListFloat(v) => v.into_iter().map(f64::from).collect(),
        Property::ListDouble(v) => v,
        _ => Vec::new(),
    }
}

/// Longest reason of a fault in a message, characters.
const MAX_REASON: usize = 200;

fn fault(e: ParseError) -> Fault {
    let message = e.to_string();
    // The parser's message contains the whole line of the file before the reason.
    let reason = message.rsplit("Error: ").next().unwrap_or_default();
    let first: String =
        reason.lines().next().unwrap_or_default().chars().take(MAX_REASON).collect();
    Fault { line: e.line(), message: format!("the PLY is damaged: {first}") }
}

struct Elements {
    vertices: Vec<Vertex>,
    faces: Vec<Face>,
    texture: Option<String>,
    warnings: Vec<String>,
}

fn elements(bytes: &[u8]) -> Result<Elements, Fault> {
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Vertex>::new().read_header(&mut reader).map_err(fault)?;
    let texture = header.comments.iter().find_map(|c| c.strip_prefix("TextureFile"));
    let mut out = Elements {
        vertices: Vec::new(),
        faces: Vec::new(),
        texture: texture.map(|t| t.trim().to_owned()),
        warnings: Vec::new(),
    };
    for (name, element) in &header.elements {
        // An element has at least one byte: a larger count is false.
        if element.count > bytes.len() || (element.properties.is_empty() && element.count > 0) {
            return Err(Fault::new(format!(
                "the PLY declares {} elements {name:?}, but has only {} bytes",
                element.count,
                bytes.len()
            )));
        }
        match name.as_str() {
            "vertex" => {
                out.vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
            }
            "face" => {
                out.faces = Parser::<Face>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
            }
            other => {
                Parser::<Other>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
                if other != "edge" && element.count > 0 {
                    out.warnings.push(format!("the PLY's elements {other:?} are ignored"));
                }
            }
        }
    }
    Ok(out)
}

/// Positions, normals, colours and standard deviations of a PLY's vertices.
///
/// # Errors
/// [`Fault`] with the line or what is wrong.
pub(in crate::io) fn decode_cloud(bytes: &[u8]) -> Result<Cloud, Fault> {
    cloud(&elements(bytes)?.vertices)
}

fn cloud(vertices: &[Vertex]) -> Result<Cloud, Fault> {
    let points = vertices
        .iter()
        .enumerate()
        .map(|(i, v)| match v.position {
            [Some(x), Some(y), Some(z)] if [x, y, z].iter().all(|c| c.is_finite()) => {
                Ok(Vec3::new(x, y, z))
            }
            _ => Err(Fault::new(format!("the PLY's vertex {i} needs finite x, y and z"))),
        })
        .collect::<Result<_, _>>()?;
    let all = |v: [Option<f64>; 3]| Some(Vec3::new(v[0]?, v[1]?, v[2]?));
    let finite = |v: &Vec3| v.iter().all(|c| c.is_finite());
    let column = |v: &Vertex| all(v.normal).filter(finite);
    Ok(Cloud {
        points,
        normals: vertices.iter().map(column).collect::<Option<_>>().unwrap_or_default(),
        colors: vertices
            .iter()
            .map(|v| Some([v.color[0]?, v.color[1]?, v.color[2]?]))
            .collect::<Option<_>>()
            .unwrap_or_default(),
        sigmas: vertices
            .iter()
            .map(|v| v.sigma.filter(|s| s.is_finite()))
            .collect::<Option<_>>()
            .unwrap_or_default(),
    })
}

/// Standard deviations and measured flags; empty unless every vertex has both.
fn uncertainty(vertices: &[Vertex]) -> (Vec<f64>, Vec<bool>) {
    let both = |v: &Vertex| {
        let sigma = v.sigma_mm.filter(|s| s.is_finite() && *s >= 0.0)?;
        Some((sigma, v.measured? > 0.5))
    };
    vertices.iter().map(both).collect::<Option<_>>().map_or_else(Default::default, unzip)
}

fn unzip(rows: Vec<(f64, bool)>) -> (Vec<f64>, Vec<bool>) {
    rows.into_iter().unzip()
}

/// Reads the bytes of a PLY file; `folder` has its texture.
///
/// # Errors
/// [`Fault`] with the line or what is wrong.
pub(in crate::io) fn decode(bytes: &[u8], folder: &Path) -> Result<LoadedMesh, Fault> {
    let mut found = elements(bytes)?;
    let cloud = cloud(&found.vertices)?;
    let count = cloud.points.len();
    let mut mesh = Mesh { vertices: cloud.points, colors: cloud.colors, ..Mesh::default() };
    (mesh.sigmas, mesh.measured) = uncertainty(&found.vertices);
    let by_vertex: Option<Vec<[f64; 2]>> =
        found.vertices.iter().map(|v| Some([v.uv[0]?, v.uv[1]?])).collect();
    let by_corner =
        !found.faces.is_empty() && found.faces.iter().all(|f| f.uvs.len() == 2 * f.corners.len());
    let mut left_out = 0;
    for (i, face) in found.faces.iter().enumerate() {
        let corners: Vec<u32> = face
            .corners
            .iter()
            .map(|&c| u32::try_from(c).ok().filter(|&c| (c as usize) < count))
            .collect::<Option<_>>()
            .ok_or_else(|| {
                Fault::new(format!(
                    "face {i} names vertices {:?}, but there are {count}",
                    face.corners
                ))
            })?;
        let base = mesh.uvs.len() as u32;
        if by_corner {
            mesh.uvs.extend(face.uvs.chunks_exact(2).map(|uv| [uv[0], uv[1]]));
        }
        let mut whole = 0;
        for k in 1..corners.len().saturating_sub(1) {
            let triangle = [corners[0], corners[k], corners[k + 1]];
            let [a, b, c] = triangle;
            if a == b || b == c || c == a {
                continue;
            }
            whole += 1;
            mesh.faces.push(triangle);
            if by_corner {
                mesh.face_uvs.push([0, k as u32, k as u32 + 1].map(|j| base + j));
            } else if by_vertex.is_some() {
                mesh.face_uvs.push(triangle);
            }
        }
        left_out += usize::from(whole + 2 != corners.len());
    }
    if left_out > 0 {
        found.warnings.push(format!(
            "{left_out} faces have repeated or too few corners; triangles without area are not read"
        ));
    }
    if let (false, Some(uvs)) = (by_corner, by_vertex) {
        mesh.uvs = if mesh.face_uvs.is_empty() { Vec::new() } else { uvs };
    }
    if by_corner {
        share_equal_uvs(&mut mesh);
    }
    let texture = found.texture.filter(|_| mesh.has_uv()).and_then(|name| {
        let Some(path) = find_beside(folder, &name) else {
            found.warnings.push(format!("the texture {name} does not exist"));
            return None;
        };
        read_rgb(&path).map_err(|e| found.warnings.push(e.to_string())).ok()
    });
    Ok(LoadedMesh { mesh, texture, unit: None, warnings: found.warnings })
}

/// Corners with the same texture coordinates share one entry, in order of first use.
fn share_equal_uvs(mesh: &mut Mesh) {
    let mut number = std::collections::BTreeMap::new();
    let mut uvs = Vec::new();
    let renumbered: Vec<u32> = mesh
        .uvs
        .iter()
        .map(|uv| {
            *number.entry(uv.map(f64::to_bits)).or_insert_with(|| {
                uvs.push(*uv);
                uvs.len() as u32 - 1
            })
        })
        .collect();
    for face in &mut mesh.face_uvs {
        *face = face.map(|k| renumbered[k as usize]);
    }
    mesh.uvs = uvs;
}
