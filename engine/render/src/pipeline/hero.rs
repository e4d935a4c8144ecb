//! Film-first for one wavelength, which leads; the light found along its ray is carried back through the lens for the
//! other wavelengths of its set, and counts where each of them arrives.
//!
//! A ray could have been led to by any of them: each is weighted by the balance heuristic over all, which keeps the
//! edges right where some are vignetted. So a wavelength costs a trace through the lens, not a path.

use super::stretch::Leads;
use super::{Shot, add_splats};
use crate::Rgb;
use crate::accel::Ray;
use crate::camera::batch::LensBatch;
use crate::camera::packet::{Led, Request};
use crate::camera::real_lens::RealLens;
use crate::film::Patch;
use crate::sampler::raster::Raster;

/// Rays from real lenses.
pub(super) struct Hero<'a> {
    lenses: Vec<(&'a RealLens, LensBatch)>,
    raster: &'a Raster,
}

impl<'a> Hero<'a> {
    pub(super) fn new(shot: &Shot<'a>) -> Self {
        let lenses = shot.cameras.iter().filter_map(|camera| camera.traced_lens());
        Self { lenses: lenses.map(|lens| (lens, lens.batch())).collect(), raster: shot.raster }
    }
}

impl Leads for Hero<'_> {
    type Lead = Led;

    fn ask(&mut self, camera: usize, requests: &[Request], leads: &mut Vec<Option<Led>>) {
        let (lens, batch) = &mut self.lenses[camera];
        lens.lead_all_batch(requests, self.raster, batch, leads);
    }

    fn ray(lead: &Led) -> Ray {
        lead.ray
    }

    fn carried(&self, camera: usize) -> usize {
        self.lenses[camera].0.packet_size()
    }

    fn add(&self, camera: usize, _: &Request, lead: &Led, radiance: Rgb, light: &mut Patch) {
        add_splats(light, self.lenses[camera].0, &lead.splats, radiance);
    }
}
