//! The settings of a lens, as the commands of `petzval lens` give them.

use crate::camera::PyApertureMask;
use crate::error::{Error, invalid};
use crate::lens::Lens;
use petzval_optics::coating::Coating;
use petzval_optics::focus::{Focus, Focusing};
use petzval_optics::prescription::moving::MovingParts;
use petzval_optics::system::{FocalLength, System, SystemSettings};
use pyo3::prelude::*;

/// Read by attribute; `petzval/lens_setting.py` has the dataclass. `None`: as published.
#[derive(Default, FromPyObject)]
pub(crate) struct Setting {
    scale: Option<f64>,
    focal_length_mm: Option<f64>,
    f_number: Option<f64>,
    pupil_diameter_mm: Option<f64>,
    blades: u32,
    blade_curvature: f64,
    blade_rotation_rad: f64,
    aperture_mask: Option<PyApertureMask>,
    /// Wherever glass meets air; `None`: as the lens file has it.
    coating: Option<String>,
}

impl Setting {
    /// The lens so set, and focused on a distance from the entrance pupil at a wavelength; `None` is infinity. What moves inside to
    /// focus does so, and the film stays; else the film moves.
    pub(crate) fn focused(
        self,
        lens: &Lens,
        wavelength_nm: f64,
        distance_mm: Option<f64>,
    ) -> Result<(System, Focus), Error> {
        let coating = self.coating()?;
        let (settings, mask) = self.parts();
        let moving = lens.prescription.moving.as_ref().is_some_and(MovingParts::focuses);
        let system = match distance_mm.filter(|mm| moving && *mm != f64::INFINITY) {
            Some(mm) => {
                let done = Focusing::default().by_groups(&lens.prescription, &settings, wavelength_nm, mm);
                masked(done.map_err(|error| invalid(error.to_string()))?.system, &settings, mask)?
            }
            None => masked(System::new(&lens.prescription, &settings)?, &settings, mask)?,
        };
        let system = coated(system, coating);
        let focus = focus_at(&system, wavelength_nm, distance_mm)?;
        Ok((system, focus))
    }

    /// The lens so set, as it is focused in its file.
    pub(crate) fn system(self, lens: &Lens) -> Result<System, Error> {
        let coating = self.coating()?;
        let (settings, mask) = self.parts();
        Ok(coated(masked(System::new(&lens.prescription, &settings)?, &settings, mask)?, coating))
    }

    /// True if coatings are those that the lens file names, or those assumed.
    pub(crate) fn keeps_coatings(&self) -> bool {
        self.coating.is_none()
    }

    fn coating(&self) -> Result<Option<Coating>, Error> {
        self.coating.as_deref().map(coating).transpose()
    }

    fn parts(self) -> (SystemSettings, Option<PyApertureMask>) {
        let focal_length = match (self.focal_length_mm, self.scale) {
            (Some(mm), _) => FocalLength::Millimetres(mm),
            (None, Some(scale)) => FocalLength::Scale(scale),
            (None, None) => FocalLength::AsPublished,
        };
        let Self { f_number, pupil_diameter_mm, blades, blade_rotation_rad, blade_curvature, aperture_mask, .. } = self;
        let settings =
            SystemSettings { focal_length, f_number, pupil_diameter_mm, blades, blade_rotation_rad, blade_curvature };
        (settings, aperture_mask)
    }
}

/// A coating by name or layer by layer.
pub(crate) fn coating(text: &str) -> Result<Coating, Error> {
    Coating::parse(text).map_err(|error| invalid(error.to_string()))
}

fn coated(system: System, coating: Option<Coating>) -> System {
    match coating {
        Some(coating) => system.coated(&coating),
        None => system,
    }
}

fn masked(system: System, settings: &SystemSettings, mask: Option<PyApertureMask>) -> Result<System, Error> {
    match mask {
        Some(mask) => {
            let shape = mask.read(&format!("lens '{}'", system.name()))?;
            Ok(system.with_aperture_mask(shape, settings.blade_rotation_rad)?)
        }
        None => Ok(system),
    }
}

/// A distance from the entrance pupil; `None` is infinity.
pub(crate) fn focus_at(system: &System, wavelength_nm: f64, distance_mm: Option<f64>) -> Result<Focus, Error> {
    Ok(match distance_mm.filter(|d| *d != f64::INFINITY) {
        Some(distance) => Focus::at_distance(system, wavelength_nm, distance)?,
        None => Focus::at_infinity(system, wavelength_nm),
    })
}
