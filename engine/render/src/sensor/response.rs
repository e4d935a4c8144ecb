//! A sensor's answer to light: electrons of each channel for a picture's colours, and the matrices of a raw file.
//!
//! A colour of the scene is a spectrum ([`crate::spectrum`]), linear in the colour, so that a channel's electrons are linear in it, too:
//! a matrix holds the integral over wavelengths. As three numbers make the spectrum, the inverse of that matrix gives the colour back
//! exactly, though no camera's curves are a mixture of the observer's (the condition of Luther).

use super::exposure::{Exposure, Light, SATURATION_LX_S};
use super::file::{CurvesPer, SensorFile};
use crate::spectrum;
use glam::{DMat3, DVec3};

/// Planck's constant times the speed of light, J m (SI, exact).
const HC_J_M: f64 = 6.626_070_15e-34 * 299_792_458.0;
/// Luminous efficacy of radiation at 555 nm, lm/W (SI, rounded as lighting has it).
const LUMENS_PER_WATT: f64 = 683.0;
/// Step of integrals over wavelengths, nm.
const STEP_NM: f64 = 1.0;

/// A sensor's answer to light.
#[derive(Clone, Debug)]
pub struct Response {
    sensor: SensorFile,
    /// Quantum efficiency for one of the curve's numbers per photon at 1 nm.
    scale: f64,
    /// Film speed of the sensor's own gain, ISO.
    pub base_iso: f64,
    /// Largest quantum efficiency, with filters.
    pub peak_quantum_efficiency: f64,
}

impl Response {
    /// Finds the numbers that the sensor's file leaves open: quantum efficiency, or base speed.
    pub fn new(sensor: SensorFile) -> Self {
        let mut made = Self { sensor, scale: 1.0, base_iso: 1.0, peak_quantum_efficiency: 1.0 };
        let peak = made.peak();
        // At a peak of 1.
        made.scale = 1.0 / peak;
        let lux_seconds = made.saturation_lx_s();
        let (peak, iso) = match (made.sensor.peak_quantum_efficiency, made.sensor.base_iso) {
            (Some(peak), Some(iso)) => (peak, iso),
            (Some(peak), None) => (peak, SATURATION_LX_S / (lux_seconds / peak)),
            (None, iso) => {
                let iso = iso.unwrap_or(SATURATION_LX_S / lux_seconds);
                (lux_seconds * iso / SATURATION_LX_S, iso)
            }
        };
        made.scale *= peak;
        (made.peak_quantum_efficiency, made.base_iso) = (peak, iso);
        made
    }

    /// The sensor.
    pub fn sensor(&self) -> &SensorFile {
        &self.sensor
    }

    /// Quantum efficiency of a channel at a wavelength, nm: electrons for each photon on the photosite, with its filter.
    pub fn quantum_efficiency(&self, channel: usize, nm: f64) -> f64 {
        self.scale * self.relative(channel, nm)
    }

    /// The curve per photon, in units of the file.
    fn relative(&self, channel: usize, nm: f64) -> f64 {
        let curve = self.sensor.curves()[channel];
        let place = (nm - self.sensor.first_nm) / self.sensor.step_nm;
        if place < 0.0 || place > (curve.len() - 1) as f64 {
            return 0.0;
        }
        let i = (place as usize).min(curve.len() - 2);
        let value = curve[i] + (curve[i + 1] - curve[i]) * (place - i as f64);
        match self.sensor.curves_per {
            CurvesPer::Photon => value,
            // A photon has the energy h c / wavelength.
            CurvesPer::Energy => value / nm,
        }
    }

    fn peak(&self) -> f64 {
        let count = self.sensor.curves()[0].len();
        let at = |i: usize| self.sensor.first_nm + self.sensor.step_nm * i as f64;
        let channels = 0..self.sensor.curves().len();
        channels.flat_map(|c| (0..count).map(move |i| (c, i))).map(|(c, i)| self.relative(c, at(i))).fold(0.0, f64::max)
    }

