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
    blades: u32,
    blade_curvature: f64,
    blade_rotation_rad: f64,
    aperture_mask: Option<PyApertureMask>,
}

impl Setting {
    /// The lens so set.
    pub(crate) fn system(self, lens: &Lens) -> Result<System, Error> {
        let settings = SystemSettings {
            focal_length: focal_length(self.scale, self.focal_length_mm),
            f_number: self.f_number,
            blades: self.blades,
            blade_rotation_rad: self.blade_rotation_rad,
            blade_curvature: self.blade_curvature,
        };
        lens.system(&settings, self.aperture_mask)
    }
}
