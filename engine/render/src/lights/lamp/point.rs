//! Point lamps: spheres that emit to all sides.

use super::super::bounds::LightBounds;
use super::super::sample::LightSample;
use super::ball::Ball;
use super::shape::{LampExtent, LampFrame, LampRay, LampShape, LampView};
use crate::{Rgb, sampler::warp};
use glam::{Vec2, Vec3A};
use std::f32::consts::{PI, TAU};

/// A point lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointLamp(pub(super) Ball);

impl LampShape for PointLamp {
    fn strength(&self, color: Rgb) -> Rgb {
        self.0.strength(color)
    }

    fn is_point_like(&self) -> bool {
        self.0.is_point_like()
    }

    fn extent(&self) -> Option<LampExtent> {
        self.0.extent()
    }

    fn normal(&self, frame: &LampFrame, place: Vec3A, wi: Vec3A) -> Vec3A {
        self.0.normal(frame, place, wi)
    }

    fn uv(&self, frame: &LampFrame, seen: &LampView) -> Vec2 {
        let n = frame.local(seen.normal);
        let turn = if n.x == 0.0 && n.y == 0.0 { 0.0 } else { 0.5 - n.x.atan2(n.y) / TAU };
        Vec2::new(turn, 1.0 - n.z.clamp(-1.0, 1.0).acos() / PI)
    }

    fn bounds(&self, frame: &LampFrame, power: f32) -> LightBounds {
        // Pi times the intensity in the brightest direction, which for a surface that emits is its power.
        frame.bounds(0.25 * power, self.0.radius)
    }

    fn sample(&self, frame: &LampFrame, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        self.0.sample(frame, from, u)
    }

    fn hit(&self, frame: &LampFrame, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        self.0.hit(frame, origin, d, t_max)
    }

    fn emit(&self, frame: &LampFrame, u_place: [f32; 2], u_direction: [f32; 2], _scene: (Vec3A, f32)) -> LampRay {
        self.0.emit(frame, warp::sample_sphere(u_direction), u_place, frame.strength)
    }

    fn emission_density(&self, distance: f32, _scene_radius: f32) -> f32 {
        self.0.emission_density(distance, warp::SPHERE_PDF)
    }

    fn arrival_pdf(&self, frame: &LampFrame, at: Vec3A, direction: Vec3A, _distance: f32) -> Option<f32> {
        self.0.arrival_pdf(frame, at, direction)
    }
}
