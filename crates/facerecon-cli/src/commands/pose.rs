//! The JSON file that `facerecon register` writes beside the registered cloud.

use std::path::Path;

use facerecon_core::Error;
use facerecon_core::io;
use facerecon_core::math::Similarity;
use facerecon_core::output;
use facerecon_core::stages::register::Registration;
use serde::{Deserialize, Deserializer};
use serde_json::{Value, json};

use crate::failure::Failure;

/// The result of `register`, as `deform` and `texture` need it.
#[derive(Deserialize)]
pub(super) struct Pose {
    /// Model frame from the frame of the cloud.
    #[serde(deserialize_with = "similarity")]
    pub(super) model_from_data: Similarity,
    /// Factor that brings the template to the scale of the cloud.
    pub(super) template_scale: f64,
}

impl Default for Pose {
    fn default() -> Self {
        Self { model_from_data: Similarity::identity(), template_scale: 1.0 }
    }
}

impl Pose {
    /// Reads the file that [`to_json`] describes.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let text = io::read_text(path, "pose")?;
        let malformed = |reason: String| {
            let file = path.display();
            Error::Input(format!("{file}: expected the JSON written by register, but {reason}"))
        };
        let pose: Self = serde_json::from_str(&text).map_err(|e| malformed(e.to_string()))?;
        if !(pose.template_scale > 0.0 && pose.template_scale.is_finite()) {
            let reason =
                format!("template_scale is {}, not a positive number", pose.template_scale);
            return Err(malformed(reason).into());
        }
        Ok(pose)
    }
}

/// The contents of the file.
pub(super) fn to_json(pose: &Registration, model_from_data: &Similarity) -> Value {
    let mut facts = json!({
        "model_from_data": model_from_data.to_rows(),
        "template_scale": 1.0 / pose.model_from_data.scale,
    });
    if let Some(facts) = facts.as_object_mut() {
        facts.extend(output::registration_json(pose));
    }
    facts
}

fn similarity<'de, D: Deserializer<'de>>(from: D) -> Result<Similarity, D::Error> {
    let rows = <[[f64; 4]; 4]>::deserialize(from)?;
    Similarity::from_rows(&rows).ok_or_else(|| {
        let reason = "model_from_data is not a rotation with translation and uniform scale";
        serde::de::Error::custom(reason)
    })
}
