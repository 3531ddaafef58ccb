//! Single stages, from files to files.

use std::path::Path;

use facerecon_core::data::{CloudFrame, MeasuredLandmark, Rgb};
use facerecon_core::math::Similarity;
use facerecon_core::output::report::marks;
use facerecon_core::single_stage;
use facerecon_core::spatial::eliminate_multiple;
use facerecon_core::stages::detect::{self, DetectMethod};
use facerecon_core::stages::register::RegisterInput;
use facerecon_core::stages::{
    deform as deform_stage, filter as filter_stage, register as register_stage,
    smooth as smooth_stage,
};
use facerecon_core::template::Template;
use facerecon_core::{Params, Profile};
use facerecon_core::{io, output};
use serde_json::json;

use super::pose::{self, Pose};
use super::shared::{load_params, require_png_name, to_json};
use super::{capture, template};
use crate::args::{
    DeformArgs, DetectArgs, FilterArgs, FilterStep, RegisterArgs, SmoothArgs, StageArgs,
    SurfaceArgs, TextureArgs, TriangulateArgs,
};
use crate::failure::Failure;
use crate::output::Terminal;
use crate::progress::Progress;

/// Colour of the crosses on detected dots, sRGB.
const DOT_COLOR: [u8; 3] = [255, 64, 32];

/// Filters one photo (thesis section 2.2) and writes the image after one step.
pub(super) fn filter(args: &FilterArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    require_png_name(&args.output)?;
    let photo = io::image::read_photo(&args.image)?;
    let progress = Progress::new(terminal);
    let filtered = filter_stage::filter(&photo.gray, &params.filter, &progress)?;
    let image = match args.step {
        FilterStep::Equalize => filtered.equalized.unwrap_or(photo.gray),
        FilterStep::Sharpen => filtered.sharpened,
        FilterStep::Threshold => filtered.binary,
        FilterStep::Thin => {
            let thin = detect::DetectParams { method: DetectMethod::Thin, ..params.detect };
            let found = detect::detect(&filtered.binary, &thin, &progress)?;
            found.thinned.unwrap_or(filtered.binary)
        }
    };
    drop(progress);
    io::image::write_png(&args.output, &image.to_u8())?;
    terminal.wrote(&[&args.output], json!({}));
    Ok(())
}

/// Detects the dots of one photo.
pub(super) fn detect(args: &DetectArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    args.picture.as_deref().map_or(Ok(()), require_png_name)?;
    let photo = io::image::read_photo(&args.image)?;
    let found = single_stage::detect_dots(&photo.gray, &params, &Progress::new(terminal))?;
    if let Some(path) = &args.output {
        io::table::write_dots(path, &found.dots)?;
        terminal.message(format!("wrote {}", path.display()));
    }
    if let Some(path) = &args.picture {
        let mut picture: Rgb = photo.rgb.clone();
        marks::crosses(&mut picture, found.dots.iter().map(|d| (d.position, DOT_COLOR)));
        io::image::write_png(path, &picture)?;
        terminal.message(format!("wrote {}", path.display()));
    }
    if terminal.json {
        let facts = json!({ "dots": found.dots.len(), "spacing_px": found.spacing_px });
        terminal.result(&to_json(&facts));
    } else {
        let (count, spacing) = (found.dots.len(), found.spacing_px);
        terminal.result(&format!("{count} dots, {spacing:.2} px apart"));
    }
    Ok(())
}

/// Matches the dots of a capture and writes the table of matches.
pub(super) fn correspond(args: &StageArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = capture::read(&args.capture)?;
    loaded.warnings.iter().for_each(|w| terminal.warning(w));
    let found = single_stage::find_matches(&loaded.capture, &params, &Progress::new(terminal))?;
    let rows =
        output::matches_table(&found.matches, &found.rectification, &[], &Similarity::identity());
    io::table::write_matches(&args.output, &rows)?;
    terminal.message(format!("wrote {}", args.output.display()));
    if terminal.json {
        let [left, right] = found.dots;
        let dots = json!({ "left": left, "right": right });
        terminal.result(&to_json(&json!({ "dots": dots, "matches": found.matches.len() })));
    } else {
        terminal.result(&format!("{} matches", found.matches.len()));
    }
    Ok(())
}

