//! Factors of the brightness of each pixel of a camera: vignetting taken out of a picture, or put into the picture of a camera that makes
//! its rays otherwise than the lens.
//!
//! Both brightnesses are measured by the weights of rays, for a uniform world. So brightness is right, whatever makes the rays; only the
//! noise stays as it was.

use crate::camera::description::{CameraDescription, EnabledEffects};
use crate::camera::lens::real_lens::packet::Request;
use crate::camera::{Camera, CameraError, Model};
use crate::luminance;
use crate::sampler::evenly::Evenly;
use glam::Vec2;
use rayon::prelude::*;

/// Places that are measured, across and up: light falls off smoothly.
const GRID: [usize; 2] = [33, 25];
/// Rays for each, an error of some 0.2 %.
const RAYS: u32 = 1024;

/// The factor of each pixel's light, rows from below; `None` where everything stays as it is. `camera` is the one that the description
/// makes.
///
/// # Errors
/// As [`Camera::new`].
pub fn gains(d: &CameraDescription, camera: &Camera, width: u32, height: u32) -> Result<Option<Vec<f32>>, CameraError> {
    // A calibrated camera leaves its own vignetting out.
    let has_own = d.model == Model::Calibrated;
    if has_own || (d.shown.vignetting && d.shown.is_traced_plainly()) {
        return Ok(None);
    }
    let whole = Camera::new(&CameraDescription { shown: EnabledEffects::default(), ..d.clone() }, width, height)?;
    let middle = brightness(&whole, Vec2::ZERO);
    let gain = |i: usize| {
        let place =
            Vec2::new((i % GRID[0]) as f32 / (GRID[0] - 1) as f32, (i / GRID[0]) as f32 / (GRID[1] - 1) as f32) - 0.5;
        let is = brightness(camera, place);
        let wanted = if d.shown.vignetting { brightness(&whole, place) } else { middle };
        // What gets no light at all stays black.
        if is > 0.0 { (wanted / is) as f32 } else { 0.0 }
    };
    let nodes: Vec<f32> = (0..GRID[0] * GRID[1]).into_par_iter().map(gain).collect();
    let pixel = |x: u32, y: u32| {
        let along = |i: u32, count: u32, nodes: usize| {
            let at = (i as f32 + 0.5) / count as f32 * (nodes - 1) as f32;
            let cell = (at as usize).min(nodes - 2);
            (cell, at - cell as f32)
        };
        let ((column, u), (row, v)) = (along(x, width, GRID[0]), along(y, height, GRID[1]));
        let node = |row: usize, column: usize| nodes[row * GRID[0] + column];
        let across = |row: usize| node(row, column) + (node(row, column + 1) - node(row, column)) * u;
        across(row) + (across(row + 1) - across(row)) * v
    };
    Ok(Some((0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()))
}

/// The brightness of a place in a uniform world of radiance one.
fn brightness(camera: &Camera, place: Vec2) -> f64 {
    let points = Evenly::<3>::default();
    let request = |i: u32| {
        let [u, v, u_wavelength] = points.point(i).map(|u| u as f32);
        Request { place, u_lens: [u, v], u_wavelength, ..Request::default() }
    };
    let requests: Vec<Request> = (0..RAYS).map(request).collect();
    let mut rays = Vec::with_capacity(requests.len());
    camera.sample_batch(&requests, camera.batch().as_mut(), &mut rays);
    rays.iter().flatten().map(|ray| f64::from(luminance(ray.white()))).sum::<f64>() / f64::from(RAYS)
}
