//! Data of a camera for the panel and the viewport.

use crate::described::Described;
use crate::error::{Error, json};
use crate::gil::without_gil;
use glam::DMat4;
use petzval_render::camera::{self, CameraDescription};
use pyo3::prelude::*;

/// A 4 x 4 matrix as Blender gives it, row by row.
#[derive(FromPyObject)]
#[pyo3(transparent)]
pub(crate) struct Matrix4([[f64; 4]; 4]);

impl From<Matrix4> for DMat4 {
    fn from(m: Matrix4) -> Self {
        DMat4::from_cols_array_2d(&m.0).transpose()
    }
}

/// The part of the picture that the lens lights.
#[pyfunction]
pub(crate) fn coverage_json(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
) -> Result<String, Error> {
    json(&without_gil(py, || camera.0.coverage([width, height]))??)
}

/// Width and height of the film for which the lens is made.
#[pyfunction]
pub(crate) fn film_of_lens_mm(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
) -> Result<[f64; 2], Error> {
    Ok(without_gil(py, || camera.0.film_of_lens_mm([width, height]))??)
}

/// Data of the camera for the panel and the viewport.
#[pyfunction]
pub(crate) fn camera_info_json(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
) -> Result<String, Error> {
    json(&without_gil(py, || camera::lens_info(&camera.0, width, height))??)
}
