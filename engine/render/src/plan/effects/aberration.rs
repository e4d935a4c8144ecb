//! Spherical aberration, coma, astigmatism and field curvature.

use super::LensEffect;
use crate::camera::Model;
use crate::plan::choice::{CameraChoice, CameraKind};
use crate::plan::measured::{Known, Measured};

pub(super) struct Aberration;

impl LensEffect for Aberration {
    fn name(&self) -> &'static str {
        "aberration"
    }

    fn is_in(&self, model: Model) -> bool {
        model == Model::ImageBased
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        Measured::at(known.lens.aberration, self.unit())
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.way == CameraKind::Exact && choice.shown.aberration
    }
}
