//! Focusing by groups inside of a lens: the film stays where it shows infinity sharp, and the groups move.

use thiserror::Error;

use super::{FocusError, Focusing};
use crate::prescription::Prescription;
use crate::system::{LensSettings, System, SystemError};

/// Groups may move beyond infinity by this part of their travel, as those of most lenses can.
const BEYOND_INFINITY: f64 = 0.02;
/// Places at which the travel is looked for, before it is found exactly.
const STEPS: u32 = 32;

/// An error by which groups cannot focus.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GroupsError {
    /// The lens cannot be set.
    #[error(transparent)]
    System(#[from] SystemError),
    /// No film is sharp at the distance.
    #[error(transparent)]
    Focus(#[from] FocusError),
}

/// A lens focused by its groups.
#[derive(Clone, Debug)]
pub struct Focused {
    /// The lens with its groups in place.
    pub system: System,
    /// The z of the film in lens space, mm.
    pub film_z_mm: f64,
    /// Travel of the groups: 0 at infinity, 1 at the nearest distance of their table.
    pub travel: f64,
}

impl Focusing {
    /// Moves the groups of a lens, which must have such, until a film at the place of infinity shows points that are
    /// `distance_mm` away.
    ///
    /// # Errors
    /// [`GroupsError`]: a distance nearer than the table's nearest is [`FocusError::TooClose`].
    pub fn by_groups(
        &self,
        prescription: &Prescription,
        settings: &LensSettings,
        wavelength_nm: f64,
        distance_mm: f64,
    ) -> Result<Focused, GroupsError> {
        if !(distance_mm > 0.0) {
            return Err(FocusError::NotPositive { distance_mm }.into());
        }
        let at_rest = System::new(prescription, settings)?;
        let infinity = self.film_z_mm(&at_rest, wavelength_nm, f64::INFINITY)?;
        // What lies between the last glass and the film may be one of the gaps that move.
        let behind = infinity - at_rest.film_z_published_mm();
        let at = |travel: f64| -> Result<Focused, GroupsError> {
            let system = System::with_travel(prescription, settings, travel)?;
            let film_z_mm = system.film_z_published_mm() + behind;
            Ok(Focused { system, film_z_mm, travel })
        };
        if distance_mm == f64::INFINITY {
            return at(0.0);
        }
        // How far the film stands behind where it would have to be.
        let error = |focused: &Focused| -> Result<f64, GroupsError> {
            Ok(focused.film_z_mm - self.film_z_mm(&focused.system, wavelength_nm, distance_mm)?)
        };
        let travel = |i: u32| -BEYOND_INFINITY + (1.0 + BEYOND_INFINITY) * f64::from(i) / f64::from(STEPS);
        let mut before: Option<(f64, f64)> = None;
        for i in 0..=STEPS {
            // Where a group has moved so far that nothing is sharp, it has not yet moved too far.
            let focused = at(travel(i))?;
            let Ok(now) = error(&focused) else { continue };
            if let Some((from, then)) = before.filter(|(_, then)| then * now <= 0.0) {
                return bisect(&at, &error, [from, travel(i)], then);
            }
            before = Some((travel(i), now));
        }
        let nearest = at(1.0)?;
        let nearest_mm = self.distance_mm(&nearest.system, wavelength_nm, nearest.film_z_mm);
        Err(FocusError::TooClose { distance_mm, nearest_mm }.into())
    }
}

/// The zero of the error between two ends, by bisection; `first` is the error at the first end.
fn bisect(
    at: &impl Fn(f64) -> Result<Focused, GroupsError>,
    error: &impl Fn(&Focused) -> Result<f64, GroupsError>,
    [mut from, mut to]: [f64; 2],
    first: f64,
) -> Result<Focused, GroupsError> {
    for _ in 0..52 {
        let middle = 0.5 * (from + to);
        if error(&at(middle)?)? * first > 0.0 { from = middle } else { to = middle }
    }
    at(0.5 * (from + to))
}
