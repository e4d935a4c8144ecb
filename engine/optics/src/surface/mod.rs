//! The shapes of optical surfaces: where a ray meets one, and the normal there.
//!
//! Coordinates are those of the surface: the origin at its vertex, z along the axis. Nothing here knows of
//! glass; callers are the tracer and the surface tests.

mod conic;

pub(crate) use conic::CANCELLED;
pub use conic::{Conic, Hit};

/// Why a ray got no farther than a surface. A lost ray is a result, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Failure {
    /// The ray passes by the surface.
    Missed,
    /// The ray meets the mathematical surface, but only on the part that is not the lens: a hyperboloid's second
    /// sheet, the far half of an ellipsoid.
    WrongSheet,
    /// The hit lies outside of the clear aperture.
    OutsideAperture,
    /// The hit lies inside of a central obstruction.
    Obstructed,
    /// The hit lies on the closed part of the diaphragm.
    BladeStop,
    /// Total internal reflection.
    TotalInternalReflection,
    /// An iteration found no hit within its bound of steps.
    NotConverged,
}

impl Failure {
    /// The word for it in tables and on the command line.
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
