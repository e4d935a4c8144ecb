//! The shapes of optical surfaces: where a ray hits one, and the normal there (Wu et al. 2011, §3.1 and §3.2.1).
//!
//! Coordinates are those of the surface: the origin at its vertex, z along its axis. Nothing here knows of glass or of
//! rims; callers are the tracer and the surface tests. Every shape is written once for all [`Lane`]s.

mod asphere;
mod conic;
mod iterate;
mod pose;
mod toroid;

use crate::lane::{Lane, Real};
use crate::vector::Vector;

pub use asphere::{Asphere, LAST_POWER};
pub use conic::Conic;
pub use pose::Pose;
pub use toroid::Toroid;

/// The reason why a ray got no farther than a surface. A lost ray is a result, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Failure {
    /// The ray passes by the surface.
    Missed,
    /// The ray hits the mathematical surface, but only on the part that is not the lens: a hyperboloid's second
    /// sheet, the far half of an ellipsoid.
    WrongSheet,
    /// The hit lies outside of the clear aperture.
    OutsideAperture,
    /// The hit lies inside of a central obstruction.
    Obstructed,
    /// The hit lies on the closed part of the diaphragm.
    BladeStop,
    /// Total internal reflection: the ray cannot leave the denser medium.
    TotalInternalReflection,
    /// An iteration found no hit within its bound of steps.
    NotConverged,
}

impl Failure {
    /// The word for the failure in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Missed => "missed",
            Self::WrongSheet => "wrong_sheet",
            Self::OutsideAperture => "outside_aperture",
            Self::Obstructed => "obstructed",
            Self::BladeStop => "blade_stop",
            Self::TotalInternalReflection => "tir",
            Self::NotConverged => "not_converged",
        }
    }
}

/// Hits of rays on a surface, one in each lane. The numbers of a lane that missed it are undefined.
#[derive(Clone, Copy)]
pub struct Crossing<L: Lane> {
    /// Distance along the ray from the origin that was given, in mm; negative if it lies behind.
    pub t: L,
    /// The hit, in mm from the vertex.
    pub point: Vector<L>,
    /// The normal, towards +z at the vertex; not of unit length.
    pub normal: Vector<L>,
    /// |N|², the square of the normal's length.
    pub normal_squared: L,
    /// (N · D)². For conicoids from the discriminant: exact where N · D itself would cancel.
    pub cosine_squared: L,
    /// |N · D| with the unit direction D of the ray: |N| times the cosine of incidence.
    pub cosine: L,
    /// True if the ray hits the surface with sign(N · D) = side.
    pub met: L::Mask,
    /// Lanes without a hit, for [`Failure::WrongSheet`].
    pub wrong_sheet: L::Mask,
    /// Lanes without a hit, for [`Failure::NotConverged`].
    pub not_converged: L::Mask,
}

/// A plane through the axis in which a lens without rotational symmetry is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// The plane of y and z.
    Y,
    /// The plane of x and z.
    X,
}

/// The shape of a surface. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<R = f64> {
    /// Planes, spheres and conicoids of revolution.
    Conic(Conic<R>),
    /// A conicoid and a polynomial of the distance from the axis.
    Asphere(Asphere<R>),
    /// A curve in the y-z plane, turned about a line parallel to y: cylinders and toroids.
    Toroid(Toroid<R>),
}

impl<R: Real> Shape<R> {
    /// The points at which the rays `origin` + t `direction` (unit) cross the surface with sign(N · D) = `side`, for
    /// rays that start near the vertex, measured in radii.
    ///
    /// `side` is +1 while light goes from the scene to the film, −1 on the way back, flipped by each mirror; it is
    /// not the sign of D's z. Negative t is right where the previous vertex lies behind.
    #[inline(always)]
    pub fn meet<L: Lane<Real = R>>(&self, origin: Vector<L>, direction: Vector<L>, side: R) -> Crossing<L> {
        match self {
            Self::Conic(shape) => shape.meet(origin, direction, side),
            Self::Asphere(shape) => shape.meet(origin, direction, side),
            Self::Toroid(shape) => shape.meet(origin, direction, side),
        }
    }

