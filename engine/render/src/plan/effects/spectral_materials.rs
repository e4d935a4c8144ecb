//! Materials that are more than three colours.

use super::LensEffect;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::unit::Unit;

pub(super) struct SpectralMaterials;

impl LensEffect for SpectralMaterials {
    fn name(&self) -> &'static str {
        "spectral_materials"
    }

    fn unit(&self) -> Unit {
        Unit::Exposure
    }

    fn is_available(&self) -> bool {
        false
    }

    fn is_of_rays(&self) -> bool {
        false
    }

    fn measure(&self, _known: &Known<'_>) -> Measured {
        Measured::nothing("all of the scene is described in three colours")
    }

    fn is_simulated(&self, _choice: &CameraChoice, _known: &Known<'_>) -> bool {
        false
    }
}
