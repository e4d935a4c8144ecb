//! How a lens is set, as the commands of `petzval lens` say it.

use crate::camera::PyApertureMask;
use crate::error::Error;
use crate::lens::{Lens, focal_length};
use petzval_optics::system::{System, SystemSettings};
use pyo3::prelude::*;

/// Read by attribute; `petzval/lens_setting.py` has the dataclass. `None`: as published.
#[derive(FromPyObject)]
pub(crate) struct Setting {
    scale: Option<f64>,
    focal_length_mm: Option<f64>,
    f_number: Option<f64>,
    pupil_diameter_mm: Option<f64>,
    blades: u32,
    blade_curvature: f64,
    blade_rotation_rad: f64,
    aperture_mask: Option<PyApertureMask>,
}

impl Setting {
    /// The lens so set; what moves inside it to focus stands where it makes this distance sharp at this wavelength.
    pub(crate) fn system(self, lens: &Lens, (wavelength_nm, distance_mm): (f64, Option<f64>)) -> Result<System, Error> {
        let settings = SystemSettings {
            focal_length: focal_length(self.scale, self.focal_length_mm),
            f_number: self.f_number,
            pupil_diameter_mm: self.pupil_diameter_mm,
            blades: self.blades,
            blade_rotation_rad: self.blade_rotation_rad,
            blade_curvature: self.blade_curvature,
        };
        Ok(lens.focused(&settings, self.aperture_mask, wavelength_nm, distance_mm)?.0)
    }
}