    /// [`Self::meet`] from any distance: the origin is first carried to its point nearest the vertex, which keeps the
    /// digits of far sources.
    #[inline(always)]
    pub fn meet_from_afar<L: Lane<Real = R>>(&self, origin: Vector<L>, direction: Vector<L>, side: R) -> Crossing<L> {
        let carried = -origin.dot(direction);
        let mut crossing = self.meet(origin + direction * carried, direction, side);
        crossing.t = crossing.t + carried;
        crossing
    }

    /// [`Self::meet_from_afar`] for one ray. A hit is finite.
    pub fn intersect(&self, origin: Vector<R>, direction: Vector<R>, side: R) -> Result<Crossing<R>, Failure> {
        let crossing = self.meet_from_afar(origin, direction, side);
        match crossing.met {
            true if crossing.point.length_squared().is_finite() => Ok(crossing),
            _ if crossing.wrong_sheet => Err(Failure::WrongSheet),
            _ if crossing.not_converged => Err(Failure::NotConverged),
            _ => Err(Failure::Missed),
        }
    }
}

impl Shape {
    /// A sphere or plane (radius 0 or infinite), or, with a conic constant, a conicoid of revolution.
    pub fn conic(radius_mm: f64, conic: f64) -> Self {
        Self::Conic(Conic::new(radius_mm, conic))
    }

    /// The shape of a conicoid with aspheric `terms` (power, coefficient) and a radius of curvature in the x-z plane;
    /// the simplest kind that holds it. A radius of 0 is flat, none is that of the y-z plane.
    pub fn from_numbers(base: Conic, terms: &[(u32, f64)], radius_x_mm: Option<f64>) -> Self {
        let profile = Asphere::new(base, terms);
        let has_terms = !profile.terms().is_empty();
        match radius_x_mm.map(|radius| Conic::new(radius, 0.0).curvature) {
            // A sphere written with both of its radii stays one.
            Some(across) if has_terms || base.conic != 0.0 || across != base.curvature => {
                Self::Toroid(Toroid { profile, across })
            }
            _ if has_terms => Self::Asphere(profile),
            _ => Self::Conic(base),
        }
    }

    /// The profile: the conicoid in the y-z plane and its polynomial.
    pub fn profile(&self) -> Asphere {
        match self {
            Self::Conic(conic) => Asphere::new(*conic, &[]),
            Self::Asphere(asphere) => *asphere,
            Self::Toroid(toroid) => toroid.profile,
        }
    }

    /// This shape on another conicoid.
    pub fn with_base(&self, base: Conic) -> Self {
        match *self {
            Self::Conic(_) => Self::Conic(base),
            Self::Asphere(asphere) => Self::Asphere(asphere.with_base(base)),
            Self::Toroid(toroid) => Self::Toroid(Toroid { profile: toroid.profile.with_base(base), ..toroid }),
        }
    }

