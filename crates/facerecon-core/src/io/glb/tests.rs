use proptest::prelude::*;
use serde_json::Value;

use super::*;
use crate::data::Mesh;
use crate::io::{LengthUnit, read_mesh, write_mesh};
use crate::math::Vec3;

/// A square of two triangles whose diagonal is a seam of the texture at one end.
fn mesh() -> Mesh {
    Mesh {
        vertices: vec![
            Vec3::new(-70.5, 110.25, 3.0),
            Vec3::new(70.0, 0.0, 0.0),
            Vec3::new(0.0, -110.0, 40.0),
            Vec3::new(1.0, 2.0, 3.0),
        ],
        faces: vec![[0, 1, 2], [0, 2, 3]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.5], [0.25, 0.25]],
        face_uvs: vec![[0, 1, 2], [4, 2, 3]],
        ..Mesh::default()
    }
}

#[test]
fn what_is_written_is_read_back_in_millimetres() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("face.glb");
    let texture = Rgb::from_fn(16, 8, |x, y| [x as u8, y as u8, 77]);
    write_mesh(&path, &mesh(), Some(&texture)).unwrap();
    let back = read_mesh(&path).unwrap();
    assert_eq!(back.texture, Some(texture));
    assert_eq!(back.unit, Some(LengthUnit::Millimetre));
    assert_eq!(back.warnings, Vec::<String>::new());
    // One vertex on the seam is repeated; the first four keep their order.
    assert_eq!(back.mesh.vertices.len(), 5);
    for (found, v) in back.mesh.vertices.iter().zip(&mesh().vertices) {
        assert!((found - v).norm() < 1e-5, "{found} {v}");
    }
    assert_eq!(back.mesh.faces, vec![[0, 1, 2], [4, 2, 3]]);
    for (face, uvs) in back.mesh.face_uvs.iter().zip(&mesh().face_uvs) {
        for (k, j) in face.iter().zip(uvs) {
            assert_eq!(back.mesh.uvs[*k as usize], mesh().uvs[*j as usize]);
        }
    }
}

#[test]
fn vertex_colours_come_back() {
    let bare = Mesh { uvs: Vec::new(), face_uvs: Vec::new(), ..mesh() };
    let colored = Mesh { colors: vec![[200, 150, 100], [255; 3], [90, 60, 250], [128; 3]], ..bare };
    let back = decode(&encode(&colored, None)).unwrap().mesh;
    assert_eq!(back.faces, colored.faces);
    for (a, b) in back.colors.iter().flatten().zip(colored.colors.iter().flatten()) {
        assert!(a.abs_diff(*b) <= 2, "{a} {b}");
    }
    assert_eq!(encode(&colored, None), encode(&colored, None));
}

#[test]
fn uncertainty_comes_back_and_seams_repeat_it() {
    let known = Mesh {
        sigmas: vec![0.25, 0.5, 12.0, 0.125],
        measured: vec![true, false, false, true],
        ..mesh()
    };
    let bytes = encode(&known, None);
    let back = decode(&bytes).unwrap().mesh;
    // the vertex on the seam is repeated with its values
    assert_eq!(back.sigmas, [0.25, 0.5, 12.0, 0.125, 0.25]);
    assert_eq!(back.measured, [true, false, false, true, true]);
    assert!(String::from_utf8_lossy(&bytes).contains("\"_SIGMA_MM\""));
    assert!(!decode(&encode(&mesh(), None)).unwrap().mesh.has_uncertainty());
}

/// Lengths, alignment and bounds, which other programs check.
#[test]
fn the_container_is_well_formed() {
    let bytes = encode(&mesh(), Some(b"12345"));
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((word(8), word(4)), (bytes.len(), 2));
    let json: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
    assert_eq!(word(12) % 4, 0);
    let binary = word(20 + word(12));
    assert_eq!(binary, json["buffers"][0]["byteLength"].as_u64().unwrap() as usize);
    for view in json["bufferViews"].as_array().unwrap() {
        let (at, n) = (view["byteOffset"].as_u64().unwrap(), view["byteLength"].as_u64().unwrap());
        assert!(at % 4 == 0 && at + n <= binary as u64);
    }
    let position = &json["accessors"][0];
    assert_eq!(position["min"], serde_json::json!([-70.5, -110.0, 0.0]));
    assert_eq!(position["max"], serde_json::json!([70.0, 110.25, 40.0]));
}

/// The `gltf` crate accepts the file and finds the same corners.
#[test]
fn the_gltf_crate_reads_the_same() {
    let bytes = encode(&mesh(), Some(&encode_png(&Rgb::filled(4, 4, [9; 3])).unwrap()));
    let twin = gltf::Gltf::from_slice(&bytes).unwrap();
    let node = twin.nodes().next().unwrap();
    assert_eq!(node.transform().decomposed().2, [0.001; 3]);
    let primitive = node.mesh().unwrap().primitives().next().unwrap();
    let position = primitive.get(&gltf::Semantic::Positions).unwrap();
    assert_eq!(position.count(), 5);
    assert_eq!(primitive.indices().unwrap().count(), 6);
    let texture = primitive.material().pbr_metallic_roughness().base_color_texture().unwrap();
    assert_eq!(texture.tex_coord(), 0);
}

fn with_json(change: impl Fn(&mut Value)) -> Vec<u8> {
    let bytes = encode(&mesh(), None);
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    change(&mut json);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = bytes[..12].to_vec();
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend(&bytes[20 + length..]);
    out
}

#[test]
fn transforms_of_nodes_are_applied() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned = with_json(|root| {
        root["nodes"] = serde_json::json!([
            { "children": [1], "translation": [1.0, 0.0, 0.0] },
            { "mesh": 0, "rotation": [0.0, 0.0, half, half] }
        ]);
    });
    let found = decode(&turned).unwrap().mesh.vertices[1];
    assert!((found - Vec3::new(1000.0, 70_000.0, 0.0)).norm() < 1e-2, "{found}");
}

#[test]
fn circles_and_false_counts_are_refused() {
    let fault = |bytes: &[u8]| decode(bytes).unwrap_err().message;
    let circle = with_json(|r| r["nodes"][0]["children"] = serde_json::json!([0, 0]));
    assert!(fault(&circle).contains("circle"));
    let count = with_json(|r| r["accessors"][0]["count"] = serde_json::json!(4_000_000_000u64));
    assert!(fault(&count).contains("do not fit"));
    let view = with_json(|r| r["bufferViews"][0]["byteOffset"] = serde_json::json!(1u64 << 40));
    assert!(fault(&view).contains("beyond the file"));
    let few = with_json(|r| r["accessors"][0]["count"] = serde_json::json!(2));
    assert!(fault(&few).contains("beyond"));
    let draco =
        with_json(|r| r["extensionsRequired"] = serde_json::json!(["KHR_draco_mesh_compression"]));
    assert!(fault(&draco).contains("draco"));
    assert!(fault(b"glTF\x01\0\0\0\0\0\0\0").contains("version 1"));
    assert!(fault(b"glT").contains("not a GLB"));
    let whole = encode(&mesh(), None);
    assert!(fault(&whole[..whole.len() - 9]).contains("truncated"));
}

proptest! {
    #[test]
    fn no_damage_panics(at in 0usize..3000, value: u8, cut in 0usize..3000) {
        let mut bytes = encode(&mesh(), Some(b"not a png"));
        let at = at % bytes.len();
        bytes[at] = value;
        let _ = decode(&bytes);
        bytes.truncate(cut);
        let _ = decode(&bytes);
    }
}
