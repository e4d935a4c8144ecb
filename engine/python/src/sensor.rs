//! Sensors for `petzval sensor` and `petzval render --sensor`.

use crate::described::Named;
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use petzval_pictures::dng::RawPicture;
use petzval_pictures::png;
use petzval_render::sensor::exposure::ExposureRequest;
use petzval_render::sensor::file::SensorFile;
use petzval_render::sensor::photograph::{photograph, photograph_pixels};
use petzval_render::sensor::report::report;
use petzval_render::sensor::response::Response;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The properties of a sensor at a film speed.
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

/// Photographs an OpenEXR picture into a raw file; returns the report on its light.
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

/// Photographs a rendered picture, height x width x 4, rows from below, into a raw file; returns the report on its light.
#[pyfunction]
pub(crate) fn expose_pixels_json(
    py: Python<'_>,
    sensor: &str,
    exposure: Named<ExposureRequest>,
    pixels: PyReadonlyArray3<'_, f32>,
    output: PathBuf,
) -> Result<String, Error> {
    let response = Response::new(SensorFile::find(sensor)?);
    let [height, width, 4] = *pixels.shape() else { return Err(invalid("a picture has four numbers for each pixel")) };
    let values: Vec<f32> = pixels.as_array().iter().copied().collect();
    let taken = without_gil(py, || photograph_pixels(&response, [width, height], &values, &exposure.0, &output))?;
    json(&taken?)
}

/// Writes red, green and blue of 16 bits, first row at the top, as PNG.
#[pyfunction]
pub(crate) fn write_png(py: Python<'_>, pixels: PyReadonlyArray3<'_, u16>, output: PathBuf) -> Result<(), Error> {
    let shape = pixels.shape();
    let (size, planes) = ([shape[1], shape[0]], shape[2]);
    let picture = RawPicture { size, planes, counts: pixels.as_array().iter().copied().collect() };
    Ok(without_gil(py, || png::write(&output, &picture))??)
}