    /// Sag z in mm at (x, y); `None` where the surface does not reach.
    pub fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        match self {
            Self::Conic(conic) => conic.sag_mm(x_mm.hypot(y_mm)),
            Self::Asphere(asphere) => asphere.sag_mm(x_mm.hypot(y_mm)),
            Self::Toroid(toroid) => toroid.sag_mm(x_mm, y_mm),
        }
    }

    /// The sag at `radius_mm` from the axis: of a toroid the larger of its two sections'.
    pub fn rim_sag_mm(&self, radius_mm: f64) -> Option<f64> {
        let [x, y] = [self.sag_mm(radius_mm, 0.0)?, self.sag_mm(0.0, radius_mm)?];
        Some(if x.abs() > y.abs() { x } else { y })
    }

    /// Distance from the axis that the surface reaches, in mm; infinite for most.
    pub fn reach_mm(&self) -> f64 {
        let profile = self.profile();
        let reach = |conic: &Conic| {
            let inside = (1.0 + conic.conic) * conic.curvature * conic.curvature;
            if inside > 0.0 { 1.0 / inside.sqrt() } else { f64::INFINITY }
        };
        let across = if let Self::Toroid(toroid) = self { 1.0 / toroid.across.abs() } else { f64::INFINITY };
        reach(&profile.base).min(across)
    }

    /// Curvature at the vertex in 1/mm.
    pub fn curvature_at_vertex(&self, section: Section) -> f64 {
        match (self, section) {
            (Self::Toroid(toroid), Section::X) => toroid.across,
            _ => self.profile().curvature_at_vertex(),
        }
    }

    /// 8 times the coefficient of r⁴ by which the sag departs from the sphere of the curvature at the vertex, in
    /// 1/mm³; k c³ for a conicoid. In the y-z plane.
    pub fn asphericity(&self) -> f64 {
        self.profile().asphericity()
    }

    /// Largest curvature of the surface anywhere near the axis, in 1/mm, against which distances count as far.
    pub(crate) fn steepness(&self) -> f64 {
        let profile = self.profile();
        let across = if let Self::Toroid(toroid) = self { toroid.across.abs() } else { 0.0 };
        (profile.base.curvature.abs() * (1.0 + profile.base.conic.abs())).max(across)
    }

    /// True if nothing changes when the surface is turned about its axis.
    pub fn is_rotationally_symmetric(&self) -> bool {
        !matches!(self, Self::Toroid(_))
    }

    /// This shape, `factor` times as large.
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Conic(conic) => Self::Conic(conic.scaled(factor)),
            Self::Asphere(asphere) => Self::Asphere(asphere.scaled(factor)),
            Self::Toroid(toroid) => Self::Toroid(toroid.scaled(factor)),
        }
    }

    /// This shape in numbers of another kind.
    pub fn cast<R: Real>(&self) -> Shape<R> {
        match self {
            Self::Conic(conic) => Shape::Conic(conic.cast()),
            Self::Asphere(asphere) => Shape::Asphere(asphere.cast()),
            Self::Toroid(toroid) => Shape::Toroid(toroid.cast()),
        }
    }

    /// True if all numbers of the shape are finite.
    pub fn is_finite(&self) -> bool {
        let across = if let Self::Toroid(toroid) = self { toroid.across } else { 0.0 };
        across.is_finite() && self.profile().is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Every shape that a sphere can be written as has the sphere's hits.
    #[test]
    fn a_sphere_by_any_name() {
        let sphere = Conic::new(40.0, 0.0);
        let shapes = [
            Shape::Conic(sphere),
            Shape::Asphere(Asphere::new(sphere, &[])),
            // The parabola's polynomial made up for: r^2 / 2R + r^4 / 8R^3 ..., to r^20.
            Shape::Asphere(Asphere::new(Conic::new(0.0, 0.0), &series(40.0))),
            Shape::Toroid(Toroid { profile: Asphere::new(sphere, &[]), across: 1.0 / 40.0 }),
        ];
        for (i, shape) in shapes.iter().enumerate() {
            for j in 0..100 {
                let angle = f64::from(j);
                let origin = DVec3::new(7.0 * angle.cos(), 6.0 * (1.7 * angle).sin(), -8.0);
                let direction = DVec3::new(0.2 * (0.3 * angle).sin(), 0.3 * angle.cos(), 1.0).normalize();
                let [origin, direction] = [origin, direction].map(Vector::from_f64);
                let meet = |shape: &Shape| shape.intersect(origin, direction, 1.0).map(|c| c.point.of(0)).unwrap();
                let error = (meet(shape) - meet(&shapes[0])).length();
                // The series ends at (r / R)^22: 3e-13 of R here.
                assert!(error < if i == 2 { 1e-9 } else { 1e-13 }, "shape {i}: {error:e}");
            }
        }
    }

    fn series(radius: f64) -> Vec<(u32, f64)> {
        // R (1 - sqrt(1 - x)), x = (r / R)^2: each coefficient (2 j - 1) / (2 j + 2) times the one before.
        let mut coefficient = 0.5 / radius;
        let mut terms = Vec::new();
        for j in 1..=10u32 {
            terms.push((2 * j, coefficient));
            coefficient *= f64::from(2 * j - 1) / f64::from(2 * j + 2) / (radius * radius);
        }
        terms
    }
}
