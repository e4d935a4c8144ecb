//! The sphere of point and spot lamps, or the disk in its place that faces whoever looks at it: Blender's soft falloff, which has no
//! edge where the sphere would cut into a surface.

use super::super::sample::{Leaving, LightSample};
use super::shape::{LampExtent, LampFrame, LampRay, on_disk};
use crate::{Rgb, sampler::warp};
use glam::Vec3A;
use std::f32::consts::PI;

/// The slant up to which a lamp without extent lights points past the plane that it stands in: its cosine.
const LEAST_SLANT: f32 = 0.1;

/// A sphere or a disk in its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    /// Radius, Blender units.
    pub(super) radius: f32,
    /// True for the disk.
    pub(super) soft: bool,
}

impl Ball {
    /// Strength of a lamp: a watt is spread over the whole sphere; a spot is a point light seen through a hole.
    pub(super) fn strength(self, color: Rgb) -> Rgb {
        let radius = self.radius;
        if radius > 0.0 { color / (4.0 * PI * PI * radius * radius) } else { color / (4.0 * PI) }
    }

    pub(super) fn is_point_like(self) -> bool {
        self.radius <= 0.0
    }

    pub(super) fn extent(self) -> Option<LampExtent> {
        (self.radius > 0.0).then_some(LampExtent::Ball { radius: self.radius })
    }

    pub(super) fn normal(self, frame: &LampFrame, place: Vec3A, wi: Vec3A) -> Vec3A {
        if !self.soft && self.radius > 0.0 { (place - frame.center).normalize_or(-wi) } else { -wi }
    }

    pub(super) fn sample(self, frame: &LampFrame, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        if self.soft && self.radius > 0.0 {
            self.sample_disk(frame, from, u)
        } else {
            self.sample_sphere(frame, from, u)
        }
    }

    pub(super) fn hit(self, frame: &LampFrame, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        if self.soft { self.hit_disk(frame, origin, d, t_max) } else { self.hit_sphere(frame, origin, d, t_max) }
    }

    /// True if a place is within the sphere: as in Cycles, which looks at it from inside, its light comes from all sides there.
    pub(super) fn holds(self, frame: &LampFrame, place: Vec3A) -> bool {
        !self.soft && (frame.center - place).length_squared() <= self.radius * self.radius && self.radius > 0.0
    }

    fn sample_sphere(self, frame: &LampFrame, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        let radius = self.radius;
        let to = frame.center - from;
        let distance2 = to.length_squared();
        let distance = distance2.sqrt();
        if self.holds(frame, from) {
            let wi = warp::sample_sphere(u);
            return Some(frame.light(wi, self.way_out(to, wi), frame.strength, warp::SPHERE_PDF));
        }
        if distance <= 0.0 {
            return None;
        }
        let axis = to / distance;
        if radius <= 0.0 {
            let leaves = Some(Leaving { cos: LEAST_SLANT, error: frame.rounding });
            let seen = frame.light(axis, distance, frame.strength / distance2, 1.0);
            return Some(LightSample { point_like: true, leaves, ..seen });
        }
        let sin2_max = radius * radius / distance2;
        let limit = sin2_max / (1.0 + (1.0 - sin2_max).max(0.0).sqrt());
        let local = warp::sample_cone(u, limit);
        let wi = warp::to_world(&warp::frame(axis), local).normalize();
        // Distance to the near side of the sphere.
        let sin2 = local.x * local.x + local.y * local.y;
        let half_chord = (radius * radius - distance2 * sin2).max(0.0).sqrt();
        Some(frame.light(wi, distance * local.z - half_chord, frame.strength, warp::cone_pdf(limit)))
    }

    /// Distance along `d` to the sphere from a place within it, from which `to` leads to its middle.
    fn way_out(self, to: Vec3A, d: Vec3A) -> f32 {
        let along = to.dot(d);
        along + (self.radius * self.radius - (to - d * along).length_squared()).max(0.0).sqrt()
    }

    fn hit_sphere(self, frame: &LampFrame, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        let radius = self.radius;
        if radius <= 0.0 {
            return None;
        }
        let to = frame.center - origin;
        let distance2 = to.length_squared();
        let along = to.dot(d);
        let off2 = (to - d * along).length_squared();
        if self.holds(frame, origin) {
            let t = self.way_out(to, d);
            return (t > 0.0 && t < t_max).then_some((frame.strength, warp::SPHERE_PDF, t));
        }
        if along <= 0.0 || off2 > radius * radius {
            return None;
        }
        let t = along - (radius * radius - off2).max(0.0).sqrt();
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let sin2_max = radius * radius / distance2;
        let limit = sin2_max / (1.0 + (1.0 - sin2_max).max(0.0).sqrt());
        Some((frame.strength, warp::cone_pdf(limit), t))
    }

    fn sample_disk(self, frame: &LampFrame, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        let radius = self.radius;
        let axis = (frame.center - from).try_normalize()?;
        let [x, y, _] = warp::frame(axis);
        let p = warp::sample_disk(u) * radius;
        let to = frame.center + x * p.x + y * p.y - from;
        let distance = to.length();
        let wi = to / distance;
        let cos = wi.dot(axis);
        let pdf = distance * distance / (cos * PI * radius * radius);
        (cos > 0.0).then(|| frame.light(wi, distance, frame.strength, pdf))
    }

    fn hit_disk(self, frame: &LampFrame, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        let radius = self.radius;
        if radius <= 0.0 {
            return None;
        }
        let to = frame.center - origin;
        let distance = to.length();
        let cos = d.dot(to) / distance;
        let t = distance / cos;
        // Refuses NaN, too: the start may be the lamp's very centre.
        let ahead = cos > 0.0 && t < t_max;
        let inside = (d * t - to).length_squared() <= radius * radius;
        (ahead && inside).then(|| (frame.strength, t * t / (cos * PI * radius * radius), t))
    }

    /// A ray of one direction: these fill a disk at right angles to it.
    pub(super) fn emit(self, frame: &LampFrame, direction: Vec3A, u: [f32; 2], strength: Rgb) -> LampRay {
        let radius = self.radius;
        let aside = if radius > 0.0 { on_disk(direction, radius, u) } else { Vec3A::ZERO };
        let ahead = if self.soft { 0.0 } else { (radius * radius - aside.length_squared()).max(0.0).sqrt() };
        LampRay { origin: frame.center + aside + direction * ahead, direction, strength }
    }

    /// [`super::shape::LampShape::emission_density`] where directions have that density per steradian.
    pub(super) fn emission_density(self, distance: f32, per_sr: f32) -> f32 {
        let radius = self.radius;
        per_sr / if radius > 0.0 { PI * radius * radius } else { distance * distance }
    }

    pub(super) fn arrival_pdf(self, frame: &LampFrame, at: Vec3A, direction: Vec3A) -> Option<f32> {
        let radius = self.radius;
        let to = frame.center - at;
        let d2 = to.length_squared();
        if radius <= 0.0 {
            return Some(1.0);
        }
        if self.soft {
            let cos = -direction.dot(to) / d2.sqrt();
            let t = d2.sqrt() / cos;
            let inside = cos > 0.0 && (direction * t + to).length_squared() <= radius * radius;
            return inside.then(|| t * t / (cos * PI * radius * radius));
        }
        let sin2_max = radius * radius / d2;
        (sin2_max < 1.0).then(|| warp::cone_pdf(sin2_max / (1.0 + (1.0 - sin2_max).sqrt())))
    }
}
