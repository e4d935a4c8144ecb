//! Cylinders and toroids, as anamorphic lenses have them.

use super::asphere::{AsphereProfile, at_root, size};
use super::iterate::{Along, Profiled, rising_root};
use super::{Asphere, Conic, Crossing};
use crate::lane::{Lane, Real};
use crate::vector::Vector;

/// A profile z = g(y) in the y-z plane, turned about the line parallel to y at z = 1 / c across the axis.
///
/// A toroid with curvature c = 0 across is a cylinder along x; with a flat profile it is one along y. On the surface z
/// − g − c (x² + z² − g²) / 2 = 0, which needs no limit at c = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toroid<R = f64> {
    /// g, as a function of |y|.
    pub profile: Asphere<R>,
    /// Curvature in the x-z plane, in 1/mm.
    pub across: R,
}

impl Toroid {
    /// Sag z in mm at (x, y); `None` where the surface does not reach.
    pub fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let g = self.profile.sag_mm(y_mm.abs())?;
        // z of a circle of radius 1 / c − g about z = 1 / c.
        let squared = (1.0 - self.across * g).powi(2) - (self.across * x_mm).powi(2);
        (squared >= 0.0).then(|| {
            let rise = g * (2.0 - self.across * g) + self.across * x_mm * x_mm;
            rise / (1.0 + squared.sqrt())
        })
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { profile: self.profile.scaled(factor), across: self.across / factor }
    }

    pub(super) fn cast<R: Real>(&self) -> Toroid<R> {
        Toroid { profile: self.profile.cast(), across: R::from_f64(self.across) }
    }
}

impl<R: Real> Toroid<R> {
    /// See [`super::Shape::meet`]: Newton's method from the hit of a quadric of the same curvatures.
    #[inline(always)]
    pub(super) fn meet<L: Lane<Real = R>>(&self, p: Vector<L>, d: Vector<L>, side: R) -> Crossing<L> {
        let start = self.hit_of_quadric(p, d, side);
        let root = rising_root(start, side, size(p, start), &RayToToroid { shape: self, p, d });
        let point = p + d * root.t;
        let normal = self.gradient(point, &self.profile.profile(point.y * point.y));
        let mut crossing = at_root(root, point, normal, d, side);
        crossing.wrong_sheet = root.converged & normal.z.less(start.like(R::ZERO));
        crossing
    }

    /// The gradient of the surface's function, times the profile's weight.
    #[inline(always)]
    fn gradient<L: Lane<Real = R>>(&self, at: Vector<L>, profile: &AsphereProfile<L>) -> Vector<L> {
        let c = self.across;
        let AsphereProfile { sag, weight, slope } = *profile;
        Vector { x: -(at.x * c * weight), y: at.y * slope * (sag * c - R::ONE), z: -((at.z * c - R::ONE) * weight) }
    }

    /// t where the ray crosses the quadric of the same curvatures at the vertex; 0 where it does not.
    #[inline(always)]
    fn hit_of_quadric<L: Lane<Real = R>>(&self, p: Vector<L>, d: Vector<L>, side: R) -> L {
        let Conic { curvature: cy, conic: k } = self.profile.base;
        let cx = self.across;
        // Exact for a cylinder along x and, with a flat profile, along y.
        let (y, x) = (cy + cy * k, cx);
        let is_plain = cx == R::ZERO || cy == R::ZERO;
        let cz = (x + y) * R::from_f64(if is_plain { 1.0 } else { 0.5 });
        let curved = Vector { x: d.x * cx, y: d.y * cy, z: d.z * cz };
        let a = curved.dot(d);
        let b = curved.dot(p) - d.z;
        let c = p.x * p.x * cx + p.y * p.y * cy + p.z * p.z * cz - (p.z + p.z);
        let zero = a.like(R::ZERO);
        let q = b * b - a * c;
        let t = c / (q.most(zero).sqrt() * side - b);
        let is_hit = q.at_least(zero) & t.is_finite();
        L::select(is_hit, t, zero)
    }
}

struct RayToToroid<'a, L: Lane> {
    shape: &'a Toroid<L::Real>,
    p: Vector<L>,
    d: Vector<L>,
}

impl<L: Lane> Profiled<L> for RayToToroid<'_, L> {
    #[inline(always)]
    fn along(&self, t: L) -> Along<L> {
        let half = L::Real::from_f64(0.5) * self.shape.across;
        let at = self.p + self.d * t;
        let profile = self.shape.profile.profile(at.y * at.y);
        let AsphereProfile { sag, weight, .. } = profile;
        let bent = (at.x * at.x + at.z * at.z) * half;
        Along {
            value: (at.z - sag - (bent - sag * sag * half)) * weight,
            slope: self.shape.gradient(at, &profile).dot(self.d),
            terms: (at.z.abs() + sag.abs() + bent.abs()) * weight,
        }
    }
}
