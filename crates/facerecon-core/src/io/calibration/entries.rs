//! The entries of a calibration file, found by any of their names.

use super::names::{self, normalised};
use super::numbers::{camera, check_baseline};
use super::tree::Tree;
use crate::camera::Pinhole;
use crate::io::error::Fault;
use crate::io::unit::LengthUnit;
use crate::math::Vec3;
use crate::settings::nearest_name;

/// Entries that an error message lists at most.
const MAX_LISTED: usize = 20;
/// Names of up to two letters (K1, R, T) are too short to guess which other name was meant.
const LONGEST_SHORT_NAME: usize = 2;
/// Largest image side that is accepted, pixels.
const MAX_SIDE: f64 = 1e6;

/// The entries of a calibration file.
pub(super) struct Entries<'a>(&'a [(String, Tree)]);

impl<'a> Entries<'a> {
    pub(super) fn new(entries: &'a [(String, Tree)]) -> Self {
        Self(entries)
    }

    /// The entry of the first of the `names` that exists.
    fn find(&self, names: &str) -> Option<&Tree> {
        let named = |n: &str| self.0.iter().find(|(k, _)| normalised(k) == n);
        names.split_whitespace().find_map(named).map(|(_, value)| value)
    }

    /// The numbers of an entry; `what` names it in errors.
    pub(super) fn numbers(&self, what: &str, names: &str) -> Result<Vec<f64>, Fault> {
        let value = self.find(names).ok_or_else(|| self.missing(what, names))?;
        value.numbers().map_err(|e| Fault::new(format!("{what}: {e}")))
    }

    fn missing(&self, what: &str, names: &str) -> Fault {
        let keys: Vec<&str> = self.0.iter().map(|(k, _)| k.as_str()).take(MAX_LISTED).collect();
        let first = names.split_whitespace().next().unwrap_or_default().to_uppercase();
        let near = nearest_name(&first, keys.iter().copied())
            .filter(|_| first.len() > LONGEST_SHORT_NAME)
            .map_or(String::new(), |n| format!("; did you mean {n}?"));
        let split = if names == names::ROTATION || names == names::TRANSLATION {
            " (OpenCV's samples write R and T to a second file, extrinsics.yml: merge both files)"
        } else {
            ""
        };
        Fault::new(format!(
            "{what} is missing{near}; the file has {}; expected are K1 D1 K2 D2 R T{split}",
            if keys.is_empty() { "no entries".to_owned() } else { keys.join(", ") },
        ))
    }

    /// The camera of one side; a missing distortion is a warning.
    pub(super) fn camera(
        &self,
        side: &str,
        matrix: &str,
        lens: &str,
        warnings: &mut Vec<String>,
    ) -> Result<Pinhole, Fault> {
        let k = self.numbers(&format!("the {side} camera matrix"), matrix)?;
        let d = match self.find(lens) {
            Some(_) => self.numbers(&format!("the {side} distortion"), lens)?,
            None => {
                warnings.push(format!(
                    "the calibration has no distortion of the {side} camera; none is assumed"
                ));
                Vec::new()
            }
        };
        camera(&k, &d, warnings).map_err(|e| Fault::new(format!("the {side} camera: {e}")))
    }

    /// T in millimetres.
    pub(super) fn translation(&self, warnings: &mut Vec<String>) -> Result<Vec3, Fault> {
        let t = self.numbers("T (translation)", names::TRANSLATION)?;
        let [x, y, z] = t[..] else {
            return Err(Fault::new(format!("T has {} numbers, but 3 are expected", t.len())));
        };
        let t = Vec3::new(x, y, z);
        if let Some(value) = self.find(names::UNIT) {
            let name = value.text().unwrap_or_default();
            let unit = LengthUnit::from_name(&name.to_lowercase()).map_err(|_| {
                Fault::new(format!("unknown unit {name:?}; use mm, cm, dm, m, um or in"))
            })?;
            return Ok(t * unit.in_mm());
        }
        check_baseline(t.norm(), "T", warnings)?;
        Ok(t)
    }

    /// `(width, height)` of the photos of the calibration, where stated.
    pub(super) fn image_size(&self) -> Result<Option<(usize, usize)>, Fault> {
        let pair = match (self.find("imagewidth"), self.find("imageheight")) {
            (Some(w), Some(h)) => vec![w.numbers(), h.numbers()],
            _ => match self.find(names::IMAGE_SIZE) {
                Some(Tree::Map(m)) => ["width", "height"]
                    .iter()
                    .filter_map(|n| m.iter().find(|(k, _)| normalised(k) == *n))
                    .map(|(_, v)| v.numbers())
                    .collect(),
                Some(other) => vec![other.numbers()],
                None => return Ok(None),
            },
        };
        let numbers: Vec<f64> =
            pair.into_iter().collect::<Result<Vec<_>, _>>().map_err(Fault::new)?.concat();
        let whole = |v: f64| (1.0..=MAX_SIDE).contains(&v) && v.fract() == 0.0;
        match numbers[..] {
            [w, h] if whole(w) && whole(h) => Ok(Some((w as usize, h as usize))),
            _ => Err(Fault::new(format!(
                "the image size is {numbers:?}; two whole numbers, width and height, are expected"
            ))),
        }
    }

    pub(super) fn refuse_fisheye(&self) -> Result<(), Fault> {
        let model =
            self.find(names::LENS_MODEL).and_then(Tree::text).unwrap_or_default().to_lowercase();
        if names::FISHEYE_MODELS.iter().any(|m| model.contains(m)) {
            return Err(Fault::new(format!(
                "the lens model is {model:?}, but only the pinhole with radial and tangential \
                 distortion is supported: calibrate with OpenCV's stereoCalibrate"
            )));
        }
        Ok(())
    }
}
