//! Lateral and axial colour.

use super::{Effect, LensEffect};
use crate::camera::Model;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::price::{Price, sample_ns};

/// An error of colour.
pub(super) struct Colour {
    name: &'static str,
    effect: Effect,
}

/// The size of the image depends on the wavelength.
pub(super) const LATERAL: Colour = Colour { name: "lateral_colour", effect: Effect::LateralColour };
/// The focus depends on the wavelength.
pub(super) const AXIAL: Colour = Colour { name: "axial_colour", effect: Effect::AxialColour };

impl Colour {
    fn is_lateral(&self) -> bool {
        self.effect == Effect::LateralColour
    }
}

impl LensEffect for Colour {
    fn name(&self) -> &'static str {
        self.name
    }

    fn is_in(&self, model: Model) -> bool {
        model == Model::Paraxial
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        if !known.survey.has_colours() {
            return Measured::nothing(match known.d.wavelength_nm {
                Some(nm) => format!("the camera photographs at {nm:.0} nm alone"),
                None => "nothing in the lens disperses".to_owned(),
            });
        }
        let one = if self.is_lateral() { known.lens.lateral_colour } else { known.lens.axial_colour };
        Measured::at(one, self.unit())
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        let is_shown = if self.is_lateral() { choice.shown.lateral_colour } else { choice.shown.axial_colour };
        choice.spectrum.is_some() && is_shown
    }

    /// The larger one carries both.
    fn cost_ns(&self, _choice: &CameraChoice, price: Price, known: &Known<'_>) -> f64 {
        let shape = known.survey.shape();
        let lateral_is_larger = known.lens.lateral_colour.value >= known.lens.axial_colour.value;
        if self.is_lateral() != lateral_is_larger {
            return 0.0;
        }
        sample_ns(price, shape) - sample_ns(Price::Exact { is_single: true, carried: 1 }, shape)
    }
}
