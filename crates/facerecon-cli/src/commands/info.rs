//! `facerecon info`, `facerecon convert`.

use std::path::Path;

use facerecon_core::data::{PatternKind, Topology};
use facerecon_core::io;
use serde_json::{Value, json};

use super::shared::to_json;
use crate::failure::Failure;
use crate::output::Terminal;

/// Prints facts about a file as JSON.
pub(super) fn info(file: &Path, terminal: &Terminal) -> Result<(), Failure> {
    let extension =
        file.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let facts = if file.is_dir() || extension == "toml" {
        capture(file)?
    } else {
        match extension.as_str() {
            "png" | "jpg" | "jpeg" | "gif" => image(file)?,
            "yml" | "yaml" | "xml" | "json" => calibration(file)?,
            _ => mesh(file)?,
        }
    };
    terminal.result(&to_json(&facts));
    Ok(())
}

fn image(file: &Path) -> Result<Value, Failure> {
    let photo = io::image::read_photo(file)?;
    let (width, height) = photo.size();
    let n = photo.gray.data().len().max(1) as f64;
    let mean = photo.gray.data().iter().map(|v| f64::from(*v)).sum::<f64>() / n;
    let saturated = photo.gray.data().iter().filter(|v| **v >= 254.5).count() as f64 / n;
    Ok(json!({
        "kind": "image", "width": width, "height": height,
        "mean_grey": mean, "saturated_fraction": saturated,
    }))
}

fn mesh(file: &Path) -> Result<Value, Failure> {
    let loaded = io::read_mesh(file)?;
    let mesh = &loaded.mesh;
    let topology = Topology::new(mesh);
    let bounds = mesh.bounds().map(|(low, high)| json!([low.as_slice(), high.as_slice()]));
    let components = topology.components().iter().max().map_or(0, |m| m + 1);
    Ok(json!({
        "kind": "mesh",
        "vertices": mesh.vertices.len(),
        "faces": mesh.faces.len(),
        "has_uv": mesh.has_uv(),
        "texture": loaded.texture.map(|t| json!({ "width": t.width(), "height": t.height() })),
        "vertex_colors": !mesh.colors.is_empty(),
        "bounds": bounds,
        "components": components,
        "border_vertices": topology.border.iter().filter(|b| **b).count(),
        "non_manifold_edges": topology.non_manifold_edges,
        "warnings": loaded.warnings,
    }))
}

fn calibration(file: &Path) -> Result<Value, Failure> {
    let found = io::calibration::read_calibration(file)?;
    let rig = found.rig;
    Ok(json!({
        "kind": "calibration",
        "baseline_mm": rig.baseline_mm(),
        "focal_left_px": [rig.left.fx, rig.left.fy],
        "focal_right_px": [rig.right.fx, rig.right.fy],
        "angle_deg": rig.right_from_left.angle().to_degrees(),
        "distorted": !(rig.left.distortion.is_none() && rig.right.distortion.is_none()),
        "image_size": rig.image_size,
        "warnings": found.warnings,
    }))
}

fn capture(file: &Path) -> Result<Value, Failure> {
    let loaded = io::capture::read_capture(file)?;
    let c = &loaded.capture;
    let (width, height) = c.left.size();
    let pattern = match c.pattern.kind {
        PatternKind::Dots => "dots",
        PatternKind::Stripes => "stripes",
    };
    Ok(json!({
        "kind": "capture", "width": width, "height": height,
        "pattern": { "kind": pattern, "columns": c.pattern.columns, "rows": c.pattern.rows,
            "rotation_deg": c.pattern.rotation.to_degrees() },
        "plain_pair": c.plain.is_some(),
        "extra_photos": c.extra.len(),
        "calibrated": c.rig.is_some(),
        "baseline_mm": c.rig.map(|r| r.baseline_mm()),
        "seeds": c.seeds.is_some(),
        "landmarks": c.landmarks.len(),
        "warnings": loaded.warnings,
    }))
}

/// Converts a mesh.
pub(super) fn convert(input: &Path, output: &Path, terminal: &Terminal) -> Result<(), Failure> {
    let loaded = io::read_mesh(input)?;
    io::write_mesh(output, &loaded.mesh, loaded.texture.as_ref())?;
    for warning in &loaded.warnings {
        terminal.warning(warning);
    }
    let facts = json!({ "vertices": loaded.mesh.vertices.len(), "faces": loaded.mesh.faces.len() });
    terminal.wrote(&[output], facts);
    Ok(())
}
