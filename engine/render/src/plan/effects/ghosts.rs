//! Light reflected between the surfaces of the lens.

use super::LensEffect;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::unit::Unit;
use crate::plan::words::size;

pub(super) struct GhostsEffect;

impl LensEffect for GhostsEffect {
    fn name(&self) -> &'static str {
        "ghosts"
    }

    fn unit(&self) -> Unit {
        Unit::Exposure
    }

    fn is_of_rays(&self) -> bool {
        false
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        match &known.ghosts {
            Some(ghosts) => {
                Measured::new(ghosts.value, format!("the brightest is {}", size(ghosts.value, Unit::Exposure)))
            }
            None => Measured::nothing("no bright source before the lens"),
        }
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.ghosts
    }

    fn picture_s(&self, known: &Known<'_>) -> f64 {
        known.ghosts.as_ref().map_or(0.0, |ghosts| ghosts.picture_s)
    }
}
