//! Planes, spheres and conicoids of revolution: c (x² + y² + (1 + k) z²) − 2 z = 0.

use super::Crossing;
use crate::lane::{Lane, Mask, Real};
use crate::vector::Vector;

/// A conicoid of revolution in vertex form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conic<R = f64> {
    /// Curvature c = 1 / R in 1/mm; 0 is a plane, positive has its centre on the +z side.
    pub curvature: R,
    /// Conic constant k = −e²: 0 a sphere, −1 a paraboloid, below −1 a hyperboloid, above 0 oblate.
    pub conic: R,
}

/// The part of B² below which the discriminant B² − A C is formed again without the rounding of its products.
/// Larger costs time, smaller loses digits at grazing incidence.
const CANCELLED: f64 = 1e-2;

/// Conic constants of a larger size cost digits, about their root in units in the last place. Larger loses them,
/// smaller costs two roots and three divisions.
const ECCENTRIC: f64 = 16.0;
/// Least w² for which w is good to a rounding or two from r.
const FAR_FROM_THE_END: f64 = 0.002;
/// Least cos² i for which N · D is good to some roundings.
const GRAZING: f64 = 1e-2;

impl Conic {
    /// A conicoid of curvature 1 / `radius_mm` (radius 0 or infinite: a plane) and conic constant `conic`.
    pub fn new(radius_mm: f64, conic: f64) -> Self {
        let curvature = if radius_mm == 0.0 { 0.0 } else { 1.0 / radius_mm };
        Self { curvature, conic }
    }

    /// Sag z in mm at `radius_mm` from the axis; `None` where the surface does not reach.
    pub fn sag_mm(&self, radius_mm: f64) -> Option<f64> {
        let c = self.curvature;
        let inside = 1.0 - (1.0 + self.conic) * c * c * radius_mm * radius_mm;
        (inside >= 0.0).then(|| c * radius_mm * radius_mm / (1.0 + inside.sqrt()))
    }

    /// This shape, `factor` times as large.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { curvature: self.curvature / factor, ..*self }
    }

    /// This conicoid in numbers of another kind.
    pub(super) fn cast<R: Real>(&self) -> Conic<R> {
        Conic { curvature: R::from_f64(self.curvature), conic: R::from_f64(self.conic) }
    }
}

/// The terms of A t² + 2 B t + C = 0, and half of its discriminant.
struct Quadratic<L> {
    a: L,
    b: L,
    c: L,
    q: L,
}

impl<R: Real> Conic<R> {
    /// See [`super::Shape::meet`].
    ///
    /// With A = c (1 + k Dz²), B = c (P·D + k Pz Dz) − Dz, C = c (P·P + k Pz²) − 2 Pz and q = B² − A C, the
    /// crossing with N · D = s √q is t = C / (−B + s √q) = (−B − s √q) / A; of the two forms the one whose terms
    /// do not cancel is taken. The first serves planes and paraboloids along the axis, where A = 0; the second
    /// the rear face of a ball, where the first is 0 / 0.
    #[inline(always)]
    pub(super) fn meet<L: Lane<Real = R>>(&self, p: Vector<L>, d: Vector<L>, side: R) -> Crossing<L> {
        let (c, k) = (self.curvature, self.conic);
        let is_sphere = k == R::ZERO;
        let (mut a, mut along, mut across) = (d.z.like(c), p.dot(d), p.length_squared());
        if !is_sphere {
            a = (d.z * d.z * k + R::ONE) * c;
            along = along + p.z * d.z * k;
            across = across + p.z * p.z * k;
        }
        let b = along * c - d.z;
        let cc = across * c - (p.z + p.z);
        let b_squared = b * b;
        let mut q = b_squared - a * cc;
        let mut cosine = q.sqrt();
        let mut t = cc / (cosine * side - b);
        let zero = b.like(R::ZERO);
        let is_usual = q.greater(b_squared * R::from_f64(CANCELLED)) & (b * side).less(zero);
        if !is_usual.all() {
            (q, t) = Quadratic { a, b, c: cc, q }.solve_with_care(side);
            cosine = q.sqrt();
        }
        let point = p + d * t;
        let normal = Vector { x: point.x * -c, y: point.y * -c, z: -(point.z * (c + k * c) - R::ONE) };
        // 1 − k c² r² is the same and loses its digits at the rim of a huge conic.
        let normal_squared = if is_sphere { zero + R::ONE } else { normal.length_squared() };
        // Written so that NaN, too, is a miss.
        let is_crossed = q.at_least(zero) & t.is_finite();
        let crossing = Crossing {
            t,
            point,
            normal,
            normal_squared,
            cosine_squared: q,
            cosine,
            met: is_crossed & normal.z.at_least(zero),
            wrong_sheet: is_crossed & normal.z.less(zero),
            not_converged: zero.less(zero),
        };
        if Lane::abs(k) > R::from_f64(ECCENTRIC) { self.polished(&crossing, p, d, side) } else { crossing }
    }
}

