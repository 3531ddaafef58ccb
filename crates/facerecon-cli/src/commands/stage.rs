//! Every stage alone, from files to files.

use facerecon_core::data::{CloudFrame, Rgb};
use facerecon_core::math::Similarity;
use facerecon_core::params::Params;
use facerecon_core::pipeline::parts;
use facerecon_core::report::marks;
use facerecon_core::stages::detect::{self, DetectMethod};
use facerecon_core::stages::filter;
use facerecon_core::stages::register::RegisterInput;
use facerecon_core::stages::{
    deform as deform_stage, register as register_stage, smooth as smooth_stage,
};
use facerecon_core::{io, result};
use serde_json::json;

use super::{capture, load_params, template, to_json};
use crate::args::{
    DeformArgs, DetectArgs, FilterArgs, FilterStep, RegisterArgs, SmoothArgs, StageArgs,
    TextureArgs, TriangulateArgs,
};
use crate::failure::Failure;
use crate::output::Terminal;
use crate::progress::Progress;

/// Thesis section 2.2: one photo after a step of the preprocessing.
pub(super) fn filter(args: &FilterArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
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
    terminal.say(format!("wrote {}", args.output.display()));
    Ok(())
}

/// The dots of one photo.
pub(super) fn detect(args: &DetectArgs, as_json: bool, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let photo = io::image::read_photo(&args.image)?;
    let found = parts::dots(&photo.gray, &params, &Progress::new(terminal.quiet))?;
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
    if as_json {
        let facts = json!({ "dots": found.dots.len(), "spacing_px": found.spacing_px });
        terminal.result(&to_json(&facts));
    } else {
        let (count, spacing) = (found.dots.len(), found.spacing_px);
        terminal.result(&format!("{count} dots, {spacing:.2} px apart"));
    }
    Ok(())
}

/// The table of matches of a capture.
pub(super) fn find_matches(
    args: &StageArgs,
    as_json: bool,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = capture::read(&args.capture)?;
    let found = parts::find_matches(&loaded.capture, &params, &Progress::new(terminal.quiet))?;
    let rows = result::table(&found.matches, &found.rectification, &[], &Similarity::identity());
    io::table::write_matches(&args.output, &rows)?;
    for warning in loaded.warnings.iter().chain(&found.warnings) {
        terminal.warning(warning);
    }
    terminal.say(format!("wrote {}", args.output.display()));
    if as_json {
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
    let points = parts::triangulate_photo_pairs(&capture, &pairs, &head, &params, &())?;
    let frame =
        if points.frame.is_metric() { "camera frame, mm" } else { "model units: no calibration" };
    io::ply::write_cloud(&args.output, &points.cloud, frame)?;
    terminal.say(format!("wrote {} ({frame})", args.output.display()));
    Ok(())
}

/// A cloud in the frame of the generic head.
pub(super) fn register(
    args: &RegisterArgs,
    as_json: bool,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let head = template::load(&args.template, terminal)?;
    let cloud = io::read_points(&args.cloud)?;
    let input = RegisterInput {
        data: &cloud,
        model: &head.mesh,
        coarse: head.coarse.as_ref(),
        features: &[],
        frame: if args.model_units { CloudFrame::Model } else { CloudFrame::Metric },
    };
    let pose = register_stage::register(&input, &params.register, &Progress::new(terminal.quiet))?;
    let (_, model_from_data) = parts::to_scale(&head, &pose, !args.model_units);
    io::ply::write_cloud(&args.output, &cloud.transformed(&model_from_data), "model frame")?;
    let facts = json!({
        "model_from_data": model_from_data.to_rows(),
        "template_scale": 1.0 / pose.model_from_data.scale,
        "iterations": pose.iterations,
        "termination": pose.termination,
        "rms_before": pose.rms_before,
        "rms_after": pose.rms_after,
        "error_history": pose.history,
    });
    let beside = args.output.with_extension("json");
    io::atomic::write(&beside, format!("{facts:#}\n").as_bytes())?;
    terminal.say(format!("wrote {} and {}", args.output.display(), beside.display()));
    if as_json {
        terminal.result(&to_json(&facts));
    }
    Ok(())
}

/// The generic head bent to a registered cloud.
pub(super) fn deform(args: &DeformArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let head = template::load(&args.template, terminal)?;
    let cloud = io::read_points(&args.cloud)?;
    let assignments =
        facerecon_core::spatial::eliminate_multiple(&cloud.points, &head.mesh.vertices, None);
    let input = deform_stage::DeformInput {
        template: &head.mesh,
        data: &cloud,
        assignments: &assignments,
        features: &[],
    };
    let bent = deform_stage::deform(&input, &params.deform, &Progress::new(terminal.quiet))?;
    io::write_mesh(&args.output, &bent.mesh, None)?;
    terminal.say(format!(
        "wrote {}: {:.3} from its goals before, {:.3} after (root mean square)",
        args.output.display(),
        bent.rms_before,
        bent.rms_after
    ));
    Ok(())
}

/// A smoothed mesh.
pub(super) fn smooth(args: &SmoothArgs, terminal: &Terminal) -> Result<(), Failure> {
    // smoothing nothing would be an odd thing to be asked for: the thesis's way is the default here
    let mut params = load_params(&args.params)?;
    if args.params.profile.is_none() && params.smooth == Params::default().smooth {
        params.smooth = Params::of(facerecon_core::params::Profile::Facebuilder).smooth;
    }
    let loaded = io::read_mesh(&args.mesh)?;
    let done = smooth_stage::smooth(&loaded.mesh, &[], &params.smooth, &())?;
    io::write_mesh(&args.output, &done.mesh, loaded.texture.as_ref())?;
    terminal.say(format!("wrote {} after {} steps", args.output.display(), done.steps));
    Ok(())
}

/// A mesh coloured from the photographs of a capture.
pub(super) fn texture(args: &TextureArgs, terminal: &Terminal) -> Result<(), Failure> {
    let params = load_params(&args.params)?;
    let loaded = io::read_mesh(&args.mesh)?;
    let capture = io::capture::read_capture(&args.capture)?.capture;
    let made =
        parts::texture_mesh(&capture, &loaded.mesh, &params, &Progress::new(terminal.quiet))?;
    io::write_mesh(&args.output, &loaded.mesh, Some(&made.image))?;
    terminal.say(format!("wrote {}", args.output.display()));
    Ok(())
}
