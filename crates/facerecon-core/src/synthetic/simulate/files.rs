//! Writes a simulated capture and its truth.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::truth::{Simulated, Truth};
use crate::data::Raster;
use crate::io::{IoError, atomic, ply, write_calibration, write_capture};

/// Writes a capture folder with the truth in it, and returns the path of its `capture.toml`:
/// * `truth_mesh.ply`: the subject, left camera frame, mm,
/// * `truth_dots.csv`: see [`dots_csv`],
/// * `truth_depth.npy`: float32 (height, width), depth of the subject at each pixel centre of the
///   left photo, mm, NaN elsewhere,
/// * `truth_calibration.yml`: the actual rig,
/// * `truth.json`: the landmarks (`features`: `xyz` mm in the left camera frame, `left` and `right`
///   px), the pose `camera_from_model` and the motion of the head `plain_from_dots` (4x4, row by row).
///
/// # Errors
/// [`IoError::Write`].
pub fn write_simulated(folder: &Path, simulated: &Simulated) -> Result<PathBuf, IoError> {
    let truth = &simulated.truth;
    ply::write_mesh(&folder.join("truth_mesh.ply"), &truth.mesh, None)?;
    atomic::write(&folder.join("truth_dots.csv"), dots_csv(truth).as_bytes())?;
    atomic::write(&folder.join("truth_depth.npy"), &npy(&truth.depth_mm))?;
    write_calibration(&folder.join("truth_calibration.yml"), &truth.rig)?;
    atomic::write(&folder.join("truth.json"), truth_json(truth).as_bytes())?;
    // Written last, so that a folder with a capture.toml is complete.
    write_capture(folder, &simulated.capture)
}

fn truth_json(truth: &Truth) -> String {
    let landmarks: serde_json::Map<String, serde_json::Value> = truth
        .landmarks
        .iter()
        .map(|(name, pair)| {
            let xyz = truth.landmark_points.get(name).map(|p| [p.x, p.y, p.z]);
            let (left, right) = ([pair.left.x, pair.left.y], [pair.right.x, pair.right.y]);
            (name.clone(), json!({ "xyz": xyz, "left": left, "right": right }))
        })
        .collect();
    let value = json!({
        "features": landmarks,
        "camera_from_model": truth.camera_from_model.to_rows(),
        "plain_from_dots": truth.plain_from_dots.to_rows(),
    });
    format!("{value:#}\n")
}

/// The dots as a table, one row per dot of the pattern:
/// `col,row,X,Y,Z,xl,yl,xr,yr,vis_l,vis_r,lit,on_face`. X, Y, Z in millimetres of the left camera
/// frame, x, y in pixels of the left and right photo; `nan` for a dot that is not on the subject.
pub fn dots_csv(truth: &Truth) -> String {
    let mut text = String::from("col,row,X,Y,Z,xl,yl,xr,yr,vis_l,vis_r,lit,on_face\n");
    for d in &truth.dots {
        let _ = write!(text, "{},{}", d.column, d.row);
        let [l, r] = d.pixel;
        for value in [d.point.x, d.point.y, d.point.z, l.x, l.y, r.x, r.y] {
            let _ = if value.is_nan() { write!(text, ",nan") } else { write!(text, ",{value:.4}") };
        }
        let flags = [d.visible[0], d.visible[1], d.lit, d.on_face].map(u8::from);
        let _ = writeln!(text, ",{},{},{},{}", flags[0], flags[1], flags[2], flags[3]);
    }
    text
}

/// A raster as a NumPy file: format 1.0, float32, little endian, C order, shape (height, width).
pub fn npy(raster: &Raster<f32>) -> Vec<u8> {
    let shape = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
        raster.height(),
        raster.width()
    );
    // Magic, version, length and header together are a multiple of 64 bytes.
    let length = (10 + shape.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{shape:<width$}\n", width = length - 1).as_bytes());
    bytes.extend(raster.data().iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_numpy_file_has_its_header_and_rows_in_order() {
        let bytes = npy(&Raster::from_fn(3, 2, |x, y| (10 * y + x) as f32));
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(header.contains("'shape': (2, 3)") && header.ends_with('\n'), "{header}");
        let data: Vec<f32> = bytes[10 + length..]
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        assert_eq!(data, [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
    }
}
