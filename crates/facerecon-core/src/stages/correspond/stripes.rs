//! Correspondence of parallel stripes of varying width and colour (thesis, "Future Works").
//!
//! The edges of the stripes are detected in every row ([`edges`]) and linked from row to row
//! ([`chains`]). The sequences of edges in both photos are aligned by colour and width ([`align`]),
//! and the rows of a stripe vote which one it is ([`vote`]). Both edges of a stripe are matched; the
//! thesis proposes the left one alone.

mod align;
mod chains;
mod edges;
mod params;
mod prune;
#[cfg(test)]
mod tests;
mod vote;

pub use params::StripesParams;

use rayon::prelude::*;

use super::error::CorrespondError;
use super::matches::Correspondence;
use crate::camera::RectifiedRig;
use crate::data::{Match, Rgb};
use crate::math::Vec2;
use crate::observer::{Event, Observer};
use crate::settings::Value;
use align::{EdgePair, align};
use chains::Chains;
use edges::{Edge, row_edges};
use vote::{EdgeMatch, vote};

/// Fewest matches of a result; a face has some thousands.
const MIN_MATCHES: usize = 60;
/// Cost of an edge without a match, in the units of dissimilarity. Two edges are matched only where
/// their difference of colour and width costs less than twice this.
const SKIP_COST: f64 = 2.0;

/// Matches the edges of the stripes of two rectified photos. Warns the observer of matches that were left
/// out.
///
/// `images` are the photos `[left, right]`. `lattice` of a match is the number of the edge's chain in
/// the left photo (not its number in the pattern) and the number of the row.
///
/// # Errors
/// [`CorrespondError::TooFewMatches`] where the photos show no stripes in common; or a parameter is
/// out of its range, or the observer cancels.
///
/// # Examples
/// ```
/// use facerecon_core::data::Rgb;
/// use facerecon_core::stages::correspond::{StripesParams, correspond_stripes};
///
/// // Stripes in four colours on a plane with a disparity of 12 px.
/// let colors = [[200, 20, 20], [20, 200, 20], [20, 20, 200], [200, 200, 20]];
/// let photo = |disparity: usize| {
///     Rgb::from_fn(240, 40, |x, _| match (x + disparity) % 20 {
///         0..10 => colors[(x + disparity) / 20 % 4],
///         _ => [10; 3],
///     })
/// };
/// let found =
///     correspond_stripes([&photo(0), &photo(12)], None, &StripesParams::default(), &())?;
/// assert!(found.matches.len() > 200);
/// assert!(found.matches.iter().all(|m| (m.disparity() - 12.0).abs() < 0.1));
/// # Ok::<(), facerecon_core::stages::correspond::CorrespondError>(())
/// ```
pub fn correspond_stripes(
    images: [&Rgb; 2],
    rig: Option<&RectifiedRig>,
    params: &StripesParams,
    observer: &dyn Observer,
) -> Result<Correspondence, CorrespondError> {
    params.check("correspond.stripes", None)?;
    let height = images[0].height().min(images[1].height());
    let rows: Vec<usize> = (0..height).step_by(params.row_step_px).collect();
    let [left, right] = images.map(|image| {
        let edges: Vec<Vec<Edge>> = rows.par_iter().map(|y| row_edges(image, *y, params)).collect();
        Chains::link(edges)
    });
    observer.check()?;
    let aligned: Vec<Vec<EdgePair>> = (0..rows.len())
        .into_par_iter()
        .map(|n| align(&left.rows[n], &right.rows[n], SKIP_COST))
        .collect();
    let voted = vote(&left, &right, &aligned, params.min_votes);
    let mut matches: Vec<Match> =
        voted.iter().map(|m| to_match(m, [&left, &right], rows[m.row])).collect();
    prune::drop_outliers(&mut matches);
    let dropped = prune::drop_background(&mut matches, images[0].width(), rig, params.gap);
    observer.event(&Event::Count { stage: "correspond", what: "matches", count: matches.len() });
    if dropped > 0 {
        let warning = format!(
            "{dropped} matches in front of or behind the subject (probably a wall) were left out"
        );
        observer.warn("correspond", &warning);
    }
    if matches.len() < MIN_MATCHES {
        return Err(CorrespondError::TooFewMatches {
            candidates: "stripe edges",
            got: matches.len(),
            needed: MIN_MATCHES,
            left: left.count(),
            right: right.count(),
        });
    }
    Ok(Correspondence { matches })
}

/// The match of two edges in row `y` of the photos.
fn to_match(found: &EdgeMatch, [left, right]: [&Chains; 2], y: usize) -> Match {
    let EdgeMatch { row, votes, .. } = *found;
    Match {
        left: Vec2::new(left.rows[row][found.left].x, y as f64),
        right: Vec2::new(right.rows[row][found.right].x, y as f64),
        lattice: Some([left.ids[row][found.left] as i32, row as i32]),
        sigma_px: 0.0,
        score: votes,
    }
}
