use std::fs;

use super::*;
use crate::io::write_mesh;
use crate::math::Vec3;

/// A strip of triangles 200 units high, `count` vertices.
fn strip(count: usize, height: f64) -> Mesh {
    let step = height / (count / 2 - 1) as f64;
    Mesh {
        vertices: (0..count)
            .map(|i| Vec3::new((i % 2) as f64 * height / 3.0, (i / 2) as f64 * step, 0.25 * height))
            .collect(),
        faces: (0..count as u32 - 2).map(|i| [i, i + 1, i + 2]).collect(),
        ..Mesh::default()
    }
}

fn with_side(mesh: &Mesh, side: Option<&str>) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("my.obj");
    write_mesh(&path, mesh, None).unwrap();
    if let Some(side) = side {
        fs::write(dir.path().join("my.landmarks.toml"), side).unwrap();
    }
    (dir, path)
}

fn refusal(mesh: &Mesh, side: Option<&str>) -> String {
    let (_dir, path) = with_side(mesh, side);
    load_template(&path, None, None).unwrap_err().to_string()
}

#[test]
fn a_sidecar_states_unit_axes_kept_vertices_and_landmarks() {
    let side = "name = \"mine\"\nunit = \"cm\"\nup = \"z\"\nfront = \"-y\"\nkeep = [[2, 9], [12, 40]]\n\
        [landmarks]\nnose_tip = 13\nchin = 2\n";
    // Rotated: up in the model is z in the file.
    let mut mesh = strip(40, 20.0);
    mesh.vertices.iter_mut().for_each(|v| *v = Vec3::new(v.x, -v.z, v.y));
    let (_dir, path) = with_side(&mesh, Some(side));
    let found = load_template(&path, None, None).unwrap();
    assert_eq!((found.name.as_str(), found.unit), ("mine", LengthUnit::Centimetre));
    assert_eq!(found.source_vertices[..9], [2, 3, 4, 5, 6, 7, 8, 9, 12]);
    assert_eq!(found.template.landmarks["nose_tip"], 9);
    assert_eq!(found.template.landmarks["chin"], 0);
    let expected = strip(40, 20.0).vertices[13] * 10.0;
    assert!((found.template.mesh.vertices[9] - expected).norm() < 1e-4);
    assert!((found.height_mm - 200.0 * 18.0 / 19.0).abs() < 1e-3, "{}", found.height_mm);
    assert_eq!(found.template.mesh.faces.len(), 6 + 26);
    assert!(found.warnings[0].contains("16 of the 18"));
}

#[test]
fn the_unit_is_never_guessed() {
    let error = refusal(&strip(40, 0.22), None);
    assert!(error.contains("not stated") && error.contains("220 mm in m"), "{error}");
    assert!(error.contains("my.landmarks.toml"), "{error}");
    let error = refusal(&strip(468, 17.0), None);
    assert!(error.contains("mediapipe=FILE"), "{error}");
    let (_dir, path) = with_side(&strip(40, 0.22), None);
    let stated = load_template(&path, None, Some(LengthUnit::Metre)).unwrap();
    assert!((stated.height_mm - 220.0).abs() < 1e-2);
}

#[test]
fn impossible_sizes_are_refused_with_figures() {
    let error = refusal(&strip(40, 22.0), Some("unit = \"mm\""));
    assert!(error.contains("22.0 mm") && error.contains("220 mm in cm"), "{error}");
    let eyes = "unit = \"mm\"\n[landmarks]\neye_left_outer = 0\neye_right_outer = 39\n";
    let error = refusal(&strip(40, 220.0), Some(eyes));
    assert!(error.contains("corners of the eyes"), "{error}");
}

