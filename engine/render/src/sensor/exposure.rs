//! An exposure of a sensor: film speed, time, and the light that a picture's value 1 stands for.

use super::SensorError;
use super::file::{SensorFile, within};
use super::mosaic::Mosaic;
use serde::Deserialize;
use std::f64::consts::PI;

/// Saturation exposure of a digital camera, lux seconds times ISO: ISO 12232:2019, saturation-based speed.
pub const SATURATION_LX_S: f64 = 78.0;

/// The request of an exposure. Of the ways to give the amount of light, one at most is given; else the picture's value 1 is where a
/// film of `picture_iso` saturates, as in pictures that Petzval exposes physically ([`crate::camera::exposure::PhysicalExposure`]).
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExposureRequest {
    /// Film speed, ISO; none: the sensor's base speed.
    pub iso: Option<f64>,
    /// Exposure time, s: of the dark current, and of `nits`.
    pub shutter_s: f64,
    /// Film speed by which the picture was exposed; none: `iso`.
    pub picture_iso: Option<f64>,
    /// Luminous exposure of the picture's white, lux seconds.
    pub lux_seconds: Option<f64>,
    /// Luminance of the picture's white, cd/m², through a lens without losses of `f_number`.
    pub nits: Option<f64>,
    /// F-number of `nits`, and in the file.
    pub f_number: Option<f64>,
    /// Photons that a photosite receives where the picture is white, all of `wavelength_nm`.
    pub photons: Option<f64>,
    /// Wavelength of `photons`, nm.
    pub wavelength_nm: Option<f64>,
    /// Temperature of the sensor, degrees Celsius; none: that at which its dark current is stated.
    pub temperature_c: Option<f64>,
    /// Distance of the lens's exit pupil from the film, mm; none: all light arrives upright.
    pub exit_pupil_mm: Option<f64>,
    /// Pitch instead of the sensor's own, um.
    pub pitch_um: Option<f64>,
    /// Pattern instead of the sensor's own.
    pub mosaic: Option<Mosaic>,
    /// Number of the sensor: of its fixed pattern and of its noise.
    pub seed: u64,
    /// Number of the frame: its noise is another.
    pub frame: u64,
    /// True to leave out all noise and fixed patterns: the means alone, rounded.
    pub noiseless: bool,
}

/// The light of a picture's value 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// The scene's spectra, white at a luminous exposure, lx s.
    White(f64),
    /// Photons of one wavelength, nm.
    Photons(f64, f64),
}

/// An exposure, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// Film speed, ISO.
    pub iso: Option<f64>,
    /// The light of a picture's value 1; `None`: that where the film speed saturates.
    pub light: Option<Light>,
    /// Mean dark current, electrons in the exposure time.
    pub dark_e: f64,
    /// Pitch, um.
    pub pitch_um: f64,
    /// Pattern of colour filters.
    pub mosaic: Mosaic,
}

impl ExposureRequest {
    /// Checks the request for a sensor.
    ///
    /// # Errors
    /// [`SensorError::Exposure`].
    pub fn checked(&self, sensor: &SensorFile) -> Result<Exposure, SensorError> {
        self.check(sensor).map_err(SensorError::Exposure)
    }

    fn check(&self, sensor: &SensorFile) -> Result<Exposure, String> {
        let positive = |what: &str, value: Option<f64>| value.map_or(Ok(()), |value| within(what, value, 1e-12, 1e12));
        positive("film speed, ISO", self.iso)?;
        positive("film speed of the picture, ISO", self.picture_iso)?;
        positive("f-number", self.f_number)?;
        positive("exit pupil, mm", self.exit_pupil_mm)?;
        within("exposure time, s", self.shutter_s, 0.0, 1e6)?;
        if let Some(temperature_c) = self.temperature_c {
            within("temperature of the sensor, degrees Celsius", temperature_c, -273.15, 500.0)?;
        }
        if let Some(pitch_um) = self.pitch_um {
            within("pitch, um", pitch_um, 0.1, 1000.0)?;
        }
        let mosaic = self.mosaic.clone().unwrap_or_else(|| sensor.mosaic.clone());
        sensor.check_mosaic(&mosaic)?;
        Ok(Exposure {
            iso: self.iso,
            light: self.light()?,
            dark_e: self.dark_e(sensor),
            pitch_um: self.pitch_um.unwrap_or(sensor.pixel_pitch_um),
            mosaic,
        })
    }

    /// The light of a picture's value 1, where it is stated by itself.
    fn light(&self) -> Result<Option<Light>, String> {
        let ways = [self.picture_iso, self.lux_seconds, self.nits, self.photons];
        if ways.iter().flatten().count() > 1 {
            return Err("film speed of the picture, lux seconds, nits and photons each say what light the picture's white is: give one of them".to_owned());
        }
        if self.photons.is_some() != self.wavelength_nm.is_some() {
            return Err("photons need a wavelength, and a wavelength photons: give both, or neither".to_owned());
        }
        if let Some(lux_seconds) = self.lux_seconds {
            within("lux seconds", lux_seconds, 0.0, 1e12)?;
            return Ok(Some(Light::White(lux_seconds)));
        }
        if let Some(nits) = self.nits {
            within("nits, cd/m2", nits, 0.0, 1e12)?;
            let Some(f_number) = self.f_number.filter(|_| self.shutter_s > 0.0) else {
                return Err("nits need an f-number and an exposure time: give both".to_owned());
            };
            // The irradiance on the axis behind a lens without losses, focused at infinity, of radiance one: the sine condition.
            return Ok(Some(Light::White(PI / (4.0 * f_number * f_number) * nits * self.shutter_s)));
        }
        if let (Some(photons), Some(nm)) = (self.photons, self.wavelength_nm) {
            within("photons", photons, 0.0, 1e12)?;
            within("wavelength of the photons, nm", nm, 100.0, 2000.0)?;
            return Ok(Some(Light::Photons(photons, nm)));
        }
        Ok(self.picture_iso.map(|iso| Light::White(SATURATION_LX_S / iso)))
    }

    /// Mean electrons of the dark current, which doubles by so many degrees (EMVA 1288, equations 15 and 16).
    fn dark_e(&self, sensor: &SensorFile) -> f64 {
        let warmer_c = self.temperature_c.map_or(0.0, |is_c| is_c - sensor.dark_current_at_c);
        let factor = sensor.dark_current_doubles_by_c.map_or(1.0, |doubles_c| libm::exp2(warmer_c / doubles_c));
        sensor.dark_current_e_per_s * factor * self.shutter_s
    }
}
