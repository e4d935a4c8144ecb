//! A picture's light on a sensor, counted.

use super::SensorError;
use super::exposure::{Exposure, ExposureRequest, SATURATION_LX_S};
use super::file::{ReadNoise, SensorFile};
use super::random::Stream;
use super::response::Response;
use glam::{DMat3, DVec3};
use petzval_pictures::dng::{RawPicture, RawTags};
use rayon::prelude::*;
use serde::Serialize;

/// A linear picture.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Scene-linear red, green and blue, Rec.709, first row at the top.
    pub channels: [&'a [f32]; 3],
}

/// The outcome of an exposure.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Width and height, photosites.
    pub size: [usize; 2],
    /// Film speed, ISO.
    pub iso: f64,
    /// System gain, DN for each electron.
    pub gain_dn_per_e: f64,
    /// Mean electrons of each channel for the picture's white.
    pub white_e: [f64; 3],
    /// Mean electrons of the dark current.
    pub dark_e: f64,
    /// Numbers at saturation.
    pub saturated: usize,
    /// Photosites whose light was below zero and counts as none: colours that no light has.
    pub below_zero: usize,
    /// Numbers in all.
    pub numbers: usize,
}

/// A picture on a sensor.
#[derive(Clone, Debug)]
pub struct Exposed {
    /// The numbers.
    pub raw: RawPicture,
    /// The data for a developing program.
    pub tags: RawTags,
    /// The outcome of the exposure.
    pub summary: Summary,
}

/// All that a photosite needs to know.
struct Sensor<'a> {
    file: &'a SensorFile,
    exposure: Exposure,
    electrons: DMat3,
    noise: ReadNoise,
    gain_dn_per_e: f64,
    white_dn: f64,
    request: &'a ExposureRequest,
    size: [usize; 2],
}

/// Photographs a picture: one pixel, one photosite.
///
/// # Errors
/// [`SensorError::Exposure`] for settings that are none, [`SensorError::Picture`] where a pixel is no finite number.
pub fn expose(response: &Response, picture: Picture, request: &ExposureRequest) -> Result<Exposed, SensorError> {
    let file = response.sensor();
    let exposure = request.checked(file)?;
    check_picture(&picture)?;
    let iso = exposure.iso.unwrap_or(response.base_iso);
    let gain_dn_per_e = response.gain_dn_per_e(iso);
    let saturated_dn = (file.black_level_dn + gain_dn_per_e * file.full_well_e).round().max(1.0);
    let sensor = Sensor {
        file,
        electrons: response.electrons(&exposure),
        noise: file.read_noise_at(iso),
        gain_dn_per_e,
        white_dn: file.largest_dn().min(saturated_dn),
        request,
        size: picture.size,
        exposure,
    };
    let planes = sensor.exposure.mosaic.planes();
    let [width, height] = picture.size;
    let mut counts = vec![0_u16; width * height * planes];
    let below_zero =
        counts.par_chunks_mut(width * planes).enumerate().map(|(y, row)| sensor.expose_row(&picture, y, row)).sum();
    let saturated = counts.par_iter().filter(|count| f64::from(**count) >= sensor.white_dn).count();
    let summary = Summary {
        size: picture.size,
        iso,
        gain_dn_per_e,
        white_e: (sensor.electrons * DVec3::ONE).to_array(),
        dark_e: sensor.exposure.dark_e,
        saturated,
        below_zero,
        numbers: counts.len(),
    };
    let tags = tags(response, &sensor, iso);
    Ok(Exposed { raw: RawPicture { size: picture.size, planes, counts }, tags, summary })
}

fn check_picture(picture: &Picture) -> Result<(), SensorError> {
    let [width, height] = picture.size;
    for channel in picture.channels {
        if channel.len() != width * height || channel.is_empty() {
            return Err(SensorError::Picture(format!(
                "the picture has {} numbers in a channel, not {width} x {height}",
                channel.len()
            )));
        }
        if let Some(place) = channel.iter().position(|value| !value.is_finite()) {
            return Err(SensorError::Picture(format!(
                "pixel {}, {}, counted from the upper left, is {}: no light: render it again, or repair it",
                place % width,
                place / width,
                channel[place]
            )));
        }
    }
    Ok(())
}

fn tags(response: &Response, sensor: &Sensor, iso: f64) -> RawTags {
    use super::mosaic::Mosaic;
    let mosaic = match &sensor.exposure.mosaic {
        Mosaic::None | Mosaic::Monochrome => None,
        Mosaic::Pattern { width, filters } => Some(([*width as u16, (filters.len() / width) as u16], filters.clone())),
    };
    // Saturation beside white of the exposure at which a film of that speed saturates.
    let white_e =
        (response.electrons_per_lx_s(sensor.exposure.pitch_um) * DVec3::ONE).max_element() * SATURATION_LX_S / iso;
    let saturation_e = (sensor.white_dn - sensor.file.black_level_dn) / sensor.gain_dn_per_e;
    RawTags {
        baseline_stops: libm::log2(saturation_e / white_e).clamp(-100.0, 100.0),
        model: sensor.file.name.clone(),
        mosaic,
        black_level_dn: sensor.file.black_level_dn.round() as u16,
        white_level_dn: sensor.white_dn as u16,
        // Rows of the file's matrix, columns of ours.
        channels_from_xyz: response.channels_from_xyz().map(|matrix| matrix.transpose().to_cols_array_2d()),
        neutral: response.neutral().map(|neutral| neutral.to_array()),
        iso,
        shutter_s: sensor.request.shutter_s,
        f_number: sensor.request.f_number,
    }
}

