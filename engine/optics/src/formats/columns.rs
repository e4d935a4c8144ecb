//! The columns of a lens file after the usual six, and the surface that their numbers describe.

use glam::{DMat3, DVec3};

use crate::prescription::Place;
use crate::surface::{LAST_POWER, Pose};

use super::text::finite;

/// Columns that may follow, beside the coefficients.
pub(super) const OBSTRUCTION: &str = "obstruction";
pub(super) const RADIUS_X: &str = "radius_x";
/// Thin films, by name or layer by layer.
pub(super) const COATING: &str = "coating";
/// The text in the column [`COATING`] of a surface of which nothing is known, or only the text of the header.
pub(super) const NO_COATING_SAID: &str = "-";
/// Parts of a [`Pose`]: two lengths, three angles, and a length along the axis.
pub(super) const POSE: [&str; 6] = ["decenter_x", "decenter_y", "tilt_x", "tilt_y", "tilt_z", "decenter_z"];

/// An element that stands beside its place.
#[derive(Clone)]
pub(super) struct ElementLine {
    pub(super) place: Place,
    pub(super) first: usize,
    pub(super) last: usize,
    pub(super) pose: Pose,
}

/// A [`Pose`] by the names of its parts; lengths in mm, angles in degrees.
#[derive(Default)]
pub(super) struct Misalignment([f64; 6]);

impl Misalignment {
    /// The part of this name.
    pub(super) fn part(&mut self, name: &str) -> Option<&mut f64> {
        POSE.iter().position(|known| *known == name).map(|i| &mut self.0[i])
    }

    pub(super) fn pose(&self) -> Pose {
        let [x, y, tilt_x, tilt_y, tilt_z, z] = self.0;
        let tilted = Pose::misaligned([x, y], [tilt_x, tilt_y, tilt_z].map(f64::to_radians));
        if z == 0.0 { tilted } else { Pose::new(DVec3::Z * z, DMat3::IDENTITY) * tilted }
    }

    /// The parts of a pose, in the order of [`POSE`].
    pub(super) fn of(pose: &Pose) -> [f64; 6] {
        let ([x, y, z], tilts) = pose.parts();
        let [tilt_x, tilt_y, tilt_z] = tilts.map(f64::to_degrees);
        [x, y, tilt_x, tilt_y, tilt_z, z]
    }
}

/// The power that a column of aspheric coefficients is for.
pub(super) fn power(column: &str) -> Option<u32> {
    let power = column.strip_prefix('a')?.parse().ok()?;
    (2..=LAST_POWER).contains(&power).then_some(power)
}

/// `2-3 decenter_x=0.05 tilt_y=0.1`: surfaces, then parts of a pose.
pub(super) fn element(text: &str, place: Place) -> Option<ElementLine> {
    let mut words = text.split_whitespace();
    let surfaces = words.next()?;
    let (first, last) = surfaces.split_once('-').unwrap_or((surfaces, surfaces));
    let (first, last) = (first.parse().ok()?, last.parse().ok()?);
    let mut misalignment = Misalignment::default();
    for word in words {
        let (name, value) = word.split_once('=')?;
        *misalignment.part(&name.to_lowercase())? = finite(value)?;
    }
    (first <= last).then(|| ElementLine { place, first, last, pose: misalignment.pose() })
}
