//! From the text of a capture file to pattern, seeds and features, checked against the photos.

use std::collections::BTreeMap;

use super::text::{PairText, PatternText, SeedsText};
use super::{CaptureFiles, LandmarkPairs, Pattern, PatternKind, Seeds, Vec2};
use crate::data::{LANDMARKS, Pair};
use crate::io::source::nearest_name;

/// Most columns or rows of a pattern.
const MAX_PATTERN: usize = 10_000;

/// The pattern; what the command line gives counts.
pub(super) fn pattern(text: PatternText, given: &CaptureFiles) -> Result<Pattern, String> {
    let kind = match (given.kind, text.kind.as_deref()) {
        (Some(kind), _) => kind,
        (None, None | Some("dots")) => PatternKind::Dots,
        (None, Some("stripes")) => PatternKind::Stripes,
        (None, Some(other)) => {
            return Err(format!("[pattern] kind is {other:?}; \"dots\" and \"stripes\" are known"));
        }
    };
    let side = |given: Option<usize>, text: Option<usize>, name: &str, least: usize| match given
        .or(text)
    {
        Some(n) if (least..=MAX_PATTERN).contains(&n) => Ok(n),
        Some(n) => {
            Err(format!("the pattern has {n} {name}; {least} to {MAX_PATTERN} are possible"))
        }
        // Stripes are told apart by width and colour: their number is no need.
        None if kind == PatternKind::Stripes => Ok(0),
        None => Err(format!(
            "the pattern's {name} are not given; write {name} = NUMBER under [pattern], or give \
             --{name} NUMBER: how many dots the projected picture has"
        )),
    };
    let least = if kind == PatternKind::Dots { 2 } else { 0 };
    let columns = side(given.columns, text.columns, "columns", least)?;
    let rows = side(given.rows, text.rows, "rows", least)?;
    let degrees = given.rotation_deg.or(text.rotation_deg).unwrap_or(0.0);
    if !(-360.0..=360.0).contains(&degrees) {
        return Err(format!("the pattern's rotation_deg is {degrees}; -360 to 360 is possible"));
    }
    Ok(Pattern { kind, columns, rows, rotation: degrees.to_radians() })
}

/// The three seeds.
pub(super) fn seeds(
    text: Option<SeedsText>,
    size: (usize, usize),
) -> Result<Option<Seeds>, String> {
    let Some(text) = text else { return Ok(None) };
    let get = |pair: Option<PairText>, name: &str| match pair {
        Some(p) => pair_inside(&p, size).map_err(|e| format!("[seeds] {name}: {e}")),
        None => Err(format!(
            "[seeds] {name} is missing; head, left_ear and right_ear are needed, or none"
        )),
    };
    Ok(Some(Seeds {
        head: get(text.head, "head")?,
        left_ear: get(text.left_ear, "left_ear")?,
        right_ear: get(text.right_ear, "right_ear")?,
    }))
}

/// The marked landmarks, with names that are known.
pub(super) fn landmarks(
    text: BTreeMap<String, PairText>,
    size: (usize, usize),
) -> Result<LandmarkPairs, String> {
    text.into_iter()
        .map(|(name, pair)| {
            if !LANDMARKS.contains(&name.as_str()) {
                return Err(format!("[landmarks] {}", unknown_landmark(&name)));
            }
            let pair = pair_inside(&pair, size).map_err(|e| format!("[landmarks] {name}: {e}"))?;
            Ok((name, pair))
        })
        .collect()
}

/// What to say of a landmark name that is none of the 18.
pub(crate) fn unknown_landmark(name: &str) -> String {
    match nearest_name(name, LANDMARKS) {
        Some(near) => format!("unknown landmark {name:?}; did you mean {near}?"),
        None => format!("unknown landmark {name:?}; the 18 names are {}", LANDMARKS.join(", ")),
    }
}

fn pair_inside(pair: &PairText, (width, height): (usize, usize)) -> Result<Pair, String> {
    let inside = |[x, y]: [f64; 2], side: &str| {
        let (w, h) = (width as f64, height as f64);
        if (-0.5..=w - 0.5).contains(&x) && (-0.5..=h - 0.5).contains(&y) {
            Ok(Vec2::new(x, y))
        } else {
            Err(format!("({x}, {y}) lies outside the {side} photo of {width}x{height} pixels"))
        }
    };
    Ok(Pair { left: inside(pair.left, "left")?, right: inside(pair.right, "right")? })
}
