//! Light that goes into a body and comes out elsewhere, by a random walk (Chiang, Kutz and Burley 2016).

use super::Stage;
use crate::Rgb;
use crate::accel::{Ray, offset_origin};
use crate::sampler::warp;
use crate::scene::visibility::Rays;
use crate::shading::subsurface::Entry;
use crate::surface::SurfacePoint;
use glam::Vec3A;
use std::f32::consts::TAU;

/// Scatterings after which a walk is given up.
const MOST_STEPS: u32 = 256;
/// Scatterings after which their direction no longer matters.
const EVEN_AFTER: u32 = 10;
/// Surfaces of other bodies that a stretch may pass.
const MOST_PASSED: u32 = 16;

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

/// Where a walk that begins at `point` leaves the body, seen from outside, and what is left of its light; `None` where
/// it ends within.
pub(super) fn walk(
    stage: &Stage,
    point: &SurfacePoint,
    entry: &Entry,
    numbers: &mut Numbers,
    rays: &mut u32,
) -> Option<(SurfacePoint, Rgb)> {
    let inwards = -point.geometric_normal;
    let start = offset_origin(point.position, inwards, point.position_error);
    let mut ray = Ray::new(start, entry.direction).at(point.moment);
    let mut medium = entry.medium;
    let mut light = entry.light;
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
