//! From rectified photos to matches: detect and correspond, for either kind of pattern.

use super::inputs;
use super::run::{Run, SideObserver};
use super::{Error, Params};
use crate::data::{Capture, Dot, Gray, PatternKind, Rgb};
use crate::math::Vec3;
use crate::observer::{Artifact, Observer};
use crate::stages::correspond::{Correspondence, correspond, correspond_stripes};
use crate::stages::detect::{DetectMethod, Detection, detect};
use crate::stages::filter::filter;
use crate::stages::rectify::Rectified;

/// The matches of a rectified capture, and the dots they were chosen from.
pub(super) struct DotsAndMatches {
    pub(super) correspondence: Correspondence,
    /// Dots of the left and the right photo, rectified pixels; empty for stripes.
    pub(super) dots: [Vec<Dot>; 2],
    /// Number of dots in the left and the right photo; for stripes, of matched edges.
    pub(super) counts: [usize; 2],
}

/// Detects the pattern in both photos and matches it.
pub(super) fn match_photos(
    run: &Run<'_>,
    capture: &Capture,
    rectified: &Rectified,
    params: &Params,
) -> Result<DotsAndMatches, Error> {
    match capture.pattern.kind {
        PatternKind::Stripes => {
            let correspondence =
                run.stage("correspond", |o| match_stripes(rectified, params, o))?;
            let counts = [correspondence.matches.len(); 2];
            Ok(DotsAndMatches { correspondence, dots: [Vec::new(), Vec::new()], counts })
        }
        PatternKind::Dots => {
            let dots = |side, image| {
                run.stage("detect", |observer| {
                    detect_dots(image, params, &SideObserver { side, observer })
                })
            };
            let (left, right) = (dots("left", &rectified.left)?, dots("right", &rectified.right)?);
            let input = inputs::correspond(capture, rectified, &left, &right);
            let correspondence =
                run.stage("correspond", |o| correspond(&input, &params.correspond, o))?;
            let counts = [left.dots.len(), right.dots.len()];
            Ok(DotsAndMatches { correspondence, dots: [left.dots, right.dots], counts })
        }
    }
}

/// The dots of one photo: after the thesis's preprocessing where `detect.method` is `thin`, else
/// from the photo itself.
///
/// # Errors
/// Those of the stages filter and detect.
pub fn detect_dots(
    image: &Gray,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Detection, Error> {
    let found = if params.detect.method == DetectMethod::Thin {
        let filtered = filter(image, &params.filter, observer)?;
        detect(&filtered.binary, &params.detect, observer)?
    } else {
        detect(image, &params.detect, observer)?
    };
    let positions: Vec<Vec3> = found.dots.iter().map(|d| d.position.push(0.0)).collect();
    observer.artifact("detect", "dots", Artifact::Points(&positions));
    Ok(found)
}

/// The matches of a capture of stripes. Rectification keeps the colours of such a capture.
fn match_stripes(
    rectified: &Rectified,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Correspondence, Error> {
    let rig = rectified.rectification.rig.as_ref();
    let empty = [Rgb::filled(0, 0, [0; 3]), Rgb::filled(0, 0, [0; 3])];
    let [left, right] = rectified.colors.as_ref().unwrap_or(&empty);
    Ok(correspond_stripes([left, right], rig, &params.correspond.stripes, observer)?)
}
