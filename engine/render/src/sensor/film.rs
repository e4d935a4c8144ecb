//! A sensor as the film of a spectral picture: its response to single wavelengths, where a lens separates them.

use super::exposure::SATURATION_LX_S;
use super::file::SensorFile;
use super::response::Response;
use crate::spectrum::FilmSpectrum;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Deserializer};
use std::sync::Arc;

/// A sensor's channels as the film of a camera. The picture's colours are linear Rec.709 which the inverse of the sensor's matrix makes of its
/// channels ([`Response::channels_from_xyz`]): colours of the scene are as the observer sees them, and at the edges where a lens parts
/// wavelengths they are those of the sensor, so that [`super::expose::expose`] finds the electrons of each channel exactly.
#[derive(Clone, Debug)]
pub struct FilmSensor {
    response: Arc<Response>,
    /// The picture's colours from electrons.
    picture_from_channels: DMat3,
}

/// The noise of a sensor in a grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GreyNoise {
    /// Film speed, ISO.
    pub iso: f64,
    /// Temporal noise of the noisiest channel, as a part of white.
    pub part: f64,
}

/// Reflectance of photographers' grey card.
const GREY: f64 = 0.18;

impl FilmSensor {
    /// The film of a sensor; `None`: it has no colours, and the response of the observer.
    pub fn new(response: Response) -> Option<Self> {
        let matrix = response.electrons_per_lx_s(response.sensor().pixel_pitch_um);
        let is_coloured = response.sensor().monochrome.is_empty() && matrix.determinant() != 0.0;
        is_coloured.then(|| Self { picture_from_channels: matrix.inverse(), response: Arc::new(response) })
    }

    /// The noise of a grey of 18 %, where white saturates a film of a speed; none: the sensor's own.
    pub fn grey_noise(&self, iso: Option<f64>) -> GreyNoise {
        let sensor = self.response.sensor();
        let iso = iso.unwrap_or(self.response.base_iso);
        let white = self.response.electrons_per_lx_s(sensor.pixel_pitch_um) * DVec3::ONE * (SATURATION_LX_S / iso);
        let read_e = self.response.read_noise_e(iso);
        let parts = white.to_array().map(|white_e| (GREY * white_e + read_e * read_e).sqrt() / white_e);
        GreyNoise { iso, part: parts.into_iter().fold(0.0, f64::max) }
    }

    /// The wavelengths of the film, in `count` bands: [`FilmSpectrum::seen_in`].
    pub fn visible_in(&self, count: usize) -> FilmSpectrum {
        FilmSpectrum::seen_in(count, &|nm| {
            // Electrons are those of photons, of which a watt has the more the longer the wavelength.
            let seen = [0, 1, 2].map(|channel| nm * self.response.quantum_efficiency(channel, nm));
            self.picture_from_channels * DVec3::from_array(seen)
        })
    }
}

/// The film of the sensor of a file or of a shipped one, by its name; nothing for a sensor without colours.
///
/// # Errors
/// There is none of that name, or its file is none.
pub(crate) fn by_name<'de, D: Deserializer<'de>>(from: D) -> Result<Option<FilmSensor>, D::Error> {
    let Some(name) = Option::<String>::deserialize(from)? else { return Ok(None) };
    let file = SensorFile::find(&name).map_err(serde::de::Error::custom)?;
    Ok(FilmSensor::new(Response::new(file)))
}
