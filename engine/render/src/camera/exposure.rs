//! Exposure as a photographer sets it: shutter and film speed beside the f-number.

use super::CameraDescription;
use petzval_optics::pupil_map::{on_axis_throughput, unobstructed_part};
use petzval_optics::system::System;
use petzval_optics::trace::Tracer;
use serde::Deserialize;

/// Saturation exposure of a digital camera, lux seconds times ISO: ISO 12232:2019, saturation-based speed.
const SATURATION_LX_S: f64 = 78.0;

/// A shutter and a film.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhysicalExposure {
    /// Exposure time, s.
    pub shutter_s: f64,
    /// Film speed, ISO 12232.
    pub iso: f64,
    /// Luminous flux of one watt of the scene's white light, lm/W. Blender's own exchange formats count 683.
    pub lumens_per_watt: f64,
}

impl PhysicalExposure {
    /// The picture's value for radiance one, W/(m² sr), where the film has an irradiance of `throughput` for it:
    /// 1 is the saturation of the film.
    pub fn value(&self, throughput: f64) -> f64 {
        self.lumens_per_watt * throughput * self.shutter_s * self.iso / SATURATION_LX_S
    }
}

impl CameraDescription {
    /// The picture's value for radiance one in the middle of a film with that irradiance: 1, as Blender has it, unless
    /// the exposure is physical.
    pub(super) fn brightness(&self, throughput: f64) -> f64 {
        self.exposure.map_or(1.0, |exposure| exposure.value(throughput))
    }

    /// The picture's value for radiance one in the middle of a film behind a lens that may have a central obstruction. Exposure by the
    /// T-number makes up for the obstruction as for the absorption of glass; by the f-number the obstruction makes the picture darker.
    pub(super) fn brightness_through(&self, tracer: &Tracer, system: &System, film_z_mm: f64) -> f64 {
        let throughput = on_axis_throughput(tracer, system, film_z_mm);
        let clear = if self.exposes_by_f_number { 1.0 } else { unobstructed_part(tracer, system, film_z_mm) };
        self.brightness(throughput / clear)
    }
}
