//! Rays in places where tracers lose digits or take the wrong crossing, by the thousand.
//!
//! Each is a pure function of category, seed and index, and the same on every machine: only + − × ÷ √ are used. The
//! fate of a ray is not decided here; [`crate::exact`] finds it.

mod aim;
mod aspheres;
mod conics;
mod dice;

use crate::exact::Case;
use dice::Dice;

/// The property that makes a ray hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Category {
    /// No hardship: conics as lenses have them, within and a little beyond the rim. The group to compare with.
    Ordinary,
    /// Out of the denser medium, sin i within 1e-15 to 1e-1 of critical, relative; a third of the surfaces are planes.
    NearCritical,
    /// Past ellipsoids, 1e-15 to 1e-1 of the radius inside or outside of a tangent.
    Tangent,
    /// A = c (1 + k Dz²) near 0: paraboloids along the axis, hyperboloids along their asymptotes.
    NoLeadingTerm,
    /// Aimed at a hyperboloid's second sheet or at the far half of an ellipsoid.
    FarSheet,
    /// |k| from 1e-3 to 1e6, of both signs.
    ConicConstant,
    /// |R| from 1e-3 to 1e15 mm.
    Radius,
    /// Rays from 0 to 1e10 mm away.
    FarStart,
    /// Indices that differ by 1e-15 to 1e-1, relative, up to grazing.
    NearIndex,
    /// |R| from 1e-4 to 1e-2 mm.
    MicroLens,
    /// |R| from 1e3 to 1e5 mm.
    MetreLens,
    /// Mirrors: spheres, paraboloids, hyperboloids, ellipsoids.
    Mirror,
    /// The rear face of a ball, from the ball's own front.
    BallRear,
    /// Rays from the surface itself, or a few roundings off it.
    OnSurface,
    /// Hits within 1e-15 to 1e-3, relative, of the rim, of a central obstruction, or of a conic's own end.
    Rim,
    /// Rays from the film to the scene: side −1, Dz < 0.
    Backward,
    /// Side +1 and Dz < 0: a fisheye's front.
    BeyondRightAngle,
    /// Aspheres as lenses have them, powers to 20, crossed once.
    Asphere,
    /// Aspheres that depart from their conic by up to a fifth of their half diameter, crossed once.
    StrongAsphere,
    /// Toroids, a third of them with an aspheric profile, crossed once.
    Toroid,
    /// Cylinders along x or y, a third of those along x with an aspheric profile, crossed once.
    Cylinder,
}

impl Category {
    /// Every category, the one to compare with first.
    pub const ALL: [Self; 21] = [
        Self::Ordinary,
        Self::NearCritical,
        Self::Tangent,
        Self::NoLeadingTerm,
        Self::FarSheet,
        Self::ConicConstant,
        Self::Radius,
        Self::FarStart,
        Self::NearIndex,
        Self::MicroLens,
        Self::MetreLens,
        Self::Mirror,
        Self::BallRear,
        Self::OnSurface,
        Self::Rim,
        Self::Backward,
        Self::BeyondRightAngle,
        Self::Asphere,
        Self::StrongAsphere,
        Self::Toroid,
        Self::Cylinder,
    ];

    /// The word for the category in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ordinary => "ordinary",
            Self::NearCritical => "near-critical",
            Self::Tangent => "tangent",
            Self::NoLeadingTerm => "no-leading-term",
            Self::FarSheet => "far-sheet",
            Self::ConicConstant => "conic-constant",
            Self::Radius => "radius",
            Self::FarStart => "far-start",
            Self::NearIndex => "near-index",
            Self::MicroLens => "micro-lens",
            Self::MetreLens => "metre-lens",
            Self::Mirror => "mirror",
            Self::BallRear => "ball-rear",
            Self::OnSurface => "on-surface",
            Self::Rim => "rim",
            Self::Backward => "backward",
            Self::BeyondRightAngle => "beyond-right-angle",
            Self::Asphere => "asphere",
            Self::StrongAsphere => "strong-asphere",
            Self::Toroid => "toroid",
            Self::Cylinder => "cylinder",
        }
    }

    /// Ray number `index` of this category. Every number of it is finite and the direction is of unit length, rounded.
    pub fn case(self, seed: u64, index: u64) -> Case {
        let dice = &mut Dice::new(seed, self as u64, index);
        match self {
            Self::Ordinary => conics::ordinary(dice),
            Self::NearCritical => conics::near_critical(dice),
            Self::Tangent => conics::tangent(dice),
            Self::NoLeadingTerm => conics::no_leading_term(dice),
            Self::FarSheet => conics::far_sheet(dice),
            Self::ConicConstant => conics::conic_constant(dice),
            Self::Radius => conics::radius(dice),
            Self::FarStart => conics::far_start(dice),
            Self::NearIndex => conics::near_index(dice),
            Self::MicroLens => conics::of_size(dice, 1e-4, 1e-2),
            Self::MetreLens => conics::of_size(dice, 1e3, 1e5),
            Self::Mirror => conics::mirror(dice),
            Self::BallRear => conics::ball_rear(dice),
            Self::OnSurface => conics::on_surface(dice),
            Self::Rim => conics::rim(dice),
            Self::Backward => conics::backward(dice),
            Self::BeyondRightAngle => conics::beyond_right_angle(dice),
            Self::Asphere => aspheres::asphere(dice, 0.02),
            Self::StrongAsphere => aspheres::asphere(dice, 0.2),
            Self::Toroid => aspheres::toroid(dice),
            Self::Cylinder => aspheres::cylinder(dice),
        }
    }
}

#[cfg(test)]
mod tests;
