use proptest::prelude::*;

use super::*;
use crate::io::{read_mesh, write_mesh};

const ASCII: &str = "solid thing\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
    vertex -0 1 0\nendloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 0 1 0\nvertex 1 0 0\n\
    vertex 1 1 0\nendloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 5 5 5\nvertex 5 5 5\n\
    vertex 1 1 0\nendloop\nendfacet\nendsolid thing\n";

#[test]
fn corners_at_the_same_position_become_one_vertex() {
    let found = decode(ASCII.as_bytes()).unwrap();
    assert_eq!(found.mesh.faces, vec![[0, 1, 2], [2, 1, 3]]);
    assert_eq!(found.mesh.vertices.len(), 5);
    assert_eq!(found.warnings.len(), 1);
}

#[test]
fn binary_comes_back_even_when_it_begins_with_solid() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.stl");
    let mesh = Mesh {
        vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(0.5, 0.25, -8.0)],
        faces: vec![[0, 1, 2], [2, 1, 3]],
        ..Mesh::default()
    };
    write_mesh(&path, &mesh, None).unwrap();
    assert_eq!(read_mesh(&path).unwrap().mesh, mesh);
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[..6].copy_from_slice(b"solid ");
    assert_eq!(decode(&bytes).unwrap().mesh, mesh);
}

#[test]
fn false_counts_and_damage_are_refused() {
    let mut false_count = vec![0u8; 84];
    false_count[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(decode(&false_count).unwrap_err().message.contains("damaged"));
    assert!(decode(b"").is_err());
    assert!(decode(ASCII.replace("vertex 1 0 0", "vertex 1 z 0").as_bytes()).is_err());
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("nan.stl");
    std::fs::write(&path, ASCII.replace("vertex 1 1 0", "vertex nan 1 0")).unwrap();
    assert!(read_mesh(&path).is_err());
}

proptest! {
    #[test]
    fn no_damage_panics(at in 0usize..400, value: u8, bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let mut text = ASCII.as_bytes().to_vec();
        let at = at % text.len();
        text[at] = value;
        let _ = decode(&text);
        let _ = decode(&bytes);
    }
}
