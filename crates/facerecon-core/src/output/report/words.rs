//! The numbers of a run in words.

use crate::pipeline::Reconstruction;
use crate::stages::surface::SurfaceMethod;

/// A few sentences that say what was measured, how well, and what to mind.
pub fn summary(result: &Reconstruction) -> Vec<String> {
    let mut words = Vec::new();
    words.push(format!(
        "{} dots were found in the left and {} in the right photo; {} of them were matched.",
        result.dots[0],
        result.dots[1],
        result.matches.len()
    ));
    let unit = if result.metric { "mm" } else { "model units" };
    if result.cloud.len() > result.matches.len() {
        words.push(format!(
            "Between the dots the surface was measured at {} points.",
            result.cloud.len()
        ));
    }
    words.push(if result.metric {
        "The cameras are calibrated: lengths are millimetres.".to_owned()
    } else {
        "The cameras are not calibrated: lengths are in units of the generic head, not millimetres."
            .to_owned()
    });
    if let Some(pose) = &result.registration {
        words.push(format!(
            "The points came to the generic head in {} steps: they lay {:.2} {unit} from it before \
             and {:.2} {unit} after (root mean square of the closest).",
            pose.iterations, pose.rms_before, pose.rms_after
        ));
    }
    if result.params.surface.method != SurfaceMethod::None {
        words.push(format!(
            "The mesh is the measured surface itself, without a generic head: {} vertices; what was \
             not measured is open.",
            result.mesh.vertices.len()
        ));
    }
    if let Some(size) = result.face_size() {
        words.push(format!(
            "The face is {:.1} mm wide between the upper ear connections and {:.1} mm high from the \
             saddle of the nose to the chin.",
            size.width_mm, size.height_mm
        ));
    }
    words.push(format!("The run took {:.2} s.", total_ms(result) / 1000.0));
    words
}

/// Milliseconds of all stages together.
pub(super) fn total_ms(result: &Reconstruction) -> f64 {
    result.timings_ms.iter().map(|t| t.1).sum()
}
