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
