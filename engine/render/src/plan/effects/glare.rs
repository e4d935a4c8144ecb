//! Light scattered by surfaces, dust, barrel and film.

use super::LensEffect;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::price::glare_s;
use crate::plan::unit::Unit;
use crate::plan::words::size;

pub(super) struct GlareEffect;

impl LensEffect for GlareEffect {
    fn name(&self) -> &'static str {
        "glare"
    }

    fn unit(&self) -> Unit {
        Unit::Exposure
    }

    fn is_of_rays(&self) -> bool {
        false
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        let Some(light) = known.front_light else {
            return Measured { value: None, text: "the picture is black: not measured".to_owned() };
        };
        let value = known.glare * light;
        let (veil, part) = (size(value, Unit::Exposure), 100.0 * known.glare);
        Measured::new(value, format!("{part:.2} % of the light is scattered: a veil of {veil}"))
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.glare
    }

    fn picture_s(&self, known: &Known<'_>) -> f64 {
        glare_s(known.pixels)
    }
}
