//! Motion of the scene over the picture while the shutter is open.

use super::Unit;
use super::words::size;
use crate::accel::Ray;
use crate::camera::shutter::Exposure;
use crate::scene::Scene;
use crate::scene::motion::Moving;
use glam::DVec3;

/// Moments at which the place of the camera is looked up.
const LOOKS: u32 = 16;

/// The motion before the lens or of the camera.
pub(super) struct SceneMotion {
    /// The farthest way, px.
    pub(super) px: f64,
    /// The text of that length, and of the object that moves so.
    pub(super) text: String,
}

/// The farthest motion over the picture: of moving objects, seen or not, since their shadows or mirror images may be; and, where the camera
/// moves, of the hits `seen` of its `rays`. `None` where everything stands still.
pub(super) fn scene_motion(
    scene: &Scene,
    exposure: Option<&Exposure>,
    rays: &[Option<Ray>],
    seen: &[Option<DVec3>],
) -> Option<SceneMotion> {
    let of_object = |one: &Moving| {
        let name = &scene.instances[one.instance as usize].object_name;
        (scene.pixels_moved(one), format!("object '{name}'"))
    };
    let objects = scene.moving.iter().map(of_object);
    let camera = exposure.filter(|exposure| exposure.has_way()).map(|exposure| {
        let pixel = f64::from(scene.viewport.pixel_angle_rad()).max(1e-9);
        let ways = rays.iter().zip(seen).filter_map(|(ray, seen)| Some(way(exposure, ray.as_ref()?, *seen)));
        (ways.fold(0.0, f64::max) / pixel, "the camera".to_owned())
    });
    let (px, what) = objects.chain(camera).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(SceneMotion { px, text: format!("{}, {what}", size(px, Unit::Pixels)) })
}

/// The angle that the hit of a ray moves through as the camera sees it, rad: the sum of its steps.
fn way(exposure: &Exposure, ray: &Ray, seen: Option<DVec3>) -> f64 {
    let origin = ray.origin.as_dvec3();
    // What is not hit lies as good as infinitely far.
    const FAR: f64 = 1e6;
    let point = seen.unwrap_or_else(|| origin + FAR * ray.direction.as_dvec3());
    let moments = (0..=LOOKS).map(|look| (look * 65_535 / LOOKS) as u16);
    let directions: Vec<DVec3> = moments.map(|moment| exposure.seen(point, moment) - origin).collect();
    directions.windows(2).map(|pair| pair[0].angle_between(pair[1])).filter(|angle| angle.is_finite()).sum()
}
