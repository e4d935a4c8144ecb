//! Blades or a mask in blur discs.

use super::LensEffect;
use crate::camera::Model;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::unit::Unit;
use crate::plan::words::size;

pub(super) struct DiaphragmEffect;

impl LensEffect for DiaphragmEffect {
    fn name(&self) -> &'static str {
        "diaphragm"
    }

    fn is_in(&self, model: Model) -> bool {
        !matches!(model, Model::Pinhole | Model::Orthographic | Model::Panoramic | Model::Calibrated)
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        let lens = &known.lens;
        if lens.diaphragm_part == 0.0 {
            return Measured::nothing("the opening is round");
        }
        let value = lens.diaphragm_part * (lens.defocus.value + lens.aberration.value);
        Measured::new(value, size(value, Unit::Pixels))
    }

    fn is_simulated(&self, choice: &CameraChoice, known: &Known<'_>) -> bool {
        known.lens.diaphragm_part > 0.0 && choice.round_f_number.is_none()
    }
}
