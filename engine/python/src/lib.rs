//! The wall between Python and the engine: arrays in, tiles out, errors mapped, the interpreter's lock freed for
//! every long call. Nothing is computed here. `petzval/_native.pyi` is the shape as Python sees it.

mod bake;
mod calibration;
mod camera;
mod compiled;
mod curves;
mod described;
mod edges;
mod error;
mod files;
mod focusing;
mod framing;
mod gil;
mod glass;
mod graph;
mod job;
mod lens;
mod material;
mod memory;
mod mesh;
mod parts;
mod pictures;
mod plan;
mod points;
mod proofs;
mod questions;
mod reports;
mod scene;
mod sensor;
mod surface;

use pyo3::prelude::*;

/// The target of this module's compilation: a level of x86-64 (`petzval/processors.py`), or the kind of processor.
const PROCESSOR: &str = if cfg!(not(target_arch = "x86_64")) {
    std::env::consts::ARCH
} else if cfg!(all(target_feature = "avx512f", target_feature = "avx512vl")) {
    "x86-64-v4"
} else if cfg!(all(target_feature = "avx2", target_feature = "fma", target_feature = "bmi2")) {
    "x86-64-v3"
} else if cfg!(all(target_feature = "sse4.2", target_feature = "popcnt")) {
    "x86-64-v2"
} else {
    "x86-64"
};

/// The compiled half of the package.
#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("PROCESSOR", PROCESSOR)?;
    error::register(m)?;
    m.add_class::<lens::Lens>()?;
    m.add_class::<scene::SceneBuilder>()?;
    m.add_class::<scene::SceneDraft>()?;
    m.add_class::<scene::Scene>()?;
    m.add_class::<job::Job>()?;
    m.add_class::<plan::Plan>()?;
    m.add_class::<files::FileReplacement>()?;
    m.add_class::<files::Checkpoint>()?;
    m.add_function(wrap_pyfunction!(files::check_replaceable, m)?)?;
    m.add_function(wrap_pyfunction!(job::film_bytes_a_pixel, m)?)?;
    m.add_function(wrap_pyfunction!(job::denoising_seconds, m)?)?;
    m.add_function(wrap_pyfunction!(files::read_bounded, m)?)?;
    m.add_function(wrap_pyfunction!(files::checkpoint_problem, m)?)?;
    m.add_function(wrap_pyfunction!(pictures::check_exr, m)?)?;
    m.add_function(wrap_pyfunction!(calibration::calibration_json, m)?)?;
    m.add_function(wrap_pyfunction!(calibration::calibration_remarks, m)?)?;
    m.add_function(wrap_pyfunction!(calibration::photographic_lens_json, m)?)?;
    m.add_function(wrap_pyfunction!(calibration::calibration_text, m)?)?;
    m.add_function(wrap_pyfunction!(calibration::fitted_camera_json, m)?)?;
    m.add_function(wrap_pyfunction!(calibration::write_calibration_map, m)?)?;
    m.add_function(wrap_pyfunction!(calibration::write_photographic_map, m)?)?;
    m.add_function(wrap_pyfunction!(sensor::sensor_json, m)?)?;
    m.add_function(wrap_pyfunction!(sensor::check_exposure, m)?)?;
    m.add_function(wrap_pyfunction!(sensor::expose_sensor_json, m)?)?;
    m.add_function(wrap_pyfunction!(sensor::expose_pixels_json, m)?)?;
    m.add_function(wrap_pyfunction!(sensor::write_png, m)?)?;
    m.add_function(wrap_pyfunction!(camera::camera_info_json, m)?)?;
    m.add_function(wrap_pyfunction!(camera::coverage_json, m)?)?;
    m.add_function(wrap_pyfunction!(camera::film_of_lens_mm, m)?)?;
    m.add_function(wrap_pyfunction!(focusing::autofocus_json, m)?)?;
    m.add_function(wrap_pyfunction!(focusing::autofocus_by_json, m)?)?;
    m.add_function(wrap_pyfunction!(focusing::sharp_points_json, m)?)?;
    m.add_function(wrap_pyfunction!(focusing::sharpness_json, m)?)?;
    m.add_function(wrap_pyfunction!(framing::framing_json, m)?)?;
    m.add_function(wrap_pyfunction!(framing::osl_camera, m)?)?;
    m.add_function(wrap_pyfunction!(framing::distortion_map, m)?)?;
    m.add_function(wrap_pyfunction!(framing::write_distortion_map, m)?)?;
    m.add_function(wrap_pyfunction!(reports::lens_report_json, m)?)?;
    m.add_function(wrap_pyfunction!(reports::lens_drawing_json, m)?)?;
    m.add_function(wrap_pyfunction!(proofs::lens_proof_json, m)?)?;
    m.add_function(wrap_pyfunction!(reports::lens_ghosts_json, m)?)?;
    m.add_function(wrap_pyfunction!(reports::lens_reality_json, m)?)?;
    m.add_function(wrap_pyfunction!(reports::fitted_lens_json, m)?)?;
    m.add_function(wrap_pyfunction!(reports::lens_groups, m)?)?;
    m.add_function(wrap_pyfunction!(glass::glass_json, m)?)?;
    m.add_function(wrap_pyfunction!(glass::glasses_json, m)?)?;
    m.add_function(wrap_pyfunction!(edges::random_per_island, m)?)?;
    m.add_function(wrap_pyfunction!(edges::pointiness, m)?)?;
    m.add_function(wrap_pyfunction!(memory::free_memory_bytes, m)?)?;
    m.add_function(wrap_pyfunction!(plan::effects_json, m)?)?;
    m.add_function(wrap_pyfunction!(graph::evaluate_graph, m)?)?;
    m.add_function(wrap_pyfunction!(pictures::merge_pictures_json, m)?)?;
    m.add_function(wrap_pyfunction!(surface::trace_surfaces_json, m)?)?;
    Ok(())
}
