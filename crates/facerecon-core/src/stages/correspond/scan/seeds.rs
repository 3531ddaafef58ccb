//! The three marked pairs.

use super::{CorrespondError, Limits, Marked};
use crate::data::Seeds;
use crate::math::Vec2;
use crate::spatial::PointIndex;

/// Snaps the three marked pairs to the nearest dots.
pub(super) fn mark(
    seeds: Option<&Seeds>,
    left: &[Vec2],
    right: &[Vec2],
    limits: &Limits,
) -> Result<Vec<Marked>, CorrespondError> {
    let seeds = seeds.ok_or(CorrespondError::NoSeeds)?;
    let no_dots = |photo| CorrespondError::NoDots { photo };
    let left_index = PointIndex::<2>::new(left).ok_or(no_dots("left"))?;
    let right_index = PointIndex::<2>::new(right).ok_or(no_dots("right"))?;
    let named =
        [("head", seeds.head), ("left_ear", seeds.left_ear), ("right_ear", seeds.right_ear)];
    let mut marked: Vec<Marked> = Vec::new();
    for (seed, pair) in named {
        let snap = |index: &PointIndex<2>, photo: &'static str, p: Vec2| {
            let found = index.nearest(&[p.x, p.y]);
            match found.filter(|n| n.distance <= limits.seed) {
                Some(n) => Ok(n.index),
                None => Err(CorrespondError::SeedOffDot {
                    seed,
                    photo,
                    distance_px: found.map_or(f64::INFINITY, |n| n.distance),
                    allowed_px: limits.seed,
                }),
            }
        };
        let pair = Marked {
            left: snap(&left_index, "left", pair.left)?,
            right: snap(&right_index, "right", pair.right)?,
            score: 1.0,
        };
        // a pixel more than in the scan: the hand is not as steady as the detection
        let allowed_px = limits.rows + 1.0;
        let rows_px = (left[pair.left].y - right[pair.right].y).abs();
        if rows_px > allowed_px {
            return Err(CorrespondError::SeedRows { seed, rows_px, allowed_px });
        }
        if !marked.iter().any(|m| m.left == pair.left || m.right == pair.right) {
            marked.push(pair);
        }
    }
    Ok(marked)
}

/// The part of the left photo in which the head lies, as the marks say: an upright ellipse.
pub(super) struct Window {
    centre: Vec2,
    half: Vec2,
}

impl Window {
    /// From the marks for head and ears; the whole photo when one is missing or `size` is 0.
    pub(super) fn new(marked: &[Marked], left: &[Vec2], size: f64) -> Self {
        let everything = Self { centre: Vec2::zeros(), half: Vec2::repeat(f64::INFINITY) };
        let [head, left_ear, right_ear] = marked else {
            return everything;
        };
        let (head, a, b) = (left[head.left], left[left_ear.left], left[right_ear.left]);
        let centre = (a + b) / 2.0;
        // Ears stand about 145 mm apart, a forehead 80 mm above their middle; the larger figure
        // holds when the head is turned. Hair ends 165 mm above, a jaw 105 mm beside the middle.
        let width = (a - b).norm().max(1.8 * (head - centre).norm());
        if size > 0.0 && width > 0.0 {
            Self { centre, half: Vec2::new(0.72, 1.15) * width * size }
        } else {
            everything
        }
    }

    /// Whether a place of the left photo lies in it.
    pub(super) fn holds(&self, p: Vec2) -> bool {
        (p - self.centre).component_div(&self.half).norm_squared() <= 1.0
    }
}

/// A warning when the marked pairs' disparities lie further apart than heads are deep.
pub(super) fn disagreement(marked: &[Marked], left: &[Vec2], right: &[Vec2]) -> Option<String> {
    let disparities = marked.iter().map(|m| left[m.left].x - right[m.right].x);
    let low = disparities.clone().fold(f64::INFINITY, f64::min);
    let high = disparities.fold(f64::NEG_INFINITY, f64::max);
    let reach = marked
        .iter()
        .flat_map(|a| marked.iter().map(move |b| (left[a.left] - left[b.left]).norm()));
    let apart = reach.fold(0.0, f64::max);
    // a slope of one half over the face would be a depth far beyond any head's
    (apart > 0.0 && high - low > 0.5 * apart).then(|| {
        format!(
            "the marked pairs' disparities differ by {:.1} px over {apart:.0} px: is each pair the same dot in both photos?",
            high - low
        )
    })
}