/// Computes points in space from a table of matches.
pub(super) fn triangulate(args: &TriangulateArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = io::capture::read_capture(&args.capture)?;
    loaded.warnings.iter().for_each(|w| terminal.warning(w));
    let head = template::load(&args.template, terminal)?;
    let rows = io::table::read_matches(&args.matches)?;
    let pairs: Vec<_> = rows.iter().map(|r| (r.left, r.right)).collect();
    let progress = Progress::new(terminal);
    let points =
        single_stage::triangulate_photo_pairs(&loaded.capture, &pairs, &head, &params, &progress)?;
    drop(progress);
    let frame = frame_comment(points.frame.is_metric());
    io::ply::write_cloud(&args.output, &points.cloud, frame)?;
    terminal.message(format!("{} points, {frame}", points.cloud.len()));
    let facts = json!({ "points": points.cloud.len(), "metric": points.frame.is_metric() });
    terminal.wrote(&[&args.output], facts);
    Ok(())
}

/// Registers a cloud with the generic head.
pub(super) fn register(args: &RegisterArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let head = template::load(&args.template, terminal)?;
    let cloud = io::read_points(&args.cloud)?;
    let landmarks = landmarks(args.capture.as_deref(), &head, &params, terminal)?;
    let input = RegisterInput {
        data: &cloud,
        model: &head.mesh,
        coarse: head.coarse.as_ref(),
        chin_y: head.chin_y(),
        landmarks: &single_stage::landmark_points(&landmarks, &head),
        frame: if args.model_units { CloudFrame::Model } else { CloudFrame::Metric },
    };
    let pose = register_stage::register(&input, &params.register, &Progress::new(terminal))?;
    let (_, model_from_data) = single_stage::to_scale(&head, &pose, !args.model_units);
    io::ply::write_cloud(&args.output, &cloud.transformed(&model_from_data), "model frame")?;
    let facts = pose::to_json(&pose, &model_from_data);
    let beside = args.output.with_extension("json");
    io::atomic::write(&beside, format!("{facts:#}\n").as_bytes())?;
    terminal.message(format!("wrote {} and {}", args.output.display(), beside.display()));
    if terminal.json {
        terminal.result(&to_json(&facts));
    }
    Ok(())
}

/// Deforms the generic head to a registered cloud.
pub(super) fn deform(args: &DeformArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let head = template::load(&args.template, terminal)?;
    let cloud = io::read_points(&args.cloud)?;
    let beside = args.cloud.with_extension("json");
    let pose = match &args.pose {
        Some(path) => Pose::read(path)?,
        None if beside.is_file() => Pose::read(&beside)?,
        None if args.capture.is_some() => {
            return Err(Failure::usage("--capture needs --pose, the JSON written by register"));
        }
        None => Pose::default(),
    };
    let landmarks = landmarks(args.capture.as_deref(), &head, &params, terminal)?;
    let size = Similarity { scale: pose.template_scale, ..Similarity::identity() };
    let mesh = head.mesh.transformed(&size);
    let assignments = eliminate_multiple(&cloud.points, &mesh.vertices, None);
    let input = deform_stage::DeformInput {
        template: &mesh,
        data: &cloud,
        assignments: &assignments,
        landmarks: &single_stage::landmark_targets(&landmarks, &head, &pose.model_from_data),
        outlines: &[],
    };
    let deformed = deform_stage::deform(&input, &params.deform, &Progress::new(terminal))?;
    io::write_mesh(&args.output, &deformed.mesh, None)?;
    terminal.message(format!(
        "root mean square distance from the targets: {:.3} before, {:.3} after",
        deformed.rms_before, deformed.rms_after
    ));
    let facts = json!({
        "targets": assignments.len(),
        "landmarks": input.landmarks.len(),
        "rms_before": deformed.rms_before,
        "rms_after": deformed.rms_after,
    });
    terminal.wrote(&[&args.output], facts);
    Ok(())
}

