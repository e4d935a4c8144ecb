//! Sun lamps: disks infinitely far along the lamp's +z.

use super::super::bounds::LightBounds;
use super::super::sample::LightSample;
use super::shape::{LampFrame, LampRay, LampShape, LampView, on_disk, one_minus_cos};
use crate::{Rgb, sampler::warp};
use glam::{Vec2, Vec3A};
use std::f32::consts::{FRAC_PI_2, PI};

/// A sun lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct SunLamp {
    /// Half of the angular diameter.
    pub(super) half_angle_rad: f32,
}

impl SunLamp {
    /// Light of the sun, which is equal everywhere.
    fn light(&self, frame: &LampFrame, u: [f32; 2]) -> LightSample {
        let axis = frame.axes.z_axis;
        if self.half_angle_rad <= 0.0 {
            return LightSample { point_like: true, ..frame.light(axis, f32::INFINITY, frame.strength, 1.0) };
        }
        let limit = one_minus_cos(self.half_angle_rad);
        let wi = warp::to_world(&warp::frame(axis), warp::sample_cone(u, limit)).normalize();
        frame.light(wi, f32::INFINITY, frame.strength, warp::cone_pdf(limit))
    }

    /// The density of its directions per steradian; 1 where there is but one.
    fn per_sr(&self) -> f32 {
        if self.half_angle_rad > 0.0 { warp::cone_pdf(one_minus_cos(self.half_angle_rad)) } else { 1.0 }
    }
}

impl LampShape for SunLamp {
    fn strength(&self, color: Rgb) -> Rgb {
        // Its irradiance on a surface that faces it: radiance times the projected solid angle.
        let sin = self.half_angle_rad.min(FRAC_PI_2).sin();
        if sin > 0.0 { color / (PI * sin * sin) } else { color }
    }

    fn is_point_like(&self) -> bool {
        self.half_angle_rad <= 0.0
    }

    fn half_angle_at_infinity(&self) -> Option<f32> {
        Some(self.half_angle_rad)
    }

    fn uv(&self, frame: &LampFrame, seen: &LampView) -> Vec2 {
        let d = frame.local(seen.wi);
        let scale = 0.5 / self.half_angle_rad.sin().max(1e-6);
        Vec2::new(0.5 + d.x * scale, 0.5 + d.y * scale)
    }

    fn bounds(&self, frame: &LampFrame, power: f32) -> LightBounds {
        frame.bounds(power, 0.0)
    }

    fn sample(&self, frame: &LampFrame, _from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        Some(self.light(frame, u))
    }

    fn hit_at_infinity(&self, frame: &LampFrame, d: Vec3A) -> Option<(Rgb, f32)> {
        if self.half_angle_rad <= 0.0 {
            return None;
        }
        let limit = one_minus_cos(self.half_angle_rad);
        // 1 - cos from the difference of unit vectors keeps its digits for small angles.
        let off = 0.5 * (d - frame.axes.z_axis).length_squared();
        (off <= limit).then(|| (frame.strength, warp::cone_pdf(limit)))
    }

    fn emit(
        &self,
        frame: &LampFrame,
        u_place: [f32; 2],
        u_direction: [f32; 2],
        (center, scene_radius): (Vec3A, f32),
    ) -> LampRay {
        let towards = self.light(frame, u_direction).wi;
        let origin = center + on_disk(towards, scene_radius, u_place) + towards * scene_radius;
        LampRay { origin, direction: -towards, strength: frame.strength }
    }

    fn emission_density(&self, _distance: f32, scene_radius: f32) -> f32 {
        self.per_sr() / (PI * scene_radius * scene_radius)
    }

    fn arrival_pdf(&self, _frame: &LampFrame, _at: Vec3A, _direction: Vec3A, _distance: f32) -> Option<f32> {
        Some(self.per_sr())
    }
}
