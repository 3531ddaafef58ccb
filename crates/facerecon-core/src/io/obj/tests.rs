use proptest::prelude::*;

use super::*;
use crate::io::{read_mesh, write_mesh};
use crate::math::Vec3;

fn decode_text(text: &str) -> LoadedMesh {
    decode(text.as_bytes(), Path::new("/nowhere")).unwrap()
}

fn refusal(text: &str) -> String {
    decode(text.as_bytes(), Path::new("/nowhere")).unwrap_err().to_string()
}

fn tetrahedron() -> Mesh {
    Mesh {
        vertices: vec![
            Vec3::new(0.123456, -7.0, 1e-9),
            Vec3::new(100.25, 0.0, -0.000001),
            Vec3::new(0.0, 12345.678901, 0.0),
            Vec3::new(3.0, 4.0, 5.0),
            Vec3::new(9.0, 9.0, 9.0),
        ],
        faces: vec![[0, 1, 2], [3, 1, 0], [2, 3, 0]],
        uvs: vec![[0.0, 0.0], [1.0, 0.25], [0.5, 1.0]],
        face_uvs: vec![[0, 1, 2], [2, 1, 0], [1, 1, 0]],
        ..Mesh::default()
    }
}

#[test]
fn what_is_written_is_read_back_to_the_printed_digits() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a head.obj");
    let texture = Rgb::from_fn(8, 8, |x, y| [x as u8 * 9, y as u8 * 9, 4]);
    let mesh = tetrahedron();
    write_mesh(&path, &mesh, Some(&texture)).unwrap();
    let back = read_mesh(&path).unwrap();
    assert_eq!(back.warnings, Vec::<String>::new());
    assert_eq!(back.texture, Some(texture));
    let rounded = |v: f64| (v * 1e6).round() / 1e6 + 0.0;
    assert_eq!(
        back.mesh.vertices,
        mesh.vertices.iter().map(|v| v.map(rounded)).collect::<Vec<_>>()
    );
    assert_eq!(back.mesh.faces, mesh.faces);
    assert_eq!((&back.mesh.uvs, &back.mesh.face_uvs), (&mesh.uvs, &mesh.face_uvs));
    // Once more: now the numbers hold exactly, and so do the bytes.
    let again = dir.path().join("again.obj");
    write_mesh(&again, &back.mesh, None).unwrap();
    assert_eq!(read_mesh(&again).unwrap().mesh, back.mesh);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(!text.contains("-0.000000"), "{text}");
    assert!(text.contains("mtllib a head.mtl"));
}

#[test]
fn colours_are_kept() {
    let mesh = Mesh { colors: (0..5).map(|i| [i * 50, 255 - i, 7]).collect(), ..tetrahedron() };
    assert_eq!(decode_text(&encode(&mesh, None)).mesh.colors, mesh.colors);
    let bytes = decode_text("v 0 0 0 255 0 10\nv 1 0 0 20 30 40\nv 0 1 0 2 3 4\nf 1 2 3");
    assert_eq!(bytes.mesh.colors[1], [20, 30, 40]);
    let some = decode_text("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 1\nf 1 2 3");
    assert!(some.mesh.colors.is_empty() && some.warnings[0].contains("only 1 of 3"));
}

#[test]
fn unusual_but_valid_files_are_read() {
    let text = "\u{feff}# a comment that ends in a backslash \\\r\nmtllib none.mtl\r\no thing\r\n\
        v 9 9 9\r\nv 0 0 0\r\nv 1 0 0 1.0\r\nv 1 1 0\r\nv 0 1 0\r\nvt 0 0\r\nvt 1 0 0\r\nvt 1 1\r\n\
        vt 0 1\r\nvn 0 0 1\r\ng left right\r\ns off\r\nusemtl skin # soft\r\n\
        f 2/1/1 3/2/1 \\\r\n 4/3/1 5/4/1 # the square\r\nf -4//1 -3//1 -2//1\r\nl 1 2\r\np 1\r\n";
    let found = decode_text(text);
    assert_eq!(found.mesh.vertices.len(), 5);
    assert_eq!(found.mesh.vertices[0], Vec3::new(9.0, 9.0, 9.0));
    assert_eq!(found.mesh.faces, vec![[1, 2, 3], [1, 3, 4], [1, 2, 3]]);
    assert_eq!(found.mesh.face_uvs, vec![[0, 1, 2], [0, 2, 3], [4, 4, 4]]);
    assert!(found.warnings.iter().any(|w| w.contains("1 of 3 triangles")), "{:?}", found.warnings);
    assert!(found.warnings.iter().any(|w| w.contains("none.mtl")));
    let latin = decode(b"# caf\xe9\nv 0 0 0\rv 1 0 0\rv 0 1 0\rg \xfc\rf 1 2 3", Path::new(""));
    assert_eq!(latin.unwrap().mesh.faces, vec![[0, 1, 2]]);
    let flat = decode_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2 3\nf 1 2\nzmodeler 3\nf 1 2 3");
    assert_eq!(flat.mesh.faces, vec![[0, 1, 2], [0, 1, 2]]);
    assert_eq!(flat.warnings.len(), 2, "{:?}", flat.warnings);
}

