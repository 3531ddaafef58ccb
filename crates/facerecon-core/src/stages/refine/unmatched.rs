//! Dots that were detected in one photo only (dim on a brow, compressed on a steep cheek), matched
//! through the measured surface.

use super::refined::Refined;
use crate::data::{Dot, Match};
use crate::math::Vec2;
use crate::spatial::PointIndex;

/// A dot nearer than this to a matched one is the same dot, in pitches: less than half way to the
/// next one.
const SAME_DOT_RADIUS: f64 = 0.4;
/// Most fixed-point steps from a right position to the left one. Each shrinks the error by the
/// disparity's slope, which is well below 1.
const MAX_STEPS: usize = 12;
/// Fixed-point steps shorter than this are the end, in pitches: less than half of the best
/// matches' error.
const CONVERGED: f64 = 0.002;

/// Adds a match for every dot without one where the surface is measured to a standard deviation of
/// at most `max_sigma_px`. `dots` are the detected dots of the left and of the right photo, in
/// rectified pixels. The added matches have no lattice label. All matches come out in raster order
/// of their left positions.
///
/// ```
/// use facerecon_core::data::{Dot, Gray, Match};
/// use facerecon_core::math::Vec2;
/// use facerecon_core::stages::refine::{Refined, match_remaining_dots};
///
/// let matched = Match {
///     left: Vec2::new(20.0, 10.0),
///     right: Vec2::new(12.0, 10.0),
///     lattice: None,
///     sigma_px: 0.05,
///     score: 1.0,
/// };
/// let mut refined = Refined {
///     matches: vec![matched],
///     disparity: Gray::filled(40, 20, 8.0),
///     sigma_px: Gray::filled(40, 20, 0.05),
///     pitch_px: 10.0,
///     dropped: 0,
///     misfit: 1.0,
///     blur_difference: 0.0,
/// };
/// let dot = Dot { position: Vec2::new(30.0, 10.0), sigma_px: 1.0, amplitude: 40.0, score: 0.9 };
/// match_remaining_dots(&mut refined, [&[dot], &[]], 0.15);
/// assert_eq!(refined.matches[1].right, Vec2::new(22.0, 10.0));
/// ```
pub fn match_remaining_dots(refined: &mut Refined, dots: [&[Dot]; 2], max_sigma_px: f64) {
    let added = remaining_matches(refined, dots, max_sigma_px);
    refined.matches.extend(added);
    refined
        .matches
        .sort_by(|a, b| a.left.y.total_cmp(&b.left.y).then(a.left.x.total_cmp(&b.left.x)));
}

/// Matches of the dots without one, in the order of the dots, those of the left photo first. A dot
/// that both photos show is matched once.
fn remaining_matches(refined: &Refined, dots: [&[Dot]; 2], max_sigma_px: f64) -> Vec<Match> {
    let radius = SAME_DOT_RADIUS * refined.pitch_px;
    let mut added: Vec<Match> = Vec::new();
    for (side, dots) in dots.into_iter().enumerate() {
        let known: Vec<Match> = refined.matches.iter().chain(&added).copied().collect();
        let positions: Vec<Vec2> = known.iter().map(|m| [m.left, m.right][side]).collect();
        let Some(index) = PointIndex::<2>::new(&positions) else { return added };
        for dot in dots {
            let position = dot.position;
            let nearest = index.nearest(&[position.x, position.y]).filter(|n| n.distance > radius);
            let Some(nearest) = nearest else { continue };
            let neighbour = &known[nearest.index];
            let row_offset = neighbour.right.y - neighbour.left.y;
            let left = match side {
                0 => Some(position),
                _ => left_position(
                    refined,
                    position - Vec2::new(0.0, row_offset),
                    neighbour.disparity(),
                ),
            };
            let Some((left, (disparity, sigma_px))) =
                left.and_then(|p| Some((p, refined.measured_at(p)?)))
            else {
                continue;
            };
            if sigma_px <= max_sigma_px {
                let right = left + Vec2::new(-disparity, row_offset);
                added.push(Match { left, right, lattice: None, sigma_px, score: dot.score });
            }
        }
    }
    added
}

/// The left position whose disparity leads to a right position, by fixed-point steps from a
/// neighbour's disparity. `None` where they leave the measured surface or do not converge.
fn left_position(refined: &Refined, right: Vec2, disparity: f64) -> Option<Vec2> {
    let mut left = right + Vec2::new(disparity, 0.0);
    for _ in 0..MAX_STEPS {
        let next = right + Vec2::new(refined.measured_at(left)?.0, 0.0);
        let step = (next.x - left.x).abs();
        left = next;
        if step < CONVERGED * refined.pitch_px {
            return Some(left);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Gray;

    /// Disparity 30 + x / 20 left of a hole from column 70 on; dots 10 apart.
    fn refined(kept: impl Fn(usize) -> bool) -> (Refined, Vec<Dot>, Vec<Dot>) {
        let disparity =
            Gray::from_fn(120, 60, |x, _| if x < 70 { 30.0 + x as f32 / 20.0 } else { f32::NAN });
        let sigma_px = disparity.map(|d| if d.is_finite() { 0.05 } else { f32::NAN });
        let dot = |x: f64, y: f64| Dot {
            position: Vec2::new(x, y),
            sigma_px: 1.0,
            amplitude: 50.0,
            score: 0.8,
        };
        let positions: Vec<Vec2> = (0..60)
            .map(|i| Vec2::new(5.0 + 10.0 * f64::from(i % 10), 5.0 + 10.0 * f64::from(i / 10)))
            .collect();
        let right = |p: &Vec2| Vec2::new(p.x - 30.0 - p.x / 20.0, p.y + 0.25);
        let matches = positions.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, p)| Match {
            left: *p,
            right: right(p),
            lattice: None,
            sigma_px: 0.05,
            score: 1.0,
        });
        let refined = Refined {
            matches: matches.collect(),
            disparity,
            sigma_px,
            pitch_px: 10.0,
            dropped: 0,
            misfit: 1.0,
            blur_difference: 0.0,
        };
        let left = positions.iter().map(|p| dot(p.x, p.y)).collect();
        let right = positions.iter().map(right).map(|p| dot(p.x, p.y)).collect();
        (refined, left, right)
    }

    #[test]
    fn a_dot_of_either_photo_is_matched_in_the_other() {
        let (refined, left, right) = refined(|i| i != 12 && i != 33);
        let all = remaining_matches(&refined, [&left, &right], 0.2);
        // the columns of dots at 75 and beyond are in the hole
        assert_eq!(all.len(), 2);
        for dots in [[&left[..], &[]], [&[], &right[..]]] {
            let added = remaining_matches(&refined, dots, 0.2);
            assert_eq!(added.len(), 2);
            for (m, i) in added.iter().zip([12, 33]) {
                assert!((m.left - left[i].position).norm() < 0.05, "{m:?}");
                assert!((m.right - right[i].position).norm() < 0.05, "{m:?}");
            }
        }
    }

    #[test]
    fn dots_where_the_surface_is_uncertain_stay_unmatched() {
        let (mut refined, left, right) = refined(|i| i != 12);
        assert!(remaining_matches(&refined, [&left, &right], 0.01).is_empty());
        refined.matches.clear();
        assert!(remaining_matches(&refined, [&left, &right], 0.2).is_empty());
    }
}
