//! Correspondence of parallel stripes of varying width and colour (thesis, "Future Works").
//!
//! Every row is cut at the edges of the stripes ([`edges`]); the sequences of edges in both photos
//! are aligned by colour and width, and stripes vote over their rows which one they are
//! ([`align`]). Both edges of a stripe count, not its left one alone.

mod align;
mod edges;

use rayon::prelude::*;

use crate::camera::RectifiedRig;
use crate::data::{Match, Rgb};
use crate::math::{Vec2, median};
use crate::observer::{Event, Observer};
use crate::settings;
use crate::settings::Value;

use super::{CorrespondError, Correspondence};
use align::{Aligned, align, settle};
use edges::{Chains, Edge, row_edges};

settings! {
    /// Correspondence of stripes (captures of kind "stripes").
    pub struct StripesParams {
        /// Distance of the rows that are looked at.
        row_step_px: usize = 3, range 1.0..=64.0, unit "px";
        /// Rows above and below that are averaged with each.
        average_rows: usize = 2, range 0.0..=32.0;
        /// Smoothing along the row before edges are sought (standard deviation).
        smooth_px: f64 = 1.2, range 0.3..=10.0, unit "px";
        /// Least step of brightness (sum of the colours) at an edge, per pixel.
        min_step: f64 = 5.0, range 0.1..=200.0, unit "grey levels";
        /// Cost of leaving an edge without a partner; a partner of another colour or width costs
        /// more than twice this.
        skip_cost: f64 = 2.0, range 0.1..=20.0;
        /// Share of the rows around that must agree which stripe an edge belongs to.
        min_votes: f64 = 0.6, range 0.1..=1.0;
        /// Step of depth that parts the subject from what is behind it, as a part of its depth;
        /// without a calibrated rig, of the width of the photo in disparity.
        gap: f64 = 0.03, range 0.001..=1.0;
    }
}

/// Fewer matches than this make no face.
const LEAST_MATCHES: usize = 60;

/// Matches the edges of the stripes of two rectified photos.
///
/// # Errors
/// [`CorrespondError::TooFewMatches`] where the photos show no stripes in common.
pub fn correspond_stripes(
    images: [&Rgb; 2],
    rig: Option<&RectifiedRig>,
    params: &StripesParams,
    observer: &dyn Observer,
) -> Result<Correspondence, CorrespondError> {
    params.check("correspond.stripes", None)?;
    let height = images[0].height().min(images[1].height());
    let rows: Vec<usize> = (0..height).step_by(params.row_step_px.max(1)).collect();
    let [left, right] = images.map(|image| {
        let found: Vec<Vec<Edge>> = rows.par_iter().map(|y| row_edges(image, *y, params)).collect();
        Chains::link(found)
    });
    observer.check()?;
    let aligned: Vec<Vec<Aligned>> = (0..rows.len())
        .into_par_iter()
        .map(|n| align(&left.rows[n], &right.rows[n], params.skip_cost))
        .collect();
    let settled = settle(&left, &right, &aligned, params.min_votes);
    let edge = |chains: &Chains, n: usize, i: usize| chains.rows[n][i];
    let mut matches: Vec<Match> = settled
        .iter()
        .map(|s| {
            let (l, r) = (edge(&left, s.row, s.left), edge(&right, s.row, s.right));
            let y = rows[s.row] as f64;
            Match {
                left: Vec2::new(l.x, y),
                right: Vec2::new(r.x, y),
                lattice: Some([left.ids[s.row][s.left] as i32, s.row as i32]),
                sigma_px: 0.0,
                score: s.votes,
            }
        })
        .collect();
    drop_strays(&mut matches);
    let dropped = drop_background(&mut matches, images[0].width(), rig, params.gap);
    observer.event(&Event::Count { stage: "correspond", what: "matches", count: matches.len() });
    if matches.len() < LEAST_MATCHES {
        return Err(CorrespondError::TooFewMatches {
            got: matches.len(),
            needed: LEAST_MATCHES,
            left: left.count(),
            right: right.count(),
        });
    }
    let mut warnings = Vec::new();
    if dropped > 0 {
        warnings.push(format!("{dropped} matches far behind the subject (a wall) were left out"));
    }
    Ok(Correspondence { matches, warnings })
}

/// Drops matches whose disparity differs from the median of their stripe's rows around by more
/// than a pixel and a quarter of the usual spread.
fn drop_strays(matches: &mut Vec<Match>) {
    const AROUND: i32 = 4;
    let mut by_stripe: std::collections::BTreeMap<i32, Vec<(i32, f64)>> = Default::default();
    for m in matches.iter() {
        if let Some([stripe, row]) = m.lattice {
            by_stripe.entry(stripe).or_default().push((row, m.disparity()));
        }
    }
    matches.retain(|m| {
        let Some([stripe, row]) = m.lattice else {
            return false;
        };
        let around: Vec<f64> = by_stripe
            .get(&stripe)
            .into_iter()
            .flatten()
            .filter(|(r, _)| (r - row).abs() <= AROUND && *r != row)
            .map(|(_, d)| *d)
            .collect();
        around.len() >= 2 && median(&around).is_some_and(|d| (m.disparity() - d).abs() < 1.25)
    });
}

/// Drops what lies behind the subject: disparities fall into clusters parted by empty gaps, and the
/// subject is the nearest cluster with at least 15 % of the matches.
fn drop_background(
    matches: &mut Vec<Match>,
    width: usize,
    rig: Option<&RectifiedRig>,
    gap: f64,
) -> usize {
    let mut disparities: Vec<f64> = matches.iter().map(Match::disparity).collect();
    disparities.sort_by(|a, b| b.total_cmp(a));
    let count = disparities.len();
    let parted = |near: f64, far: f64| match rig {
        Some(rig) => match (rig.depth_mm(near), rig.depth_mm(far)) {
            (Some(a), Some(b)) => b - a > gap * a,
            _ => true,
        },
        None => near - far > gap * width as f64,
    };
    let (mut start, mut kept) = (0, 0..count);
    for end in 1..=count {
        if end == count || parted(disparities[end - 1], disparities[end]) {
            if 100 * (end - start) >= 15 * count {
                kept = start..end;
                break;
            }
            start = end;
        }
    }
    let (Some(high), Some(low)) = (
        disparities.get(kept.start).copied(),
        disparities.get(kept.end.saturating_sub(1)).copied(),
    ) else {
        return 0;
    };
    matches.retain(|m| (low..=high).contains(&m.disparity()));
    count - matches.len()
}

#[cfg(test)]
mod tests;
