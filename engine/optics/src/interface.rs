//! What an interface between two media does to the direction of a ray.
//!
//! Directions are unit vectors; the normal need not be: it comes with its squared length and with (N · D)², as
//! [`crate::surface::Hit`] holds them.

use glam::DVec3;

use crate::surface::{Failure, Hit};

/// The two media of a refracting interface, as seen by a ray that crosses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Relative index m = n / n′, from the medium that the ray leaves to the one that it enters.
    pub ratio: f64,
    /// m² − 1, formed from the difference of the indices so that it keeps its digits when they are near.
    pub excess: f64,
}

impl Interface {
    /// From index `from` to index `to`.
    pub fn new(from: f64, to: f64) -> Self {
        let excess = (from - to) * (from + to) / (to * to);
        Self { ratio: from / to, excess }
    }

    /// The refracted unit direction of the ray `direction` that met the surface from `side`.
    ///
    /// D′ = m D − s (m² − 1) N / (√r + m √q), with q = (N · D)² and r = m² q − (m² − 1) |N|². This is Snell's
    /// law in vector form, D′ = m D + s (√r − m √q) N / |N|², without its cancellation between near indices.
    #[inline(always)]
    pub fn refract(&self, direction: DVec3, hit: &Hit, side: f64) -> Result<DVec3, Failure> {
        let m = self.ratio;
        let incident_squared = m * m * hit.cosine_squared;
        let mut radicand = incident_squared - self.excess * hit.normal_squared;
        if radicand < NEAR_CRITICAL * incident_squared {
            radicand = self.radicand_near_critical(hit);
        }
        if !(radicand >= 0.0) {
            return Err(Failure::TotalInternalReflection);
        }
        let bend = side * self.excess / (radicand.sqrt() + m * hit.cosine_squared.sqrt());
        Ok(direction * m - hit.normal * bend)
    }

    /// (m cos i − w) (m cos i + w) |N|², w = √(m² − 1): the radicand without the rounding of squares.
    #[cold]
    fn radicand_near_critical(&self, hit: &Hit) -> f64 {
        let incident = self.ratio * hit.cosine_squared.sqrt();
        let critical = (self.excess * hit.normal_squared).sqrt();
        (incident - critical) * (incident + critical)
    }
}

/// Below this part of (m cos i)², the radicand is formed in factors. Larger costs time, smaller loses digits.
pub(crate) const NEAR_CRITICAL: f64 = 1e-2;

/// The reflected unit direction: D − 2 (N · D) N / |N|².
#[inline(always)]
pub fn reflect(direction: DVec3, hit: &Hit, side: f64) -> DVec3 {
    let twice = 2.0 * side * hit.cosine_squared.sqrt() / hit.normal_squared;
    direction - hit.normal * twice
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Conic;

    fn at_plane(angle: f64) -> (DVec3, Hit) {
        let direction = DVec3::new(0.0, angle.sin(), angle.cos());
        let hit = Conic::new(0.0, 0.0).intersect(DVec3::new(0.0, 0.0, -1.0), direction, 1.0).unwrap();
        (direction, hit)
    }

    #[test]
    fn sines_are_in_the_ratio_of_the_indices() {
        for angle in [0.0, 0.1, 0.7, 1.5] {
            let (direction, hit) = at_plane(angle);
            let out = Interface::new(1.0, 1.5).refract(direction, &hit, 1.0).unwrap();
            assert!((out.y * 1.5 - angle.sin()).abs() < 1e-15);
            assert!((out.length() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn beyond_the_critical_angle_light_turns_back() {
        let critical = (1.0f64 / 1.5).asin();
        for (part, passes) in [(1.0 - 1e-12, true), (1.0 + 1e-12, false)] {
            let (direction, hit) = at_plane(critical * part);
            assert_eq!(Interface::new(1.5, 1.0).refract(direction, &hit, 1.0).is_ok(), passes);
        }
    }

    #[test]
    fn a_mirror_keeps_the_angle() {
        let (direction, hit) = at_plane(0.4);
        let out = reflect(direction, &hit, 1.0);
        assert!((out - DVec3::new(0.0, 0.4f64.sin(), -(0.4f64.cos()))).length() < 1e-15);
    }
}
