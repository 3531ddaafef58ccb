//! Dots that only one photo shows as a dot (dim on a brow, squeezed on a steep cheek), placed in
//! the other by the measured surface.

use super::Refined;
use crate::data::{Dot, Match};
use crate::math::Vec2;
use crate::spatial::PointIndex;

/// Dots nearer than this to a matched one are that dot, in pitches.
const SAME: f64 = 0.4;
/// Most steps from a right place to the left one.
const STEPS: usize = 12;

impl Refined {
    /// Adds matches for the dots (rectified pixels, left and right photo) that no match uses, where
    /// the surface there is measured to within `max_sigma_px`. They have no place in the lattice;
    /// the matches come in raster order of their left positions.
    pub fn add_lone_dots(&mut self, dots: [&[Dot]; 2], max_sigma_px: f64) {
        let found = lone_dots(self, dots, max_sigma_px);
        self.matches.extend(found);
        let raster = |m: &Match| (m.left.y, m.left.x);
        self.matches.sort_by(|a, b| {
            let (a, b) = (raster(a), raster(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
    }
}

/// A dot counts once, the left photo's first. In the order of the dots.
fn lone_dots(refined: &Refined, dots: [&[Dot]; 2], max_sigma_px: f64) -> Vec<Match> {
    let near = SAME * refined.pitch_px;
    let mut found: Vec<Match> = Vec::new();
    for (side, dots) in dots.into_iter().enumerate() {
        let known: Vec<Match> = refined.matches.iter().chain(&found).copied().collect();
        let places: Vec<Vec2> = known.iter().map(|m| [m.left, m.right][side]).collect();
        let Some(index) = PointIndex::<2>::new(&places) else { return found };
        for dot in dots {
            let at = dot.position;
            let Some(nearest) = index.nearest(&[at.x, at.y]).filter(|n| n.distance > near) else {
                continue;
            };
            let guide = &known[nearest.index];
            let fall = guide.right.y - guide.left.y;
            let left = match side {
                0 => Some(at),
                _ => left_of(refined, at - Vec2::new(0.0, fall), guide.disparity()),
            };
            let Some((left, (disparity, sigma_px))) =
                left.and_then(|p| Some((p, measured(refined, p)?)))
            else {
                continue;
            };
            if sigma_px <= max_sigma_px {
                let right = left + Vec2::new(-disparity, fall);
                found.push(Match { left, right, lattice: None, sigma_px, score: dot.score });
            }
        }
    }
    found
}

/// The left place whose disparity leads to a right place: fixed-point steps from a neighbour's
/// disparity. `None` where they leave the measured surface or do not end.
fn left_of(refined: &Refined, right: Vec2, disparity: f64) -> Option<Vec2> {
    let mut left = right + Vec2::new(disparity, 0.0);
    for _ in 0..STEPS {
        let next = right + Vec2::new(measured(refined, left)?.0, 0.0);
        let moved = (next.x - left.x).abs();
        left = next;
        if moved < 0.02 {
            return Some(left);
        }
    }
    None
}

/// Disparity between the pixels and the larger of their deviations; `None` beside holes.
fn measured(refined: &Refined, at: Vec2) -> Option<(f64, f64)> {
    let disparity = refined.disparity.bilinear(at.x, at.y).filter(|d| d.is_finite())?;
    let (x, y) = (at.x.round() as isize, at.y.round() as isize);
    let sigma = refined.sigma_px.get(x, y).filter(|s| s.is_finite())?;
    Some((f64::from(disparity), f64::from(sigma)))
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
        let places: Vec<Vec2> = (0..60)
            .map(|i| Vec2::new(5.0 + 10.0 * f64::from(i % 10), 5.0 + 10.0 * f64::from(i / 10)))
            .collect();
        let right = |p: &Vec2| Vec2::new(p.x - 30.0 - p.x / 20.0, p.y + 0.25);
        let matches = places.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, p)| Match {
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
        };
        let left = places.iter().map(|p| dot(p.x, p.y)).collect();
        let right = places.iter().map(right).map(|p| dot(p.x, p.y)).collect();
        (refined, left, right)
    }

    #[test]
    fn a_dot_of_either_photo_finds_its_place_in_the_other() {
        let (refined, left, right) = refined(|i| i != 12 && i != 33);
        let all = lone_dots(&refined, [&left, &right], 0.2);
        // the columns of dots at 75 and beyond are in the hole
        assert_eq!(all.len(), 2);
        for dots in [[&left[..], &[]], [&[], &right[..]]] {
            let found = lone_dots(&refined, dots, 0.2);
            assert_eq!(found.len(), 2);
            for (m, i) in found.iter().zip([12, 33]) {
                assert!((m.left - left[i].position).norm() < 0.05, "{m:?}");
                assert!((m.right - right[i].position).norm() < 0.05, "{m:?}");
            }
        }
    }

    #[test]
    fn what_is_not_measured_well_stays_unmatched() {
        let (mut refined, left, right) = refined(|i| i != 12);
        assert!(lone_dots(&refined, [&left, &right], 0.01).is_empty());
        refined.matches.clear();
        assert!(lone_dots(&refined, [&left, &right], 0.2).is_empty());
    }
}
