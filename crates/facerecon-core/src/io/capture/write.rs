//! Writing a capture folder.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::types::FILE_NAME;
use crate::data::{Capture, ExtraPhoto, Pair, Photo};
use crate::io::atomic;
use crate::io::calibration::write_calibration;
use crate::io::error::IoError;
use crate::io::image::write_png;
use crate::math::Mat3;

/// Writes a capture as a folder that [`super::read_capture`] reads: the photos as 8-bit PNG,
/// `calibration.yml` when there is a rig, and `capture.toml` last. Returns the path of that file.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_capture(folder: &Path, capture: &Capture) -> Result<PathBuf, IoError> {
    let mut text = String::from("[images]\n");
    let mut photo = |key: &str, name: &str, photo: &Photo| {
        let _ = writeln!(text, "{key} = \"{name}\"");
        write_png(&folder.join(name), &photo.rgb)
    };
    photo("left", "left_dots.png", &capture.left)?;
    photo("right", "right_dots.png", &capture.right)?;
    if let Some([left, right]) = &capture.plain {
        photo("left_plain", "left_plain.png", left)?;
        photo("right_plain", "right_plain.png", right)?;
    }
    for (i, extra) in capture.extra.iter().enumerate() {
        let name = format!("extra_{}_plain.png", i + 1);
        write_png(&folder.join(&name), &extra.photo.rgb)?;
        text += &extra_text(&name, extra);
    }
    let pattern = &capture.pattern;
    let _ = write!(
        text,
        "\n[pattern]\nkind = \"{}\"\ncolumns = {}\nrows = {}\nrotation_deg = {:?}\n",
        pattern.kind,
        pattern.columns,
        pattern.rows,
        pattern.rotation.to_degrees(),
    );
    if let Some(rig) = &capture.rig {
        write_calibration(&folder.join("calibration.yml"), rig)?;
        text += "\n[rig]\ncalibration = \"calibration.yml\"\n";
    }
    text += &marks_text(capture);
    let path = folder.join(FILE_NAME);
    atomic::write(&path, text.as_bytes())?;
    Ok(path)
}

/// The table `[[images.extra]]` of one photo.
fn extra_text(name: &str, extra: &ExtraPhoto) -> String {
    let row = |m: &Mat3, r: usize| format!("[{:?}, {:?}, {:?}]", m[(r, 0)], m[(r, 1)], m[(r, 2)]);
    let rows = |m: &Mat3| format!("[{}, {}, {}]", row(m, 0), row(m, 1), row(m, 2));
    let pose = &extra.camera_from_left;
    let t = pose.translation;
    format!(
        "\n[[images.extra]]\nimage = \"{name}\"\nK = {}\nD = {:?}\nR = {}\nT = [{:?}, {:?}, {:?}]\n",
        rows(&extra.camera.matrix()),
        extra.camera.distortion.0,
        rows(&pose.rotation),
        t.x,
        t.y,
        t.z,
    )
}

/// The tables `[seeds]` and `[landmarks]`, where there are marks.
fn marks_text(capture: &Capture) -> String {
    let pair = |name: &str, p: &Pair| {
        format!(
            "{name} = {{ left = [{:?}, {:?}], right = [{:?}, {:?}] }}\n",
            p.left.x, p.left.y, p.right.x, p.right.y
        )
    };
    let mut text = String::new();
    if let Some(seeds) = &capture.seeds {
        text += "\n[seeds]\n";
        text += &pair("head", &seeds.head);
        text += &pair("left_ear", &seeds.left_ear);
        text += &pair("right_ear", &seeds.right_ear);
    }
    if !capture.landmarks.is_empty() {
        text += "\n[landmarks]\n";
        for (name, p) in &capture.landmarks {
            text += &pair(name, p);
        }
    }
    text
}
