//! Files of calibrations for `petzval calibration` and the panel.

use crate::described::Described;
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use petzval_optics::calibration::MapDirection;
use petzval_optics::formats::calibration::{self, CalibratedCamera, Format};
use petzval_pictures::channels;
use petzval_render::camera::CameraDescription;
use petzval_render::reports;
use pyo3::prelude::*;
use std::path::PathBuf;

/// What a file holds.
#[pyfunction]
pub(crate) fn calibration_json(py: Python<'_>, path: PathBuf) -> Result<String, Error> {
    let found = without_gil(py, || calibration::read(&path).map(|file| reports::calibration::report(&file)))?;
    json(&found?)
}

/// The file's cameras in another format.
#[pyfunction]
pub(crate) fn calibration_text(path: PathBuf, camera: Option<&str>, format: &str) -> Result<String, Error> {
    let format = match format {
        "opencv-yaml" => Format::OpenCvYaml,
        "opencv-json" => Format::OpenCvJson,
        "ros" => Format::Ros,
        "colmap" => Format::Colmap,
        other => return Err(invalid(format!("calibrations are not written as {other}"))),
    };
    let file = calibration::read(&path)?;
    let cameras: Vec<CalibratedCamera> = match camera {
        Some(name) => vec![file.camera(Some(name))?.clone()],
        None => file.cameras,
    };
    calibration::write(&cameras, format).map_err(|error| invalid(format!("{}: {error}", path.display())))
}

/// Writes a calibration's ST map to an OpenEXR file; the share of its pixels that have a source.
#[pyfunction]
pub(crate) fn write_calibration_map(
    py: Python<'_>,
    path: PathBuf,
    camera: Option<&str>,
    size: Option<[u32; 2]>,
    undistorts: bool,
    comments: &str,
    output: PathBuf,
) -> Result<f64, Error> {
    let file = calibration::read(&path)?;
    let found = file.camera(camera)?;
    let size = size.unwrap_or(found.calibration.size_px());
    let direction = if undistorts { MapDirection::Undistort } else { MapDirection::Distort };
    without_gil(py, || {
        let dark = || invalid(format!("{}: camera '{}' does not see straight ahead", path.display(), found.name));
        let map = found.calibration.st_map(size, direction).ok_or_else(dark)?;
        let channel = |i: usize, name: &str| (name.to_owned(), map.iter().map(|pixel| pixel[i]).collect());
        let named = ["R", "G", "B", "A"].into_iter().enumerate().map(|(i, name)| channel(i, name)).collect();
        channels::write(&output, size.map(|side| side as usize), named, comments)?;
        Ok(map.iter().filter(|pixel| pixel[3] > 0.0).count() as f64 / map.len() as f64)
    })?
}

/// A sentence on what of a calibrated camera's picture shows nothing, and why; `None` if all of it shows something.
#[pyfunction]
pub(crate) fn calibration_complaint(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
) -> Result<Option<String>, Error> {
    Ok(without_gil(py, || camera.0.calibration_complaint([width, height]))??)
}
