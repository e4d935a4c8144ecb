//! The shape of a lamp: the operations by which kinds of lamp differ, and their shared code.

use super::super::bounds::LightBounds;
use super::super::sample::LightSample;
use crate::scene::visibility::{LightSets, Rays};
use crate::{Rgb, sampler::warp};
use glam::{Mat3A, Vec2, Vec3A};
use std::f32::consts::{FRAC_PI_2, PI};

/// A kind of lamp. Distances are in Blender units, places and directions in render space.
pub(super) trait LampShape {
    /// Radiance of a lamp with extent; radiant intensity of one without (sun: irradiance). `color` is its power.
    fn strength(&self, color: Rgb) -> Rgb;

    /// Full length of a flat lamp, to bound the rounding of its plane; 0 of others.
    fn size(&self) -> f32 {
        0.0
    }

    /// True if no ray can hit the lamp: it has no extent.
    fn is_point_like(&self) -> bool;

    /// The extent of a lamp that stands in the scene and can be hit; else `None`.
    fn extent(&self) -> Option<LampExtent> {
        None
    }

    /// A point of a flat lamp, even by area; the centre of a ball.
    fn place(&self, frame: &LampFrame, _u: [f32; 2]) -> Vec3A {
        frame.center
    }

    /// Half of the angular diameter of a lamp infinitely far away; `None` of one that stands in the scene.
    fn half_angle_at_infinity(&self) -> Option<f32> {
        None
    }

    /// The normal of the lamp at a place that is seen along `wi`.
    fn normal(&self, _frame: &LampFrame, _place: Vec3A, wi: Vec3A) -> Vec3A {
        -wi
    }

    /// Blender's coordinates for images on lamps.
    fn uv(&self, frame: &LampFrame, seen: &LampView) -> Vec2;

    /// The lamp's position and directions of emission, of so much power; not for lamps at infinity.
    fn bounds(&self, frame: &LampFrame, power: f32) -> LightBounds;

    /// Light of the lamp at `from`, before the lamp's nodes.
    fn sample(&self, frame: &LampFrame, from: Vec3A, u: [f32; 2]) -> Option<LightSample>;

    /// Radiance along a ray that hits the lamp before `t_max`, the density of [`Self::sample`], and its distance.
    fn hit(&self, _frame: &LampFrame, _origin: Vec3A, _d: Vec3A, _t_max: f32) -> Option<(Rgb, f32, f32)> {
        None
    }

    /// Radiance of a lamp at infinity with extent along `d`, and the density of its samples.
    fn hit_at_infinity(&self, _frame: &LampFrame, _d: Vec3A) -> Option<(Rgb, f32)> {
        None
    }

    /// A ray chosen by four uniform numbers; of a lamp at infinity it crosses the ball of a radius about a center, which holds the scene.
    fn emit(&self, frame: &LampFrame, u_place: [f32; 2], u_direction: [f32; 2], scene: (Vec3A, f32)) -> LampRay;

    /// The density of [`Self::emit`] per unit of etendue. Of a lamp without extent, the density per unit of area at right angles to the
    /// ray, `distance` from it.
    fn emission_density(&self, distance: f32, scene_radius: f32) -> f32;

    /// The density per steradian with which [`Self::sample`] at a place chooses a ray along `direction` that left the lamp and arrives
    /// there after `distance`. `None` where the lamp, seen from that place, is not there.
    fn arrival_pdf(&self, frame: &LampFrame, at: Vec3A, direction: Vec3A, distance: f32) -> Option<f32>;
}

/// The extent of a lamp, Blender units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::lights) enum LampExtent {
    /// A ball of a radius, or a disk in its place.
    Ball {
        /// The radius.
        radius: f32,
    },
    /// A flat lamp that shines to one side.
    Flat {
        /// The area.
        area: f32,
    },
}

/// A place of a lamp as it is seen.
pub(super) struct LampView {
    pub(super) place: Vec3A,
    pub(super) normal: Vec3A,
    /// Direction to the place, unit.
    pub(super) wi: Vec3A,
}

/// Properties of a lamp that all kinds have.
#[derive(Clone, Debug)]
pub(super) struct LampFrame {
    pub(super) axes: Mat3A,
    pub(super) center: Vec3A,
    pub(super) reaches: Rays,
    pub(super) sets: LightSets,
    pub(super) cast_shadow: bool,
    /// The lamp's [`LampShape::strength`]. The factor of the lamp's nodes is not included.
    pub(super) strength: Rgb,
    /// Bound of the rounding error of a surface beside the lamp that stands in the lamp's plane, Blender units.
    pub(super) rounding: f32,
}

impl LampFrame {
    /// A direction along the lamp's own axes.
    pub(super) fn local(&self, v: Vec3A) -> Vec3A {
        self.axes.transpose() * v
    }

    /// A sample of a lamp with extent that needs no room before it.
    pub(super) fn light(&self, wi: Vec3A, distance: f32, radiance: Rgb, pdf: f32) -> LightSample {
        LightSample {
            wi,
            distance,
            radiance,
            pdf,
            point_like: false,
            cast_shadow: self.cast_shadow,
            reaches: self.reaches,
            sets: self.sets,
            leaves: None,
        }
    }

    /// Bounds of a ball that emits to all sides.
    pub(super) fn bounds(&self, power: f32, radius: f32) -> LightBounds {
        LightBounds {
            min: self.center - Vec3A::splat(radius),
            max: self.center + Vec3A::splat(radius),
            power,
            axis: -self.axes.z_axis,
            normal_spread_rad: PI,
            emission_spread_rad: FRAC_PI_2,
            two_sided: false,
        }
    }
}

/// A ray that leaves a lamp.
pub(in crate::lights) struct LampRay {
    pub(in crate::lights) origin: Vec3A,
    pub(in crate::lights) direction: Vec3A,
    /// Radiance; of a lamp without extent its intensity, of a sun without extent its irradiance.
    pub(in crate::lights) strength: Rgb,
}

/// A point, even by area, of a disk about the origin at right angles to `axis`.
pub(in crate::lights) fn on_disk(axis: Vec3A, radius: f32, u: [f32; 2]) -> Vec3A {
    let [x, y, _] = warp::frame(axis);
    let p = warp::sample_disk(u) * radius;
    x * p.x + y * p.y
}

/// 1 - cos of an angle, which keeps its digits for small ones.
pub(super) fn one_minus_cos(angle_rad: f32) -> f32 {
    2.0 * (0.5 * angle_rad).sin().powi(2)
}
