//! Bounds of an emitter, or of several together: position, power and directions of emission.

use glam::Vec3A;
use std::f32::consts::{FRAC_PI_2, PI};

/// A cone is widened by this rather than turned: turns of no more than rounding add up.
const LEAST_TURN_RAD: f32 = 1e-5;

/// Bounds of an emitter, or of all emitters under a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    /// Least corner of the box.
    pub min: Vec3A,
    /// Greatest corner of the box.
    pub max: Vec3A,
    /// Emitted power, any unit.
    pub power: f32,
    /// Middle of the emitters' normals.
    pub axis: Vec3A,
    /// Largest angle of a normal to the axis.
    pub normal_spread_rad: f32,
    /// Largest angle of light to its emitter's normal.
    pub emission_spread_rad: f32,
    /// True if light also leaves backwards.
    pub two_sided: bool,
}

impl LightBounds {
    /// The smallest bounds around both.
    pub(super) fn union(&self, other: &Self) -> Self {
        let (axis, normal_spread_rad) =
            join_cones((self.axis, self.normal_spread_rad), (other.axis, other.normal_spread_rad));
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            power: self.power + other.power,
            axis,
            normal_spread_rad,
            emission_spread_rad: self.emission_spread_rad.max(other.emission_spread_rad),
            two_sided: self.two_sided || other.two_sided,
        }
    }

    pub(super) fn center(&self) -> Vec3A {
        0.5 * (self.min + self.max)
    }

    /// Cost of a node in a split: power times the measures of its position and of its directions of emission.
    pub(super) fn cost(&self) -> f32 {
        let d = self.max - self.min;
        let area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
        let (o, e) = (self.normal_spread_rad, (self.normal_spread_rad + self.emission_spread_rad).min(PI));
        // Solid angle of the cone of normals, and of the falling-off rim about it.
        let rim = 2.0 * e * o.sin() - (o - 2.0 * e).cos() - 2.0 * o * o.sin() + o.cos();
        let directions = 2.0 * PI * (1.0 - o.cos()) + FRAC_PI_2 * rim;
        // A flat or single-point node still has a cost: half of its diagonal squared is its least area.
        self.power * directions * area.max(0.5 * d.length_squared())
    }
}

/// A cone around two cones.
fn join_cones(a: (Vec3A, f32), b: (Vec3A, f32)) -> (Vec3A, f32) {
    let (a, b) = if a.1 >= b.1 { (a, b) } else { (b, a) };
    // What is common needs no angle.
    if a.1 >= PI || a.0 == b.0 {
        return a;
    }
    // Not the cosine's inverse: of nearly equal directions that tells nothing, and thousands of equal normals, one joined after
    // the other, would end up with a cone of all directions.
    let (cos, across) = (a.0.dot(b.0), b.0 - a.0 * a.0.dot(b.0));
    let between = across.length().atan2(cos);
    if (between + b.1).min(PI) <= a.1 + LEAST_TURN_RAD {
        return (a.0, a.1.max((between + b.1).min(PI)));
    }
    let spread = 0.5 * (a.1 + between + b.1);
    if spread >= PI {
        return (a.0, PI);
    }
    let turn = spread - a.1;
    // Opposite: any side will do, and none is better.
    let Some(side) = across.try_normalize() else { return (a.0, PI) };
    // Once more, for what rounding left of a difference between nearly opposite directions.
    let side = (side - a.0 * a.0.dot(side)).normalize();
    let (s, c) = turn.sin_cos();
    ((a.0 * c + side * s).normalize(), spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facing(axis: Vec3A, normal_spread_rad: f32) -> LightBounds {
        let (min, max) = (Vec3A::ZERO, Vec3A::ONE);
        LightBounds { min, max, power: 1.0, axis, normal_spread_rad, emission_spread_rad: 1.0, two_sided: false }
    }

    /// The union of equal normals keeps a narrow cone, however many there are and whatever rounding does to each.
    #[test]
    fn equal_normals_keep_a_narrow_cone() {
        let tilted = Vec3A::new(0.3, -0.5, 0.8).normalize();
        for about in [Vec3A::NEG_Z, tilted] {
            let normal = |i: u32| {
                let u = sobol_burley::sample_4d(i, 0, 1);
                (about + (Vec3A::new(u[0], u[1], u[2]) - 0.5) * 4e-7).normalize()
            };
            let whole = (0..20_000).map(|i| facing(normal(i), 0.0)).reduce(|a, b| a.union(&b)).unwrap();
            assert!(whole.normal_spread_rad < 1e-3, "{}", whole.normal_spread_rad);
            assert!(whole.axis.dot(about) > 1.0 - 1e-6);
        }
    }

    /// A cone around two holds both: their edges, too.
    #[test]
    fn joined_cones_hold_both() {
        use crate::sampler::warp::sample_sphere;
        for i in 0..2000 {
            let (u, v) = (sobol_burley::sample_4d(i, 0, 1), sobol_burley::sample_4d(i, 0, 2));
            let (a, mut b) = (sample_sphere([u[0], u[1]]), sample_sphere([u[2], u[3]]));
            match i % 4 {
                0 => b = a,
                1 => b = (a + b * 1e-3).normalize(),
                2 => b = (b * 1e-3 - a).normalize(),
                _ => {}
            }
            let (a, b) = (facing(a, v[0] * v[0] * PI), facing(b, v[1] * v[1] * PI));
            let both = a.union(&b);
            for part in [a, b] {
                let between = (part.axis.cross(both.axis)).length().atan2(part.axis.dot(both.axis));
                let needed = (between + part.normal_spread_rad).min(PI);
                assert!(both.normal_spread_rad >= needed - 2e-6, "{needed} of {both:?} for {part:?}");
            }
        }
    }
}
