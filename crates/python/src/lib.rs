//! polyreel for Python: the engine, the pipeline and the program as the module `polyreel._polyreel`. The package around
//! it (`python/polyreel`) knows the kinds of pictures; here they are numpy arrays.

mod away;
mod error;
mod file;
mod mesh;
mod options;
mod picture;
mod renderer;
mod stream;
mod work;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program with the command line `arguments`, and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| polyreel::program::main_of(arguments))
}

/// The native half of the package `polyreel`.
#[pymodule]
fn _polyreel(module: &Bound<'_, PyModule>) -> PyResult<()> {
    error::register(module)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<renderer::Renderer>()?;
    module.add_class::<stream::FrameStream>()?;
    module.add_class::<mesh::Mesh>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(renderer::render, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::triangulate, module)?)?;
    module.add_function(wrap_pyfunction!(file::probe, module)?)?;
    module.add_function(wrap_pyfunction!(file::render_file, module)?)?;
    module.add_function(wrap_pyfunction!(file::end_all, module)?)?;
    module.add_function(wrap_pyfunction!(options::presets, module)?)?;
    module.add_function(wrap_pyfunction!(options::described, module)?)
}
