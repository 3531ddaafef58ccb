//! Parameters of the pipeline, and those of `simulate`, `pattern`, `check` and `compare`.

use facerecon_core::Params as CoreParams;
use facerecon_core::settings::{self, SettingsError, Value};
use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::errors::to_py;

/// Single settings: `(dotted name, value as TOML text)`.
pub(crate) type Sets = Vec<(String, String)>;

/// All parameters of a reconstruction.
#[pyclass(frozen, module = "facerecon._core")]
pub(crate) struct Params(pub(crate) CoreParams);

#[pymethods]
impl Params {
    #[new]
    fn new(
        py: Python<'_>,
        profile: Option<&str>,
        toml: Option<&str>,
        sets: Sets,
    ) -> PyResult<Self> {
        CoreParams::load(profile, toml, &sets).map(Self).map_err(|e| to_py(py, e))
    }

    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        self.0.to_toml().map_err(|e| to_py(py, e))
    }

    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&self.0)
            .map_err(|e| to_py(py, SettingsError::Malformed(e.to_string())))
    }
}

/// The parameters of a function that has its own struct.
pub(crate) fn command_params<T>(py: Python<'_>, sets: &Sets) -> PyResult<T>
where
    T: Value + Serialize + DeserializeOwned,
{
    settings::from_sets(sets).map_err(|e| to_py(py, e))
}

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Params>()
}
