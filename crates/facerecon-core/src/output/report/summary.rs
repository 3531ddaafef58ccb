//! The numbers of a run as sentences.

use crate::data::PatternKind;
use crate::pipeline::Reconstruction;
use crate::stages::surface::SurfaceMethod;

/// A few sentences that say what was measured, and how well.
pub fn summary(result: &Reconstruction) -> Vec<String> {
    let unit = if result.metric { "mm" } else { "model units" };
    let mut sentences = vec![matches(result)];
    if result.cloud.len() > result.matches.len() {
        let points = result.cloud.len();
        sentences.push(format!("The surface was measured at {points} points between the dots."));
    }
    sentences.push(if result.metric {
        "The cameras are calibrated: lengths are in millimetres.".to_owned()
    } else {
        "The cameras are not calibrated: lengths are in units of the template, not in millimetres."
            .to_owned()
    });
    if let Some(pose) = &result.registration {
        sentences.push(format!(
            "Registration took {} iterations; the RMS distance of the points from the template was \
             {:.2} {unit} before and {:.2} {unit} after.",
            pose.iterations, pose.rms_before, pose.rms_after
        ));
    }
    if result.params.surface.method != SurfaceMethod::None {
        sentences.push(format!(
            "The mesh is the measured surface, without a template: {} vertices, with holes where \
             nothing was measured.",
            result.mesh.vertices.len()
        ));
    }
    sentences.extend(face_size(result));
    sentences.push(format!("The run took {:.2} s.", total_ms(result) / 1000.0));
    sentences
}

/// Width and height of the face, as far as they were measured.
fn face_size(result: &Reconstruction) -> Option<String> {
    let size = result.face_size()?;
    let width =
        size.width_mm.map(|mm| format!("{mm:.1} mm wide between the upper ear attachments"));
    let height =
        size.height_mm.map(|mm| format!("{mm:.1} mm high from the saddle of the nose to the chin"));
    let parts: Vec<String> = [width, height].into_iter().flatten().collect();
    if parts.is_empty() {
        return None;
    }
    Some(format!("The face is {}.", parts.join(" and ")))
}

fn matches(result: &Reconstruction) -> String {
    let matches = result.matches.len();
    match result.pattern {
        PatternKind::Dots => format!(
            "{} dots were found in the left photo and {} in the right photo; {matches} were matched.",
            result.dots[0], result.dots[1]
        ),
        PatternKind::Stripes => format!("{matches} points on stripe edges were matched."),
    }
}

/// Time of all stages, milliseconds.
pub(super) fn total_ms(result: &Reconstruction) -> f64 {
    result.timings_ms.iter().map(|t| t.1).sum()
}
