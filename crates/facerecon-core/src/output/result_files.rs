//! The files of a result folder. Each is written completely or not at all.

use std::path::Path;

use serde_json::{Map, Value, json};

use crate::camera::Rectification;
use crate::data::{Capture, Match};
use crate::io;
use crate::io::table::MatchRow;
use crate::math::{Similarity, Vec3, percentile};
use crate::output::Record;
use crate::output::number_tables::{self, tenths};
use crate::output::report;
use crate::pipeline::Error;
use crate::pipeline::Reconstruction;
use crate::render::Frame;
use crate::stages::register::Registration;
use crate::template::{landmarks_toml, sidecar_path};

/// Folder of the intermediate results, inside the result folder.
pub const STAGES_FOLDER: &str = "stages";

/// The facts of the run as `result.json` holds them.
pub fn result_json(found: &Reconstruction) -> Value {
    let mut timings = Map::new();
    for (stage, ms) in &found.timings_ms {
        timings.insert(stage.clone(), json!(round(*ms, 2)));
    }
    let total: f64 = found.timings_ms.iter().map(|t| t.1).sum();
    timings.insert("total".into(), json!(round(total, 2)));
    let size = found.face_size();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "dots": { "left": found.dots[0], "right": found.dots[1] },
        "matches": found.matches.len(),
        "points": found.cloud.len(),
        "vertices": found.mesh.vertices.len(),
        "faces": found.mesh.faces.len(),
        "metric": found.metric,
        "unit": if found.metric { "mm" } else { "model units" },
        "verdict": verdict_json(found),
        "face_width_mm": size.and_then(|s| s.width_mm).map(tenths),
        "face_height_mm": size.and_then(|s| s.height_mm).map(tenths),
        "landmarks": number_tables::landmarks_json(found),
        "distances": number_tables::distances_json(found),
        "uncertainty": uncertainty_json(found),
        "model_from_camera": found.model_from_camera.to_rows(),
        "registration": found.registration.as_ref().map(|pose| {
            let mut facts = registration_json(pose);
            facts.insert("rms_before".into(), json!(round(pose.rms_before, 4)));
            facts.insert("rms_after".into(), json!(round(pose.rms_after, 4)));
            let history: Vec<_> = pose.history.iter().map(|e| round(*e, 5)).collect();
            facts.insert("error_history".into(), json!(history));
            let mut all = Map::from_iter([("method".into(), json!(found.params.register.method))]);
            all.append(&mut facts);
            all
        }),
        "rows": {
            "offset_px": round(found.rows.offset_px, 3),
            "roll_deg": round(found.rows.roll_deg, 4),
            "scale": round(found.rows.scale, 6),
            "residual_px": found.rows.residual_px.map(|r| round(r, 3)),
            "corrected": found.rows.corrected,
        },
        "timings_ms": timings,
        "warnings": found.warnings,
        "params": found.params,
    })
}

/// The verdict with figures of three decimal places.
fn verdict_json(found: &Reconstruction) -> Value {
    fn rounded(value: Value) -> Value {
        match value {
            Value::Number(n) if n.is_f64() => json!(n.as_f64().map(|v| round(v, 3))),
            Value::Object(fields) => fields.into_iter().map(|(k, v)| (k, rounded(v))).collect(),
            other => other,
        }
    }
    let verdict = &found.verdict;
    json!({
        "level": verdict.level,
        "reasons": verdict.reasons,
        "figures": rounded(json!(verdict.figures)),
    })
}

/// Share of the vertices that were measured, and the standard deviations of these.
fn uncertainty_json(found: &Reconstruction) -> Value {
    let mesh = &found.mesh;
    let measured = || mesh.sigmas.iter().zip(&mesh.measured).filter(|(_, m)| **m);
    let sigmas: Vec<f64> = measured().map(|(s, _)| *s).collect();
    let quantile = |q| percentile(&sigmas, q).map(|s| round(s, 3));
    json!({
        "measured_vertices": sigmas.len(),
        "sigma_median_mm": quantile(0.5),
        "sigma_p95_mm": quantile(0.95),
    })
}

/// The facts of a registration, in full precision: `iterations`, `start_iterations`,
/// `coarse_iterations`, `termination`, `from_features`, `rms_before`, `rms_after`, `inliers` (their
/// number) and `error_history`. Lengths are in units of the model.
pub fn registration_json(pose: &Registration) -> Map<String, Value> {
    let facts = json!({
        "iterations": pose.iterations,
        "start_iterations": pose.start_iterations,
        "coarse_iterations": pose.coarse_iterations,
        "termination": pose.termination,
        "from_features": pose.from_landmarks,
        "rms_before": pose.rms_before,
        "rms_after": pose.rms_after,
        "inliers": pose.inliers.len(),
        "error_history": pose.history,
    });
    match facts {
        Value::Object(facts) => facts,
        _ => Map::new(),
    }
}