#[test]
fn faults_name_their_line() {
    let start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, part) in [
        ("v 0 0 nan", "line 1: nan"),
        ("v 0 0 inf", "line 1"),
        ("v 0 0\n", "has 2 coordinates, but 3"),
        ("v 0 0,5 1", "line 1: \"0,5\""),
        ("f 1 2 4", "names vertex 4, but 3"),
        ("f 1 2 0", "vertex 0"),
        ("f 1 2 -4", "vertex -4"),
        ("f 1 2 99999999999999999999", "is not a vertex number"),
        ("f 1/1 2/1 3/1", "texture coordinate 1, but 0"),
        ("f 1 2 \\\n x", "line 4"),
        ("vt", "0 numbers, but 2"),
    ] {
        let error = refusal(&if part.starts_with("line 1") || part.contains("has 2 ") {
            text.to_owned()
        } else {
            format!("{start}{text}")
        });
        assert!(error.contains(part), "{part}: {error}");
    }
    assert!(refusal("hello\n").contains("is an OBJ file"));
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("points.obj");
    std::fs::write(&path, start).unwrap();
    let error = read_mesh(&path).unwrap_err().to_string();
    assert!(error.contains("points.obj") && error.contains("3 vertices and 0 faces"), "{error}");
    std::fs::write(&path, "v 1e200 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").unwrap();
    assert!(read_mesh(&path).unwrap_err().to_string().contains("vertex 0"));
}

#[test]
fn unusual_material_files_are_read() {
    let text = b"newmtl a\nKd 1 x\nmap_Kd -s 1 1 1 -o 0.5 dir\\my skin.png # c\nnewmtl b\r\nKd\n\
        map_Ka other.png\nnewmtl c d\nMAP_KD \"c.png\"\nillum x\n";
    let expected = [("a", "dir/my skin.png"), ("c d", "c.png")];
    assert_eq!(
        material::parse_materials(text),
        expected.map(|(m, p)| (m.to_owned(), p.to_owned())).to_vec()
    );
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    std::fs::write(at("m.mtl"), text).unwrap();
    let png = |v: u8| encode_png(&Rgb::filled(2, 2, [v; 3])).unwrap();
    std::fs::write(at("my skin.png"), png(10)).unwrap();
    std::fs::write(at("c.png"), png(20)).unwrap();
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl c d\nf 1/1 2/1 3/1\n\
        usemtl a\nf 1/1 2/1 3/1\nf 3/1 2/1 1/1\n";
    std::fs::write(at("m.obj"), obj).unwrap();
    let found = read_mesh(&at("m.obj")).unwrap();
    assert_eq!(found.texture, Some(Rgb::filled(2, 2, [10; 3])));
    assert!(found.warnings[0].contains("2 textures"), "{:?}", found.warnings);
    std::fs::write(at("my skin.png"), b"not an image").unwrap();
    assert!(read_mesh(&at("m.obj")).unwrap().texture.is_none());
}

#[test]
fn names_that_obj_cannot_contain_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let error = write_with(&dir.path().join("a#b.obj"), &tetrahedron(), "t.png", b"").unwrap_err();
    assert!(error.to_string().contains("another file name"));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

/// `tobj` renumbers the vertices: the triangles are compared by position.
#[test]
fn tobj_reads_the_same_triangles() {
    let text = encode(&tetrahedron(), None);
    let options = tobj::LoadOptions::default();
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
        Err(tobj::LoadError::GenericFailure)
    })
    .unwrap();
    let twin = &models[0].mesh;
    let ours = decode_text(&text).mesh;
    let theirs = twin
        .indices
        .iter()
        .map(|&i| Vec3::from_column_slice(&twin.positions[3 * i as usize..][..3]));
    let mine = ours.faces.iter().flatten().map(|&i| ours.vertices[i as usize]);
    assert!(theirs.eq(mine));
}

proptest! {
    #[test]
    fn meshes_come_back(
        points in proptest::collection::vec((-1e4..1e4f64, -1e4..1e4f64, -1e4..1e4f64), 3..40),
        corners in proptest::collection::vec((0usize..40, 0usize..40, 0usize..40), 1..60),
    ) {
        let rounded = |v: f64| (v * 1e6).round() / 1e6;
        let vertices: Vec<Vec3> = points.iter().map(|&(x, y, z)| Vec3::new(x, y, z).map(rounded)).collect();
        let n = vertices.len();
        let faces: Vec<[u32; 3]> = corners
            .iter()
            .map(|&(a, b, c)| [a % n, b % n, c % n].map(|i| i as u32))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        let mesh = Mesh { vertices, faces, ..Mesh::default() };
        prop_assert_eq!(decode_text(&encode(&mesh, None)).mesh, mesh);
    }

    #[test]
    fn no_text_panics(text in "(v|vt|f|usemtl|mtllib|#|\\\\|/|-|[0-9.e]|[ \n\r]|nan){0,80}") {
        let _ = decode(text.as_bytes(), Path::new(""));
        let _ = material::parse_materials(text.replace('f', "map_Kd").as_bytes());
    }

    #[test]
    fn no_material_panics(text in "((newmtl|Kd|Ks|map_Kd|Ns|d|illum|-o|-s|[a-z0-9.]+)[ \n]){0,40}") {
        let _ = material::parse_materials(text.as_bytes());
    }

    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = decode(&bytes, Path::new(""));
        let _ = material::parse_materials(&bytes);
    }
}
