//! Directions of view, and the rays of each.

use glam::{DVec2, DVec3};

use crate::trace::Ray;

/// A direction of view. Its rays are told apart by where they cross the plane at right angles to it through the first
/// vertex.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Direction of the light.
    pub along: DVec3,
    across: DVec3,
    up: DVec3,
}

impl Field {
    /// Light that comes from `angle_rad` beside the axis and goes towards `azimuth`, a unit vector of x and y.
    pub fn new(angle_rad: f64, [x, y]: [f64; 2]) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        Self {
            along: DVec3::new(sin * x, sin * y, cos),
            across: DVec3::new(y, -x, 0.0),
            up: DVec3::new(cos * x, cos * y, -sin),
        }
    }

    /// A place in the plane, mm: along `across`, and towards the azimuth.
    pub fn point(&self, at: DVec2) -> DVec3 {
        self.across * at.x + self.up * at.y
    }

    /// The coordinates of a place in the plane.
    pub fn coordinates(&self, place: DVec3) -> DVec2 {
        DVec2::new(place.dot(self.across), place.dot(self.up))
    }
}

/// The source of the rays of fields.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// The object plane, lens space, mm; `None`: at infinity.
    pub object_z_mm: Option<f64>,
    /// The entrance pupil, towards whose middle a field is counted.
    pub pupil_z_mm: f64,
}

impl Origin {
    /// The ray of `field` that crosses its plane at `at`.
    pub fn ray(&self, field: &Field, at: DVec2) -> Ray {
        let target = field.point(at);
        let Some(object_z) = self.object_z_mm else { return Ray { origin: target, direction: field.along } };
        let pupil = DVec3::new(0.0, 0.0, self.pupil_z_mm);
        let origin = pupil - field.along * ((self.pupil_z_mm - object_z) / field.along.z);
        Ray { origin, direction: (target - origin).normalize_or(DVec3::Z) }
    }

    /// The point at which the ray of `field` through a place crosses its plane.
    pub fn crossing(&self, field: &Field, place: DVec3) -> DVec2 {
        let Ray { origin, direction } = self.ray(field, DVec2::ZERO);
        let way = if self.object_z_mm.is_some() { place - origin } else { direction };
        field.coordinates(place - way * (place.dot(field.along) / way.dot(field.along)))
    }
}