impl Sensor<'_> {
    /// Exposes a row; the number of its photosites whose light is below zero.
    fn expose_row(&self, picture: &Picture, y: usize, row: &mut [u16]) -> usize {
        let planes = self.exposure.mosaic.planes();
        let mut below_zero = 0;
        for (x, out) in row.chunks_mut(planes).enumerate() {
            let at = y * self.size[0] + x;
            let colour = DVec3::from_array(picture.channels.map(|channel| f64::from(channel[at])));
            let electrons = self.electrons * colour * self.share_at(x, y);
            let mut is_below = false;
            for (plane, number) in out.iter_mut().enumerate() {
                let channel = self.exposure.mosaic.channel(x, y, plane);
                is_below |= electrons[channel] < 0.0;
                *number = self.number((at * planes + plane) as u64, electrons[channel].max(0.0));
            }
            below_zero += usize::from(is_below);
        }
        below_zero
    }

    /// The number of a photosite with so many electrons of light in the mean.
    fn number(&self, place: u64, light_e: f64) -> u16 {
        let file = self.file;
        let signal_dn = if self.request.noiseless {
            (light_e + self.exposure.dark_e).min(file.full_well_e) * self.gain_dn_per_e
        } else {
            let mut own = Stream::new(self.request.seed, None, place);
            let [share, offset] = own.normal_pair();
            let responds = (1.0 + 0.01 * file.prnu_percent * share).max(0.0);
            let mut noise = Stream::new(self.request.seed, Some(self.request.frame), place);
            let mean = light_e * responds + self.exposure.dark_e;
            // Beyond, the well is full for sure.
            let counted = if mean > 2.0 * file.full_well_e + 1000.0 { mean } else { noise.poisson(mean) };
            let [upstream, downstream] = noise.normal_pair();
            let electrons = counted.min(file.full_well_e) + file.dsnu_e * offset + self.noise.upstream_e * upstream;
            self.gain_dn_per_e * electrons + self.noise.downstream_dn * downstream
        };
        (file.black_level_dn + signal_dn).round().clamp(0.0, self.file.largest_dn()) as u16
    }

    /// The share of the light that passes cover glass and micro-lens at a photosite, of that which passes upright.
    fn share_at(&self, x: usize, y: usize) -> f64 {
        let Some(pupil_mm) = self.request.exit_pupil_mm else { return 1.0 };
        let from_middle = |place: usize, count: usize| place as f64 + 0.5 - 0.5 * count as f64;
        let [across, up] = [from_middle(x, self.size[0]), from_middle(y, self.size[1])];
        let height_mm = 1e-3 * self.exposure.pitch_um * across.hypot(up);
        let angle = libm::atan(height_mm / pupil_mm);
        let glass = self.file.cover_glass_index.map_or(1.0, |index| {
            // Two faces, one reflection each.
            (transmittance(angle, index) / transmittance(0.0, index)).powi(2)
        });
        let aimed = self.file.micro_lens_pupil_mm.map_or(0.0, |designed_mm| libm::atan(height_mm / designed_mm));
        glass * micro_lens_response(&self.file.micro_lens, (angle - aimed).abs().to_degrees())
    }
}

/// Transmittance of a face of glass in air for unpolarized light (Fresnel's equations).
fn transmittance(angle: f64, index: f64) -> f64 {
    let cos = libm::cos(angle);
    let inside = (1.0 - (libm::sin(angle) / index).powi(2)).sqrt();
    let senkrecht = ((cos - index * inside) / (cos + index * inside)).powi(2);
    let parallel = ((index * cos - inside) / (index * cos + inside)).powi(2);
    1.0 - 0.5 * (senkrecht + parallel)
}

/// A micro-lens's response at an angle, degrees, between the table's, and beyond its end the last.
fn micro_lens_response(table: &[[f64; 2]], angle_deg: f64) -> f64 {
    let behind = table.partition_point(|one| one[0] <= angle_deg);
    match (behind.checked_sub(1).and_then(|i| table.get(i)), table.get(behind)) {
        (Some(low), Some(high)) => low[1] + (high[1] - low[1]) * (angle_deg - low[0]) / (high[0] - low[0]),
        (Some(last), None) => last[1],
        _ => 1.0,
    }
}