#[test]
fn invalid_sidecars_are_explained() {
    let mesh = strip(40, 220.0);
    for (side, part) in [
        ("unit = \"feet\"", "line 1"),
        ("unit = \"mm\"\nextra = 1", "extra"),
        ("unit = \"mm\"\nup = \"w\"", "\"w\""),
        ("unit = \"mm\"\nup = \"-z\"", "different axes"),
        ("unit = \"mm\"\nkeep = [[50, 60]]", "no face left"),
        ("unit = \"mm\"\n[landmarks]\nchinn = 3", "did you mean chin"),
        ("unit = \"mm\"\n[landmarks]\nchin = 40", "the mesh has 40 vertices"),
        ("unit = \"mm\"\nkeep = [[4, 39]]\n[landmarks]\nchin = 3", "left out"),
        ("unit = \"mm\"\n[landmarks]\nchin = -3", "line 3"),
    ] {
        let error = refusal(&mesh, Some(side));
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn presets_are_consistent() {
    for preset in PRESETS {
        let mut seen = std::collections::BTreeSet::new();
        for &(name, index) in preset.landmarks {
            assert!(LANDMARKS.contains(&name) && seen.insert(index), "{} {name}", preset.name);
            let kept = preset.keep.is_empty()
                || preset.keep.iter().any(|r| (r[0]..=r[1]).contains(&index));
            assert!(kept && preset.vertices.iter().all(|&n| index < n), "{} {name}", preset.name);
        }
    }
    assert_eq!(preset("ICT").unwrap().landmarks.len(), 18);
}

#[test]
fn names_resolve() {
    let head = resolve("head", None).unwrap();
    assert_eq!(head.template.landmarks.len(), 18);
    assert!(HEIGHT_MM.contains(&head.height_mm));
    let error = |text: &str, file: Option<&Path>| resolve(text, file).unwrap_err().to_string();
    assert!(error("ict", None).contains("ict=FILE"));
    assert!(error("icd", None).contains("did you mean ict"));
    assert!(error("nothing.obj", None).contains("nothing.obj"));
    let (_dir, path) = with_side(&strip(40, 22.0), None);
    assert!(error("ict", Some(&path)).contains("26719"));
    // Landmarks of the sidecar are added to those of the preset.
    let side = "[landmarks]\near_left_upper = 127\nchin = 152\n";
    let (_dir, path) = with_side(&strip(468, 17.6), Some(side));
    let marked = load_template(&path, preset("flame"), None).unwrap_err();
    assert!(matches!(marked, TemplateError::VertexCount { .. }));
    let mut narrow = strip(468, 17.6);
    narrow.vertices[263].x += 8.0;
    let (_dir, path) = with_side(&narrow, Some(side));
    let marks = load_template(&path, preset("mediapipe"), None);
    let marks = marks.map(|t| t.template.landmarks).unwrap_or_default();
    assert_eq!((marks.len(), marks.get("chin"), marks.get("nose_tip")), (15, Some(&152), Some(&4)));
    // The file of a preset: the uppermost 320 mm of the body.
    let mut body = strip(13_380, 17.0);
    body.vertices.iter_mut().for_each(|v| v.x *= 0.1);
    let (_dir, path) = with_side(&body, None);
    let found = resolve(&format!("makehuman={}", path.display()), None).unwrap();
    assert!((found.height_mm - 320.0).abs() < 1.0, "{}", found.height_mm);
    assert_eq!(found.source_vertices.last(), Some(&13_379));
}

#[test]
fn an_exported_head_loads_as_it_was() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("head.obj");
    let head = head();
    write_mesh(&path, &head.mesh, None).unwrap();
    write_landmarks(&path, "head", &head.landmarks).unwrap();
    let found = resolve(&path.display().to_string(), None).unwrap();
    assert_eq!(found.template.landmarks, head.landmarks);
    assert_eq!(found.template.mesh.faces, head.mesh.faces);
    assert_eq!(found.warnings, Vec::<String>::new());
    let worst =
        found.template.mesh.vertices.iter().zip(&head.mesh.vertices).map(|(a, b)| (a - b).amax());
    assert!(worst.fold(0.0, f64::max) < 1e-6);
}
