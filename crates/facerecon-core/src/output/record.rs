//! Keeping what a run showed on the way: for `stages/`, the report and notebooks.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use crate::data::{Gray, Mesh, Rgb};
use crate::io::{self, IoError};
use crate::math::Vec3;
use crate::observer::{Artifact, Event, Observer};

/// An intermediate result, kept.
#[derive(Clone, Debug, PartialEq)]
pub enum Kept {
    /// A grey image, 0 to 255.
    Gray(Gray),
    /// A colour image.
    Rgb(Rgb),
    /// Points.
    Points(Vec<Vec3>),
    /// A mesh.
    Mesh(Mesh),
}

/// What a run showed: artifacts by stage and name in the order they came, and the errors of
/// iterative stages step by step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// `(stage, name, artifact)`.
    pub artifacts: Vec<(String, String, Kept)>,
    /// Error after each step, by stage.
    pub histories: BTreeMap<String, Vec<f64>>,
}

/// An observer that keeps everything it is shown.
#[derive(Debug, Default)]
pub struct Recorder {
    record: Mutex<Record>,
}

impl Recorder {
    /// What was kept so far; the recorder is empty afterwards.
    pub fn take(&self) -> Record {
        self.record.lock().map(|mut record| std::mem::take(&mut *record)).unwrap_or_default()
    }
}

impl Observer for Recorder {
    fn event(&self, event: &Event<'_>) {
        if let (Event::Iteration { stage, error, .. }, Ok(mut record)) = (event, self.record.lock())
        {
            record.histories.entry((*stage).to_owned()).or_default().push(*error);
        }
    }

    fn artifact(&self, stage: &str, name: &str, artifact: Artifact<'_>) {
        let kept = match artifact {
            Artifact::Gray(image) => Kept::Gray(image.clone()),
            Artifact::Rgb(image) => Kept::Rgb(image.clone()),
            Artifact::Points(points) => Kept::Points(points.to_vec()),
            Artifact::Mesh(mesh) => Kept::Mesh(mesh.clone()),
        };
        if let Ok(mut record) = self.record.lock() {
            record.artifacts.push((stage.to_owned(), name.to_owned(), kept));
        }
    }
}

impl Record {
    /// The first artifact of a stage that has this name.
    pub fn kept(&self, stage: &str, name: &str) -> Option<&Kept> {
        self.artifacts.iter().find(|(s, n, _)| s == stage && n == name).map(|a| &a.2)
    }

    /// Writes every artifact into a folder: images as PNG, points and meshes as PLY, named
    /// `NN_stage_name` in the order they came.
    ///
    /// # Errors
    /// [`IoError`] naming the file that could not be written.
    pub fn write(&self, folder: &Path) -> Result<(), IoError> {
        for (number, (stage, name, kept)) in self.artifacts.iter().enumerate() {
            let stem = folder.join(format!("{:02}_{stage}_{name}", number + 1));
            match kept {
                Kept::Gray(image) => {
                    io::image::write_png(&stem.with_extension("png"), &image.to_u8())?;
                }
                Kept::Rgb(image) => io::image::write_png(&stem.with_extension("png"), image)?,
                Kept::Points(points) => io::ply::write_cloud(
                    &stem.with_extension("ply"),
                    &crate::data::Cloud::from_points(points.clone()),
                    &format!("{stage}: {name}"),
                )?,
                Kept::Mesh(mesh) => io::ply::write_mesh(&stem.with_extension("ply"), mesh, None)?,
            }
        }
        Ok(())
    }
}
