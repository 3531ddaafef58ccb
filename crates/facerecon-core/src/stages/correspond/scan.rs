//! The scan of the thesis (section 2.3): matches grow from three marked pairs, dot by dot, in turns
//! between the left and the right photo.

mod consistency;
mod grow;
mod limits;
mod params;
mod plane;
mod seeds;
mod window;

pub use params::ScanParams;

use super::error::CorrespondError;
use super::input::CorrespondInput;
use super::matches::sort_in_raster_order;
use crate::data::Match;
use crate::math::Vec2;
use crate::observer::Observer;
use limits::Limits;
use window::HeadWindow;

/// Matches the dots from the three marked pairs.
pub(super) fn match_by_scan(
    input: &CorrespondInput<'_>,
    params: &ScanParams,
    observer: &dyn Observer,
) -> Result<Vec<Match>, CorrespondError> {
    let limits = Limits::new(input, params)?;
    let left: Vec<Vec2> = input.left.iter().map(|d| d.position).collect();
    let right: Vec<Vec2> = input.right.iter().map(|d| d.position).collect();
    let seeds = seeds::snap_to_dots(input.seeds.as_ref(), &left, &right, &limits)?;
    if let Some(warning) = seeds::disparity_warning(&seeds, &left, &right) {
        observer.warn("correspond", &warning);
    }
    let window = HeadWindow::new(&seeds, &left, params.window);
    let grown = grow::grow(&left, &right, &seeds, &window, &limits, observer)?;
    let consistent = consistency::keep_consistent(grown, seeds.len(), &left, &right, &limits);
    let mut matches: Vec<Match> = consistent
        .iter()
        .map(|m| Match {
            left: left[m.left],
            right: right[m.right],
            lattice: None,
            sigma_px: 0.0,
            score: m.score,
        })
        .collect();
    sort_in_raster_order(&mut matches);
    Ok(matches)
}