impl<R: Real> Conic<R> {
    /// z and N's z at the distance r from the axis: c r² / (1 + w) and w = √(1 − (1 + k) c² r²), and w².
    #[inline(always)]
    fn at_radius<L: Lane<Real = R>>(&self, at: Vector<L>) -> (L, L, L) {
        let (c, k) = (self.curvature, self.conic);
        let squared = at.x * at.x + at.y * at.y;
        let w_squared = -(squared * ((c + k * c) * c) - R::ONE);
        let w = w_squared.sqrt();
        (squared * c / (w + R::ONE), w, w_squared)
    }

    /// A crossing of a strongly eccentric conicoid with the digits that its terms of size |k| have taken.
    ///
    /// Such a surface is nearly a plane or a cone: its z says much less of the ray than the ray's own rounding. One step
    /// of Newton on z − sag(r) mends t; z, normal and cosine then come from r. Not where the ray grazes, nor near the
    /// end of an ellipsoid, where r says little of w.
    #[inline(always)]
    fn polished<L: Lane<Real = R>>(&self, at: &Crossing<L>, p: Vector<L>, d: Vector<L>, side: R) -> Crossing<L> {
        let normal_at =
            |point: Vector<L>, w: L| Vector { x: point.x * -self.curvature, y: point.y * -self.curvature, z: w };
        let (sag, w, w_squared) = self.at_radius(at.point);
        let normal = normal_at(at.point, w);
        let slope = normal.dot(d);
        let is_steep = (slope * slope).greater(normal.length_squared() * R::from_f64(GRAZING));
        let is_mended = at.met & w_squared.greater(w.like(R::from_f64(FAR_FROM_THE_END))) & is_steep;
        let t = at.t - (at.point.z - sag) * w / slope;
        let on_ray = p + d * t;
        let (sag, w, _) = self.at_radius(on_ray);
        let point = Vector { z: sag, ..on_ray };
        let normal = normal_at(point, w);
        let cosine = normal.dot(d) * side;
        Crossing {
            t: L::select(is_mended, t, at.t),
            point: Vector::select(is_mended, point, at.point),
            normal: Vector::select(is_mended, normal, at.normal),
            normal_squared: L::select(is_mended, normal.length_squared(), at.normal_squared),
            cosine_squared: L::select(is_mended, cosine * cosine, at.cosine_squared),
            cosine: L::select(is_mended, cosine, at.cosine),
            ..*at
        }
    }
}

impl<L: Lane> Quadratic<L> {
    /// The discriminant and the root, where products or terms may cancel.
    #[cold]
    #[inline(never)]
    fn solve_with_care(&self, side: L::Real) -> (L, L) {
        let Self { a, b, c, q } = *self;
        let zero = b.like(L::Real::ZERO);
        let is_cancelled = q.less(b * b * L::Real::from_f64(CANCELLED));
        let q = L::select(is_cancelled, L::difference_of_products(b, b, a, c), q);
        let root = q.sqrt() * side;
        // Where q is 0, perhaps because it is too small a number, C and B may be rounding alone: B / A is not.
        let agree = (b * side).less(zero) & !q.at_most(zero);
        (q, L::select(agree, c, -b - root) / L::select(agree, root - b, a))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;
    use glam::DVec3;

    fn hit(shape: Conic, origin: DVec3) -> Crossing<f64> {
        Shape::Conic(shape).intersect(Vector::from_f64(origin), Vector::from_f64(DVec3::Z), 1.0).unwrap()
    }

    #[test]
    fn a_sphere_is_hit_on_its_near_side() {
        let hit = hit(Conic::new(50.0, 0.0), DVec3::new(30.0, 0.0, -100.0));
        assert!((hit.point.z - 10.0).abs() < 1e-14);
        assert!((hit.cosine_squared - 0.64).abs() < 1e-15);
    }

    #[test]
    fn the_sag_is_where_the_ray_lands() {
        for (radius, conic) in [(50.0, 0.0), (-30.0, -1.0), (12.0, -4.0), (80.0, 2.0), (0.0, 0.0)] {
            let surface = Conic::new(radius, conic);
            let hit = hit(surface, DVec3::new(0.0, 7.0, -20.0));
            assert!((hit.point.z - surface.sag_mm(7.0).unwrap()).abs() < 1e-14);
        }
        assert_eq!(Conic::new(5.0, 0.0).sag_mm(6.0), None);
    }

    #[test]
    fn the_rear_of_a_ball_is_found_from_its_own_surface() {
        let hit = hit(Conic::new(-5.0, 0.0), DVec3::new(0.0, 0.0, -10.0));
        assert!(hit.point.length_squared() < 1e-30);
    }

    #[test]
    fn no_ray_yields_a_number_that_is_none() {
        let bad = [f64::NAN, f64::INFINITY, 0.0, 1e300, -1e-300];
        for x in bad {
            for z in bad {
                let origin = Vector { x, y: 0.0, z };
                if let Ok(hit) = Shape::conic(10.0, 0.3).intersect(origin, Vector::from_f64(DVec3::Z), 1.0) {
                    assert!(hit.point.of(0).is_finite() && hit.normal.of(0).is_finite());
                }
            }
        }
    }
}
