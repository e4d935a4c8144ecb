//! A lens beside a pinhole: how it frames alike, and the map between their pictures.

use crate::described::{Described, Named};
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use petzval_pictures::channels;
use petzval_render::camera::CameraDescription;
use petzval_render::camera::tools::distortion_map::{Direction, DistortionMap};
use petzval_render::camera::tools::framing::Framed;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Maps by wavelength, then pixel.
type Maps = Vec<Vec<[f32; 4]>>;

/// Largest number of pixels of a map.
const MOST_PIXELS: u64 = 1 << 28;

/// The settings with the frame of Blender's camera.
#[pyfunction]
pub(crate) fn framing_json(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
    by: Named<Framed>,
) -> Result<String, Error> {
    json(&without_gil(py, || camera.0.framed_like_blender([width, height], by.0))??)
}

fn pixels(
    camera: Described<CameraDescription>,
    size: [u32; 2],
    wavelengths_nm: &[f64],
    direction: Direction,
) -> Result<impl FnOnce() -> Result<Maps, Error> + use<>, Error> {
    let [width, height] = size.map(u64::from);
    if width * height > MOST_PIXELS {
        return Err(invalid(format!("a map of {width} x {height} pixels: give less")));
    }
    let description = camera.0;
    let wavelengths = wavelengths_nm.to_vec();
    Ok(move || {
        let map = |&nm: &f64| Ok(DistortionMap::new(&description, size, nm)?.pixels(size, direction));
        wavelengths.iter().map(map).collect()
    })
}

/// The map for one wavelength.
#[pyfunction]
pub(crate) fn distortion_map<'py>(
    py: Python<'py>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
    wavelength_nm: f64,
    direction: Named<Direction>,
) -> Result<Bound<'py, PyArray3<f32>>, Error> {
    let work = pixels(camera, [width, height], &[wavelength_nm], direction.0)?;
    let values: Vec<f32> = without_gil(py, work)??.concat().into_flattened();
    Ok(PyArray1::from_vec(py, values).reshape([height as usize, width as usize, 4])?)
}

/// Writes distortion maps to an OpenEXR file: the first wavelength's map as its picture, the others as layers of these names. Returns for
/// each map the share of its pixels that lie in the other picture.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "what a map is of")]
pub(crate) fn write_distortion_map(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
    maps: Vec<(String, f64)>,
    direction: Named<Direction>,
    comments: &str,
    output: PathBuf,
) -> Result<Vec<f64>, Error> {
    let (names, wavelengths): (Vec<String>, Vec<f64>) = maps.into_iter().unzip();
    let work = pixels(camera, [width, height], &wavelengths, direction.0)?;
    without_gil(py, || {
        let found = work()?;
        let mut named = Vec::new();
        let mut shares = Vec::new();
        for (name, map) in names.iter().zip(&found) {
            for (i, letter) in ["R", "G", "B", "A"].into_iter().enumerate() {
                // Files have their first row at the top.
                let rows = map.chunks(width as usize).rev();
                let values = rows.flat_map(|row| row.iter().map(|pixel| pixel[i])).collect();
                named.push((format!("{name}{}{letter}", if name.is_empty() { "" } else { "." }), values));
            }
            let within = map.iter().filter(|pixel| pixel[3] > 0.0).count();
            shares.push(within as f64 / map.len() as f64);
        }
        channels::write(&output, [width as usize, height as usize], named, comments)?;
        Ok(shares)
    })?
}

/// The lens as a camera of Cycles: the text of an OSL script.
#[pyfunction]
pub(crate) fn osl_camera(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
) -> Result<String, Error> {
    let description = camera.0;
    Ok(without_gil(py, || description.osl_camera([width, height]))??)
}
