//! What is known of an emitter, or of several together: where it is, how much it emits and where to.

use glam::Vec3A;
use std::f32::consts::{FRAC_PI_2, PI};

/// What is known of an emitter, or of all emitters under a node.
#[derive(Clone, Copy, Debug)]
pub struct LightBounds {
    /// Least corner of the box.
    pub min: Vec3A,
    /// Greatest corner.
    pub max: Vec3A,
    /// Emitted power, any unit.
    pub power: f32,
    /// Middle of the emitters' normals.
    pub axis: Vec3A,
    /// Largest angle of a normal to the axis.
    pub normal_spread_rad: f32,
    /// Largest angle of light to its emitter's normal.
    pub emission_spread_rad: f32,
    /// Light also leaves backwards.
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

    /// Cost of a node in a split: power times the measure of where it is and where it shines to.
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
    let between = a.0.dot(b.0).clamp(-1.0, 1.0).acos();
    if (between + b.1).min(PI) <= a.1 {
        return a;
    }
    let spread = 0.5 * (a.1 + between + b.1);
    if spread >= PI {
        return (a.0, PI);
    }
    let turn = spread - a.1;
    let Some(side) = (b.0 - a.0 * a.0.dot(b.0)).try_normalize() else { return (a.0, PI) };
    let (s, c) = turn.sin_cos();
    ((a.0 * c + side * s).normalize(), spread)
}
