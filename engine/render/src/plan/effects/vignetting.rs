//! Less light towards the corners.

use super::LensEffect;
use crate::camera::Model;
use crate::plan::choice::{CameraChoice, CameraKind};
use crate::plan::measured::{Known, Measured};
use crate::plan::unit::Unit;
use crate::plan::words::size;

pub(super) struct VignettingEffect;

impl LensEffect for VignettingEffect {
    fn name(&self) -> &'static str {
        "vignetting"
    }

    fn unit(&self) -> Unit {
        Unit::Stops
    }

    fn is_in(&self, model: Model) -> bool {
        model == Model::ImageBased
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        let cut = match known.lens.cats_eye.value {
            v if v >= 0.1 => format!(", rims narrow blur by {}", size(v, Unit::Pixels)),
            _ => String::new(),
        };
        let one = Measured::at(known.lens.vignetting, self.unit());
        Measured { text: one.text + &cut, ..one }
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.way == CameraKind::Exact && choice.shown.vignetting
    }
}
