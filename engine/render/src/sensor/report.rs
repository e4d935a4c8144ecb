//! The properties of a sensor, for a table.

use super::SensorError;
use super::exposure::ExposureRequest;
use super::response::Response;
use serde::Serialize;

/// A sensor's numbers at a film speed.
#[derive(Clone, Debug, Serialize)]
pub struct SensorReport {
    /// The camera.
    pub name: String,
    /// The source of the curves.
    pub source: String,
    /// The licence of the curves.
    pub licence: String,
    /// The source of the other numbers.
    pub pixel_source: String,
    /// The numbers that no source states.
    pub assumed: Vec<String>,
    /// Distance from photosite to photosite, um.
    pub pixel_pitch_um: f64,
    /// The pattern of colour filters, its rows from above.
    pub mosaic: String,
    /// Bits of the numbers.
    pub bits: u32,
    /// Number without light, DN.
    pub black_level_dn: f64,
    /// Film speed of the sensor's own gain.
    pub base_iso: f64,
    /// Film speed by saturation in D65, ISO 12232.
    pub saturation_iso: f64,
    /// Largest quantum efficiency, with filters.
    pub peak_quantum_efficiency: f64,
    /// True if the file leaves the quantum efficiency to be found from the base speed.
    pub is_efficiency_found: bool,
    /// Film speed of the following.
    pub iso: f64,
    /// System gain K, DN for each electron.
    pub gain_dn_per_e: f64,
    /// Electrons that saturate at this film speed.
    pub saturation_e: f64,
    /// Read noise with quantisation, electrons (the temporal dark noise of EMVA 1288).
    pub read_noise_e: f64,
    /// Ratio of saturation and read noise, stops.
    pub dynamic_range_stops: f64,
    /// Mean dark current, electrons a second.
    pub dark_current_e_per_s: f64,
    /// Standard deviation of photosites in the dark, electrons.
    pub dsnu_e: f64,
    /// Standard deviation of photosites' response, per cent.
    pub prnu_percent: f64,
    /// Electrons of each channel for white of 1 lx s.
    pub white_e_per_lx_s: Vec<f64>,
    /// Channels from CIE XYZ under D65, rows: the ColorMatrix of a raw file.
    pub channels_from_xyz: Option<[[f64; 3]; 3]>,
    /// Luminous exposure, lx s, below which white's noise is more than one in a hundred of the signal in the most sensitive channel.
    pub visible_below_lx_s: f64,
}

/// Noise that shows: one in a hundred of the signal.
const VISIBLE_NOISE: f64 = 0.01;

/// The properties of a sensor at a film speed; `None`: its base speed.
///
/// # Errors
/// [`SensorError::Exposure`](super::SensorError::Exposure) for a film speed that is none.
pub fn report(response: &Response, iso: Option<f64>) -> Result<SensorReport, SensorError> {
    let sensor = response.sensor();
    ExposureRequest { iso, ..ExposureRequest::default() }.checked(sensor)?;
    // What the file leaves open is found by visible light.
    if ![response.base_iso, response.peak_quantum_efficiency].iter().all(|found| *found > 0.0 && found.is_finite()) {
        let what = "its curves see nothing of visible light: give base_iso and peak_quantum_efficiency both";
        return Err(SensorError::File { file: sensor.name.clone(), what: what.to_owned() });
    }
    let iso = iso.unwrap_or(response.base_iso);
    let gain = response.gain_dn_per_e(iso);
    let read_noise_e = response.read_noise_e(iso);
    let saturation_e = sensor.full_well_e.min((sensor.largest_dn() - sensor.black_level_dn) / gain);
    let white = response.electrons_per_lx_s(sensor.pixel_pitch_um) * glam::DVec3::ONE;
    // (electrons + read noise²) / electrons² = tolerance².
    let squared = VISIBLE_NOISE * VISIBLE_NOISE;
    let needed_e = (1.0 + (1.0 + 4.0 * squared * read_noise_e * read_noise_e).sqrt()) / (2.0 * squared);
    Ok(SensorReport {
        name: sensor.name.clone(),
        source: sensor.source.clone(),
        licence: sensor.licence.clone(),
        pixel_source: sensor.pixel_source.clone(),
        assumed: sensor.assumed.clone(),
        pixel_pitch_um: sensor.pixel_pitch_um,
        mosaic: sensor.mosaic.words(),
        bits: sensor.bits,
        black_level_dn: sensor.black_level_dn,
        base_iso: response.base_iso,
        saturation_iso: response.saturation_iso(),
        peak_quantum_efficiency: response.peak_quantum_efficiency,
        is_efficiency_found: sensor.peak_quantum_efficiency.is_none(),
        iso,
        gain_dn_per_e: gain,
        saturation_e,
        read_noise_e,
        dynamic_range_stops: (saturation_e / read_noise_e).log2(),
        dark_current_e_per_s: sensor.dark_current_e_per_s,
        dsnu_e: sensor.dsnu_e,
        prnu_percent: sensor.prnu_percent,
        white_e_per_lx_s: white.to_array()[..sensor.curves().len()].to_vec(),
        channels_from_xyz: response.channels_from_xyz().map(|matrix| matrix.transpose().to_cols_array_2d()),
        visible_below_lx_s: needed_e / white.max_element(),
    })
}
