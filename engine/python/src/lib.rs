//! The wall between Python and the engine: arrays in, tiles out, errors mapped, the interpreter's lock freed for
//! every long call. Nothing is computed here. `petzval/_native.pyi` is the shape as Python sees it.

mod camera;
mod doorway;
mod error;
mod focusing;
mod job;
mod lens;
mod material;
mod scene;
mod surface;

use pyo3::prelude::*;

/// The compiled half of the package.
#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    error::register(m)?;
    m.add_class::<lens::Lens>()?;
    m.add_class::<scene::SceneBuilder>()?;
    m.add_class::<scene::Scene>()?;
    m.add_class::<job::Job>()?;
    m.add_function(wrap_pyfunction!(camera::camera_info_json, m)?)?;
    m.add_function(wrap_pyfunction!(focusing::autofocus_json, m)?)?;
    m.add_function(wrap_pyfunction!(focusing::autofocus_by_json, m)?)?;
    m.add_function(wrap_pyfunction!(focusing::sharp_points_json, m)?)?;
    m.add_function(wrap_pyfunction!(surface::trace_surfaces_json, m)?)?;
    Ok(())
}
