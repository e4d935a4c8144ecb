//! Area lamps: rectangles and ellipses in the lamp's xy plane that emit along -z.

use super::super::bounds::LightBounds;
use super::super::sample::{Leaving, LightSample};
use super::rectangle::SphericalRectangle;
use super::shape::{LampExtent, LampFrame, LampRay, LampShape, LampView};
use crate::{Rgb, sampler::warp};
use glam::{Vec2, Vec3A};
use std::f32::consts::{FRAC_PI_2, PI};

/// An area lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct AreaLamp {
    /// Full sides, Blender units.
    pub(super) size: [f32; 2],
    /// True for an ellipse with these diameters, false for a rectangle.
    pub(super) ellipse: bool,
    /// Half of the angle that it emits into; pi/2 is a plain Lambert emitter.
    pub(super) half_spread_rad: f32,
}

impl AreaLamp {
    /// Area, Blender units squared.
    fn area(&self) -> f32 {
        self.size[0] * self.size[1] * if self.ellipse { PI / 4.0 } else { 1.0 }
    }

    /// A point of the lamp, even by area.
    fn point(&self, frame: &LampFrame, u: [f32; 2]) -> Vec3A {
        let p = if self.ellipse { warp::sample_disk(u) * 0.5 } else { Vec2::new(u[0] - 0.5, u[1] - 0.5) };
        frame.center + frame.axes.x_axis * (p.x * self.size[0]) + frame.axes.y_axis * (p.y * self.size[1])
    }

    /// The lamp as it is seen from a place, where points are chosen by that; else they are even by area.
    fn seen(&self, frame: &LampFrame, from: Vec3A) -> Option<SphericalRectangle> {
        if self.ellipse {
            return None;
        }
        SphericalRectangle::new(frame.local(frame.center - from), self.size)
    }

    /// The density per steradian with which [`LampShape::sample`] at a place chooses a direction at `cos` to the normal, in which the lamp is
    /// `distance` away.
    fn pdf(&self, seen: Option<&SphericalRectangle>, cos: f32, distance: f32) -> f32 {
        seen.map_or_else(|| distance * distance / (cos * self.area()), |seen| 1.0 / seen.solid_angle)
    }

    /// The factor of the spread on light that leaves the lamp at `cos` to its normal, brighter on axis for less spread.
    fn spread(&self, cos: f32) -> f32 {
        let half_spread_rad = self.half_spread_rad;
        if half_spread_rad >= FRAC_PI_2 - 1e-4 {
            return 1.0;
        }
        let tan_limit = half_spread_rad.tan();
        let tan = (1.0 - cos * cos).max(0.0).sqrt() / cos;
        let normalise = tan_limit - half_spread_rad;
        if normalise <= 1e-9 { 0.0 } else { ((tan_limit - tan) / normalise).max(0.0) }
    }
}

impl LampShape for AreaLamp {
    fn strength(&self, color: Rgb) -> Rgb {
        // A Lambert emitter sends pi times its radiance from each unit of area.
        let area = self.area();
        if area > 0.0 { color / (PI * area) } else { Rgb::ZERO }
    }

    fn size(&self) -> f32 {
        self.size[0].max(self.size[1])
    }

    fn is_point_like(&self) -> bool {
        false
    }

    fn extent(&self) -> Option<LampExtent> {
        let area = self.area();
        (area > 0.0).then_some(LampExtent::Flat { area })
    }

    fn place(&self, frame: &LampFrame, u: [f32; 2]) -> Vec3A {
        self.point(frame, u)
    }

    fn normal(&self, frame: &LampFrame, _place: Vec3A, _wi: Vec3A) -> Vec3A {
        -frame.axes.z_axis
    }

    fn uv(&self, frame: &LampFrame, seen: &LampView) -> Vec2 {
        let p = frame.local(seen.place - frame.center);
        Vec2::new(0.5 + p.x / self.size[0], 0.5 + p.y / self.size[1])
    }

    fn bounds(&self, frame: &LampFrame, power: f32) -> LightBounds {
        let half = frame.axes.x_axis.abs() * (0.5 * self.size[0]) + frame.axes.y_axis.abs() * (0.5 * self.size[1]);
        LightBounds {
            min: frame.center - half,
            max: frame.center + half,
            normal_spread_rad: 0.0,
            ..frame.bounds(power, 0.0)
        }
    }

    fn sample(&self, frame: &LampFrame, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        let seen = self.seen(frame, from);
        let to = seen.as_ref().map_or_else(|| self.point(frame, u) - from, |seen| frame.axes * seen.point(u));
        let distance = to.length();
        let wi = to / distance;
        let cos = wi.dot(frame.axes.z_axis);
        if !(cos > 0.0 && distance > 0.0) {
            return None;
        }
        let pdf = self.pdf(seen.as_ref(), cos, distance);
        let leaves = Some(Leaving { cos, error: frame.rounding });
        Some(LightSample { leaves, ..frame.light(wi, distance, frame.strength * self.spread(cos), pdf) })
    }

    fn hit(&self, frame: &LampFrame, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        let cos = d.dot(frame.axes.z_axis);
        if cos <= 0.0 {
            return None;
        }
        let t = (frame.center - origin).dot(frame.axes.z_axis) / cos;
        // A surface in the lamp's plane does not hide it: it is as far away but for rounding.
        if !(t > 0.0 && t < t_max + frame.rounding / cos) {
            return None;
        }
        let p = origin + d * t - frame.center;
        let (x, y) = (2.0 * p.dot(frame.axes.x_axis) / self.size[0], 2.0 * p.dot(frame.axes.y_axis) / self.size[1]);
        let inside = if self.ellipse { x * x + y * y <= 1.0 } else { x.abs() <= 1.0 && y.abs() <= 1.0 };
        inside.then(|| (frame.strength * self.spread(cos), self.pdf(self.seen(frame, origin).as_ref(), cos, t), t))
    }

    fn emit(&self, frame: &LampFrame, u_place: [f32; 2], u_direction: [f32; 2], _scene: (Vec3A, f32)) -> LampRay {
        // Evenly in projected solid angle, within the spread.
        let flat = warp::sample_disk(u_direction) * self.half_spread_rad.min(FRAC_PI_2).sin();
        let cos = (1.0 - flat.length_squared()).max(0.0).sqrt();
        let local = Vec3A::new(flat.x, flat.y, cos);
        let direction = warp::to_world(&warp::frame(-frame.axes.z_axis), local).normalize();
        LampRay { origin: self.point(frame, u_place), direction, strength: frame.strength * self.spread(cos) }
    }

    fn emission_density(&self, _distance: f32, _scene_radius: f32) -> f32 {
        let sin = self.half_spread_rad.min(FRAC_PI_2).sin();
        1.0 / (self.area() * PI * sin * sin)
    }

    fn arrival_pdf(&self, frame: &LampFrame, at: Vec3A, direction: Vec3A, distance: f32) -> Option<f32> {
        let cos = -direction.dot(frame.axes.z_axis);
        (cos > 0.0).then(|| self.pdf(self.seen(frame, at).as_ref(), cos, distance))
    }
}
