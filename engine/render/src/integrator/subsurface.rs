//! Light that goes into a body and comes out elsewhere: by a random walk (Chiang, Kutz and Burley 2016), or by a profile, at a place
//! that is found on a disk about the entry (King et al. 2013, "BSSRDF Importance Sampling").

mod walk;

use super::PreparedScene;
use crate::Rgb;
use crate::accel::{Ray, offset_origin};
use crate::sampler::{PathSampler, warp};
use crate::scene::visibility::Rays;
use crate::shading::subsurface::{Entry, Profile};
use crate::surface::SurfacePoint;
use arrayvec::ArrayVec;
use std::f32::consts::TAU;

/// Surfaces of other bodies that a stretch may pass.
const MOST_PASSED: u32 = 16;

/// Places that a ray through a disk may find: of more the nearest to its start count.
const MOST_HITS: usize = 8;

/// The place where light that entered at `point` leaves the body, seen from outside, and the part of the light that is left; `None` where
/// the light is absorbed within.
pub(super) fn leave(
    stage: &PreparedScene,
    point: &SurfacePoint,
    entry: &Entry,
    sampler: &mut PathSampler,
    rays: &mut u32,
) -> Option<(SurfacePoint, Rgb)> {
    match entry {
        Entry::Walk { direction, light, medium } => {
            walk::walk(stage, point, (*direction, *light, *medium), sampler, rays)
        }
        Entry::Beside { light, profile, u } => {
            let (exit, left) = beside(stage, point, profile, *u, sampler.next_4d()[0], rays)?;
            Some((exit, *light * left))
        }
    }
}

/// A place beside `point` by a profile, and the part of the light that comes out there. Rays through a disk about the point, along its
/// normal or at right angles to it, find the places; all three count by the power heuristic, as in Cycles (`subsurface_disk.h`).
fn beside(
    stage: &PreparedScene,
    point: &SurfacePoint,
    profile: &Profile,
    [u_distance, u_turn]: [f32; 2],
    u_hit: f32,
    rays: &mut u32,
) -> Option<(SurfacePoint, Rgb)> {
    let [x, y, z] = warp::frame(point.geometric_normal);
    // Along the disk's axis, then the plane of the disk; the chance of each axis; and a number for the turn.
    let (axes, chances, turn) = if u_turn < 0.5 {
        ([z, x, y], [0.5, 0.25, 0.25], 2.0 * u_turn)
    } else if u_turn < 0.75 {
        ([x, z, y], [0.25, 0.5, 0.25], 4.0 * u_turn - 2.0)
    } else {
        ([y, x, z], [0.25, 0.25, 0.5], 4.0 * u_turn - 3.0)
    };
    let (distance, farthest) = profile.sample(u_distance);
    let height = (farthest * farthest - distance * distance).max(0.0).sqrt();
    let (s, c) = (TAU * turn).sin_cos();
    let start = point.position + axes[0] * height + (axes[1] * c + axes[2] * s) * distance;
    let mut ray = Ray { t_max: 2.0 * height, ..Ray::new(start, -axes[0]).at(point.moment) };
    let density = profile.pdf(distance);
    let mut found = ArrayVec::<(SurfacePoint, Rgb), MOST_HITS>::new();
    let mut sum = 0.0;
    while !found.is_full() {
        let Some((hit, t)) = own_surface(stage, point.instance, ray, rays) else { break };
        // Its outside is where the entry's was.
        let outwards = if hit.backfacing == point.backfacing { hit.geometric_normal } else { -hit.geometric_normal };
        let [a, b, c] = [0, 1, 2].map(|i| chances[i] * axes[i].dot(outwards).abs());
        let share = a / (a * a + b * b + c * c).max(f32::MIN_POSITIVE);
        let light = profile.at((hit.position - point.position).length()) * (share / density);
        let origin = offset_origin(hit.position, ray.direction, hit.position_error);
        ray = Ray { t_max: ray.t_max - t, ..hit.leaving(origin, ray.direction) };
        if light.is_finite() && light != Rgb::ZERO {
            sum += light.element_sum();
            found.push((hit.seen_from(outwards), light));
        }
    }
    let mut left = u_hit * sum;
    let chosen = found.iter().position(|(_, light)| {
        left -= light.element_sum();
        left < 0.0
    });
    let (exit, light) = found.get(chosen.unwrap_or(found.len().checked_sub(1)?))?;
    Some((*exit, *light * (sum / light.element_sum())))
}

/// A ray's first hit on the body itself, whatever else stands in it, and its distance.
fn own_surface(stage: &PreparedScene, instance: u32, ray: Ray, rays: &mut u32) -> Option<(SurfacePoint, f32)> {
    let (mut ray, mut passed) = (ray, 0.0);
    for _ in 0..MOST_PASSED {
        *rays += 1;
        let hit = stage.accel.closest(&ray, Rays::BOUNCE)?;
        let point = SurfacePoint::new(&stage.scene, &hit, ray.direction);
        if hit.instance == instance {
            return Some((point, passed + hit.t));
        }
        passed += hit.t;
        let origin = offset_origin(point.position, -point.geometric_normal, point.position_error);
        ray = Ray { t_max: ray.t_max - hit.t, ..point.leaving(origin, ray.direction) };
    }
    None
}
