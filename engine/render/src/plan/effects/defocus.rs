//! Blur of points out of focus.

use super::LensEffect;
use crate::camera::Model;
use crate::plan::choice::{CameraChoice, CameraKind};
use crate::plan::measured::{Known, Measured};
use crate::plan::price::{Price, sample_ns};

pub(super) struct Defocus;

impl LensEffect for Defocus {
    fn name(&self) -> &'static str {
        "defocus"
    }

    fn is_in(&self, model: Model) -> bool {
        !matches!(model, Model::Pinhole | Model::Orthographic | Model::Panoramic | Model::Calibrated)
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        Measured::at(known.lens.defocus, self.unit())
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.shown.defocus && matches!(choice.way, CameraKind::Exact | CameraKind::Gaussian)
    }

    fn cost_ns(&self, choice: &CameraChoice, price: Price, known: &Known<'_>) -> f64 {
        let shape = known.survey.shape();
        let is_gaussian = choice.way == CameraKind::Gaussian;
        if is_gaussian { sample_ns(price, shape) - sample_ns(Price::Pinhole, shape) } else { 0.0 }
    }
}
