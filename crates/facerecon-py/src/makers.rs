//! Functions around the pipeline: simulate, pattern, render, compare, check.

use std::path::PathBuf;

use facerecon_core::evaluate::{CompareParams, MeshRegion, compare as run_compare};
use facerecon_core::render::{Heat, Mode, Scene, View, contact_sheet};
use facerecon_core::synthetic::Person;
use facerecon_core::synthetic::pattern::{PatternParams, pattern_image};
use facerecon_core::synthetic::simulate::{
    SimulateParams, Simulated, Subject, simulate as take_photos, write_simulated,
};
use facerecon_core::{Error, Params, check_capture};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::capture::Capture;
use crate::convert::{MeshIn, MeshOut, mesh, mesh_out, raster_out, rgb, rgb_out, transform_out};
use crate::errors::{argument, to_py};
use crate::params::{Sets, command_params};
use crate::reconstruction::{frame_named, to_json};
use crate::watch::{staged, warn, watched, with_warnings};

/// A simulated capture and its ground truth.
#[pyclass(frozen, module = "facerecon._core")]
pub(crate) struct Simulation(Simulated);

#[pymethods]
impl Simulation {
    fn capture(&self) -> Capture {
        Capture { capture: self.0.capture.clone(), warnings: Vec::new() }
    }

    /// The subject, camera frame, mm.
    fn mesh<'py>(&self, py: Python<'py>) -> PyResult<MeshOut<'py>> {
        mesh_out(py, self.0.truth.mesh.clone())
    }

    fn depth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        raster_out(py, self.0.truth.depth_mm.clone())
    }

    fn face<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        raster_out(py, self.0.truth.face.clone())
    }

    fn camera_from_model<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        transform_out(py, &self.0.truth.camera_from_model)
    }

    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<PathBuf> {
        py.detach(|| write_simulated(&folder, &self.0)).map_err(|e| to_py(py, e))
    }
}

/// Renders a capture of a mesh, or of a simulated person, in the virtual rig.
#[pyfunction]
fn simulate(
    py: Python<'_>,
    subject: u64,
    parts: Option<MeshIn<'_>>,
    texture: Option<PyReadonlyArray3<'_, u8>>,
    sets: Sets,
    callback: Option<Py<PyAny>>,
) -> PyResult<Simulation> {
    let params: SimulateParams = command_params(py, &sets)?;
    let given = parts.map(|p| mesh(&p)).transpose()?;
    let texture = texture.map(|t| rgb(&t)).transpose()?;
    let made = staged(py, callback, "simulate", |watch| match &given {
        Some(mesh) => {
            let texture = texture.as_ref();
            let subject = Subject { mesh, texture, landmarks: None, face: None };
            Ok(take_photos(&subject, &params, watch)?)
        }
        None => {
            let person = Person::new(subject);
            Ok(take_photos(&person.subject(), &params, watch)?)
        }
    })?;
    Ok(Simulation(made))
}

/// The image to project.
#[pyfunction]
fn pattern(py: Python<'_>, sets: Sets) -> PyResult<Bound<'_, PyArray3<u8>>> {
    let params: PatternParams = command_params(py, &sets)?;
    rgb_out(py, py.detach(|| pattern_image(&params)).map_err(|e| to_py(py, e))?)
}

/// Renders a mesh from named views, side by side.
#[pyfunction]
#[pyo3(signature = (parts, texture, heat, limit, views, mode, frame, size))]
fn render<'py>(
    py: Python<'py>,
    parts: MeshIn<'py>,
    texture: Option<PyReadonlyArray3<'py, u8>>,
    heat: Option<PyReadonlyArray1<'py, f64>>,
    limit: Option<f64>,
    views: Vec<String>,
    mode: &str,
    frame: &str,
    size: (usize, usize),
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let face = mesh(&parts)?;
    let texture = texture.map(|t| rgb(&t)).transpose()?;
    let heat: Option<Vec<f64>> = heat.map(|h| h.as_array().to_vec());
    let unknown = |what: &str, name: &str, names: Vec<&str>| {
        argument(py, &format!("{what} is {name:?}; expected one of {}", names.join(", ")))
    };
    let views = views
        .iter()
        .map(|name| {
            let names = || View::NAMED.iter().map(|v| v.0).collect();
            View::named(name).ok_or_else(|| unknown("view", name, names()))
        })
        .collect::<PyResult<Vec<_>>>()?;
    let names = || Mode::NAMED.iter().map(|m| m.0).collect();
    let mode = Mode::named(mode).ok_or_else(|| unknown("mode", mode, names()))?;
    let frame = frame_named(py, frame)?;
    let image = watched(py, None, |_| {
        let scene = Scene {
            texture: texture.as_ref(),
            heat: heat.as_deref().map(|values| Heat { values, limit, unit: "mm" }),
            frame,
            ..Scene::new(&face)
        };
        Ok(contact_sheet(&scene, &views, mode, size)?)
    })?;
    rgb_out(py, image)
}

/// Measures distances between two meshes; `(facts as JSON, distance of each vertex)`.
#[pyfunction]
fn compare<'py>(
    py: Python<'py>,
    first: MeshIn<'py>,
    second: MeshIn<'py>,
    region: Option<Vec<bool>>,
    sets: Sets,
) -> PyResult<(String, Bound<'py, PyArray1<f64>>)> {
    let params: CompareParams = command_params(py, &sets)?;
    let (first, second) = (mesh(&first)?, mesh(&second)?);
    let found = watched(py, None, |watch| -> Result<_, Error> {
        let side = MeshRegion { mesh: &first, mask: region.as_deref() };
        Ok(run_compare(&side, &MeshRegion::whole(&second), &params, watch)?)
    })?;
    Ok((to_json(py, &found)?, PyArray1::from_vec(py, found.vertex_distances)))
}

/// Checks the photographs of a capture; one finding per rule, as JSON.
#[pyfunction]
fn check(py: Python<'_>, capture: &Capture, sets: Sets) -> PyResult<String> {
    let params = Params { check: command_params(py, &sets)?, ..Params::default() };
    let (report, mut warnings) =
        with_warnings(py, None, |watch| check_capture(&capture.capture, &params, watch))?;
    // the findings of the check are its result
    warnings.retain(|text| !text.starts_with("check: "));
    warn(py, warnings)?;
    to_json(py, &report.findings)
}

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Simulation>()?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    module.add_function(wrap_pyfunction!(pattern, module)?)?;
    module.add_function(wrap_pyfunction!(render, module)?)?;
    module.add_function(wrap_pyfunction!(compare, module)?)?;
    module.add_function(wrap_pyfunction!(check, module)?)
}
