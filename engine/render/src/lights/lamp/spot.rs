//! Spot lamps: spheres that emit into a cone about the lamp's -z.

use super::super::bounds::LightBounds;
use super::super::sample::LightSample;
use super::ball::Ball;
use super::shape::{LampExtent, LampFrame, LampRay, LampShape, LampView, one_minus_cos};
use crate::{Rgb, sampler::warp};
use glam::{Vec2, Vec3A};
use std::f32::consts::PI;

/// A spot lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpotLamp {
    pub(super) ball: Ball,
    /// Half of the cone's angle.
    pub(super) half_angle_rad: f32,
    /// The softness of the cone's edge, 0 hard to 1 soft.
    pub(super) blend: f32,
}

impl SpotLamp {
    /// The part of the light along `d`, which leads away from the lamp.
    fn cone(&self, frame: &LampFrame, d: Vec3A) -> f32 {
        let cos = -d.dot(frame.axes.z_axis);
        let limit = self.half_angle_rad.cos();
        let x = ((cos - limit) / ((1.0 - limit) * self.blend).max(1e-4)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// The part of the light that is seen from a place along `d`. Within the sphere the cone counts nothing; away from the middle half is
    /// seen: there Cycles has light samples alone, whose weight is one half where the lamp is alone.
    fn part(&self, frame: &LampFrame, from: Vec3A, d: Vec3A) -> f32 {
        match self.ball.holds(frame, from) {
            false => self.cone(frame, -d),
            true if d.dot(frame.center - from) > 0.0 => 1.0,
            true => 0.5,
        }
    }

    /// 1 - cos of the cone.
    fn limit(&self) -> f32 {
        one_minus_cos(self.half_angle_rad.min(PI))
    }
}

impl LampShape for SpotLamp {
    fn strength(&self, color: Rgb) -> Rgb {
        self.ball.strength(color)
    }

    fn is_point_like(&self) -> bool {
        self.ball.is_point_like()
    }

    fn extent(&self) -> Option<LampExtent> {
        self.ball.extent()
    }

    fn normal(&self, frame: &LampFrame, place: Vec3A, wi: Vec3A) -> Vec3A {
        self.ball.normal(frame, place, wi)
    }

    fn uv(&self, frame: &LampFrame, seen: &LampView) -> Vec2 {
        let d = frame.local(-seen.wi);
        let scale = 0.5 / (self.half_angle_rad.tan() * d.z.abs());
        Vec2::new(0.5 + d.x * scale, 0.5 + d.y * scale)
    }

    fn bounds(&self, frame: &LampFrame, power: f32) -> LightBounds {
        // As that of a point lamp.
        LightBounds {
            normal_spread_rad: 0.0,
            emission_spread_rad: self.half_angle_rad.min(PI),
            ..frame.bounds(0.25 * power, self.ball.radius)
        }
    }

    fn sample(&self, frame: &LampFrame, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        let mut s = self.ball.sample(frame, from, u)?;
        s.radiance *= self.part(frame, from, s.wi);
        Some(s)
    }

    fn hit(&self, frame: &LampFrame, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        let (radiance, pdf, t) = self.ball.hit(frame, origin, d, t_max)?;
        Some((radiance * self.part(frame, origin, d), pdf, t))
    }

    fn emit(&self, frame: &LampFrame, u_place: [f32; 2], u_direction: [f32; 2], _scene: (Vec3A, f32)) -> LampRay {
        let local = warp::sample_cone(u_direction, self.limit());
        let direction = warp::to_world(&warp::frame(-frame.axes.z_axis), local).normalize();
        self.ball.emit(frame, direction, u_place, frame.strength * self.cone(frame, direction))
    }

    fn emission_density(&self, distance: f32, _scene_radius: f32) -> f32 {
        self.ball.emission_density(distance, warp::cone_pdf(self.limit()))
    }

    fn arrival_pdf(&self, frame: &LampFrame, at: Vec3A, direction: Vec3A, _distance: f32) -> Option<f32> {
        self.ball.arrival_pdf(frame, at, direction)
    }
}
