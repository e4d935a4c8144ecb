//! Files of calibrations for `petzval calibration` and the panel.

use crate::described::{Described, Named};
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use petzval_optics::calibration::{Calibration, MapDirection};
use petzval_optics::formats::calibration::{self, CalibratedCamera, Format};
use petzval_pictures::channels;
use petzval_render::camera::{CalibrationSettings, CameraDescription, calibration_of};
use petzval_render::reports;
use petzval_render::reports::fitted_camera::{FittedCamera, FittedCameraOptions, fitted_camera};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// Largest number of pixels of a map of rays, which takes a hundred bytes for each.
const MOST_PIXELS: u64 = 1 << 26;

/// The report of a file of calibrations, of a lensfun database, or of the installed one.
#[pyfunction]
pub(crate) fn calibration_json(py: Python<'_>, path: PathBuf) -> Result<String, Error> {
    let settings = CalibrationSettings { path, ..CalibrationSettings::default() };
    json(&without_gil(py, || reports::calibration::of_settings(&settings))??)
}

/// The report of a lens of a lensfun database at a camera's setting.
#[pyfunction]
pub(crate) fn photographic_lens_json(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
) -> Result<String, Error> {
    json(&without_gil(py, || reports::calibration::of_lens(&camera.0, [width, height]))??)
}

fn format_of(word: &str) -> Result<Format, Error> {
    Ok(match word {
        "opencv-yaml" => Format::OpenCvYaml,
        "opencv-json" => Format::OpenCvJson,
        "ros" => Format::Ros,
        "colmap" => Format::Colmap,
        other => return Err(invalid(format!("calibrations are not written as {other}"))),
    })
}

/// The file's cameras in another format.
#[pyfunction]
pub(crate) fn calibration_text(path: PathBuf, camera: Option<&str>, format: &str) -> Result<String, Error> {
    let format = format_of(format)?;
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
    let name = format!("{}: camera '{}'", path.display(), found.name);
    without_gil(py, || write_map(&found.calibration, &name, (size, undistorts), comments, &output))?
}

/// Writes the ST map of a lens of a lensfun database at a camera's setting, as [`write_calibration_map`].
#[pyfunction]
pub(crate) fn write_photographic_map(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    size: [u32; 2],
    undistorts: bool,
    comments: &str,
    output: PathBuf,
) -> Result<f64, Error> {
    without_gil(py, || {
        let calibration = calibration_of(&camera.0, size[0], size[1])?;
        write_map(&calibration, &camera.0.object_name, (size, undistorts), comments, &output)
    })?
}

fn write_map(
    calibration: &Calibration,
    name: &str,
    (size, undistorts): ([u32; 2], bool),
    comments: &str,
    output: &Path,
) -> Result<f64, Error> {
    let direction = if undistorts { MapDirection::Undistort } else { MapDirection::Distort };
    let dark = || invalid(format!("{name} does not see straight ahead"));
    let map = calibration.st_map(size, direction).ok_or_else(dark)?;
    let channel = |i: usize, name: &str| (name.to_owned(), map.iter().map(|pixel| pixel[i]).collect());
    let named = ["R", "G", "B", "A"].into_iter().enumerate().map(|(i, name)| channel(i, name)).collect();
    channels::write(output, size.map(|side| side as usize), named, comments)?;
    Ok(map.iter().filter(|pixel| pixel[3] > 0.0).count() as f64 / map.len() as f64)
}

/// A model fitted to a lens: the report on it, and its text in a format, if one is named. Maps are files to write, with their
/// comments.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "what is fitted, and what is written of it")]
pub(crate) fn fitted_camera_json(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    size: [u32; 2],
    options: Named<FittedCameraOptions>,
    name: &str,
    format: Option<&str>,
    ray_map: Option<(PathBuf, String)>,
    residual_map: Option<(PathBuf, String)>,
) -> Result<(String, Option<String>), Error> {
    let format = format.map(format_of).transpose()?;
    let [width, height] = size.map(u64::from);
    if (ray_map.is_some() || residual_map.is_some()) && width * height > MOST_PIXELS {
        return Err(invalid(format!("a map of {width} x {height} pixels: give less than {MOST_PIXELS} in all")));
    }
    without_gil(py, || {
        let found = fitted_camera(&camera.0, size, &options.0).map_err(|error| invalid(error.to_string()))?;
        let text = format.map(|format| {
            let camera = CalibratedCamera { name: name.to_owned(), calibration: found.calibration.clone() };
            calibration::write(&[camera], format).map_err(|error| invalid(error.to_string()))
        });
        let text = text.transpose()?;
        let sides = size.map(|side| side as usize);
        let pixels = if ray_map.is_some() || residual_map.is_some() { found.rays.pixels() } else { Vec::new() };
        if let Some((path, comments)) = &ray_map {
            channels::write(path, sides, FittedCamera::ray_map(&pixels), comments)?;
        }
        if let Some((path, comments)) = &residual_map {
            channels::write(path, sides, found.residual_map(&pixels), comments)?;
        }
        Ok((json(&found.report)?, text))
    })?
}

/// Sentences on a calibrated camera: the part of its picture that shows nothing and why, and the effects of its lens that were not
/// measured.
#[pyfunction]
pub(crate) fn calibration_remarks(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
) -> Result<Vec<String>, Error> {
    Ok(without_gil(py, || camera.0.calibration_remarks([width, height]))??)
}
