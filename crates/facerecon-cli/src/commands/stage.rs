//! Every stage alone, from files to files.

use std::path::Path;

use facerecon_core::data::{CloudFrame, Rgb};
use facerecon_core::math::{Similarity, Vec3};
use facerecon_core::output::report::marks;
use facerecon_core::pipeline::Error;
use facerecon_core::pipeline::Params;
use facerecon_core::pipeline::single_stage;
use facerecon_core::stages::detect::{self, DetectMethod};
use facerecon_core::stages::filter;
use facerecon_core::stages::register::RegisterInput;
use facerecon_core::stages::{
    deform as deform_stage, register as register_stage, smooth as smooth_stage,
};
use facerecon_core::template::Template;
use facerecon_core::{io, output};
use serde::{Deserialize, Deserializer};
use serde_json::json;

use super::{capture, load_params, named_png, template, to_json};
use crate::args::{
    DeformArgs, DetectArgs, FilterArgs, FilterStep, RegisterArgs, SmoothArgs, StageArgs,
    SurfaceArgs, TextureArgs, TriangulateArgs,
};
use crate::failure::Failure;
use crate::output::Terminal;
use crate::progress::Progress;

/// Thesis section 2.2: one photo after a step of the preprocessing.
pub(super) fn filter(args: &FilterArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    named_png(&args.output)?;
    let photo = io::image::read_photo(&args.image)?;
    let filtered = filter::filter(&photo.gray, &params.filter, &())?;
    let picture = match args.step {
        FilterStep::Equalize => filtered.equalized.unwrap_or(photo.gray),
        FilterStep::Sharpen => filtered.sharpened,
        FilterStep::Threshold => filtered.binary,
        FilterStep::Thin => {
            let thin = detect::DetectParams { method: DetectMethod::Thin, ..params.detect };
            let found = detect::detect(&filtered.binary, &thin, &())?;
            found.thinned.unwrap_or(filtered.binary)
        }
    };
    io::image::write_png(&args.output, &picture.to_u8())?;
    terminal.wrote(&[&args.output], json!({}));
    Ok(())
}

