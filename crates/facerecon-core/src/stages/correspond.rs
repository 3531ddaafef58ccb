//! Correspond: match the dots of the left photo with those of the right (thesis section 2.3).

mod error;
mod input;
mod lattice;
mod matches;
mod scan;
mod stripes;
#[cfg(test)]
mod tests;

pub use error::CorrespondError;
pub use input::CorrespondInput;
pub use lattice::LatticeParams;
pub use matches::Correspondence;
pub use scan::ScanParams;
pub use stripes::{StripesParams, correspond_stripes};

use crate::observer::{Event, Observer};
use crate::settings::Value;
use crate::settings::{choices, settings};

choices! {
    /// How correspondences are found.
    pub enum CorrespondMethod {
        /// The scan of the thesis from three marked pairs.
        Scan = "scan",
        /// The lattice of the dots, without marked pairs.
        Lattice = "lattice",
    }
}

settings! {
    /// Correspondence of the dots of both photos.
    pub struct CorrespondParams {
        /// How correspondences are found.
        method: CorrespondMethod = CorrespondMethod::Scan;
        /// The scan of the thesis.
        scan: ScanParams = ScanParams::default();
        /// The lattice of the dots.
        lattice: LatticeParams = LatticeParams::default();
        /// Stripes, for captures of that kind.
        stripes: StripesParams = StripesParams::default();
    }
}

/// Fewest matches of a result; a face has some hundreds.
const MIN_MATCHES: usize = 12;

/// Matches the dots of both photos. Warns the observer of seeds that contradict each other and of
/// matches that were left out.
///
/// # Errors
/// [`CorrespondError`] where a photo has no dots, a seed is not on a dot, the lattice is missing or
/// its shift is ambiguous, there are too few matches, a parameter is out of its range, or the
/// observer cancels.
///
/// # Examples
/// ```
/// use facerecon_core::data::{Dot, Pair, Pattern, PatternKind, Seeds};
/// use facerecon_core::math::Vec2;
/// use facerecon_core::stages::correspond::{CorrespondInput, CorrespondParams, correspond};
///
/// // 12 x 12 dots 10 px apart on a plane with a disparity of 30 px.
/// let dots = |disparity: f64| -> Vec<Dot> {
///     let position = |i: i32| Vec2::new(f64::from(10 * (i % 12)) - disparity, f64::from(10 * (i / 12)));
///     let dot = |i| Dot { position: position(i), sigma_px: 1.5, amplitude: 60.0, score: 1.0 };
///     (0..144).map(dot).collect()
/// };
/// let (left, right) = (dots(0.0), dots(30.0));
/// let pair = |i: usize| Pair { left: left[i].position, right: right[i].position };
/// let input = CorrespondInput {
///     left: &left,
///     right: &right,
///     spacing_px: 10.0,
///     plain: None,
///     pattern: &Pattern { kind: PatternKind::Dots, columns: 12, rows: 12, rotation: 0.0 },
///     seeds: Some(Seeds { head: pair(18), left_ear: pair(74), right_ear: pair(81) }),
///     rig: None,
/// };
/// let found = correspond(&input, &CorrespondParams::default(), &())?;
/// assert!(found.matches.len() > 100);
/// assert!(found.matches.iter().all(|m| m.disparity() == 30.0));
/// # Ok::<(), facerecon_core::stages::correspond::CorrespondError>(())
/// ```
pub fn correspond(
    input: &CorrespondInput<'_>,
    params: &CorrespondParams,
    observer: &dyn Observer,
) -> Result<Correspondence, CorrespondError> {
    params.check("correspond", None)?;
    for (photo, dots) in [("left", input.left), ("right", input.right)] {
        if dots.is_empty() {
            return Err(CorrespondError::NoDots { photo });
        }
    }
    let matches = match params.method {
        CorrespondMethod::Scan => scan::match_by_scan(input, &params.scan, observer)?,
        CorrespondMethod::Lattice => lattice::match_by_lattice(input, &params.lattice, observer)?,
    };
    observer.event(&Event::Count { stage: "correspond", what: "matches", count: matches.len() });
    if matches.len() < MIN_MATCHES {
        return Err(CorrespondError::TooFewMatches {
            candidates: "dots",
            got: matches.len(),
            needed: MIN_MATCHES,
            left: input.left.len(),
            right: input.right.len(),
        });
    }
    Ok(Correspondence { matches })
}