    /// Electrons of each channel for the scene's red, green and blue of value 1, where white has a luminous exposure of 1 lx s. Of a
    /// sensor without colours, the first row alone counts.
    pub fn electrons_per_lx_s(&self, pitch_um: f64) -> DMat3 {
        let area_m2 = pitch_um * pitch_um * 1e-12;
        let mut matrix = DMat3::ZERO;
        let mut luminance = 0.0;
        for (nm, light) in spectrum::scene_lights(STEP_NM) {
            luminance += light.element_sum() * spectrum::observer(nm).y;
            let seen = DVec3::from_array(std::array::from_fn(|c| {
                let channel = c.min(self.sensor.curves().len() - 1);
                // J/(m² nm) into electrons.
                self.quantum_efficiency(channel, nm) * area_m2 * nm * 1e-9 / HC_J_M
            }));
            matrix += DMat3::from_cols(seen * light.x, seen * light.y, seen * light.z);
        }
        matrix * (LUMENS_PER_WATT * luminance).recip()
    }

    /// Electrons that saturate a photosite at the base speed: its full well, or the largest number.
    pub fn saturation_e(&self) -> f64 {
        let sensor = &self.sensor;
        sensor.full_well_e.min((sensor.largest_dn() - sensor.black_level_dn) / sensor.gain_dn_per_e)
    }

    /// Luminous exposure of white, D65, that saturates the first of the channels, lx s.
    pub fn saturation_lx_s(&self) -> f64 {
        let white = self.electrons_per_lx_s(self.sensor.pixel_pitch_um) * DVec3::ONE;
        self.saturation_e() / white.max_element()
    }

    /// Film speed by saturation in D65, ISO 12232.
    pub fn saturation_iso(&self) -> f64 {
        SATURATION_LX_S / self.saturation_lx_s()
    }

    /// System gain K at a film speed, DN for each electron.
    pub fn gain_dn_per_e(&self, iso: f64) -> f64 {
        self.sensor.gain_dn_per_e * iso / self.base_iso
    }

    /// Read noise at a film speed with that of rounding, electrons: the temporal dark noise of EMVA 1288 (equation 11; rounding has a twelfth of
    /// a DN squared).
    pub fn read_noise_e(&self, iso: f64) -> f64 {
        let (noise, gain) = (self.sensor.read_noise_at(iso), self.gain_dn_per_e(iso));
        (noise.upstream_e.powi(2) + (noise.downstream_dn.powi(2) + 1.0 / 12.0) / (gain * gain)).sqrt()
    }

    /// Electrons of each channel for a picture's red, green and blue of value 1.
    pub fn electrons(&self, exposure: &Exposure) -> DMat3 {
        let iso = exposure.iso.unwrap_or(self.base_iso);
        match exposure.light.unwrap_or(Light::White(SATURATION_LX_S / iso)) {
            Light::White(lx_s) => self.electrons_per_lx_s(exposure.pitch_um) * lx_s,
            Light::Photons(count, nm) => {
                let last = self.sensor.curves().len() - 1;
                let seen: [f64; 3] = std::array::from_fn(|c| self.quantum_efficiency(c.min(last), nm));
                let luminance = crate::luminance(crate::Rgb::ONE);
                let weights = [crate::Rgb::X, crate::Rgb::Y, crate::Rgb::Z].map(|c| crate::luminance(c) / luminance);
                let columns = weights.map(|weight| DVec3::from_array(seen) * count * f64::from(weight));
                DMat3::from_cols(columns[0], columns[1], columns[2])
            }
        }
    }

    /// The channels' answers to white, D65, the largest 1; `None`: the sensor has no colours.
    pub fn neutral(&self) -> Option<DVec3> {
        let white = self.electrons_per_lx_s(1.0) * DVec3::ONE;
        self.sensor.monochrome.is_empty().then(|| white / white.max_element())
    }

    /// The channels from CIE XYZ under D65, as white of Y = 1 makes [`Self::neutral`] (the DNG's ColorMatrix); `None`: the sensor has no
    /// colours.
    pub fn channels_from_xyz(&self) -> Option<DMat3> {
        let matrix = self.electrons_per_lx_s(1.0);
        let largest = (matrix * DVec3::ONE).max_element();
        self.sensor.monochrome.is_empty().then(|| matrix * largest.recip() * spectrum::rec_709_from_xyz())
    }
}
