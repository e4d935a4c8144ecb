//! Tangents along UV maps.

use glam::{Vec2, Vec3};
use petzval_nodes::{Number, Vector};
use std::f32::consts::{PI, TAU};

/// The direction in which u grows on a triangle with places on a map, at right angles to a normal that need not be unit, and the side on which
/// v grows, 1 or -1: of one point, or of those of all lanes.
#[inline(always)]
pub(super) fn along_map<V: Vector>(
    [a, b, c]: [V; 3],
    [ua, ub, uc]: [[V::Number; 2]; 3],
    mesh_normal: V,
) -> (V, V::Number) {
    let (e, f) = (b - a, c - a);
    let (p, q) = ([ub[0] - ua[0], ub[1] - ua[1]], [uc[0] - ua[0], uc[1] - ua[1]]);
    let turn = (p[0] * q[1] - p[1] * q[0]).sign();
    let (along_u, along_v) = ((e.times(q[1]) - f.times(p[1])).times(turn), (f.times(p[0]) - e.times(q[0])).times(turn));
    let normal = mesh_normal.unit();
    let tangent = (along_u - normal.times(normal.inner(along_u))).unit();
    let [zero, one] = [0.0, 1.0].map(V::Number::of);
    let side = normal.across(tangent).inner(along_v).if_below(zero, -one, one);
    // What Cycles has where the map takes no area: x, and the other side. A tangent is zero or unit.
    let (size, half) = (tangent.inner(tangent), V::Number::of(0.5));
    let [x, y, z] = tangent.parts();
    (
        V::of([size.if_below(half, one, x), size.if_below(half, zero, y), size.if_below(half, zero, z)]),
        size.if_below(half, -one, side),
    )
}

/// The place on an equirectangular map of a sphere about the origin: Cycles' UV of a mesh without maps.
pub(super) fn around_the_origin(p: Vec3) -> Vec2 {
    let turn = if p.x == 0.0 && p.y == 0.0 { 0.0 } else { 0.5 - p.x.atan2(p.y) / TAU };
    Vec2::new(turn, 1.0 - p.normalize_or_zero().z.clamp(-1.0, 1.0).acos() / PI)
}
