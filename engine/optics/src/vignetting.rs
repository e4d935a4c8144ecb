//! Vignetting: the field angles at which the rims of a lens let its beam through, by exact rays.
//!
//! The beam of a field angle is all light from there that the present opening of the stop would let through if it were
//! alone. Rays are traced through the lens without its rims, and looked at where they hit each surface: a rim cuts
//! those that pass outside of it. A polygon of blades counts as the circle through its corners, and central
//! obstructions do not count.

mod beam;
mod survey;

use crate::field::Field;
use crate::focus::Focus;
use crate::system::System;

use beam::RimOfBeam;

pub(crate) use beam::RimlessLens;
pub(crate) use survey::FieldWindow;

/// The field angles at which the beam comes through. Angles are those of the chief ray before the lens, in degrees;
/// more than 90 for points behind the first vertex. `None`: the lens has no such angle.
///
/// A lens that looks different from different sides has the smallest of the angles up, down, left and right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vignetting {
    /// Index of the surface that cuts the beam on the axis, if one does: the rim that cuts most.
    pub axial_beam_cut_by: Option<usize>,
    /// The largest angle up to which nothing cuts any of the beam; 0 if a rim cuts it on the axis.
    pub free_field_deg: Option<f64>,
    /// The angle at which half as much of the stop's area is filled as on the axis, to 2 % of the area.
    pub half_field_deg: Option<f64>,
    /// The angle at which the last ray is cut.
    pub largest_field_deg: Option<f64>,
}

/// Rays that miss a rim by no more than this part of it pass: the rounding of the aim.
const ROUNDING: f64 = 1e-8;
/// Steps of the search for an angle, in degrees: a part of the angle reached, within bounds. Longer ones may jump over
/// a beam that is gone and comes back.
const FIRST_STEP_DEG: f64 = 1.0 / 64.0;
const LONGEST_STEP_DEG: f64 = 1.0;
const STEP: f64 = 0.25;
/// Steps end when so short, in degrees: where rims are aimed at, and where areas are counted.
const SHORTEST_STEP_DEG: f64 = 1e-8;
const SHORTEST_STEP_BY_AREA_DEG: f64 = 1e-4;
/// Number of steps in a row after which they are lengthened.
const SURE_STEPS: u32 = 4;

impl Vignetting {
    /// The angles at a vacuum wavelength in nm, for the plane that `focus` has sharp.
    pub fn new(system: &System, wavelength_nm: f64, focus: &Focus) -> Self {
        let Some(probe) = RimlessLens::new(system, wavelength_nm, focus.object_plane_mm) else {
            return Self::default();
        };
        let azimuths: &[[f64; 2]] = match system.is_rotationally_symmetric() {
            true => &[[0.0, 1.0]],
            false => &[[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0]],
        };
        let one = |&azimuth| Self::towards(&probe, azimuth);
        azimuths.iter().map(one).reduce(Self::least).unwrap_or_default()
    }

    fn towards(probe: &RimlessLens, azimuth: [f64; 2]) -> Self {
        let field = |degrees: f64| Field::new(degrees.to_radians(), azimuth);
        let (axial_beam_cut_by, free_field_deg) = free_field(probe, field);
        let [half_field_deg, largest_field_deg] = fields_by_area(probe, field);
        Self { axial_beam_cut_by, free_field_deg, half_field_deg, largest_field_deg }
    }

    fn least(self, other: Self) -> Self {
        let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
        Self {
            axial_beam_cut_by: self.axial_beam_cut_by.or(other.axial_beam_cut_by),
            free_field_deg: least(self.free_field_deg, other.free_field_deg),
            half_field_deg: least(self.half_field_deg, other.half_field_deg),
            largest_field_deg: least(self.largest_field_deg, other.largest_field_deg),
        }
    }
}

/// The largest angle up to which `step` leads from one state to the next, and the state there, from an angle and state
/// where it does; `None`: it leads to the widest.
///
/// A step that fails is tried again at half the length: it may have been too long to be found.
fn follow<S>(
    start: (f64, S),
    widest_deg: f64,
    shortest_deg: f64,
    step: impl Fn(f64, &S) -> Option<S>,
) -> Option<(f64, S)> {
    let (mut here, mut state) = start;
    let longest = |here: f64| (here * STEP).clamp(FIRST_STEP_DEG, LONGEST_STEP_DEG);
    let mut length = longest(here);
    let mut in_a_row = 0;
    while length >= shortest_deg {
        if here + length > widest_deg {
            return None;
        }
        match step(here + length, &state) {
            Some(found) => {
                (here, state) = (here + length, found);
                in_a_row += 1;
            }
            None => {
                length /= 2.0;
                in_a_row = 0;
            }
        }
        if in_a_row >= SURE_STEPS {
            length = (2.0 * length).min(longest(here));
        }
    }
    Some((here, state))
}

/// The rim that cuts the beam on the axis, and the angle up to which none does.
fn free_field(probe: &RimlessLens, field: impl Fn(f64) -> Field) -> (Option<usize>, Option<f64>) {
    let passes = |rim: &RimOfBeam| rim.reach <= 1.0 + ROUNDING;
    let axial = match probe.rim_of_beam(&field(0.0), &probe.paraxial_rim()) {
        Ok(rim) if passes(&rim) => rim.points,
        Ok(RimOfBeam { surface, .. }) | Err(surface) => return (Some(surface), Some(0.0)),
    };
    let free = follow((0.0, axial), probe.widest_deg(), SHORTEST_STEP_DEG, |degrees, points| {
        let field = field(degrees);
        let starts: Vec<_> = points.iter().map(|&point| probe.origin.crossing(&field, point)).collect();
        probe.rim_of_beam(&field, &starts).ok().filter(passes).map(|rim| rim.points)
    });
    (None, free.map(|(degrees, _)| degrees))
}

/// The angles where half of the axial beam's area is left, and nothing.
fn fields_by_area(probe: &RimlessLens, field: impl Fn(f64) -> Field) -> [Option<f64>; 2] {
    let axial = FieldWindow::about(probe.paraxial_rim().into_iter()).and_then(|window| window.find(probe, &field(0.0)));
    let Some(axial) = axial else { return [None; 2] };
    let last = |start: (f64, FieldWindow), least_area: f64| {
        follow(start, probe.widest_deg(), SHORTEST_STEP_BY_AREA_DEG, |degrees, window| {
            let found = window.find(probe, &field(degrees))?;
            (found.area >= least_area).then_some(found.window)
        })
    };
    let half = last((0.0, axial.window), 0.5 * axial.area);
    let largest = half.and_then(|half| last(half, 0.0));
    [half, largest].map(|end| end.map(|(degrees, _)| degrees))
}
