//! Motion vectors of a ray's hit over the picture: to its place a frame before, and from its place a frame after.
//!
//! The point that a camera ray hit is taken along with the surface to the neighbouring frame, and looked at from there
//! through the same point of the pupil, by the same light. So out of focus each ray tells the way of its own picture, and
//! their mean is the way of the blurred one. The background lies infinitely far: only turns of the camera move it.

use crate::accel::Ray;
use crate::camera::tools::imaging::{Imaging, SeenPlace};
use crate::integrator::path::FirstSurface;
use crate::scene::curves::Curves;
use crate::scene::points::Points;
use crate::scene::{Instance, Scene};
use glam::{DVec2, DVec3};

/// Number of times, at most, that the way is halved if the light from a neighbouring frame is lost in the lens.
const HALVINGS: i32 = 6;

/// The camera at a frame and its neighbours.
pub struct Motion {
    now: Imaging,
    /// A frame before, a frame after.
    neighbours: [Imaging; 2],
    size_px: DVec2,
}

impl Motion {
    /// The motion in a picture of that many pixels.
    pub fn new(now: Imaging, neighbours: [Imaging; 2], width: u32, height: u32) -> Self {
        Self { now, neighbours, size_px: DVec2::new(f64::from(width), f64::from(height)) }
    }

    /// The vector of Blender's Vector pass for a camera ray that hit `first`: pixels right and up from here to its place a frame before,
    /// and from its place a frame after to here. `None` where the lens loses the ray.
    pub fn vector(
        &self,
        scene: &Scene,
        ray: &Ray,
        u_wavelength: f32,
        first: Option<&FirstSurface>,
    ) -> Option<[f32; 4]> {
        let now = match first {
            Some(surface) => SeenPlace::Point(surface.position.as_dvec3()),
            None => SeenPlace::Direction(ray.direction.as_dvec3()),
        };
        let through = self.now.through(ray, now);
        let here = self.now.picture_point(now, through, u_wavelength)?;
        let way = |frame: usize| {
            let then = first.and_then(|surface| moved(scene, surface, frame)).map_or(now, SeenPlace::Point);
            let camera = &self.neighbours[frame];
            let place = |seen| camera.picture_point(seen, through, u_wavelength);
            let there = place(then).or_else(|| {
                // It leaves what the lens sees: the same way as it starts.
                let start = place(now)?;
                let part = |k: i32| 0.5f64.powi(k);
                (1..=HALVINGS).find_map(|k| Some(start + (place(now.towards(then, part(k)))? - start) / part(k)))
            })?;
            Some((there - here) * self.size_px)
        };
        let (before, after) = (way(0)?, -way(1)?);
        let vector = [before.x, before.y, after.x, after.y].map(|v| v as f32);
        vector.iter().all(|v| v.is_finite()).then_some(vector)
    }
}

/// The position of a point of a surface at a neighbouring frame, render space; `None` where it stands still.
fn moved(scene: &Scene, surface: &FirstSurface, frame: usize) -> Option<DVec3> {
    let instance = &scene.instances[surface.instance as usize];
    let mesh = &scene.meshes[instance.mesh as usize];
    if let Some(curves) = &mesh.curves {
        return moved_strand(instance, curves, surface, frame);
    }
    if let Some(points) = &mesh.points {
        return moved_ball(instance, points, surface, frame);
    }
    let positions = match &mesh.moved_positions {
        Some(moved) => &moved[frame],
        None if instance.moved.is_none() => return None,
        None => &mesh.positions,
    };
    let [u, v] = surface.barycentric.map(f64::from);
    let [a, b, c] = mesh.triangles[surface.triangle as usize].map(|i| positions[i as usize].as_dvec3());
    Some(placed(instance, frame, a * (1.0 - u - v) + b * u + c * v))
}

/// The position of a point on hair at a neighbouring frame, render space; `None` where it stands still. The point goes with the line
/// between the keys beside it, as in Cycles.
fn moved_strand(instance: &Instance, curves: &Curves, surface: &FirstSurface, frame: usize) -> Option<DVec3> {
    if curves.moved_keys.is_none() && instance.moved.is_none() {
        return None;
    }
    let (key, u) = (surface.triangle as usize, f64::from(surface.barycentric[0].clamp(0.0, 1.0)));
    let now = |key: usize| curves.keys[key].truncate().as_dvec3();
    let then = |key: usize| curves.moved_keys.as_ref().map_or_else(|| now(key), |moved| moved[frame][key].as_dvec3());
    let before = instance.to_render.transform_point3(now(key).lerp(now(key + 1), u).as_vec3()).as_dvec3();
    let after = placed(instance, frame, then(key).lerp(then(key + 1), u));
    Some(surface.position.as_dvec3() + after - before)
}

/// The position of a place on a point at a neighbouring frame, render space; `None` where it stands still. The place goes with the middle
/// of the point, as in Cycles.
fn moved_ball(instance: &Instance, points: &Points, surface: &FirstSurface, frame: usize) -> Option<DVec3> {
    if points.moved_points.is_none() && instance.moved.is_none() {
        return None;
    }
    let number = surface.triangle as usize;
    let now = points.points[number].truncate();
    let then = points.moved_points.as_ref().map_or(now, |moved| moved[frame][number]);
    let before = instance.to_render.transform_point3(now).as_dvec3();
    Some(surface.position.as_dvec3() + placed(instance, frame, then.as_dvec3()) - before)
}

fn placed(instance: &Instance, frame: usize, local: DVec3) -> DVec3 {
    match &instance.moved {
        Some(matrices) => matrices[frame].transform_point3(local),
        None => instance.to_render.transform_point3(local.as_vec3()).as_dvec3(),
    }
}
