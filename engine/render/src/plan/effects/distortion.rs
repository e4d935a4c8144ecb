//! Straight lines bent towards the picture's edge.

use super::LensEffect;
use crate::camera::Model;
use crate::plan::choice::{CameraChoice, CameraKind};
use crate::plan::measured::{Known, Measured};

pub(super) struct DistortionEffect;

impl LensEffect for DistortionEffect {
    fn name(&self) -> &'static str {
        "distortion"
    }

    fn is_in(&self, model: Model) -> bool {
        model == Model::ImageBased
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        Measured::at(known.lens.distortion, self.unit())
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.way == CameraKind::Exact && choice.shown.distortion
    }
}