fn round(value: f64, digits: i32) -> f64 {
    let k = 10f64.powi(digits);
    (value * k).round() / k
}

/// Writes the result of a run into a folder. `record`, where given, holds what the stages showed;
/// with `keep_stages` it is written to `stages/`.
///
/// # Errors
/// [`Error::File`] naming the file that could not be written.
pub fn write_result(
    folder: &Path,
    capture: &Capture,
    result: &Reconstruction,
    record: &Record,
    frame: Frame,
    keep_stages: bool,
) -> Result<(), Error> {
    let html = || {
        let html = report::html(capture, result, record)?;
        Ok::<_, Error>(io::atomic::write(&folder.join("report.html"), html.as_bytes())?)
    };
    let files = || write_files(folder, result, frame);
    let (html, files) = rayon::join(html, files);
    files.and(html)?;
    if keep_stages {
        record.write(&folder.join(STAGES_FOLDER))?;
    }
    let text = serde_json::to_string_pretty(&result_json(result))
        .map_err(|e| Error::Input(format!("result.json: {e}")))?;
    // last, so that its presence says that the result is complete
    io::atomic::write(&folder.join("result.json"), format!("{text}\n").as_bytes())?;
    Ok(())
}

/// The mesh, the points and the pictures.
fn write_files(folder: &Path, result: &Reconstruction, frame: Frame) -> Result<(), Error> {
    let mesh = result.mesh_in(frame);
    let png = match &result.texture {
        Some(texture) => Some(io::encode_png(&texture.image).map_err(|f| f.in_file(folder))?),
        None => None,
    };
    match &png {
        Some(png) => io::obj::write_with(&folder.join("face.obj"), &mesh, "texture.png", png)?,
        None => io::obj::write(&folder.join("face.obj"), &mesh, None)?,
    }
    if !result.landmarks.is_empty() {
        let axes = match frame {
            Frame::Model => ["y", "z"],
            Frame::Camera => ["-y", "-z"],
        };
        let text = landmarks_toml("face", &result.landmarks, axes);
        io::atomic::write(&sidecar_path(&folder.join("face.obj")), text.as_bytes())?;
    }
    let glb = io::glb::encode(&mesh, png.as_deref());
    io::atomic::write(&folder.join("face.glb"), &glb)?;
    let cloud = match frame {
        Frame::Model => result.cloud.transformed(&result.model_from_camera),
        Frame::Camera => result.cloud.clone(),
    };
    let unit = if result.metric { "millimetres" } else { "model units" };
    let comment = format!("measured points, {frame} frame, {unit}");
    io::ply::write_cloud(&folder.join("cloud.ply"), &cloud, &comment)?;
    io::table::write_matches(&folder.join("matches.csv"), &match_rows(result, frame))?;
    for (name, table) in [
        ("landmarks.csv", number_tables::landmarks_csv(result)),
        ("distances.csv", number_tables::distances_csv(result)),
    ] {
        io::atomic::write(&folder.join(name), table.as_bytes())?;
    }
    for (name, depth) in ["depth_left.png", "depth_right.png"].iter().zip(&result.depth) {
        io::image::write_png(&folder.join(name), &depth.to_u8())?;
    }
    if let Some(texture) = &result.texture {
        io::image::write_png(
            &folder.join("coverage.png"),
            &report::marks::coverage(&texture.coverage),
        )?;
    }
    Ok(())
}

/// The table of matches of a run.
pub fn match_rows(result: &Reconstruction, frame: Frame) -> Vec<MatchRow> {
    let to_frame = match frame {
        Frame::Model => result.model_from_camera,
        Frame::Camera => Similarity::identity(),
    };
    matches_table(&result.matches, &result.rectification, &result.match_points, &to_frame)
}

/// A table of matches in the photos' own pixels, with their points where there are any.
pub fn matches_table(
    matches: &[Match],
    views: &Rectification,
    points: &[Option<Vec3>],
    frame_from_points: &Similarity,
) -> Vec<MatchRow> {
    let points = points.iter().copied().chain(std::iter::repeat(None));
    matches
        .iter()
        .zip(points)
        .enumerate()
        .map(|(id, (m, point))| MatchRow {
            id,
            left: views.left.to_photo(m.left),
            right: views.right.to_photo(m.right),
            disparity: Some(m.disparity()),
            position: point.map(|p| frame_from_points.apply(&p)),
            lattice: m.lattice,
            score: m.score,
        })
        .collect()
}
