//! Film-first for one wavelength, which leads; the light found along its ray is carried back through the lens for the
//! other wavelengths of its set, and counts where each of them arrives.
//!
//! A ray could have been led to by any of them: each is weighted by the balance heuristic over all, which keeps the
//! edges right where some are vignetted. So a wavelength costs a trace through the lens, not a path.

use super::stretch::CameraSampler;
use super::{RenderContext, add_splats};
use crate::Rgb;
use crate::accel::Ray;
use crate::camera::lens::real_lens::RealLens;
use crate::camera::lens::real_lens::batch::LensBatch;
use crate::camera::lens::real_lens::packet::{HeroSample, Request};
use crate::film::TileAccumulator;
use crate::sampler::raster::Raster;

/// Rays from real lenses.
pub(super) struct Hero<'a> {
    lenses: Vec<(&'a RealLens, LensBatch)>,
    raster: &'a Raster,
}

impl<'a> Hero<'a> {
    pub(super) fn new(shot: &RenderContext<'a>) -> Self {
        let lenses = shot.cameras.iter().filter_map(|camera| camera.traced_lens());
        Self { lenses: lenses.map(|lens| (lens, lens.batch())).collect(), raster: shot.raster }
    }
}

impl CameraSampler for Hero<'_> {
    type Lead = HeroSample;

    fn ask(&mut self, camera: usize, requests: &[Request], leads: &mut Vec<Option<HeroSample>>) {
        let (lens, batch) = &mut self.lenses[camera];
        lens.lead_all_batch(requests, self.raster, batch, leads);
    }

    fn ray(lead: &HeroSample) -> Ray {
        lead.ray
    }

    fn density(&self, camera: usize, lead: &HeroSample) -> Option<f32> {
        Some(self.lenses[camera].0.led_density(lead) as f32)
    }

    fn carried(&self, camera: usize) -> usize {
        self.lenses[camera].0.packet_size()
    }

    fn add(&self, camera: usize, _: &Request, lead: &HeroSample, radiance: Rgb, light: &mut TileAccumulator) {
        add_splats(light, self.lenses[camera].0, &lead.splats, radiance);
    }
}
