//! A rectangle as it is seen from a place, sampled evenly by solid angle.
//!
//! Ureña, Fajardo and King 2013, "An area-preserving parametrization for spherical rectangles"; the letters are those of the paper.
//! Evenly by area, points near the place would come too seldom: light of a large lamp, on surfaces near it, would be noisy.

use glam::Vec3A;
use std::f32::consts::TAU;

/// Distance of the middle, in longer sides, beyond which all points count about alike: by area is quicker then.
const NEAR: f32 = 2.0;
/// A solid angle that single precision still knows, sr.
const LEAST: f32 = 1e-3;
/// A distance of the plane, over the longer side, at which it still knows the edges' directions.
const LOWEST: f32 = 1e-4;

/// A rectangle as it is seen from a place, along its own axes with the place as origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalRectangle {
    /// Two opposite corners.
    x: [f32; 2],
    y: [f32; 2],
    /// Distance of its plane.
    height: f32,
    /// Sum of two of its angles on the sphere, taken from a whole turn.
    k: f32,
    /// Parts along z of the normals of the planes through the place and the two edges along x.
    b: [f32; 2],
    /// Solid angle, sr.
    pub(super) solid_angle: f32,
}

impl SphericalRectangle {
    /// The rectangle with its middle at `center` along its axes x, y, and z from the place to its plane, and with these sides; `None`
    /// where it is to be sampled by area.
    pub(super) fn new(center: Vec3A, [width, length]: [f32; 2]) -> Option<Self> {
        let height = center.z;
        let is_near = center.length() < NEAR * width.max(length);
        if !(height > LOWEST * width.max(length) && is_near) {
            return None;
        }
        let sides = |middle: f32, side: f32| [middle - 0.5 * side, middle + 0.5 * side];
        let (x, y) = (sides(center.x, width), sides(center.y, length));
        let normal = |edge: f32| edge / (edge * edge + height * height).sqrt();
        let n = [-normal(y[0]), normal(x[1]), normal(y[1]), -normal(x[0])];
        let angle = |i: usize| (-n[i] * n[(i + 1) % 4]).clamp(-1.0, 1.0).acos();
        let k = TAU - angle(2) - angle(3);
        let solid_angle = angle(0) + angle(1) - k;
        (solid_angle > LEAST).then_some(Self { x, y, height, k, b: [n[0], n[2]], solid_angle })
    }

    /// A point of the rectangle, even by solid angle, along its axes from the place.
    pub(super) fn point(&self, u: [f32; 2]) -> Vec3A {
        let Self { x, y, height, k, b, solid_angle } = *self;
        let (sin, cos) = (u[0] * solid_angle + k).sin_cos();
        let f = (cos * b[0] - b[1]) / sin;
        let c = (1.0 / (f * f + b[0] * b[0]).sqrt()).copysign(f).clamp(-1.0, 1.0);
        // The paper's z axis points away from the rectangle.
        let x = (c * height / (1.0 - c * c).max(1e-14).sqrt()).clamp(x[0], x[1]);
        let d = (x * x + height * height).sqrt();
        let sine = |y: f32| y / (d * d + y * y).sqrt();
        let (h0, h1) = (sine(y[0]), sine(y[1]));
        let h = h0 + u[1] * (h1 - h0);
        let y = (h * d / (1.0 - h * h).max(1e-14).sqrt()).clamp(y[0], y[1]);
        Vec3A::new(x, y, height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::PathSampler;

    /// The solid angle by adding up the rectangle, and the integral of a function of the direction, both ways.
    #[test]
    fn the_solid_angle_is_sampled_evenly() {
        for (center, size) in [
            ([0.0, 0.0, 1.0], [2.0, 2.0]),
            ([3.0, -1.0, 0.4], [6.0, 1.0]),
            ([0.2, 5.0, 0.02], [0.5, 12.0]),
            ([-4.0, 2.0, 9.0], [8.0, 6.0]),
        ] {
            let center = Vec3A::from(center);
            let seen = SphericalRectangle::new(center, size).unwrap();
            let n = 2000;
            let step = |i: i32, side: f32| side * ((f64::from(i) + 0.5) / f64::from(n) - 0.5) as f32;
            let function = |d: Vec3A| f64::from(1.0 + d.x * 2.0 + d.y * d.y);
            let (mut area, mut expected) = (0.0, 0.0);
            for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
                let p = center + Vec3A::new(step(i, size[0]), step(j, size[1]), 0.0);
                let solid = f64::from(p.z / p.length().powi(3));
                area += solid;
                expected += solid * function(p.normalize());
            }
            let cell = f64::from(size[0] * size[1]) / f64::from(n * n);
            let solid_angle = f64::from(seen.solid_angle);
            assert!((area * cell / solid_angle - 1.0).abs() < 2e-3, "{center} {size:?}: {} {solid_angle}", area * cell);
            let samples = 4096;
            let found: f64 = (0..samples)
                .map(|i| {
                    let [u0, u1, ..] = PathSampler::new(3, 5, i, 7).next_4d();
                    let p = seen.point([u0, u1]);
                    assert!(((p - center) / Vec3A::new(size[0], size[1], 1.0)).abs().max_element() < 0.501, "{p}");
                    function(p.normalize())
                })
                .sum();
            let found = found / f64::from(samples) * solid_angle;
            assert!((found / (expected * cell) - 1.0).abs() < 5e-3, "{center} {size:?}: {found} {}", expected * cell);
        }
    }

    #[test]
    fn what_is_far_or_edge_on_is_sampled_by_area() {
        for (center, size) in [
            ([0.0, 0.0, 50.0], [1.0, 1.0]),
            ([0.0, 0.0, 0.0], [1.0, 1.0]),
            ([0.0, 0.0, -1.0], [1.0, 1.0]),
            ([3.0, 0.0, 1e-7], [5.0, 1.0]),
            ([0.0, 0.0, 1e-4], [5.0, 1.0]),
            ([0.0, 0.0, 1.0], [0.0, 1.0]),
            ([f32::NAN, 0.0, 1.0], [1.0, 1.0]),
        ] {
            assert!(SphericalRectangle::new(Vec3A::from(center), size).is_none(), "{center:?} {size:?}");
        }
    }

    /// Numbers at the ends of their range give points of the rectangle, however extreme that is.
    #[test]
    fn points_are_always_finite() {
        for height in [1e-6, 1e-3, 1.0, 1e3] {
            for size in [[1.0, 1.0], [1e3, 1e-3], [1e4, 1e4]] {
                let Some(seen) = SphericalRectangle::new(Vec3A::new(0.1, -0.2, height), size) else { continue };
                for u in [0.0, 1e-7, 0.25, 0.5, 0.75, 1.0 - f32::EPSILON / 2.0] {
                    for v in [0.0, 0.5, 1.0 - f32::EPSILON / 2.0] {
                        let p = seen.point([u, v]);
                        assert!(p.is_finite(), "{height} {size:?} {u} {v}: {p}");
                    }
                }
            }
        }
    }
}
