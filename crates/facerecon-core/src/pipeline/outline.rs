//! The stage outline with what it is given, and what its result rules out.

use super::measured::CameraOutline;
use super::run::SideObserver;
use crate::camera::{Rectification, View};
use crate::data::{Capture, CloudFrame, Gray, Match, Outline};
use crate::math::{Similarity, Vec2};
use crate::observer::Observer;
use crate::pipeline::{Error, Params};
use crate::spatial::median_spacing;
use crate::stages::outline::{OutlineInput, outline};
use crate::stages::refine::Refined;

/// What lies farther than this outside the subject in a photo is not on it, dot spacings: the
/// centre of a dot on the rim lies up to a third of a spacing outside.
const OUTSIDE_SPACINGS: f64 = 0.5;
/// Where a larger share of the matches lies outside, the outline is not where the dots were: the
/// head moved between the photos with and without the pattern, or the outline is wrong.
const MAX_OUTSIDE: f64 = 0.05;

/// The subject's outlines in the left and the right plain photo, where they are found.
pub(super) fn subject_outlines(
    capture: &Capture,
    views: &Rectification,
    matches: &[Match],
    params: &Params,
    observer: &dyn Observer,
) -> Result<[Option<Outline>; 2], Error> {
    let mut found = [None, None];
    let Some(plain) = &capture.plain else { return Ok(found) };
    let sides = [(&views.left, "left"), (&views.right, "right")];
    for (i, (view, side)) in sides.into_iter().enumerate() {
        let dots: Vec<Vec2> = matches.iter().map(|m| in_photo(view, m, i)).collect();
        let input = OutlineInput { image: &plain[i].rgb, dots: &dots };
        let named = SideObserver { side, observer };
        let candidate = outline(&input, &params.outline, &named)?;
        found[i] = candidate.filter(|o| {
            let limit = OUTSIDE_SPACINGS * median_spacing(&dots).unwrap_or(0.0);
            let outside = dots.iter().filter(|p| is_outside(o, **p, limit)).count();
            outside as f64 <= MAX_OUTSIDE * dots.len() as f64
        });
    }
    Ok(found)
}

fn in_photo(view: &View, m: &Match, side: usize) -> Vec2 {
    view.to_photo([m.left, m.right][side])
}

fn is_outside(outline: &Outline, pixel: Vec2, limit_px: f64) -> bool {
    outline.distance_px(pixel).is_some_and(|d| d > limit_px)
}

/// Removes the matches that lie outside the subject in either photo, and the dense disparity there:
/// both photos see a matched point, so it is on the subject in both. Returns how many matches were
/// removed.
pub(super) fn keep_subject(
    matches: &mut Vec<Match>,
    dense: Option<&mut Refined>,
    outlines: &[Option<Outline>; 2],
    views: &Rectification,
) -> usize {
    if outlines.iter().all(Option::is_none) {
        return 0;
    }
    let dots: Vec<Vec2> = matches.iter().map(|m| m.left).collect();
    let limit = OUTSIDE_SPACINGS * median_spacing(&dots).unwrap_or(0.0);
    let outside = |left: Vec2, right: Vec2| {
        let in_view = |i: usize, view: &View, p: Vec2| {
            outlines[i].as_ref().is_some_and(|o| is_outside(o, view.to_photo(p), limit))
        };
        in_view(0, &views.left, left) || in_view(1, &views.right, right)
    };
    let before = matches.len();
    matches.retain(|m| !outside(m.left, m.right));
    if let Some(dense) = dense {
        let (width, height) = dense.disparity.size();
        let kept = Gray::par_from_fn(width, height, |x, y| {
            let d = dense.disparity.at(x, y);
            let left = Vec2::new(x as f64, y as f64);
            if d.is_finite() && outside(left, left - Vec2::new(f64::from(d), 0.0)) {
                f32::NAN
            } else {
                d
            }
        });
        dense.disparity = kept;
        dense.matches.clone_from(matches);
    }
    before - matches.len()
}

/// The outlines with their cameras in the frame of the points; none where the cameras are not
/// calibrated.
pub(super) fn camera_outlines(
    capture: &Capture,
    frame: CloudFrame,
    outlines: [Option<Outline>; 2],
) -> Vec<CameraOutline> {
    let Some(rig) = capture.rig.as_ref().filter(|_| frame != CloudFrame::Model) else {
        return Vec::new();
    };
    let cameras = [(rig.left, Similarity::identity()), (rig.right, rig.right_from_left)];
    let placed = cameras.into_iter().zip(outlines).filter_map(|((camera, pose), outline)| {
        Some(CameraOutline { camera, camera_from_points: pose, outline: outline? })
    });
    placed.collect()
}
