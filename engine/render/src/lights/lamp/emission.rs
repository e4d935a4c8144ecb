//! Rays that leave a lamp. Densities are counted per unit of etendue, Blender units squared times steradians at right
//! angles to the ray, which a ray keeps as it travels: so they are the same wherever it arrives.

use super::{PreparedLamp, area_of, one_minus_cos, spread};
use crate::scene::lamp::LampKind;
use crate::{Rgb, sampler::warp};
use glam::{Vec2, Vec3A};
use std::f32::consts::{FRAC_PI_2, PI};

/// A ray that leaves a lamp.
pub(in crate::lights) struct LampRay {
    pub(in crate::lights) origin: Vec3A,
    pub(in crate::lights) direction: Vec3A,
    /// Radiance; of a lamp without extent its intensity, of a sun without extent its irradiance.
    pub(in crate::lights) strength: Rgb,
}

impl PreparedLamp {
    /// True if light paths leave the lamp: not from one without shadows, for where its rays should end is undefined.
    pub(in crate::lights) fn emits_rays(&self) -> bool {
        self.cast_shadow
    }

    /// True if no ray can hit the lamp: it has no extent.
    pub(in crate::lights) fn is_point_like(&self) -> bool {
        match self.kind {
            LampKind::Point { radius, .. } | LampKind::Spot { radius, .. } => radius <= 0.0,
            LampKind::Sun { half_angle_rad } => half_angle_rad <= 0.0,
            LampKind::Area { .. } => false,
        }
    }

    /// A ray chosen by four uniform numbers; a sun's crosses the ball of `radius` about `center`, which holds the scene.
    pub(in crate::lights) fn emit(
        &self,
        u_place: [f32; 2],
        u_direction: [f32; 2],
        (center, scene_radius): (Vec3A, f32),
    ) -> LampRay {
        match self.kind {
            LampKind::Point { radius, soft } => {
                self.emit_ball(warp::sample_sphere(u_direction), radius, soft, u_place, self.strength)
            }
            LampKind::Spot { radius, half_angle_rad, blend, soft } => {
                let local = warp::sample_cone(u_direction, spot_limit(half_angle_rad));
                let direction = warp::to_world(&warp::frame(-self.axes.z_axis), local).normalize();
                let strength = self.strength * self.cone(direction, half_angle_rad, blend);
                self.emit_ball(direction, radius, soft, u_place, strength)
            }
            LampKind::Sun { half_angle_rad } => {
                let towards = self.sample_sun(half_angle_rad, u_direction).wi;
                let origin = center + on_disk(towards, scene_radius, u_place) + towards * scene_radius;
                LampRay { origin, direction: -towards, strength: self.strength }
            }
            LampKind::Area { size, ellipse, half_spread_rad } => {
                let p = if ellipse { warp::sample_disk(u_place) * 0.5 } else { Vec2::from(u_place) - Vec2::splat(0.5) };
                let origin = self.center + self.axes.x_axis * (p.x * size[0]) + self.axes.y_axis * (p.y * size[1]);
                // Evenly in projected solid angle, within the spread.
                let flat = warp::sample_disk(u_direction) * half_spread_rad.min(FRAC_PI_2).sin();
                let cos = (1.0 - flat.length_squared()).max(0.0).sqrt();
                let local = Vec3A::new(flat.x, flat.y, cos);
                let direction = warp::to_world(&warp::frame(-self.axes.z_axis), local).normalize();
                LampRay { origin, direction, strength: self.strength * spread(cos, half_spread_rad) }
            }
        }
    }

    /// The rays of one direction through a ball fill a disk at right angles to it.
    fn emit_ball(&self, direction: Vec3A, radius: f32, soft: bool, u: [f32; 2], strength: Rgb) -> LampRay {
        let aside = if radius > 0.0 { on_disk(direction, radius, u) } else { Vec3A::ZERO };
        let ahead = if soft { 0.0 } else { (radius * radius - aside.length_squared()).max(0.0).sqrt() };
        LampRay { origin: self.center + aside + direction * ahead, direction, strength }
    }

    /// The density of [`PreparedLamp::emit`] per unit of etendue. Of a lamp without extent, the density per unit of area
    /// at right angles to the ray, `distance` from it.
    pub(in crate::lights) fn emission_density(&self, distance: f32, scene_radius: f32) -> f32 {
        let ball =
            |radius: f32, per_sr: f32| per_sr / if radius > 0.0 { PI * radius * radius } else { distance * distance };
        match self.kind {
            LampKind::Point { radius, .. } => ball(radius, warp::SPHERE_PDF),
            LampKind::Spot { radius, half_angle_rad, .. } => ball(radius, warp::cone_pdf(spot_limit(half_angle_rad))),
            LampKind::Sun { half_angle_rad } => {
                let per_sr = if half_angle_rad > 0.0 { warp::cone_pdf(one_minus_cos(half_angle_rad)) } else { 1.0 };
                per_sr / (PI * scene_radius * scene_radius)
            }
            LampKind::Area { size, ellipse, half_spread_rad } => {
                let sin = half_spread_rad.min(FRAC_PI_2).sin();
                1.0 / (area_of(size, ellipse) * PI * sin * sin)
            }
        }
    }

    /// The density per steradian with which [`PreparedLamp::sample`] at a place chooses a ray along `direction` that left the lamp and
    /// arrives there after `distance`. `None` where the lamp, seen from that place, is not there.
    pub(in crate::lights) fn arrival_pdf(&self, at: Vec3A, direction: Vec3A, distance: f32) -> Option<f32> {
        match self.kind {
            LampKind::Point { radius, soft } | LampKind::Spot { radius, soft, .. } => {
                let to = self.center - at;
                let d2 = to.length_squared();
                if radius <= 0.0 {
                    return Some(1.0);
                }
                if soft {
                    let cos = -direction.dot(to) / d2.sqrt();
                    let t = d2.sqrt() / cos;
                    let inside = cos > 0.0 && (direction * t + to).length_squared() <= radius * radius;
                    return inside.then(|| t * t / (cos * PI * radius * radius));
                }
                let sin2_max = radius * radius / d2;
                (sin2_max < 1.0).then(|| warp::cone_pdf(sin2_max / (1.0 + (1.0 - sin2_max).sqrt())))
            }
            LampKind::Sun { half_angle_rad } => {
                Some(if half_angle_rad > 0.0 { warp::cone_pdf(one_minus_cos(half_angle_rad)) } else { 1.0 })
            }
            LampKind::Area { size, ellipse, .. } => {
                let cos = -direction.dot(self.axes.z_axis);
                (cos > 0.0).then(|| distance * distance / (cos * area_of(size, ellipse)))
            }
        }
    }
}

/// 1 - cos of the cone of a spot.
fn spot_limit(half_angle_rad: f32) -> f32 {
    one_minus_cos(half_angle_rad.min(PI))
}

/// A point, even by area, of a disk about the origin at right angles to `axis`.
pub(in crate::lights) fn on_disk(axis: Vec3A, radius: f32, u: [f32; 2]) -> Vec3A {
    let [x, y, _] = warp::frame(axis);
    let p = warp::sample_disk(u) * radius;
    x * p.x + y * p.y
}
