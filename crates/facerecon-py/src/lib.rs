//! Python bindings: a private module `facerecon._core` under a typed Python facade.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line with `sys.argv`; gives the exit code.
#[pyfunction]
fn cli_main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| facerecon_cli::run(arguments))
}

/// The private core of the package.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(cli_main, module)?)
}
