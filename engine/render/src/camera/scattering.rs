//! Scattering in a lens, as a camera's description has it; [`crate::stray::glare`] computes the glare.

use serde::Deserialize;

/// The amount of scattering in a lens.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scattering {
    /// Roughness of every surface, root mean square, nm.
    pub roughness_nm: f64,
    /// Cleanliness of every surface that air touches: level of IEST-STD-CC1246; 0 is without dust.
    pub cleanliness: f64,
    /// Veiling glare index of barrel and film: the part of an even world's light that is laid evenly over the picture.
    pub veiling_index: f64,
}

impl Default for Scattering {
    /// 2 nm of roughness, a common polish; level 300; an index of 1 %, as of photographic lenses.
    fn default() -> Self {
        Self { roughness_nm: 2.0, cleanliness: 300.0, veiling_index: 0.01 }
    }
}

impl Scattering {
    /// A lens without scattering: smooth, clean and without veiling glare.
    pub const NONE: Self = Self { roughness_nm: 0.0, cleanliness: 0.0, veiling_index: 0.0 };

    /// Checks the numbers; the error names the fault and the remedy.
    pub(super) fn check(&self) -> Result<(), String> {
        let within = |value: f64, most: f64, name: &str| {
            let is_good = (0.0..=most).contains(&value);
            if is_good { Ok(()) } else { Err(format!("{name} is {value}; set it from 0 to {most}")) }
        };
        within(self.roughness_nm, 100.0, "the roughness in nm")?;
        within(self.cleanliness, 2000.0, "the cleanliness level")?;
        within(self.veiling_index, 1.0, "the veiling glare index")
    }
}
