//! Leaves out what was measured in front of the eyes: glasses.

use super::measured::Points;
use super::run::Run;
use crate::camera::RectifiedRig;
use crate::data::{Gray, Match};
use crate::math::Vec2;
use crate::observer::Observer;
use crate::stages::landmarks::CoveredEyes;
use crate::stages::refine::Refined;

/// Removes the matches, the dense disparity and the points that lie on covers of the eyes.
pub(super) fn leave_out(
    run: &Run<'_>,
    covers: &CoveredEyes,
    matches: &mut Vec<Match>,
    dense: Option<&mut Refined>,
    rig: Option<&RectifiedRig>,
    points: &mut Points,
) {
    let kept: Vec<bool> = points.dots.points.iter().map(|p| !covers.contains_dot(p)).collect();
    let mut flags = kept.iter();
    // matches and dots are in the same order
    matches.retain(|_| flags.next().copied().unwrap_or(true));
    points.dots.retain(|i, _| kept.get(i).copied().unwrap_or(true));
    let is_dense = dense.is_some();
    points.all.retain(|_, p| if is_dense { !covers.contains(p) } else { !covers.contains_dot(p) });
    if let (Some(dense), Some(rig)) = (dense, rig) {
        let (width, height) = dense.disparity.size();
        let disparity = Gray::par_from_fn(width, height, |x, y| {
            let d = dense.disparity.at(x, y);
            let point = || rig.point(Vec2::new(x as f64, y as f64), f64::from(d));
            let covered = d.is_finite() && point().is_some_and(|p| covers.contains(&p));
            if covered { f32::NAN } else { d }
        });
        dense.disparity = disparity;
        dense.matches.clone_from(matches);
    }
    run.warn(
        "landmarks",
        &format!(
            "{} dots lie in front of the eye sockets, not on skin (glasses?): they were left out, \
             and the eyes are the template's; take the photos without glasses",
            covers.dots()
        ),
    );
}
