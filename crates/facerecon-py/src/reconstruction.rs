//! Reconstructions, matches and batches.

use std::collections::BTreeMap;
use std::path::PathBuf;

use facerecon_core::Error;
use facerecon_core::data::Capture as CoreCapture;
use facerecon_core::math::Similarity;
use facerecon_core::observer::Observer;
use facerecon_core::output::batch::{self, Outcome};
use facerecon_core::output::{Kept, Record, Recorder};
use facerecon_core::render::Frame;
use facerecon_core::template::Template as CoreTemplate;
use facerecon_core::{Reconstruction as Found, reconstruct as run_pipeline, single_stage};
use facerecon_core::{
    output::{self, report},
    template,
};
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

use crate::capture::Capture;
use crate::convert::{
    CloudOut, MeshOut, array, cloud_out, mesh_out, pixels_out, points_out, raster_out, rgb_out,
    transform_out,
};
use crate::errors::{argument, to_py};
use crate::meshes::Template;
use crate::params::Params;
use crate::watch::{watched, with_warnings};

/// `(left, right, disparity, points, lattice, score)`; NaN where unknown.
type MatchesOut<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// The result of a reconstruction.
#[pyclass(frozen, module = "facerecon._core")]
pub(crate) struct Reconstruction {
    capture: CoreCapture,
    found: Found,
    record: Record,
}

/// Reconstructs a capture.
#[pyfunction]
fn reconstruct(
    py: Python<'_>,
    capture: &Capture,
    template: Option<&Template>,
    params: &Params,
    callback: Option<Py<PyAny>>,
) -> PyResult<Reconstruction> {
    let head = template.map_or_else(template::built_in, |t| t.template.clone());
    let (photos, params) = (&capture.capture, &params.0);
    // the result holds the warnings: they are not raised as Python warnings
    let ((mut found, record), _) = with_warnings(py, callback, |watch| {
        let recorder = Recorder::default();
        let found = run_pipeline(photos, &head, params, &[watch, &recorder as &dyn Observer])?;
        Ok((found, recorder.take()))
    })?;
    found.warnings.splice(0..0, capture.warnings.iter().cloned());
    Ok(Reconstruction { capture: photos.clone(), found, record })
}

#[pymethods]
impl Reconstruction {
    fn mesh<'py>(&self, py: Python<'py>, frame: &str) -> PyResult<MeshOut<'py>> {
        mesh_out(py, self.found.mesh_in(frame_named(py, frame)?))
    }

    #[getter]
    fn landmarks(&self) -> BTreeMap<String, usize> {
        self.found.landmarks.clone()
    }

    #[getter]
    fn texture<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<u8>>>> {
        self.found.texture.as_ref().map(|t| rgb_out(py, t.image.clone())).transpose()
    }

    #[getter]
    fn coverage<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<u8>>>> {
        self.found.texture.as_ref().map(|t| raster_out(py, t.coverage.clone())).transpose()
    }

    fn cloud<'py>(&self, py: Python<'py>, frame: &str) -> PyResult<CloudOut<'py>> {
        let cloud = match frame_named(py, frame)? {
            Frame::Model => self.found.cloud.transformed(&self.found.model_from_camera),
            Frame::Camera => self.found.cloud.clone(),
        };
        cloud_out(py, cloud)
    }

    fn matches<'py>(&self, py: Python<'py>, frame: &str) -> PyResult<MatchesOut<'py>> {
        matches_out(py, &output::match_rows(&self.found, frame_named(py, frame)?))
    }

    fn depth<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyArray2<u8>>; 2]> {
        let [left, right] = &self.found.depth;
        Ok([raster_out(py, left.to_u8())?, raster_out(py, right.to_u8())?])
    }

    #[getter]
    fn model_from_camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        transform_out(py, &self.found.model_from_camera)
    }

    /// The facts of `result.json`.
    fn json(&self) -> String {
        output::result_json(&self.found).to_string()
    }

    fn summary(&self) -> Vec<String> {
        report::summary(&self.found)
    }

    /// The verdict as one sentence.
    fn verdict(&self) -> String {
        self.found.verdict.to_string()
    }

    fn report_html(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| report::html(&self.capture, &self.found, &self.record))
            .map_err(|error| to_py(py, error))
    }

    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        frame: &str,
        keep_stages: bool,
    ) -> PyResult<()> {
        let frame = frame_named(py, frame)?;
        watched(py, None, |_| {
            output::write_result(
                &folder,
                &self.capture,
                &self.found,
                &self.record,
                frame,
                keep_stages,
            )
        })
    }

    /// The artifacts of the stages: `(stage, name, image or points or mesh)`.
    fn artifacts<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(String, String, Bound<'py, PyAny>)>> {
        let shown = self.record.artifacts.iter().map(|(stage, name, kept)| {
            let value = match kept {
                Kept::Gray(image) => raster_out(py, image.clone())?.into_bound_py_any(py)?,
                Kept::Rgb(image) => rgb_out(py, image.clone())?.into_bound_py_any(py)?,
                Kept::Points(points) => points_out(py, points)?.into_bound_py_any(py)?,
                Kept::Mesh(mesh) => mesh_out(py, mesh.clone())?.into_bound_py_any(py)?,
            };
            Ok((stage.clone(), name.clone(), value))
        });
        shown.collect()
    }
}

