use proptest::prelude::*;

use super::*;
use crate::io::{read_mesh, read_points};

fn cloud() -> Cloud {
    Cloud {
        points: vec![Vec3::new(0.1, -2.0, 1300.0), Vec3::new(1e-7, 5.0, 7.0)],
        normals: vec![Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.5, -0.5, 0.25)],
        colors: vec![[1, 2, 3], [255, 0, 9]],
        sigmas: vec![0.25, 0.5],
    }
}

fn mesh() -> Mesh {
    Mesh {
        vertices: (0..4).map(|i| Vec3::new(f64::from(i) / 3.0, f64::from(i * i), 0.1)).collect(),
        faces: vec![[0, 1, 2], [0, 2, 3]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.5]],
        face_uvs: vec![[0, 1, 2], [0, 2, 3]],
        colors: vec![[9, 8, 7]; 4],
        sigmas: vec![0.25, 0.5, 12.0, 0.125],
        measured: vec![true, true, false, true],
    }
}

fn fault(text: &[u8]) -> String {
    decode(text, Path::new("")).unwrap_err().to_string()
}

#[test]
fn clouds_and_meshes_come_back_exactly() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("cloud.ply");
    write_cloud(&path, &cloud(), "left camera frame, mm").unwrap();
    assert_eq!(read_points(&path).unwrap(), cloud());
    assert!(
        String::from_utf8_lossy(&std::fs::read(&path).unwrap()).contains("comment left camera")
    );
    let bare = Cloud::from_points(cloud().points);
    assert_eq!(decode_cloud(&encode_cloud(&bare, "")).unwrap(), bare);
    let path = dir.path().join("mesh.ply");
    let texture = Rgb::filled(4, 4, [1, 2, 3]);
    crate::io::write_mesh(&path, &mesh(), Some(&texture)).unwrap();
    let back = read_mesh(&path).unwrap();
    assert_eq!((back.mesh, back.texture), (mesh(), Some(texture)));
}

const ASCII: &str = "ply\nformat ascii 1.0\ncomment TextureFile skin.png\nelement vertex 4\n\
    property float x\nproperty float y\nproperty float z\nproperty float u\nproperty float v\n\
    property float red\nproperty float green\nproperty float blue\nproperty uchar alpha\n\
    element face 2\nproperty list uchar int vertex_index\nelement extra 1\nproperty int a\nend_header\n\
    0 0 0 0 0 1 0 0.5 9\n1 0 0 1 0 1 0 0.5 9\n1 1 0 1 1 1 0 0.5 9\n0 1 0 0 1 1 0 0.5 9\n\
    4 0 1 2 3\n3 0 0 1\n7\n";

#[test]
fn ascii_with_polygons_colours_and_uvs_is_read() {
    let found = decode(ASCII.as_bytes(), Path::new("/nowhere")).unwrap();
    assert_eq!(found.mesh.faces, vec![[0, 1, 2], [0, 2, 3]]);
    assert_eq!(found.mesh.face_uvs, found.mesh.faces);
    assert_eq!(found.mesh.uvs[2], [1.0, 1.0]);
    assert_eq!(found.mesh.colors[3], [255, 0, 128]);
    assert_eq!(found.warnings.len(), 3, "{:?}", found.warnings);
}

#[test]
fn big_endian_is_read() {
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty double x\n\
        property short y\nproperty uchar z\nend_header\n"
        .to_vec();
    bytes.extend(1.5f64.to_be_bytes());
    bytes.extend((-300i16).to_be_bytes());
    bytes.push(7);
    assert_eq!(decode_cloud(&bytes).unwrap().points, vec![Vec3::new(1.5, -300.0, 7.0)]);
}

#[test]
fn false_counts_are_refused_quickly() {
    let lie = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n";
    assert!(fault(lie.as_bytes()).contains("4000000000"));
    let empty = "ply\nformat ascii 1.0\nelement vertex 9\nend_header\n";
    assert!(fault(empty.as_bytes()).contains("vertex"));
    let list = "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint int vertex_index\nend_header\n\u{7f}\u{7f}\u{7f}\u{7f}";
    assert!(!fault(list.as_bytes()).is_empty());
    assert!(fault(ASCII.replace("4 0 1 2 3", "3 0 1 4").as_bytes()).contains("there are 4"));
    assert!(fault(ASCII.replace("4 0 1 2 3", "3 0 1 -1").as_bytes()).contains("face 0"));
    let nan = fault(ASCII.replace("1 1 0 1 1", "nan 1 0 1 1").as_bytes());
    assert!(nan.contains("line 21") && !nan.contains("Couldn't"), "{nan}");
    let nan = f64::NAN.to_le_bytes();
    let mut binary = encode_cloud(&cloud(), "");
    let end = binary.len();
    binary[end - 47..end - 39].copy_from_slice(&nan);
    assert!(decode_cloud(&binary).unwrap_err().message.contains("vertex 1"));
    assert!(fault(ASCII.replace("1 1 0 1 1", "x 1 0 1 1").as_bytes()).contains("line"));
    assert!(fault(&ASCII.as_bytes()[..ASCII.len() - 20]).contains("damaged"));
    assert!(fault(b"ply\n").contains("damaged"));
}

proptest! {
    #[test]
    fn no_damage_panics(at in 0usize..2000, value: u8, cut in 0usize..2000, binary: bool) {
        let mut bytes = if binary { encode_mesh(&mesh(), "x") } else { ASCII.as_bytes().to_vec() };
        let at = at % bytes.len();
        bytes[at] = value;
        let _ = decode(&bytes, Path::new(""));
        bytes.truncate(cut);
        let _ = decode_cloud(&bytes);
    }

    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mut whole = b"ply\nformat ascii 1.0\n".to_vec();
        whole.extend(&bytes);
        let _ = decode(&whole, Path::new(""));
    }
}
