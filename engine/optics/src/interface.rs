//! Refraction and reflection of a ray's direction at an interface between two media.
//!
//! Directions are unit vectors; the normal need not be: it comes with its squared length and with (N · D)², as
//! [`crate::surface::Crossing`] holds them.

use crate::lane::{Lane, Mask, Real};
use crate::surface::Crossing;
use crate::vector::Vector;

/// The two media of a refracting interface, as seen by a ray that crosses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface<R = f64> {
    /// Relative index m = n / n′, from the medium that the ray leaves to the one that it enters.
    pub ratio: R,
    /// m² − 1, formed from the difference of the indices so that it keeps its digits when they are near.
    pub excess: R,
}

/// The part of (m cos i)² below which the radicand is formed in factors. Larger costs time, smaller loses digits.
const NEAR_CRITICAL: f64 = 1e-2;

impl Interface {
    /// The interface from index `from` to index `to`.
    pub fn new(from: f64, to: f64) -> Self {
        let excess = (from - to) * (from + to) / (to * to);
        Self { ratio: from / to, excess }
    }

    /// This interface in numbers of another kind.
    pub fn cast<R: Real>(&self) -> Interface<R> {
        Interface { ratio: R::from_f64(self.ratio), excess: R::from_f64(self.excess) }
    }
}

impl<R: Real> Interface<R> {
    /// The refracted unit directions of the rays `d` that hit the surface from `side`, and true where there is one: false
    /// means total internal reflection.
    ///
    /// D′ = m D − s (m² − 1) N / (√r + m √q), with q = (N · D)² and r = m² q − (m² − 1) |N|². This is Snell's
    /// law in vector form, D′ = m D + s (√r − m √q) N / |N|², without its cancellation between near indices.
    #[inline(always)]
    pub fn refract<L: Lane<Real = R>>(&self, d: Vector<L>, at: &Crossing<L>, side: R) -> (Vector<L>, L::Mask) {
        let lanes = Interfaces { ratio: d.x.like(self.ratio), excess: d.x.like(self.excess) };
        // Into the denser medium nothing is critical.
        lanes.refract(d, at, side, self.excess > R::ZERO)
    }
}

/// An interface at several wavelengths, one in each lane.
#[derive(Clone, Copy)]
pub struct Interfaces<L> {
    /// The ratio, as in [`Interface`].
    pub ratio: L,
    /// The excess, as in [`Interface`].
    pub excess: L,
}

impl<L: Lane> Interfaces<L> {
    /// The interfaces from one index to the other, in each lane.
    #[inline(always)]
    pub fn between([from, to]: [L; 2]) -> Self {
        Self { ratio: from / to, excess: (from - to) * (from + to) / (to * to) }
    }

    /// [`Interface::refract`] in lanes; `may_be_critical` if any excess is positive.
    #[inline(always)]
    pub fn refract(
        &self,
        d: Vector<L>,
        at: &Crossing<L>,
        side: L::Real,
        may_be_critical: bool,
    ) -> (Vector<L>, L::Mask) {
        let m = self.ratio;
        let incident_squared = at.cosine_squared * (m * m);
        let incident = at.cosine * m;
        let mut radicand = incident_squared - at.normal_squared * self.excess;
        if may_be_critical {
            let is_near = radicand.less(incident_squared * L::Real::from_f64(NEAR_CRITICAL));
            if is_near.any() {
                // (m cos i − w) (m cos i + w) |N|², w = √(m² − 1): without the rounding of squares.
                let critical = (at.normal_squared * self.excess).sqrt();
                radicand = L::select(is_near, (incident - critical) * (incident + critical), radicand);
            }
        }
        let passes = radicand.at_least(incident.like(L::Real::ZERO));
        let bend = self.excess * side / (radicand.sqrt() + incident);
        let n = at.normal;
        let bent = Vector { x: d.x * m - n.x * bend, y: d.y * m - n.y * bend, z: d.z * m - n.z * bend };
        (bent, passes)
    }
}

/// The reflected unit directions: D − 2 (N · D) N / |N|².
#[inline(always)]
pub fn reflect<L: Lane>(d: Vector<L>, at: &Crossing<L>, side: L::Real) -> Vector<L> {
    let twice = at.cosine * (side + side) / at.normal_squared;
    d - at.normal * twice
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Shape;

    fn refracted(angle: f64, from: f64, to: f64) -> Option<Vector<f64>> {
        let direction = Vector { x: 0.0, y: angle.sin(), z: angle.cos() };
        let at = Shape::conic(0.0, 0.0).intersect(Vector { x: 0.0, y: 0.0, z: -1.0 }, direction, 1.0).unwrap();
        let (out, passes) = Interface::new(from, to).refract(direction, &at, 1.0);
        passes.then_some(out)
    }

    #[test]
    fn sines_are_in_the_ratio_of_the_indices() {
        for angle in [0.0, 0.1, 0.7, 1.5f64] {
            let out = refracted(angle, 1.0, 1.5).unwrap();
            assert!((out.y * 1.5 - angle.sin()).abs() < 1e-15);
            assert!((out.length_squared() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn beyond_the_critical_angle_light_turns_back() {
        let critical = (1.0f64 / 1.5).asin();
        for (part, passes) in [(1.0 - 1e-12, true), (1.0 + 1e-12, false)] {
            assert_eq!(refracted(critical * part, 1.5, 1.0).is_some(), passes);
        }
    }
    #[test]
    fn a_mirror_keeps_the_angle() {
        let direction = Vector { x: 0.0, y: 0.4f64.sin(), z: 0.4f64.cos() };
        let at = Shape::conic(0.0, 0.0).intersect(Vector { x: 0.0, y: 0.0, z: -1.0 }, direction, 1.0).unwrap();
        let out = reflect(direction, &at, 1.0);
        assert!((out.y - direction.y).abs() < 1e-15 && (out.z + direction.z).abs() < 1e-15);
    }
}