/// A table of matches as columns.
pub(crate) fn matches_out<'py>(
    py: Python<'py>,
    rows: &[facerecon_core::io::MatchRow],
) -> PyResult<MatchesOut<'py>> {
    const NONE: [f64; 3] = [f64::NAN; 3];
    let position = rows.iter().map(|r| r.position.map_or(NONE, |p| [p.x, p.y, p.z]));
    let lattice = rows.iter().map(|r| r.lattice.map_or([f64::NAN; 2], |l| l.map(f64::from)));
    let disparity = rows.iter().map(|r| r.disparity.unwrap_or(f64::NAN));
    Ok((
        pixels_out(py, rows.iter().map(|r| r.left))?,
        pixels_out(py, rows.iter().map(|r| r.right))?,
        PyArray1::from_vec(py, disparity.collect()),
        array(py, position.collect())?,
        array(py, lattice.collect())?,
        PyArray1::from_vec(py, rows.iter().map(|r| r.score).collect()),
    ))
}

/// Matches the dots of a capture; `(table of matches, numbers of dots left and right)`.
#[pyfunction]
fn find_matches<'py>(
    py: Python<'py>,
    capture: &Capture,
    params: &Params,
    callback: Option<Py<PyAny>>,
) -> PyResult<(MatchesOut<'py>, [usize; 2])> {
    let (photos, params) = (&capture.capture, &params.0);
    let found = watched(py, callback, |watch| single_stage::find_matches(photos, params, watch))?;
    let same = Similarity::identity();
    let rows = output::matches_table(&found.matches, &found.rectification, &[], &same);
    Ok((matches_out(py, &rows)?, found.dots))
}

/// The captures at these paths, with their names.
///
/// # Errors
/// `ParameterError` when several have the same name.
#[pyfunction]
fn batch_captures(py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<Vec<(PathBuf, String)>> {
    let found = batch::find_captures(&paths);
    let shared = batch::shared_names(&found);
    if !shared.is_empty() {
        let message = format!(
            "captures: several are named {}; their results would overwrite each other, so rename \
             the folders",
            shared.join(", ")
        );
        return Err(argument(py, &message));
    }
    let named = |path: PathBuf| {
        let name = batch::capture_name(&path);
        (path, name)
    };
    Ok(found.into_iter().map(named).collect())
}

/// Reconstructs one capture of a batch, unless its result exists; the outcome as JSON.
#[pyfunction]
fn batch_run(
    py: Python<'_>,
    capture: PathBuf,
    output: PathBuf,
    template: &str,
    params: &Params,
    frame: &str,
    batch: &str,
) -> PyResult<String> {
    let frame = frame_named(py, frame)?;
    let head: CoreTemplate = match template::named(template) {
        Some(head) => head,
        None => {
            let loaded = template::resolve(template, None);
            loaded.map_err(|e| to_py(py, e))?.into_template()
        }
    };
    let outcome = py.detach(|| batch::run(&capture, &output, &head, &params.0, frame, Some(batch)));
    to_json(py, &outcome)
}

/// A list of outcomes (JSON) as `(CSV, HTML)`.
#[pyfunction]
fn batch_tables(py: Python<'_>, outcomes: &str) -> PyResult<(String, String)> {
    let outcomes: Vec<Outcome> =
        serde_json::from_str(outcomes).map_err(|e| argument(py, &format!("outcomes: {e}")))?;
    let html = batch::to_html(&outcomes).map_err(|error| to_py(py, error))?;
    Ok((batch::to_csv(&outcomes), html))
}

pub(crate) fn to_json(py: Python<'_>, value: &impl serde::Serialize) -> PyResult<String> {
    let failed = |e: serde_json::Error| crate::errors::to_py(py, Error::Input(e.to_string()));
    serde_json::to_string(value).map_err(failed)
}

pub(crate) fn frame_named(py: Python<'_>, name: &str) -> PyResult<Frame> {
    Frame::named(name).ok_or_else(|| {
        argument(py, &format!("frame is {name:?}; expected \"model\" or \"camera\""))
    })
}

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Reconstruction>()?;
    module.add_function(wrap_pyfunction!(reconstruct, module)?)?;
    module.add_function(wrap_pyfunction!(find_matches, module)?)?;
    module.add_function(wrap_pyfunction!(batch_captures, module)?)?;
    module.add_function(wrap_pyfunction!(batch_run, module)?)?;
    module.add_function(wrap_pyfunction!(batch_tables, module)?)
}
