//! Softness at small openings, and spikes of bright points: the wave nature of light.

use super::LensEffect;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::price::diffraction_s;
use crate::plan::unit::Unit;
use crate::plan::words::size;

pub(super) struct DiffractionEffect;

impl LensEffect for DiffractionEffect {
    fn name(&self) -> &'static str {
        "diffraction"
    }

    fn is_of_rays(&self) -> bool {
        false
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        let (seen_px, airy_px) = (known.seen_px, known.lens.airy_px);
        if seen_px > airy_px {
            let seen = size(seen_px, Unit::Pixels);
            return Measured::new(seen_px, format!("the brightest source is seen {seen} around itself"));
        }
        Measured::new(airy_px, format!("the first dark ring is {} wide", size(airy_px, Unit::Pixels)))
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.diffraction
    }

    fn picture_s(&self, known: &Known<'_>) -> f64 {
        diffraction_s(known.pixels)
    }
}