/// The dots of one photo.
pub(super) fn detect(args: &DetectArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    args.picture.as_deref().map_or(Ok(()), named_png)?;
    let photo = io::image::read_photo(&args.image)?;
    let found = single_stage::detect_dots(&photo.gray, &params, &Progress::new(terminal.quiet))?;
    if let Some(path) = &args.output {
        io::table::write_dots(path, &found.dots)?;
        terminal.say(format!("wrote {}", path.display()));
    }
    if let Some(path) = &args.picture {
        let mut picture: Rgb = photo.rgb.clone();
        marks::crosses(&mut picture, found.dots.iter().map(|d| (d.position, [255, 64, 32])));
        io::image::write_png(path, &picture)?;
        terminal.say(format!("wrote {}", path.display()));
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

/// The table of matches of a capture.
pub(super) fn find_matches(args: &StageArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = capture::read(&args.capture)?;
    let found =
        single_stage::find_matches(&loaded.capture, &params, &Progress::new(terminal.quiet))?;
    let rows =
        output::matches_table(&found.matches, &found.rectification, &[], &Similarity::identity());
    io::table::write_matches(&args.output, &rows)?;
    for warning in &loaded.warnings {
        terminal.warning(warning);
    }
    terminal.say(format!("wrote {}", args.output.display()));
    if terminal.json {
        let [left, right] = found.dots;
        let dots = json!({ "left": left, "right": right });
        terminal.result(&to_json(&json!({ "dots": dots, "matches": found.matches.len() })));
    } else {
        terminal.result(&format!("{} matches", found.matches.len()));
    }
    Ok(())
}

/// Points in space from a table of matches.
pub(super) fn triangulate(args: &TriangulateArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let capture = io::capture::read_capture(&args.capture)?.capture;
    let head = template::load(&args.template, terminal)?;
    let rows = io::table::read_matches(&args.matches)?;
    let pairs: Vec<_> = rows.iter().map(|r| (r.left, r.right)).collect();
    let points = single_stage::triangulate_photo_pairs(&capture, &pairs, &head, &params, &())?;
    let frame =
        if points.frame.is_metric() { "camera frame, mm" } else { "model units: no calibration" };
    io::ply::write_cloud(&args.output, &points.cloud, frame)?;
    terminal.say(format!("{} points, {frame}", points.cloud.len()));
    let facts = json!({ "points": points.cloud.len(), "metric": points.frame.is_metric() });
    terminal.wrote(&[&args.output], facts);
    Ok(())
}

/// A cloud in the frame of the generic head.
pub(super) fn register(args: &RegisterArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let head = template::load(&args.template, terminal)?;
    let cloud = io::read_points(&args.cloud)?;
    let features = features(args.capture.as_deref(), &head, &params)?;
    let input = RegisterInput {
        data: &cloud,
        model: &head.mesh,
        coarse: head.coarse.as_ref(),
        features: &single_stage::feature_points(&features, &head),
        frame: if args.model_units { CloudFrame::Model } else { CloudFrame::Metric },
    };
    let pose = register_stage::register(&input, &params.register, &Progress::new(terminal.quiet))?;
    let (_, model_from_data) = single_stage::to_scale(&head, &pose, !args.model_units);
    io::ply::write_cloud(&args.output, &cloud.transformed(&model_from_data), "model frame")?;
    let facts = json!({
        "model_from_data": model_from_data.to_rows(),
        "template_scale": 1.0 / pose.model_from_data.scale,
        "iterations": pose.iterations,
        "from_features": pose.from_features,
        "termination": pose.termination,
        "rms_before": pose.rms_before,
        "rms_after": pose.rms_after,
        "error_history": pose.history,
    });
    let beside = args.output.with_extension("json");
    io::atomic::write(&beside, format!("{facts:#}\n").as_bytes())?;
    terminal.say(format!("wrote {} and {}", args.output.display(), beside.display()));
    if terminal.json {
        terminal.result(&to_json(&facts));
    }
    Ok(())
}

/// The generic head bent to a registered cloud.
pub(super) fn deform(args: &DeformArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let head = template::load(&args.template, terminal)?;
    let cloud = io::read_points(&args.cloud)?;
    let beside = args.cloud.with_extension("json");
    let pose = match &args.pose {
        Some(path) => Pose::read(path)?,
        None if beside.is_file() => Pose::read(&beside)?,
        None if args.capture.is_some() => {
            return Err(Failure::usage("--capture needs --pose, the JSON that register wrote"));
        }
        None => Pose::default(),
    };
    let features = features(args.capture.as_deref(), &head, &params)?;
    let size = Similarity { scale: pose.template_scale, ..Similarity::identity() };
    let mesh = head.mesh.transformed(&size);
    let assignments =
        facerecon_core::spatial::eliminate_multiple(&cloud.points, &mesh.vertices, None);
    let input = deform_stage::DeformInput {
        template: &mesh,
        data: &cloud,
        assignments: &assignments,
        features: &single_stage::feature_goals(&features, &head, &pose.model_from_data),
    };
    let bent = deform_stage::deform(&input, &params.deform, &Progress::new(terminal.quiet))?;
    io::write_mesh(&args.output, &bent.mesh, None)?;
    terminal.say(format!(
        "{:.3} from its goals before, {:.3} after (root mean square)",
        bent.rms_before, bent.rms_after
    ));
    let facts = json!({
        "goals": assignments.len(),
        "features": input.features.len(),
        "rms_before": bent.rms_before,
        "rms_after": bent.rms_after,
    });
    terminal.wrote(&[&args.output], facts);
    Ok(())
}

/// The measured surface of a capture.
pub(super) fn surface(args: &SurfaceArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = capture::read(&args.capture)?;
    let head = template::load(&args.template, terminal)?;
    let progress = Progress::new(terminal.quiet);
    let found = single_stage::measure_surface(&loaded.capture, &head, &params, &progress)?;
    drop(progress);
    let mesh = &found.mesh;
    io::write_mesh(&args.output, mesh, None)?;
    for warning in &loaded.warnings {
        terminal.warning(warning);
    }
    let frame = if found.metric { "camera frame, mm" } else { "model units: no calibration" };
    let (path, count) = (args.output.display(), mesh.vertices.len());
    terminal.say(format!("wrote {path}: {count} vertices ({frame})"));
    Ok(())
}

/// A smoothed mesh.
pub(super) fn smooth(args: &SmoothArgs, terminal: &Terminal) -> Result<(), Failure> {
    // smoothing nothing would be an odd thing to be asked for: the thesis's way is the default here
    let mut params = load_params(&args.params)?;
    if args.params.profile.is_none() && params.smooth == Params::default().smooth {
        params.smooth = Params::of(facerecon_core::pipeline::Profile::Facebuilder).smooth;
    }
    let loaded = io::read_mesh(&args.mesh)?;
    // nothing tells what was measured: the whole mesh keeps its bounds
    let reference = &loaded.mesh.vertices;
    let done = smooth_stage::smooth(&loaded.mesh, reference, &params.smooth, &())?;
    io::write_mesh(&args.output, &done.mesh, loaded.texture.as_ref())?;
    terminal.say(format!("{} steps", done.steps));
    terminal.wrote(&[&args.output], json!({ "steps": done.steps }));
    Ok(())
}

/// A mesh coloured from the photographs of a capture.
pub(super) fn texture(args: &TextureArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = io::read_mesh(&args.mesh)?;
    let capture = io::capture::read_capture(&args.capture)?.capture;
    let before_cameras = match &args.pose {
        Some(path) => loaded.mesh.transformed(&Pose::read(path)?.model_from_data.inverse()),
        None => loaded.mesh.clone(),
    };
    let progress = Progress::new(terminal.quiet);
    let made = single_stage::texture_mesh(&capture, &before_cameras, &params, &progress)?;
    io::write_mesh(&args.output, &loaded.mesh, Some(&made.image))?;
    terminal.wrote(&[&args.output], json!({ "texture_px": made.image.width() }));
    Ok(())
}

/// The features marked in a capture, in its own frame; none without a capture.
fn features(
    capture: Option<&Path>,
    head: &Template,
    params: &Params,
) -> Result<Vec<(String, Vec3)>, Failure> {
    match capture {
        Some(path) => {
            let capture = io::capture::read_capture(path)?.capture;
            Ok(single_stage::features(&capture, head, params)?)
        }
        None => Ok(Vec::new()),
    }
}

/// What `register` found out, as later commands need it.
#[derive(Deserialize)]
struct Pose {
    #[serde(deserialize_with = "similarity")]
    model_from_data: Similarity,
    template_scale: f64,
}

impl Default for Pose {
    fn default() -> Self {
        Self { model_from_data: Similarity::identity(), template_scale: 1.0 }
    }
}

impl Pose {
    fn read(path: &Path) -> Result<Self, Failure> {
        let text = io::read_text(path, "pose")?;
        let fault = |reason: String| {
            let file = path.display();
            Error::Input(format!("{file}: this is not the JSON that register writes: {reason}"))
        };
        let pose: Self = serde_json::from_str(&text).map_err(|e| fault(e.to_string()))?;
        if !(pose.template_scale > 0.0 && pose.template_scale.is_finite()) {
            return Err(fault(format!("template_scale is {}", pose.template_scale)).into());
        }
        Ok(pose)
    }
}

fn similarity<'de, D: Deserializer<'de>>(from: D) -> Result<Similarity, D::Error> {
    let rows = <[[f64; 4]; 4]>::deserialize(from)?;
    Similarity::from_rows(&rows).ok_or_else(|| {
        serde::de::Error::custom("model_from_data is no rotation with shift and scale")
    })
}
