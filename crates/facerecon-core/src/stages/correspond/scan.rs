//! The thesis's scan (section 2.3): from three marked pairs outward, dot by dot, in turns between
//! the left and the right photo.

mod agree;
mod grow;
mod plane;
mod seeds;

use super::{CorrespondError, CorrespondInput, Correspondence, ScanParams};
use crate::data::{Match, Pattern};
use crate::math::Vec2;
use crate::observer::Observer;

/// Finds the correspondences: marks the seeds, grows from them, orders the table.
pub(super) fn scan(
    input: &CorrespondInput<'_>,
    params: &ScanParams,
    observer: &dyn Observer,
) -> Result<Correspondence, CorrespondError> {
    let limits = Limits::new(input, params)?;
    let left: Vec<Vec2> = input.left.iter().map(|d| d.position).collect();
    let right: Vec<Vec2> = input.right.iter().map(|d| d.position).collect();
    let marked = seeds::mark(input.seeds.as_ref(), &left, &right, &limits)?;
    let window = seeds::Window::new(&marked, &left, params.window);
    let grown = grow::grow(&left, &right, &marked, &window, &limits, observer)?;
    let mut grown = agree::agreeing(grown, marked.len(), &left, &right, &limits);
    grown.sort_by(|a, b| {
        let (a, b) = (left[a.left], left[b.left]);
        a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x))
    });
    let matches = grown
        .iter()
        .map(|pair| Match {
            left: left[pair.left],
            right: right[pair.right],
            lattice: None,
            sigma_px: 0.0,
            score: pair.score,
        })
        .collect();
    let warnings = seeds::disagreement(&marked, &left, &right).into_iter().collect();
    Ok(Correspondence { matches, warnings })
}

/// Dots of both photos marked as one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Marked {
    left: usize,
    right: usize,
    score: f64,
}

/// The scan's thresholds in pixels.
#[derive(Clone, Copy, Debug)]
struct Limits {
    rows: f64,
    distance: f64,
    reach: f64,
    seed: f64,
    spacing: f64,
}

impl Limits {
    /// The thesis's threshold is "the pixel difference between any two neighbour points at
    /// x-coordinate" of the projected picture, and it leaves open how to get it for another pattern:
    /// here the spacing measured in the photos is carried to the x direction by the shape of the
    /// pattern's cells. Half of it would be where the neighbour in the row becomes as likely.
    fn new(input: &CorrespondInput<'_>, params: &ScanParams) -> Result<Self, CorrespondError> {
        let Pattern { columns, rows, .. } = *input.pattern;
        let spacing = input.spacing_px;
        if columns == 0 || rows == 0 || !(spacing > 0.0 && spacing.is_finite()) {
            return Err(CorrespondError::Pattern { columns, rows, spacing_px: spacing });
        }
        // width over height of a cell; the spacing measured is the shorter of the two
        let cell = params.picture_aspect * rows as f64 / columns as f64;
        let along_x = spacing * cell.max(1.0);
        Ok(Self {
            rows: params.row_tolerance_px,
            distance: params.distance_tolerance * along_x,
            reach: params.reach * along_x,
            seed: params.seed_tolerance * spacing,
            spacing,
        })
    }
}
