//! The three marked pairs.

use super::limits::Limits;
use crate::data::Seeds;
use crate::math::Vec2;
use crate::spatial::PointIndex;
use crate::stages::correspond::error::CorrespondError;
use crate::stages::correspond::matches::IndexedMatch;

/// Added to the row tolerance for seeds, pixels: marks by hand are rounded to whole pixels.
const MARKING_ERROR_PX: f64 = 1.0;
/// Greatest difference of disparity between two seeds over their distance in the left photo. A slope
/// of one half from ear to ear is far beyond the depth of any head.
const MAX_DISPARITY_SLOPE: f64 = 0.5;

/// Replaces the marked positions by the nearest dots. Of two seeds on one dot the first is kept.
pub(super) fn snap_to_dots(
    seeds: Option<&Seeds>,
    left: &[Vec2],
    right: &[Vec2],
    limits: &Limits,
) -> Result<Vec<IndexedMatch>, CorrespondError> {
    let seeds = seeds.ok_or(CorrespondError::NoSeeds)?;
    let no_dots = |photo| CorrespondError::NoDots { photo };
    let left_index = PointIndex::<2>::new(left).ok_or(no_dots("left"))?;
    let right_index = PointIndex::<2>::new(right).ok_or(no_dots("right"))?;
    let named =
        [("head", seeds.head), ("left_ear", seeds.left_ear), ("right_ear", seeds.right_ear)];
    let mut snapped: Vec<IndexedMatch> = Vec::new();
    for (seed, pair) in named {
        let snap = |index: &PointIndex<2>, photo: &'static str, p: Vec2| {
            let nearest = index.nearest(&[p.x, p.y]);
            match nearest.filter(|n| n.distance <= limits.seed) {
                Some(n) => Ok(n.index),
                None => Err(CorrespondError::SeedOffDot {
                    seed,
                    photo,
                    distance_px: nearest.map_or(f64::INFINITY, |n| n.distance),
                    allowed_px: limits.seed,
                }),
            }
        };
        let pair = IndexedMatch {
            left: snap(&left_index, "left", pair.left)?,
            right: snap(&right_index, "right", pair.right)?,
            score: 1.0,
        };
        let allowed_px = limits.rows + MARKING_ERROR_PX;
        let rows_px = (left[pair.left].y - right[pair.right].y).abs();
        if rows_px > allowed_px {
            return Err(CorrespondError::SeedRows { seed, rows_px, allowed_px });
        }
        if !snapped.iter().any(|m| m.left == pair.left || m.right == pair.right) {
            snapped.push(pair);
        }
    }
    Ok(snapped)
}

/// A warning when the disparities of the seeds differ more than the depth of a head allows.
pub(super) fn disparity_warning(
    seeds: &[IndexedMatch],
    left: &[Vec2],
    right: &[Vec2],
) -> Option<String> {
    let disparities = seeds.iter().map(|m| left[m.left].x - right[m.right].x);
    let low = disparities.clone().fold(f64::INFINITY, f64::min);
    let high = disparities.fold(f64::NEG_INFINITY, f64::max);
    let distances =
        seeds.iter().flat_map(|a| seeds.iter().map(move |b| (left[a.left] - left[b.left]).norm()));
    let apart = distances.fold(0.0, f64::max);
    let allowed = MAX_DISPARITY_SLOPE * apart;
    (apart > 0.0 && high - low > allowed).then(|| {
        format!(
            "the disparities of the marked pairs differ by {:.1} px (at most {allowed:.1} px expected at this distance); check that each pair marks the same dot in both photos",
            high - low
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_at_the_depth_of_a_head_cause_no_warning_and_others_one_with_figures() {
        let left = [Vec2::new(0.0, 0.0), Vec2::new(100.0, 0.0), Vec2::new(50.0, 0.0)];
        let seeds = [0, 1, 2].map(|i| IndexedMatch { left: i, right: i, score: 1.0 });
        let right = |step: f64| [0.0, 0.0, step].map(|d| d - 30.0);
        let warning = |step: f64| {
            let mut moved = left;
            moved.iter_mut().zip(right(step)).for_each(|(p, d)| p.x += d);
            disparity_warning(&seeds, &left, &moved)
        };
        assert_eq!(warning(49.0), None);
        let text = warning(51.0).unwrap();
        assert!(text.contains("51.0 px") && text.contains("50.0 px"), "{text}");
        assert_eq!(disparity_warning(&seeds[..1], &left, &left), None);
    }
}
