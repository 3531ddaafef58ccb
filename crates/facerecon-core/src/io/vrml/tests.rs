use proptest::prelude::*;

use super::*;
use crate::math::Vec3;

fn mesh(text: &str) -> LoadedMesh {
    decode(text.as_bytes(), Path::new("/nowhere")).unwrap()
}

fn fault(text: &str) -> String {
    decode(text.as_bytes(), Path::new("/nowhere")).unwrap_err().to_string()
}

const VERSION_1: &str = r#"#VRML V1.0 ascii
DEF Face Separator {
  Info { string "a face # no comment" }
  Texture2 { filename "skin.png" wrapS CLAMP }
  Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0,
                        0 1 0 ] } # the square
  TextureCoordinate2 { point [ 0 0, 1 0, 1 1, 0 1 ] }
  Separator {
    Transform { translation 10 0 0 scaleFactor 2 2 2 rotation 0 0 1 1.5707963267948966 }
    IndexedFaceSet { coordIndex [ 0, 1, 2, 3, -1 ] textureCoordIndex [ 0, 1, 2, 3, -1, ] }
  }
  IndexedFaceSet { coordIndex [ 0 1 2 ] textureCoordIndex [ 3 2 1 ] }
}
"#;

#[test]
fn version_1_is_read_with_transforms_and_state() {
    let found = mesh(VERSION_1);
    assert_eq!(found.mesh.vertices.len(), 8);
    assert_eq!(found.mesh.faces, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
    assert!((found.mesh.vertices[1] - Vec3::new(10.0, 2.0, 0.0)).norm() < 1e-12);
    assert_eq!(found.mesh.vertices[6], Vec3::new(1.0, 1.0, 0.0));
    let uv = |f: usize, k: usize| found.mesh.uvs[found.mesh.face_uvs[f][k] as usize];
    assert_eq!((uv(1, 2), uv(2, 0)), ([0.0, 1.0], [0.0, 1.0]));
    assert_eq!(found.warnings, vec!["the texture skin.png does not exist"]);
    let clockwise =
        VERSION_1.replace("Texture2 {", "ShapeHints { vertexOrdering CLOCKWISE } Texture2 {");
    assert_eq!(mesh(&clockwise).mesh.faces[0], [0, 2, 1]);
    let matrix = VERSION_1.replace(
        "Transform { translation 10 0 0 scaleFactor 2 2 2 rotation 0 0 1 1.5707963267948966 }",
        "MatrixTransform { matrix 1 0 0 0  0 1 0 0  0 0 1 0  5 6 7 1 }",
    );
    assert_eq!(mesh(&matrix).mesh.vertices[1], Vec3::new(6.0, 6.0, 7.0));
}

const VERSION_2: &str = r#"#VRML V2.0 utf8
WorldInfo { title "head" }
NavigationInfo { type [ "EXAMINE", "ANY" ] headlight TRUE }
PROTO Thing [ field SFColor c 1 0 0 ] { Shape { geometry Box { size 1 1 1 } } }
DEF T Transform {
  translation 0 0 5
  children [
    DEF S Shape {
      appearance Appearance { material Material { diffuseColor 0.8 0.6 0.5 }
        texture ImageTexture { url [ "skin.jpg" "other.jpg" ] repeatS FALSE } }
      geometry DEF G IndexedFaceSet {
        coord DEF C Coordinate { point [ 0 0 0 1 0 0 1 1 0 0 1 0 9 9 9 ] }
        coordIndex [ 0 1 2 3 -1 ]
        texCoord TextureCoordinate { point [ 0 0 1 0 1 1 0 1 ] }
        color Color { color [ 1 0 0 0 1 0 0 0 1 1 1 1 0.5 0.5 0.5 ] }
        ccw TRUE creaseAngle 1.2 solid FALSE
      }
    }
    Transform { scale -1 1 1 children USE S }
    Shape { geometry Sphere { radius 3 } }
    Switch { whichChoice -1 choice [ USE S ] }
  ]
}
USE S
ROUTE T.translation_changed TO T.set_translation
"#;

#[test]
fn version_2_is_read_with_nesting_and_reuse() {
    let found = mesh(VERSION_2);
    assert_eq!(found.mesh.vertices.len(), 15);
    assert_eq!(found.mesh.vertices[4], Vec3::new(9.0, 9.0, 14.0));
    assert_eq!(found.mesh.vertices[6], Vec3::new(-1.0, 0.0, 5.0));
    // The triangles of a mirrored shape are reversed, so that they face outward.
    assert_eq!(
        found.mesh.faces,
        vec![[0, 1, 2], [0, 2, 3], [5, 7, 6], [5, 8, 7], [10, 11, 12], [10, 12, 13]]
    );
    assert_eq!(found.mesh.uvs.len(), 12);
    assert!(found.mesh.colors.is_empty(), "vertex 4 has no face that would give it its colour");
    assert!(found.warnings.iter().any(|w| w.contains("Sphere")));
    assert!(found.warnings.iter().any(|w| w.contains("skin.jpg")));
    let inside = mesh(&VERSION_2.replace("ccw TRUE", "ccw FALSE"));
    assert_eq!(inside.mesh.faces[0], [0, 2, 1]);
    let used = VERSION_2
        .replace("coordIndex [ 0 1 2 3 -1 ]", "coordIndex [ 0 1 2 3 -1 0 3 4 -1 ]")
        .replace("1 1 0 1 ] }\n        color", "1 1 0 1 0 0 ] }\n        color");
    assert_eq!(mesh(&used).mesh.colors[4], [128; 3]);
}

#[test]
fn the_texture_is_read_from_beside_the_file() {
    let dir = tempfile::tempdir().unwrap();
    let rgb = crate::data::Rgb::filled(3, 3, [5, 6, 7]);
    crate::io::write_png(&dir.path().join("skin.png"), &rgb).unwrap();
    let path = dir.path().join("old.wrl");
    std::fs::write(&path, VERSION_1).unwrap();
    assert_eq!(crate::io::read_mesh(&path).unwrap().texture, Some(rgb));
    std::fs::write(&path, [0x1f, 0x8b, 8, 0]).unwrap();
    assert!(crate::io::read_mesh(&path).unwrap_err().to_string().contains("gunzip"));
}

#[test]
fn faults_name_their_line() {
    assert!(fault("").contains("#VRML"));
    assert!(fault("#VRML V3.0\n").contains("V3.0"));
    assert!(fault(&VERSION_1.replace("0 1 0 ] }", "0 1 0 }")).contains("line"));
    assert!(fault(&VERSION_1.replace("1 1 0,", "1 1 0x,")).contains("line 5"));
    assert!(
        fault(&VERSION_1.replace("coordIndex [ 0 1 2 ]", "coordIndex [ 0 1 4 ]"))
            .contains("point 4, but there are 4")
    );
    assert!(
        fault(&VERSION_1.replace("textureCoordIndex [ 3 2 1 ]", "textureCoordIndex [ 3 2 9 ]"))
            .contains("texture coordinate 9")
    );
    assert!(fault(&VERSION_1.replace("\"skin.png\"", "\"skin.png")).contains("never closed"));
    assert!(fault(&VERSION_1[..VERSION_1.len() - 4]).contains("ends inside"));
    assert!(fault("#VRML V2.0 utf8\nTransform { children USE X }").contains("USE X"));
    assert!(
        fault("#VRML V1.0 ascii\nIndexedFaceSet { coordIndex [ 0 1 2 ] }").contains("Coordinate3")
    );
}

#[test]
fn circles_and_repeated_nodes_end_quickly() {
    let circle = "#VRML V2.0 utf8\nDEF A Group { children [ USE A ] }";
    assert!(fault(circle).contains("contain itself"));
    let deep = format!("#VRML V2.0 utf8\n{}", "Group { children ".repeat(5000));
    assert!(fault(&deep).contains("deep"));
    let deep = format!("#VRML V1.0 ascii\n{}", "Separator { ".repeat(5000));
    assert!(fault(&deep).contains("deep"));
    let mut repeated = String::from("#VRML V2.0 utf8\nDEF N0 Group { children [ ] }\n");
    for i in 1..60 {
        repeated += &format!("DEF N{i} Group {{ children [ USE N{0} USE N{0} ] }}\n", i - 1);
    }
    assert!(fault(&repeated).contains("repeats"));
    let mut faces = String::from(
        "#VRML V2.0 utf8\nDEF N0 Shape { geometry IndexedFaceSet { coord Coordinate { point [ ",
    );
    faces += &"1 2 3 ".repeat(2000);
    faces += "] } coordIndex [ ";
    faces += &"0 1 2 -1 ".repeat(2000);
    faces += "] } }\n";
    for i in 1..19 {
        faces += &format!("DEF N{i} Group {{ children [ USE N{0} USE N{0} ] }}\n", i - 1);
    }
    assert!(fault(&faces).contains("simplify it"));
}

proptest! {
    #[test]
    fn no_damage_panics(at in 0usize..2000, text in "[-\\[\\]{}()\"#a-zA-Z0-9. \n]{0,8}", version_1: bool) {
        let mut whole = if version_1 { VERSION_1 } else { VERSION_2 }.as_bytes().to_vec();
        let at = at % whole.len();
        whole.splice(at..(at + 2).min(whole.len()), text.bytes());
        let _ = decode(&whole, Path::new(""));
    }

    #[test]
    fn no_words_panic(text in "(DEF|USE|Separator|Shape|geometry|point|coordIndex|PROTO|IS|\\{|\\}|\\[|\\]|\\(|\\||\"|[0-9]|-1|x| |\n|#){0,120}") {
        let _ = decode(format!("#VRML V1.0 ascii\n{text}").as_bytes(), Path::new(""));
        let _ = decode(format!("#VRML V2.0 utf8\n{text}").as_bytes(), Path::new(""));
    }
}
