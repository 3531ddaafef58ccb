//! Python bindings: the private module `facerecon._core` below a typed Python facade.
//!
//! The facade checks layout, shape and values of arrays. This module copies them into the types of
//! the core, releases the GIL, and turns errors into exceptions of `facerecon.errors`.

mod capture;
mod convert;
mod errors;
mod makers;
mod meshes;
mod params;
mod reconstruction;
mod stages;
mod watch;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line with `sys.argv`; returns the exit code.
#[pyfunction]
fn cli_main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| facerecon_cli::run(arguments))
}

/// The private core of the package.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("LANDMARK_NAMES", facerecon_core::data::LANDMARKS)?;
    module.add_function(wrap_pyfunction!(cli_main, module)?)?;
    params::add(module)?;
    capture::add(module)?;
    meshes::add(module)?;
    reconstruction::add(module)?;
    stages::add(module)?;
    makers::add(module)
}
