//! One ray at one surface: for tests, tables and users who want to see a single refraction.

mod printed;

use glam::DVec3;

use crate::interface::{Interface, reflect};
use crate::lane::Real;
use crate::surface::{Failure, Shape};
use crate::vector::Vector;

/// A surface between two media, its vertex at the origin. Lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct SingleSurface {
    /// Shape of the surface.
    pub shape: Shape,
    /// sign(N · D) of the crossing that is meant, N towards +z at the vertex: +1 or −1.
    pub side: f64,
    /// Index of the medium that the ray comes from.
    pub from: f64,
    /// Index of the medium that it goes to; of no account for a mirror.
    pub to: f64,
    /// True if the surface reflects.
    pub is_mirror: bool,
    /// Half of the clear diameter, whose rim passes; infinite if there is none.
    pub semi_diameter_mm: f64,
    /// Half of the diameter of a central obstruction, whose rim passes; or 0.
    pub obstruction_mm: f64,
}

/// The hit of a ray on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray in mm.
    pub t_mm: f64,
    /// The point, in mm.
    pub point: DVec3,
    /// The unit normal, towards +z at the vertex.
    pub normal: DVec3,
}

/// The outcome of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The hit on the surface, if there is one; also of a ray that goes no farther.
    pub hit: Option<Hit>,
    /// The unit direction in which it goes on, or why it does not.
    pub direction: Result<DVec3, Failure>,
}

impl Outcome {
    fn lost(reason: Failure) -> Self {
        Self { hit: None, direction: Err(reason) }
    }
}

impl SingleSurface {
    /// Traces the ray `origin` + t `direction` (of any length but 0) in numbers `R`, by the tracer's own code.
    ///
    /// The ray is carried to its point nearest the vertex in f64, whatever `R` is, as in the tracer. All numbers of the outcome are finite,
    /// whatever was given: a hit beyond the numbers of `R` is missed, and media between which it has no refracted direction reflect.
    pub fn trace<R: Real>(&self, origin: DVec3, direction: DVec3) -> Outcome {
        let direction = direction.normalize();
        let carried = -origin.dot(direction);
        let p = Vector::<R>::from_f64(origin + direction * carried);
        let d = Vector::<R>::from_f64(direction);
        let side = R::from_f64(self.side);
        let at = match self.shape.cast::<R>().intersect(p, d, side) {
            Ok(at) => at,
            Err(reason) => return Outcome::lost(reason),
        };
        let unit = at.normal.of(0) / at.normal_squared.to_f64().sqrt();
        let hit = Hit { t_mm: carried + at.t.to_f64(), point: at.point.of(0), normal: unit };
        if !(hit.t_mm.is_finite() && hit.normal.is_finite()) {
            return Outcome::lost(Failure::Missed);
        }
        let squared = at.point.x * at.point.x + at.point.y * at.point.y;
        let direction = match self.let_through(squared) {
            Err(reason) => Err(reason),
            Ok(()) if self.is_mirror => Ok(reflect(d, &at, side)),
            Ok(()) if self.from == self.to => Ok(d),
            Ok(()) => match Interface::new(self.from, self.to).cast().refract(d, &at, side) {
                (direction, true) => Ok(direction),
                (_, false) => Err(Failure::TotalInternalReflection),
            },
        };
        match direction.map(|d| d.of(0)) {
            Ok(direction) if direction.is_finite() => Outcome { hit: Some(hit), direction: Ok(direction) },
            Ok(_) if self.is_mirror => Outcome::lost(Failure::Missed),
            Ok(_) => Outcome { hit: Some(hit), direction: Err(Failure::TotalInternalReflection) },
            Err(reason) => Outcome { hit: Some(hit), direction: Err(reason) },
        }
    }

    /// Traces the ray by the equations that the paper prints; `None` if it has none for this shape.
    ///
    /// The equations are there for comparison: see docs/numerics.md.
    pub fn trace_as_printed(&self, origin: DVec3, direction: DVec3) -> Option<Outcome> {
        match &self.shape {
            Shape::Conic(conic) => Some(printed::trace(self, conic, origin, direction)),
            _ => None,
        }
    }

    /// Checks the clear aperture and the obstruction for a hit at this squared distance from the axis.
    fn let_through<R: Real>(&self, squared: R) -> Result<(), Failure> {
        let [clear, dark] = [self.semi_diameter_mm, self.obstruction_mm].map(|r| R::from_f64(r * r));
        // Written so that NaN, too, is outside.
        if !(squared <= clear) {
            return Err(Failure::OutsideAperture);
        }
        if squared < dark { Err(Failure::Obstructed) } else { Ok(()) }
    }
}
