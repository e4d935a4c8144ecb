//! Files of sensors: JSON with the sensitivities of the channels, and the conversion of photons to electrons and digital numbers.

use super::SensorError;
use super::mosaic::Mosaic;
use petzval_files::one_line;
use petzval_optics::sensitivity::Sensitivities;
use serde::Deserialize;
use std::path::Path;

/// Bytes of a sensor's file, at most.
const LONGEST_FILE: u64 = 1 << 20;

/// The quantity for which curves of sensitivity are relative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CurvesPer {
    /// Response for each joule, as monochromators measure it.
    #[default]
    Energy,
    /// Response for each photon: quantum efficiency.
    Photon,
}

/// The read noise from a film speed on.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReadNoise {
    /// The lowest film speed, ISO.
    pub from_iso: f64,
    /// Standard deviation before the gain, electrons.
    pub upstream_e: f64,
    /// Standard deviation behind the gain, DN.
    pub downstream_dn: f64,
}

/// A sensor, as its file has it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorFile {
    /// The camera.
    pub name: String,
    /// The source of the curves.
    pub source: String,
    /// The licence of the curves.
    #[serde(default)]
    pub licence: String,
    /// The source of the other numbers.
    #[serde(default)]
    pub pixel_source: String,
    /// The numbers that no source states.
    #[serde(default)]
    pub assumed: Vec<String>,
    /// Wavelength of the curves' first numbers, nm.
    pub first_nm: f64,
    /// Step from number to number, nm.
    pub step_nm: f64,
    /// Relative sensitivity of the red channel.
    #[serde(default)]
    pub red: Vec<f64>,
    /// Relative sensitivity of the green channel.
    #[serde(default)]
    pub green: Vec<f64>,
    /// Relative sensitivity of the blue channel.
    #[serde(default)]
    pub blue: Vec<f64>,
    /// Relative sensitivity of a sensor without colours, instead of the three.
    #[serde(default)]
    pub monochrome: Vec<f64>,
    /// The quantity for which curves are relative.
    #[serde(default)]
    pub curves_per: CurvesPer,
    /// Electrons for each photon where the most sensitive channel has most of them, with its filter. If it is not stated, saturation
    /// in the light of `base_iso` decides.
    pub peak_quantum_efficiency: Option<f64>,
    /// Distance from photosite to photosite, um.
    pub pixel_pitch_um: f64,
    /// The pattern of colour filters.
    pub mosaic: Mosaic,
    /// Bits of the numbers.
    pub bits: u32,
    /// Number without light, DN.
    pub black_level_dn: f64,
    /// Film speed of the gain `gain_dn_per_e`, ISO. If it is not stated, that of saturation (ISO 12232).
    pub base_iso: Option<f64>,
    /// System gain K at the base speed, DN for each electron.
    pub gain_dn_per_e: f64,
    /// Electrons that a photosite holds at most.
    pub full_well_e: f64,
    /// Read noise, in rising order of film speeds.
    pub read_noise: Vec<ReadNoise>,
    /// Mean dark current, electrons a second.
    pub dark_current_e_per_s: f64,
    /// Temperature of the dark current, degrees Celsius.
    #[serde(default = "room")]
    pub dark_current_at_c: f64,
    /// Difference of temperature that doubles the dark current, degrees; if it is not stated, the current is the same at all.
    pub dark_current_doubles_by_c: Option<f64>,
    /// Standard deviation of photosites in the dark, electrons (DSNU1288).
    pub dsnu_e: f64,
    /// Standard deviation of photosites' response, per cent (PRNU1288).
    pub prnu_percent: f64,
    /// Refractive index of a cover glass without coating; none: no glass.
    pub cover_glass_index: Option<f64>,
    /// Micro-lenses: response by the angle, degrees, between a ray and the one for which the photosite's lens is placed; falling, from
    /// `[0, 1]`.
    #[serde(default)]
    pub micro_lens: Vec<[f64; 2]>,
    /// Distance of the exit pupil for which micro-lenses are shifted, mm; none: they are not.
    pub micro_lens_pupil_mm: Option<f64>,
}

fn room() -> f64 {
    25.0
}

impl SensorFile {
    /// A shipped sensor by its word, or the sensor of a file.
    ///
    /// # Errors
    /// There is neither, or the file is none of a sensor: [`SensorError::Unknown`], [`SensorError::Read`], [`SensorError::File`].
    pub fn find(name: &str) -> Result<Self, SensorError> {
        if let Some(text) = Sensitivities::file(name) {
            return Self::parse(text, name);
        }
        let path = Path::new(name);
        if !path.exists() {
            let known = Sensitivities::words().join(", ");
            return Err(SensorError::Unknown { name: name.to_owned(), known });
        }
        let text = petzval_files::read_text_bounded(path, LONGEST_FILE)
            .map_err(|error| SensorError::Read { file: name.to_owned(), reason: error.to_string() })?;
        Self::parse(&text, name)
    }

    /// Reads a file's text, which messages call `file`.
    ///
    /// # Errors
    /// [`SensorError::File`].
    pub fn parse(text: &str, file: &str) -> Result<Self, SensorError> {
        let wrong = |what: String| SensorError::File { file: file.to_owned(), what: one_line(&what) };
        let read: Self = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        read.check().map_err(wrong)?;
        Ok(read)
    }

    /// The curves: three, or one of a sensor without colours.
    pub fn curves(&self) -> Vec<&[f64]> {
        if self.monochrome.is_empty() { vec![&self.red, &self.green, &self.blue] } else { vec![&self.monochrome] }
    }

