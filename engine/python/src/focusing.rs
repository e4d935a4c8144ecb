//! Focus found by the engine: the settings that put it there.

use crate::camera::PyCamera;
use crate::doorway::away;
use crate::error::Error;
use crate::scene::Scene;
use glam::{DVec3, Vec2};
use petzval_render::accel::RayKind;
use petzval_render::camera::CameraDescription;
use petzval_render::camera::autofocus::{Focused, on_picture_point, on_three_points};
use pyo3::prelude::*;
use serde_json::json;

/// Focuses on what a picture point sees.
#[pyfunction]
pub(crate) fn autofocus_json(
    py: Python<'_>,
    scene: &Scene,
    camera: PyCamera,
    width: u32,
    height: u32,
    point: (f32, f32),
) -> Result<String, Error> {
    let description: CameraDescription = camera.try_into()?;
    let from_middle = Vec2::new(point.0, point.1) - 0.5;
    let stage = scene.stage.clone();
    let found = away(py, || {
        let nearest = |ray: &_| stage.accel.closest(ray, RayKind::Camera).map(|hit| hit.t);
        on_picture_point(&description, [width, height], from_middle, nearest)
    })??;
    Ok(text(&found))
}

/// Turns and places the film so that three points of the world are sharp.
#[pyfunction]
pub(crate) fn sharp_points_json(
    py: Python<'_>,
    camera: PyCamera,
    width: u32,
    height: u32,
    points_world: [(f64, f64, f64); 3],
) -> Result<String, Error> {
    let description: CameraDescription = camera.try_into()?;
    let points = points_world.map(|(x, y, z)| DVec3::new(x, y, z));
    let found = away(py, || on_three_points(&description, [width, height], points))??;
    Ok(text(&found))
}

fn text(found: &Focused) -> String {
    json!({
        "film_distance_mm": found.film_distance_mm,
        "focus_scale_mm": found.focus_scale_mm,
        "tilt_rad": found.tilt_rad,
        "swing_rad": found.swing_rad,
        "moves_groups": found.moves_groups,
        "rms_spot_mm": found.rms_spot_mm,
        "subject_world": found.subject_world.map(|p| p.to_array()),
    })
    .to_string()
}
