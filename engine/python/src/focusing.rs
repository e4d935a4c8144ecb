//! Focus found by the engine: the settings that put it there.

use crate::described::Described;
use crate::error::{Error, json};
use crate::gil::{catch_panic, without_gil};
use crate::scene::Scene;
use glam::{DVec3, Vec2};
use petzval_render::accel::Ray;
use petzval_render::camera::CameraDescription;
use petzval_render::camera::tools::autofocus::{on_picture_point, on_three_points};
use petzval_render::camera::tools::sharpness::sharpness;
use petzval_render::scene::visibility::Rays;
use pyo3::prelude::*;
use std::cell::RefCell;

/// Focuses on the hit of a picture point's rays.
#[pyfunction]
pub(crate) fn autofocus_json(
    py: Python<'_>,
    scene: &Scene,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
    point: (f32, f32),
) -> Result<String, Error> {
    let description = camera.0;
    let from_middle = Vec2::new(point.0, point.1) - 0.5;
    let stage = scene.stage.clone();
    let found = without_gil(py, || {
        // Rays of a camera count from its place.
        let beside = (description.position() - stage.scene.origin).as_vec3a();
        let nearest = |ray: &Ray| {
            let ray = Ray { origin: ray.origin + beside, ..*ray };
            stage.accel.closest(&ray, Rays::CAMERA).map(|hit| hit.t)
        };
        on_picture_point(&description, [width, height], from_middle, nearest)
    })??;
    json(&found)
}

/// Focuses on the hit of a picture point's rays, which the caller traces: `distance_to(origin, direction)` gets a world ray of unit
/// direction and returns the distance to its hit, or None. It runs with the GIL held: a panel calls it for one point.
#[pyfunction]
pub(crate) fn autofocus_by_json(
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
    point: (f32, f32),
    distance_to: &Bound<'_, PyAny>,
) -> Result<String, Error> {
    let description = camera.0;
    let from_middle = Vec2::new(point.0, point.1) - 0.5;
    // Rays of the engine count from the camera's place.
    let place = description.matrix_world.w_axis.truncate();
    let complaint = RefCell::new(None);
    let nearest = |ray: &Ray| -> Option<f32> {
        let origin = ray.origin.as_dvec3() + place;
        let answer = distance_to
            .call1((<(f64, f64, f64)>::from(origin), <(f64, f64, f64)>::from(ray.direction.as_dvec3())))
            .and_then(|distance| distance.extract());
        answer.unwrap_or_else(|error| {
            complaint.borrow_mut().get_or_insert(error);
            None
        })
    };
    let found = catch_panic(|| on_picture_point(&description, [width, height], from_middle, nearest))?;
    match complaint.into_inner() {
        Some(error) => Err(error.into()),
        None => json(&found?),
    }
}

/// Turns and places the film so that three points of the world are sharp.
#[pyfunction]
pub(crate) fn sharp_points_json(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
    points_world: [(f64, f64, f64); 3],
) -> Result<String, Error> {
    let description = camera.0;
    let points = points_world.map(|(x, y, z)| DVec3::new(x, y, z));
    let found = without_gil(py, || on_three_points(&description, [width, height], points))??;
    json(&found)
}

/// The sharp distances of a camera, over a grid of its picture.
#[pyfunction]
#[pyo3(signature = (camera, width, height, columns, rows, confusion_mm = None))]
pub(crate) fn sharpness_json(
    py: Python<'_>,
    camera: Described<CameraDescription>,
    width: u32,
    height: u32,
    columns: usize,
    rows: usize,
    confusion_mm: Option<f64>,
) -> Result<String, Error> {
    let description = camera.0;
    let found = without_gil(py, || sharpness(&description, [width, height], [columns, rows], confusion_mm))??;
    // What is infinite is null in JSON.
    json(&found)
}
