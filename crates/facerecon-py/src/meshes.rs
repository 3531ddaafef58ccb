//! Mesh files and templates.

use std::collections::BTreeMap;
use std::path::PathBuf;

use facerecon_core::Error;
use facerecon_core::io;
use facerecon_core::template::{self, Template as CoreTemplate};
use numpy::{PyArray3, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::convert::{MeshIn, MeshOut, mesh, mesh_out, rgb, rgb_out};
use crate::errors::to_py;

type TextureOut<'py> = Option<Bound<'py, PyArray3<u8>>>;

/// Reads a mesh file; `(mesh, texture, warnings)`.
#[pyfunction]
fn read_mesh(
    py: Python<'_>,
    path: PathBuf,
) -> PyResult<(MeshOut<'_>, TextureOut<'_>, Vec<String>)> {
    let loaded = py.detach(|| io::read_mesh(&path)).map_err(|e| to_py(py, e))?;
    let texture = loaded.texture.map(|t| rgb_out(py, t)).transpose()?;
    Ok((mesh_out(py, loaded.mesh)?, texture, loaded.warnings))
}

/// Writes a mesh file; the file extension sets the format.
#[pyfunction]
fn write_mesh(
    py: Python<'_>,
    path: PathBuf,
    parts: MeshIn<'_>,
    texture: Option<PyReadonlyArray3<'_, u8>>,
) -> PyResult<()> {
    let (mesh, texture) = (mesh(&parts)?, texture.map(|t| rgb(&t)).transpose()?);
    py.detach(|| io::write_mesh(&path, &mesh, texture.as_ref())).map_err(|e| to_py(py, e))
}

/// Writes the landmarks of a mesh beside its file, as `NAME.landmarks.toml`.
#[pyfunction]
fn write_landmarks(
    py: Python<'_>,
    path: PathBuf,
    landmarks: BTreeMap<String, usize>,
) -> PyResult<()> {
    let name = path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    template::write_landmarks(&path, &name, &landmarks).map(drop).map_err(|e| to_py(py, e))
}

/// A template (generic head).
#[pyclass(frozen, module = "facerecon._core")]
pub(crate) struct Template {
    pub(crate) template: CoreTemplate,
    #[pyo3(get)]
    warnings: Vec<String>,
}

#[pymethods]
impl Template {
    /// `head`, `head-coarse`, `PRESET=FILE`, or a mesh file with its landmarks beside it.
    #[staticmethod]
    fn load(py: Python<'_>, name: &str) -> PyResult<Self> {
        if let Some(template) = template::named(name) {
            return Ok(Self { template, warnings: Vec::new() });
        }
        let loaded =
            py.detach(|| template::resolve(name, None)).map_err(|e| to_py(py, Error::from(e)))?;
        let warnings = loaded.warnings.clone();
        Ok(Self { template: loaded.into_template(), warnings })
    }

    /// A mesh in the model frame, mm, as the template.
    #[new]
    fn new(name: String, parts: MeshIn<'_>, landmarks: BTreeMap<String, usize>) -> PyResult<Self> {
        let mesh = mesh(&parts)?;
        let template = CoreTemplate { name, mesh, landmarks, coarse: None, texture: None };
        Ok(Self { template, warnings: Vec::new() })
    }

    fn mesh<'py>(&self, py: Python<'py>) -> PyResult<MeshOut<'py>> {
        mesh_out(py, self.template.mesh.clone())
    }

    #[getter]
    fn landmarks(&self) -> BTreeMap<String, usize> {
        self.template.landmarks.clone()
    }
}

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Template>()?;
    module.add_function(wrap_pyfunction!(read_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(write_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(write_landmarks, module)?)
}
