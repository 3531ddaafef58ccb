use proptest::prelude::*;

use super::*;
use crate::camera::{Distortion, RigError};
use crate::math::{Vec2, Vec3};

const MATRICES: &str = r"K1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 2526.32, 0., 380.2, 0.,
       2526.32, 290.1, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.12, 2.5e-01, 0., 0., 0. ]
K2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 2500., 0., 387.4, 0., 2501., 285.2, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ -0.1, 0.18, 0.001, 0.002 ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -150., 0.5, 2. ]
";

fn rig(text: &str) -> StereoRig {
    parse_calibration(text.as_bytes()).unwrap().rig
}

fn refusal(text: &str) -> String {
    parse_calibration(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn every_header_of_opencv_yaml_is_read() {
    let bare = rig(MATRICES);
    assert_eq!(bare.left.fy, 2526.32);
    assert_eq!(bare.left.cy, 290.1);
    assert_eq!(bare.left.distortion.0[1], 0.25);
    assert_eq!(bare.right.distortion.0[..4], [-0.1, 0.18, 0.001, 0.002]);
    assert_eq!(bare.right_from_left.translation, Vec3::new(-150.0, 0.5, 2.0));
    for header in ["%YAML:1.0\n---\n", "%YAML 1.2\n---\n# note\n", "---\n"] {
        assert_eq!(rig(&format!("{header}{MATRICES}")), bare);
    }
    assert_eq!(rig(&MATRICES.replace('\n', "\r\n")), bare);
    let sized = rig(&format!("image_width: 768\nimage_height: 576\n{MATRICES}"));
    assert_eq!(sized.image_size, Some((768, 576)));
    assert_eq!(rig(&format!("imageSize: [ 768, 576 ]\n{MATRICES}")).image_size, Some((768, 576)));
}

#[test]
fn names_of_other_programs_are_read() {
    let expected = rig(MATRICES);
    let names = [
        ["M1", "D1", "M2", "D2", "R", "T"],
        ["cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2", "R", "T"],
        [
            "camera_matrix_left",
            "dist_coeffs_left",
            "camera_matrix_right",
            "dist_coeffs_right",
            "rotation",
            "translation",
        ],
        ["mtxL", "distL", "mtxR", "distR", "Rot", "Trns"],
    ];
    for (i, set) in names.iter().enumerate() {
        let mut text = format!("\n{MATRICES}");
        for (old, new) in ["K1", "D1", "K2", "D2", "R", "T"].iter().zip(set) {
            text = text.replace(&format!("\n{old}: "), &format!("\n{new}: "));
        }
        if i < 3 {
            assert_eq!(rig(&text), expected, "{set:?}");
        } else {
            let error = refusal(&text);
            assert!(error.contains("T (translation)") && error.contains("Trns"), "{error}");
        }
    }
}

#[test]
fn xml_and_json_give_the_same_rig() {
    let expected = rig(MATRICES);
    let matrix = |name: &str, rows: usize, columns: usize, data: &str| {
        format!(
            "<{name} type_id=\"opencv-matrix\">\n  <rows>{rows}</rows>\n  <cols>{columns}</cols>\n  \
             <dt>d</dt>\n  <data>\n {data}</data></{name}>\n"
        )
    };
    let k1 = "2526.32 0. 380.2 0. 2526.32 290.1 0. 0. 1.";
    let k2 = "2500. 0. 387.4 0. 2501. 285.2 0. 0. 1.";
    let eye = "1. 0. 0. 0. 1. 0. 0. 0. 1.";
    let xml = format!(
        "<?xml version=\"1.0\"?>\n<!-- made by hand -->\n<opencv_storage>\n<note>x</note>\n<empty/>{}{}{}{}{}{}</opencv_storage>",
        matrix("K1", 3, 3, k1),
        matrix("D1", 1, 5, "-0.12 0.25 0. 0. 0."),
        matrix("K2", 3, 3, k2),
        matrix("D2", 1, 4, "-0.1 0.18 0.001 0.002"),
        matrix("R", 3, 3, eye),
        matrix("T", 3, 1, "-150. 0.5 2."),
    );
    assert_eq!(rig(&xml), expected);
    let json = r#"{"K1": [[2526.32,0,380.2],[0,2526.32,290.1],[0,0,1]], "D1": [[-0.12,0.25,0,0,0]],
        "K2": {"type_id": "opencv-matrix", "rows":3, "cols":3, "dt":"d", "data":[2500,0,387.4,0,2501,285.2,0,0,1]},
        "D2": [-0.1,0.18,0.001,0.002], "R": [0,0,0], "T": [-150,0.5,2], "image_size": {"width": 640, "height": 480}}"#;
    let from_json = rig(json);
    assert_eq!(from_json.image_size, Some((640, 480)));
    assert_eq!(StereoRig { image_size: None, ..from_json }, expected);
}

#[test]
fn what_is_written_is_read_back_exactly() {
    let rotation = nalgebra::Rotation3::from_euler_angles(0.01, -0.145, 0.016).into_inner();
    let mut rig = StereoRig::parallel(169.7, 2526.3, Vec2::new(380.2, 290.1), Vec2::new(1.5, 2.0));
    rig.right_from_left.rotation = rotation;
    rig.left.distortion = Distortion([-0.12, 0.25, 1e-7, -0.0, 0.3, 0.01, 0.02, 1e-9]);
    rig.image_size = Some((768, 576));
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("deep/calibration.yml");
    write_calibration(&path, &rig).unwrap();
    let back = read_calibration(&path).unwrap();
    assert!(back.warnings.is_empty());
    assert_eq!(back.rig.left, rig.left);
    assert!((back.rig.right_from_left.rotation - rotation).amax() < 1e-15);
    assert_eq!(back.rig.right_from_left.translation, rig.right_from_left.translation);
    assert_eq!(back.rig.image_size, rig.image_size);
}

#[test]
fn units_are_stated_or_refused() {
    let metres = MATRICES.replace("-150., 0.5, 2.", "-0.150, 0.0005, 0.002");
    let error = refusal(&metres);
    assert!(error.contains("metres") && error.contains("unit: m"), "{error}");
    let stated = rig(&format!("unit: m\n{metres}"));
    assert!((stated.baseline_mm() - rig(MATRICES).baseline_mm()).abs() < 1e-9);
    assert!(refusal(&format!("unit: feet\n{MATRICES}")).contains("feet"));
    let odd = MATRICES.replace("-150., 0.5, 2.", "-15., 0., 0.");
    assert_eq!(parse_calibration(odd.as_bytes()).unwrap().warnings.len(), 1);
}

#[test]
fn mistakes_are_named() {
    let cases = [
        (MATRICES.replace("R: !!", "R7: !!"), "extrinsics.yml"),
        (MATRICES.replace("2526.32, 290.1, 0., 0., 1.", "2526.32, 290.1"), "3 x 3"),
        (MATRICES.replace("0.18, 0.001, 0.002", "0.18"), "4 x 1"),
        (MATRICES.replace("2526.32, 0., 380.2", "-2526.32, 0., 380.2"), "above 0"),
        (MATRICES.replace("2526.32, 0., 380.2", ".Nan, 0., 380.2"), "finite"),
        (MATRICES.replace("0., 0., 1. ]\nD1", "0., 0., 0. ]\nD1"), "form"),
        (format!("distortion_model: equidistant\n{MATRICES}"), "pinhole"),
        (format!("imageSize: [ 0, 5 ]\n{MATRICES}"), "width and height"),
        ("just a text".into(), "FileStorage"),
        (String::new(), "FileStorage"),
        ("K1: [1, 2".into(), "line"),
        ("<opencv_storage><K1>".into(), "never closed"),
        ("<html></html>".into(), "opencv_storage"),
        ("{\"K1\": }".into(), "JSON"),
        (format!("{}1{}", "[".repeat(50_000), "]".repeat(50_000)), ""),
        (format!("{{\"K1\":{}1{}}}", "[".repeat(50_000), "]".repeat(50_000)), "JSON"),
        ("<a>".repeat(50_000), "nested"),
    ];
    for (text, part) in cases {
        let error = refusal(&text);
        assert!(error.contains(part), "{part}: {error}");
        assert!(error.len() < 1500, "{}", error.len());
    }
    assert!(distortion(&[0.0; 6]).is_err());
    assert!(distortion(&[0.0; 14]).is_ok());
    let mut prism = [0.0; 12];
    prism[9] = 0.1;
    assert!(distortion(&prism).unwrap_err().message.contains("thin-prism"));
    let transposed = [900.0, 0.0, 0.0, 0.0, 900.0, 0.0, 320.0, 240.0, 1.0];
    assert!(camera(&transposed, &[], &mut Vec::new()).unwrap_err().message.contains("transpose"));
}

#[test]
fn an_impossible_rig_is_refused_with_its_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("swapped.yml");
    std::fs::write(&path, MATRICES.replace("-150., 0.5", "150., 0.5")).unwrap();
    let error = read_calibration(&path).unwrap_err();
    assert!(matches!(error, IoError::Rig { source: RigError::Swapped { .. }, .. }), "{error}");
    assert!(error.to_string().contains("swapped.yml"));
}

proptest! {
    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = parse_calibration(&bytes);
    }

    #[test]
    fn no_damage_panics(at in 0usize..1000, text in "[-\\]\\[{}<>:!&*%#\"'a-z0-9. \n]{0,12}", head in 0usize..3) {
        let mut bytes = match head {
            0 => MATRICES.as_bytes().to_vec(),
            1 => b"<?xml version=\"1.0\"?><opencv_storage><K1 a=\"b\"><rows>3</rows></K1></opencv_storage>".to_vec(),
            _ => b"{\"K1\": {\"rows\": 3, \"data\": [1, 2, 3]}, \"T\": \"x\"}".to_vec(),
        };
        let at = at % bytes.len();
        bytes.splice(at..(at + 3).min(bytes.len()), text.bytes());
        let _ = parse_calibration(&bytes);
    }
}
