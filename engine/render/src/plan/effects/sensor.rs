//! The noise of the sensor, where the camera has one.

use super::LensEffect;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::unit::Unit;

pub(super) struct SensorEffect;

impl LensEffect for SensorEffect {
    fn name(&self) -> &'static str {
        "sensor"
    }

    fn unit(&self) -> Unit {
        Unit::Exposure
    }

    /// The camera has it or has it not: no plan takes it out.
    fn is_available(&self) -> bool {
        false
    }

    fn is_of_rays(&self) -> bool {
        false
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        let Some(sensor) = &known.d.film_sensor else {
            return Measured::nothing("the camera has no sensor with colours");
        };
        let iso = known.d.exposure.map(|exposure| exposure.iso);
        let noise = sensor.grey_noise(iso);
        let text = format!(
            "at ISO {:.0} a grey of 18 % has a noise of {:.2} % of white in the noisiest channel",
            noise.iso,
            100.0 * noise.part
        );
        Measured::new(noise.part, text)
    }

    fn is_simulated(&self, _choice: &CameraChoice, known: &Known<'_>) -> bool {
        known.d.film_sensor.is_some()
    }
}