    /// The read noise at a film speed.
    pub fn read_noise_at(&self, iso: f64) -> ReadNoise {
        let found = self.read_noise.iter().rev().find(|noise| noise.from_iso <= iso);
        *found.unwrap_or(&self.read_noise[0])
    }

    /// The largest number, DN.
    pub fn largest_dn(&self) -> f64 {
        f64::from((1_u32 << self.bits) - 1)
    }

    fn check(&self) -> Result<(), String> {
        self.check_numbers()?;
        self.check_curves()?;
        self.check_mosaic(&self.mosaic)?;
        let noise = &self.read_noise;
        if noise.is_empty() || noise.windows(2).any(|two| two[0].from_iso >= two[1].from_iso) {
            return Err("read_noise: must have one entry or more, in rising order of from_iso".to_owned());
        }
        for one in noise {
            within("from_iso of read_noise, ISO", one.from_iso, 0.0, 1e8)?;
            within("upstream_e of read_noise, electrons", one.upstream_e, 0.0, 1e6)?;
            within("downstream_dn of read_noise, DN", one.downstream_dn, 0.0, 1e5)?;
        }
        self.check_micro_lens()
    }

    fn check_micro_lens(&self) -> Result<(), String> {
        let Some(first) = self.micro_lens.first() else { return Ok(()) };
        let rises = self.micro_lens.windows(2).all(|two| two[0][0] < two[1][0]);
        let sound = |[angle, response]: &[f64; 2]| (0.0..90.0).contains(angle) && (0.0..=1.0).contains(response);
        if *first == [0.0, 1.0] && rises && self.micro_lens.iter().all(sound) {
            return Ok(());
        }
        Err("micro_lens: must be [degrees, response], from [0, 1] on in rising order of angles below 90, with responses from 0 to 1"
            .to_owned())
    }

    fn check_numbers(&self) -> Result<(), String> {
        if !(1..=16).contains(&self.bits) {
            return Err(format!("bits {}: must be from 1 to 16", self.bits));
        }
        within("pixel_pitch_um, um", self.pixel_pitch_um, 0.1, 1000.0)?;
        within("black_level_dn, DN", self.black_level_dn, 0.0, self.largest_dn() - 1.0)?;
        within("gain_dn_per_e, DN for each electron", self.gain_dn_per_e, 1e-9, 1e5)?;
        within("full_well_e, electrons", self.full_well_e, 1.0, 1e9)?;
        within("dark_current_e_per_s, electrons a second", self.dark_current_e_per_s, 0.0, 1e9)?;
        within("dark_current_at_c, degrees Celsius", self.dark_current_at_c, -273.15, 500.0)?;
        within("dsnu_e, electrons", self.dsnu_e, 0.0, 1e6)?;
        within("prnu_percent, per cent", self.prnu_percent, 0.0, 100.0)?;
        within_if("dark_current_doubles_by_c, degrees", self.dark_current_doubles_by_c, 0.1, 1000.0)?;
        within_if("base_iso, ISO", self.base_iso, 1e-3, 1e8)?;
        within_if("peak_quantum_efficiency, electrons for each photon", self.peak_quantum_efficiency, 1e-6, 1.0)?;
        within_if("cover_glass_index", self.cover_glass_index, 1.0, 4.0)?;
        within_if("micro_lens_pupil_mm, mm", self.micro_lens_pupil_mm, 0.1, 1e6)?;
        if self.base_iso.is_none() && self.peak_quantum_efficiency.is_none() {
            return Err("peak_quantum_efficiency and base_iso are missing: give one of them, or both".to_owned());
        }
        Ok(())
    }

    fn check_curves(&self) -> Result<(), String> {
        within("first_nm, nm", self.first_nm, 100.0, 2000.0)?;
        within("step_nm, nm", self.step_nm, 0.1, 100.0)?;
        let colours = [&self.red, &self.green, &self.blue];
        if !self.monochrome.is_empty() && colours.iter().any(|curve| !curve.is_empty()) {
            return Err("monochrome stands instead of red, green and blue: leave out the one or the others".to_owned());
        }
        let curves = self.curves();
        if curves.iter().any(|curve| curve.len() < 2 || curve.len() != curves[0].len()) {
            return Err(
                "red, green and blue must have as many numbers each, two or more; or give monochrome".to_owned()
            );
        }
        if curves.iter().any(|curve| curve.iter().any(|value| !value.is_finite() || *value < 0.0)) {
            return Err("a sensitivity is negative or no finite number".to_owned());
        }
        if curves.iter().any(|curve| curve.iter().all(|value| *value == 0.0)) {
            return Err("a channel sees nothing: all of its sensitivities are 0".to_owned());
        }
        Ok(())
    }

    /// Checks that the channels are those of a mosaic.
    ///
    /// # Errors
    /// A mosaic of colours on a sensor without, or none on one with them.
    pub fn check_mosaic(&self, mosaic: &Mosaic) -> Result<(), String> {
        match (self.monochrome.is_empty(), mosaic == &Mosaic::Monochrome) {
            (true, true) => {
                Err("mosaic monochrome: the sensor's curves are red, green and blue: give it a curve monochrome"
                    .to_owned())
            }
            (false, false) => Err(format!(
                "mosaic {}: the sensor has one curve, monochrome: give it red, green and blue",
                mosaic.words()
            )),
            _ => Ok(()),
        }
    }
}

/// Checks that a number lies in a range; NaN does not.
pub(super) fn within(what: &str, value: f64, least: f64, most: f64) -> Result<(), String> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(format!("{what}: {value} must be from {least} to {most}"))
    }
}

fn within_if(what: &str, value: Option<f64>, least: f64, most: f64) -> Result<(), String> {
    value.map_or(Ok(()), |value| within(what, value, least, most))
}
