//! Light that goes into a body and comes out elsewhere: by a random walk (Chiang, Kutz and Burley 2016), or by a profile, at a place
//! that is found on a disk about the entry (King et al. 2013, "BSSRDF Importance Sampling").

use super::Stage;
use crate::Rgb;
use crate::accel::{Ray, offset_origin};
use crate::sampler::warp;
use crate::scene::visibility::Rays;
use crate::shading::subsurface::{Entry, Medium, Profile};
use crate::surface::SurfacePoint;
use arrayvec::ArrayVec;
use glam::Vec3A;
use std::f32::consts::TAU;

/// Scatterings after which a walk is given up.
const MOST_STEPS: u32 = 256;
/// Scatterings after which their direction no longer matters.
const EVEN_AFTER: u32 = 10;
/// Surfaces of other bodies that a stretch may pass.
const MOST_PASSED: u32 = 16;

/// Places that a ray through a disk may find: of more the nearest to its start count.
const MOST_HITS: usize = 8;

/// Random numbers for a walk, which needs many: one path's numbers give the seed.
pub(super) struct Numbers(u64);

impl Numbers {
    pub(super) fn new(u: [f32; 3]) -> Self {
        let bits = |i: usize| u64::from(u[i].to_bits());
        Self(bits(0) ^ (bits(1) << 21) ^ (bits(2) << 42) ^ 0x9e37_79b9_7f4a_7c15)
    }

    pub(super) fn seeded(seed: u64) -> Self {
        Self(seed ^ 0x9e37_79b9_7f4a_7c15)
    }

    /// Uniform, 0 to 1 (Steele, Lea and Flood 2014, splitmix).
    pub(super) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// Where light that entered at `point` leaves the body, seen from outside, and what is left of it; `None` where it ends within.
pub(super) fn leave(
    stage: &Stage,
    point: &SurfacePoint,
    entry: &Entry,
    numbers: &mut Numbers,
    rays: &mut u32,
) -> Option<(SurfacePoint, Rgb)> {
    match entry {
        Entry::Walk { direction, light, medium } => walk(stage, point, (*direction, *light, *medium), numbers, rays),
        Entry::Beside { light, profile, u } => {
            let (exit, left) = beside(stage, point, profile, *u, numbers.next(), rays)?;
            Some((exit, *light * left))
        }
    }
}

/// A place beside `point` by a profile, and what of the light comes out there. Rays through a disk about the point, along its normal or
/// at right angles to it, find the places; all three count by the power heuristic, as in Cycles (`subsurface_disk.h`).
fn beside(
    stage: &Stage,
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

/// Where a walk that begins at `point` leaves the body, seen from outside, and what is left of its light; `None` where
/// it ends within.
fn walk(
    stage: &Stage,
    point: &SurfacePoint,
    (direction, mut light, mut medium): (Vec3A, Rgb, Medium),
    numbers: &mut Numbers,
    rays: &mut u32,
) -> Option<(SurfacePoint, Rgb)> {
    let inwards = -point.geometric_normal;
    let start = offset_origin(point.position, inwards, point.position_error);
    let mut ray = Ray::new(start, direction).at(point.moment);
    for step in 0..MOST_STEPS {
        if step == EVEN_AFTER {
            medium = medium.even();
        }
        // A channel, by what it may still bring.
        let chances = light * medium.albedo;
        let total = chances.element_sum();
        if total <= 0.0 || !total.is_finite() {
            return None;
        }
        let chances = chances / total;
        let u = numbers.next();
        let channel = usize::from(u >= chances.x) + usize::from(u >= chances.x + chances.y);
        let distance = -(1.0 - numbers.next()).ln() / medium.extinction[channel.min(2)];
        ray.t_max = distance;
        let met = own_surface(stage, point.instance, ray, rays);
        let length = met.as_ref().map_or(distance, |(_, t)| *t);
        let left = Rgb::from((medium.extinction * -length).to_array().map(f32::exp));
        if let Some((exit, _)) = met {
            light *= left / chances.dot(left);
            return light.is_finite().then(|| (exit.seen_from(ray.direction), light));
        }
        let density = chances.dot(medium.extinction * left);
        light *= medium.extinction * medium.albedo * left / density;
        // What is faint ends by chance.
        let go_on = light.max_element().min(1.0);
        if step > 3 && numbers.next() >= go_on {
            return None;
        }
        if step > 3 {
            light /= go_on;
        }
        let direction = scatter(ray.direction, medium.anisotropy, [numbers.next(), numbers.next()]);
        ray = Ray::new(ray.origin + ray.direction * distance, direction).at(point.moment);
    }
    None
}

/// Where a ray meets the body itself, whatever else stands in it, and how far that is.
fn own_surface(stage: &Stage, instance: u32, ray: Ray, rays: &mut u32) -> Option<(SurfacePoint, f32)> {
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

/// Henyey and Greenstein's phase function.
fn scatter(direction: Vec3A, g: f32, u: [f32; 2]) -> Vec3A {
    let cos = if g.abs() < 1e-3 {
        1.0 - 2.0 * u[0]
    } else {
        let k = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[0]);
        ((1.0 + g * g - k * k) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (TAU * u[1]).sin_cos();
    warp::to_world(&warp::frame(direction), Vec3A::new(sin * c, sin * s, cos)).normalize()
}
