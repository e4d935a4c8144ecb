//! Sensors for `petzval sensor` and `petzval render --sensor`.

use crate::described::Named;
use crate::error::{Error, json};
use crate::gil::without_gil;
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use petzval_pictures::dng::RawPicture;
use petzval_pictures::png;
use petzval_render::sensor::exposure::ExposureRequest;
use petzval_render::sensor::file::SensorFile;
use petzval_render::sensor::photograph::photograph;
use petzval_render::sensor::report::report;
use petzval_render::sensor::response::Response;
use pyo3::prelude::*;
use std::path::PathBuf;

/// What is known of a sensor at a film speed.
#[pyfunction]
pub(crate) fn sensor_json(sensor: &str, iso: Option<f64>) -> Result<String, Error> {
    json(&report(&Response::new(SensorFile::find(sensor)?), iso)?)
}

/// The sensor's complaint about an exposure that is none of it, raised as an error.
#[pyfunction]
pub(crate) fn check_exposure(sensor: &str, exposure: Named<ExposureRequest>) -> Result<(), Error> {
    exposure.0.checked(&SensorFile::find(sensor)?)?;
    Ok(())
}

/// Photographs an OpenEXR picture into a raw file; what became of its light.
#[pyfunction]
pub(crate) fn expose_sensor_json(
    py: Python<'_>,
    sensor: &str,
    exposure: Named<ExposureRequest>,
    picture: PathBuf,
    output: PathBuf,
) -> Result<String, Error> {
    let response = Response::new(SensorFile::find(sensor)?);
    let summary = without_gil(py, || photograph(&response, &picture, &exposure.0, &output))?;
    json(&summary?)
}

/// Writes red, green and blue of 16 bits, first row at the top, as PNG.
#[pyfunction]
pub(crate) fn write_png(py: Python<'_>, pixels: PyReadonlyArray3<'_, u16>, output: PathBuf) -> Result<(), Error> {
    let shape = pixels.shape();
    let (size, planes) = ([shape[1], shape[0]], shape[2]);
    let picture = RawPicture { size, planes, counts: pixels.as_array().iter().copied().collect() };
    Ok(without_gil(py, || png::write(&output, &picture))??)
}