/// Meshes the measured surface of a capture.
pub(super) fn surface(args: &SurfaceArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = capture::read(&args.capture)?;
    loaded.warnings.iter().for_each(|w| terminal.warning(w));
    let head = template::load(&args.template, terminal)?;
    let progress = Progress::new(terminal);
    let found = single_stage::measure_surface(&loaded.capture, &head, &params, &progress)?;
    drop(progress);
    let mesh = &found.mesh;
    io::write_mesh(&args.output, mesh, None)?;
    terminal.message(format!("{} vertices, {}", mesh.vertices.len(), frame_comment(found.metric)));
    let facts = json!({ "vertices": mesh.vertices.len(), "faces": mesh.faces.len() });
    terminal.wrote(&[&args.output], facts);
    Ok(())
}

/// Smooths a mesh.
pub(super) fn smooth(args: &SmoothArgs, terminal: &Terminal) -> Result<(), Failure> {
    // profile `precise` does not smooth: without an explicit choice this command takes the
    // thesis's settings
    let mut params = load_params(&args.params)?;
    if args.params.profile.is_none() && params.smooth == Params::default().smooth {
        params.smooth = Params::of(Profile::Facebuilder).smooth;
    }
    let loaded = io::read_mesh(&args.mesh)?;
    loaded.warnings.iter().for_each(|w| terminal.warning(w));
    // the measured part of the mesh is not known: the bounds of all its vertices are kept
    let reference = &loaded.mesh.vertices;
    let progress = Progress::new(terminal);
    let smoothed = smooth_stage::smooth(&loaded.mesh, reference, &params.smooth, &progress)?;
    drop(progress);
    io::write_mesh(&args.output, &smoothed.mesh, loaded.texture.as_ref())?;
    terminal.message(format!("{} steps", smoothed.steps));
    terminal.wrote(&[&args.output], json!({ "steps": smoothed.steps }));
    Ok(())
}

/// Textures a mesh from the photographs of a capture.
pub(super) fn texture(args: &TextureArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let mesh = io::read_mesh(&args.mesh)?;
    let capture = io::capture::read_capture(&args.capture)?;
    mesh.warnings.iter().chain(&capture.warnings).for_each(|w| terminal.warning(w));
    let in_camera_frame = match &args.pose {
        Some(path) => mesh.mesh.transformed(&Pose::read(path)?.model_from_data.inverse()),
        None => mesh.mesh.clone(),
    };
    let progress = Progress::new(terminal);
    let texture =
        single_stage::texture_mesh(&capture.capture, &in_camera_frame, &params, &progress)?;
    drop(progress);
    io::write_mesh(&args.output, &mesh.mesh, Some(&texture.image))?;
    terminal.wrote(&[&args.output], json!({ "texture_px": texture.image.width() }));
    Ok(())
}

/// The landmarks marked in a capture with their positions in its own frame; none without a
/// capture.
fn landmarks(
    capture: Option<&Path>,
    head: &Template,
    params: &Params,
    terminal: &Terminal,
) -> Result<Vec<MeasuredLandmark>, Failure> {
    let Some(path) = capture else { return Ok(Vec::new()) };
    let loaded = io::capture::read_capture(path)?;
    loaded.warnings.iter().for_each(|w| terminal.warning(w));
    Ok(single_stage::marked_landmarks(&loaded.capture, head, params)?)
}

/// The frame of a cloud or mesh, as the comment of a PLY file.
fn frame_comment(metric: bool) -> &'static str {
    if metric { "camera frame, mm" } else { "model units: no calibration" }
}
