//! Pattern, seeds and landmarks from the text of a capture file.

use std::collections::BTreeMap;

use super::text::{PairText, PatternText, SeedsText};
use super::types::CaptureFiles;
use crate::data::{LandmarkPairs, Pair, Pattern, PatternKind, Seeds};
use crate::math::Vec2;

/// The pattern; values of the command line replace those of the file.
pub(super) fn pattern(text: &PatternText, given: &CaptureFiles) -> Result<Pattern, String> {
    let kind = match (given.kind, &text.kind) {
        (Some(kind), _) => kind,
        (None, Some(name)) => {
            PatternKind::from_name(name).map_err(|e| format!("[pattern] kind: {e}"))?
        }
        (None, None) => PatternKind::Dots,
    };
    let count = |value: Option<usize>, name: &str| match value {
        Some(count) => Ok(count),
        // Stripes are identified by width and colour; their number is not needed.
        None if kind == PatternKind::Stripes => Ok(0),
        None => Err(format!(
            "the pattern's {name} are missing; write {name} = NUMBER under [pattern], or give \
             --{name} NUMBER: the number of dots in the projected image"
        )),
    };
    Ok(Pattern {
        kind,
        columns: count(given.columns.or(text.columns), "columns")?,
        rows: count(given.rows.or(text.rows), "rows")?,
        rotation: given.rotation_deg.or(text.rotation_deg).unwrap_or(0.0).to_radians(),
    })
}

/// The three seeds: all or none.
pub(super) fn seeds(text: Option<SeedsText>) -> Result<Option<Seeds>, String> {
    let Some(text) = text else { return Ok(None) };
    let seed = |pair: Option<PairText>, name: &str| {
        pair.map(|p| p.to_pair()).ok_or_else(|| {
            format!("[seeds] {name} is missing; give head, left_ear and right_ear, or no seeds")
        })
    };
    Ok(Some(Seeds {
        head: seed(text.head, "head")?,
        left_ear: seed(text.left_ear, "left_ear")?,
        right_ear: seed(text.right_ear, "right_ear")?,
    }))
}

/// The marked landmarks.
pub(super) fn landmarks(text: BTreeMap<String, PairText>) -> LandmarkPairs {
    text.into_iter().map(|(name, pair)| (name, pair.to_pair())).collect()
}

impl PairText {
    fn to_pair(&self) -> Pair {
        let point = |[x, y]: [f64; 2]| Vec2::new(x, y);
        Pair { left: point(self.left), right: point(self.right) }
    }
}
