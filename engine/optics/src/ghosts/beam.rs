//! All light of a small source that may enter a lens: rays that cover a disc before the front glass.

use glam::{DVec2, DVec3};

use crate::system::System;
use crate::trace::Ray;

/// A source without size, lens space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A source very far away in this direction: a unit vector from the lens.
    Far(DVec3),
    /// A source at this place, mm.
    Near(DVec3),
}

impl Source {
    /// The source moved across by angles as they are seen from about the lens, rad.
    #[must_use]
    pub fn moved(self, [right, up]: [f64; 2]) -> Self {
        match self {
            Self::Far(towards) => {
                let (x, y) = towards.any_orthonormal_pair();
                Self::Far((towards + x * right + y * up).normalize())
            }
            Self::Near(place) => {
                let (x, y) = place.normalize_or(DVec3::NEG_Z).any_orthonormal_pair();
                Self::Near(place + (x * right + y * up) * place.length())
            }
        }
    }
}

/// The rays of a source to a lens.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    source: Source,
    /// Centre of a disc at right angles to the beam's middle ray that holds the front glass.
    centre: DVec3,
    axes: [DVec3; 2],
    radius_mm: f64,
}

impl Beam {
    /// The beam from a source to the front glass; `None` where the source lies in it.
    pub fn new(system: &System, source: Source) -> Option<Self> {
        let first = &system.surfaces()[0];
        let sag = first.shape.rim_sag_mm(first.semi_diameter_mm).unwrap_or(0.0);
        let centre = DVec3::new(0.0, 0.0, first.z_mm + 0.5 * sag);
        // Decentred glass moves within its own rim's width.
        let whole = if system.is_rotationally_symmetric() { 1.0 } else { 1.2 };
        let radius = first.semi_diameter_mm.hypot(0.5 * sag) * whole;
        let towards = match source {
            Source::Far(towards) => towards.normalize_or_zero(),
            Source::Near(place) => (place - centre).normalize_or_zero(),
        };
        // Seen from near, the ball about the glass is wider than its disc.
        let radius_mm = match source {
            Source::Far(_) => radius,
            Source::Near(place) => {
                let (distance, ball) = (place.distance(centre), radius);
                if distance <= 1.05 * ball {
                    return None;
                }
                ball * distance / (distance * distance - ball * ball).sqrt()
            }
        };
        if towards == DVec3::ZERO || !radius_mm.is_finite() {
            return None;
        }
        let (x, y) = towards.any_orthonormal_pair();
        Some(Self { source, centre, axes: [x, y], radius_mm })
    }

    /// The ray through a point of the disc, given in radii; it starts before the lens.
    #[inline]
    pub fn ray(&self, at: DVec2) -> Ray {
        let point = self.point(at);
        match self.source {
            Source::Far(towards) => Ray { origin: point + towards * (4.0 * self.radius_mm), direction: -towards },
            Source::Near(place) => Ray { origin: place, direction: (point - place).normalize() },
        }
    }

    fn point(&self, at: DVec2) -> DVec3 {
        self.centre + (self.axes[0] * at.x + self.axes[1] * at.y) * self.radius_mm
    }

    /// The light through an element of the disc about a point, for one of irradiance in the disc's middle and for an element
    /// of the size one in radii squared: mm².
    #[inline]
    pub fn light_mm2(&self, at: DVec2) -> f64 {
        let falloff = match self.source {
            Source::Far(_) => 1.0,
            Source::Near(place) => {
                let (middle, here) = (place.distance(self.centre), place.distance(self.point(at)));
                (middle / here).powi(3)
            }
        };
        falloff * self.radius_mm * self.radius_mm
    }

    /// The middle of the disc: where the irradiance is counted, lens space, mm.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }
}
