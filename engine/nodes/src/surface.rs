//! Bump, Normal Map, Fresnel and the other nodes that are about the surface itself.

use crate::choice::choices;
use crate::lanes::{Number, Vector};
use glam::Vec3A;

choices! {
    pub(crate) NormalSpace {
        Tangent = "TANGENT",
        Object = "OBJECT",
        World = "WORLD",
        BlenderObject = "BLENDER_OBJECT",
        BlenderWorld = "BLENDER_WORLD",
    }
}
choices! { pub(crate) Axis { X = "X", Y = "Y", Z = "Z" } }

/// The share that a smooth dielectric reflects of unpolarised light. `eta`: index behind over before.
pub(crate) fn dielectric(cosine: f32, eta: f32) -> f32 {
    let c = cosine.abs();
    let square = eta * eta - 1.0 + c * c;
    if square <= 0.0 {
        return 1.0;
    }
    let g = square.sqrt();
    let a = (g - c) / (g + c);
    let b = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    0.5 * a * a * (1.0 + b * b)
}

/// Indices closer to zero than this are taken for it.
const LEAST_INDEX: f32 = 1e-5;

pub(crate) fn fresnel(ior: f32, cosine: f32, backfacing: bool) -> f32 {
    let eta = ior.max(LEAST_INDEX);
    dielectric(cosine, if backfacing { 1.0 / eta } else { eta })
}

/// The Fresnel output of the Layer Weight node: reflectance of a dielectric of index 1 / (1 − `blend`).
pub(crate) fn layer_fresnel(blend: f32, cosine: f32, backfacing: bool) -> f32 {
    let eta = (1.0 - blend).max(LEAST_INDEX);
    dielectric(cosine, if backfacing { eta } else { 1.0 / eta })
}

/// The Facing output of the Layer Weight node: 0 where the surface is seen straight on, and rising, as `blend` says, towards grazing views.
pub(crate) fn facing(blend: f32, cosine: f32) -> f32 {
    let cosine = cosine.abs();
    let share = if blend == 0.5 {
        cosine
    } else {
        let blend = blend.clamp(0.0, 1.0 - 1e-5);
        cosine.powf(if blend < 0.5 { 2.0 * blend } else { 0.5 / (1.0 - blend) })
    };
    1.0 - share
}

/// Heights at the point and beside it along the footprint's axes, and the strength and distance of the bump.
pub(crate) struct Bump {
    pub(crate) heights: [f32; 3],
    pub(crate) axes: [Vec3A; 2],
    pub(crate) strength: f32,
    pub(crate) distance: f32,
}

impl Bump {
    /// The normal of the raised surface (Mikkelsen's surface gradient).
    pub(crate) fn normal(&self, normal: Vec3A) -> Vec3A {
        let [dx, dy] = self.axes;
        let (across_x, across_y) = (dy.cross(normal), normal.cross(dx));
        let [here, beside_x, beside_y] = self.heights;
        let gradient = across_x * (beside_x - here) + across_y * (beside_y - here);
        let area = dx.dot(across_x);
        let raised = normal * area.abs() - gradient * (self.distance * area.signum());
        let raised = raised.normalize_or_zero();
        if raised == Vec3A::ZERO {
            return normal;
        }
        let strength = self.strength.max(0.0);
        (raised * strength + normal * (1.0 - strength)).normalize_or_zero()
    }
}

/// A normal by a map's colour over the axes of tangent space.
#[inline(always)]
pub(crate) fn tangent_space<V: Vector>(colour: V, strength: V::Number, tangent: V, sign: V::Number, normal: V) -> V {
    let across = normal.across(tangent).times(sign);
    let one = V::Number::of(1.0);
    let [x, y, z] = colour.parts();
    let z = one + (z - one) * strength.saturated();
    (tangent.times(x * strength) + across.times(y * strength) + normal.times(z)).unit()
}

/// A mapped normal at a strength that is not one.
pub(crate) fn strengthened(mapped: Vec3A, normal: Vec3A, strength: f32) -> Vec3A {
    if strength == 1.0 {
        return mapped;
    }
    (normal + (mapped - normal) * strength.max(0.0)).normalize_or_zero()
}

/// The direction around an axis of the object, at a generated coordinate.
pub(crate) fn around(axis: Axis, generated: Vec3A) -> Vec3A {
    let p = generated - 0.5;
    match axis {
        Axis::X => Vec3A::new(0.0, -p.z, p.y),
        Axis::Y => Vec3A::new(-p.z, 0.0, p.x),
        Axis::Z => Vec3A::new(-p.y, p.x, 0.0),
    }
}

/// Light Falloff's strength: smoothed near the light, constant, linear or quadratic by `power` 2, 1, 0.
pub(crate) fn falloff(strength: f32, smooth: f32, ray_length: f32, power: i32) -> f32 {
    let square = ray_length * ray_length;
    let strength = if smooth > 0.0 { strength * square / (smooth + square) } else { strength };
    strength * ray_length.powi(power)
}
