//! The losses of glass and coatings, by colour.

use super::LensEffect;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::price::{Price, transmission_ns};
use crate::plan::unit::Unit;
use crate::plan::words::worst;

pub(super) struct TransmissionEffect;

impl LensEffect for TransmissionEffect {
    fn name(&self) -> &'static str {
        "transmission"
    }

    fn unit(&self) -> Unit {
        Unit::Stops
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        let (info, lens) = (known.survey.info(), &known.lens);
        let changed = worst(lens.transmission, self.unit());
        let coat = match info.coatings.as_slice() {
            [] => String::new(),
            [one] if one == "none" => "uncoated, ".to_owned(),
            names if info.coating_is_assumed => format!("coated with {} (assumed), ", names.join(", ")),
            names => format!("coated with {}, ", names.join(", ")),
        };
        let exposed = match (known.d.exposes_by_f_number, known.d.white_balance) {
            (true, false) => "exposed by its f-number",
            (true, true) => "exposed by its f-number and balanced for white in the middle",
            (false, false) => "exposed for that",
            (false, true) => "exposed for that and balanced for white in the middle",
        };
        let passed = 100.0 * lens.luminous;
        let text = format!("{coat}it lets {passed:.0} % through and, {exposed}, changes colours by {changed}");
        Measured::new(lens.transmission.value, text)
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.transmission
    }

    fn cost_ns(&self, _choice: &CameraChoice, price: Price, _known: &Known<'_>) -> f64 {
        transmission_ns(price)
    }
}
