//! The landmarks and distances of a result as JSON and as CSV, rounded to what is known.

use serde_json::{Value, json};

use crate::pipeline::{FaceDistance, FaceLandmark, Reconstruction};

/// Last digit of lengths and positions, mm: standard deviations are not smaller.
const STEP_MM: f64 = 0.1;

/// Rounds a length to a tenth.
pub(super) fn tenths(value: f64) -> f64 {
    (value / STEP_MM).round() / (1.0 / STEP_MM)
}

/// Rounds a standard deviation to a tenth, but not to 0.
fn sigma_tenths(value: f64) -> f64 {
    tenths(value).max(STEP_MM)
}

/// The landmarks for `result.json`.
pub(super) fn landmarks_json(found: &Reconstruction) -> Value {
    let one = |l: &FaceLandmark| {
        json!({
            "name": l.term.name,
            "term": l.term.term,
            "abbreviation": l.term.abbreviation,
            "picture_side": l.term.side,
            "anatomical_side": l.term.side.anatomical(),
            "status": l.status,
            "model_mm": l.in_model.map(tenths).as_slice(),
            "camera_mm": l.in_camera.map(tenths).as_slice(),
            "sigma_mm": sigma_tenths(l.sigma),
            "vertex": l.vertex,
        })
    };
    found.face_landmarks().iter().map(one).collect()
}

/// The distances for `result.json`: `value_mm` and `sigma_mm` of those that were measured,
/// `template_mm` of the others.
pub(super) fn distances_json(found: &Reconstruction) -> Value {
    let one = |d: &FaceDistance| {
        let value = tenths(d.value_mm);
        json!({
            "name": d.term.name,
            "term": d.term.term,
            "abbreviation": d.term.abbreviation,
            "from": d.term.from,
            "to": d.term.to,
            "status": status(d),
            "value_mm": d.is_measured.then_some(value),
            "sigma_mm": d.is_measured.then(|| sigma_tenths(d.sigma_mm)),
            "template_mm": (!d.is_measured).then_some(value),
        })
    };
    found.face_distances().iter().map(one).collect()
}

fn status(distance: &FaceDistance) -> &'static str {
    if distance.is_measured { "measured" } else { "template only" }
}

/// `landmarks.csv`.
pub(super) fn landmarks_csv(found: &Reconstruction) -> String {
    let mut text = String::from(
        "name,term,abbreviation,picture_side,anatomical_side,status,x_model_mm,y_model_mm,\
         z_model_mm,x_camera_mm,y_camera_mm,z_camera_mm,sigma_mm,vertex\n",
    );
    for l in found.face_landmarks() {
        let t = l.term;
        let places: Vec<String> =
            l.in_model.iter().chain(l.in_camera.iter()).map(|c| format!("{c:.1}")).collect();
        text += &format!(
            "{},{},{},{},{},{},{},{:.1},{}\n",
            t.name,
            t.term,
            t.abbreviation,
            t.side,
            t.side.anatomical(),
            l.status,
            places.join(","),
            sigma_tenths(l.sigma),
            l.vertex.map_or(String::new(), |v| v.to_string()),
        );
    }
    text
}

/// `distances.csv`. The columns `value_mm` and `sigma_mm` are empty where an end is known from the
/// template alone, `template_mm` where both ends were measured.
pub(super) fn distances_csv(found: &Reconstruction) -> String {
    let mut text =
        String::from("name,term,abbreviation,from,to,status,value_mm,sigma_mm,template_mm\n");
    for d in found.face_distances() {
        let value = format!("{:.1}", d.value_mm);
        let (measured, sigma, template) = if d.is_measured {
            (value, format!("{:.1}", sigma_tenths(d.sigma_mm)), String::new())
        } else {
            (String::new(), String::new(), value)
        };
        let t = d.term;
        // some terms contain a comma
        text += &format!(
            "{},\"{}\",{},{},{},{},{measured},{sigma},{template}\n",
            t.name,
            t.term,
            t.abbreviation,
            t.from,
            t.to,
            status(&d),
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_rounded_to_tenths_and_standard_deviations_are_not_zero() {
        assert_eq!(tenths(123.4567), 123.5);
        assert_eq!(tenths(-0.04), 0.0);
        assert_eq!(sigma_tenths(0.01), 0.1);
        assert_eq!(sigma_tenths(1.26), 1.3);
    }
}
