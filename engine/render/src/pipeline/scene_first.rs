//! The other way round (Wu et al. 2011, section 5.3 and figure 6): a ray between a point that is sharp and a point of the
//! entrance pupil; the light that it finds in the scene is carried through the lens for each wavelength, and counts where it lands.
//!
//! Each pixel starts the rays that its own film point would see sharp: where a lens is sharp they land there again.
//! Transparency is kept with the pixel that started the ray.

use super::stretch::CameraSampler;
use super::{RenderContext, add_splats};
use crate::Rgb;
use crate::accel::Ray;
use crate::camera::lens::real_lens::RealLens;
use crate::camera::lens::real_lens::packet::{HeroSample, Request};
use crate::camera::lens::scene_side::is_astray;
use crate::film::TileAccumulator;
use crate::sampler::raster::Raster;

/// Rays from the scene to real lenses, one by one.
pub(super) struct SceneFirst<'a> {
    lenses: Vec<&'a RealLens>,
    raster: &'a Raster,
}

impl<'a> SceneFirst<'a> {
    pub(super) fn new(shot: &RenderContext<'a>) -> Self {
        Self { lenses: shot.cameras.iter().filter_map(|camera| camera.traced_lens()).collect(), raster: shot.raster }
    }
}

impl CameraSampler for SceneFirst<'_> {
    type Lead = HeroSample;

    fn ask(&mut self, camera: usize, requests: &[Request], leads: &mut Vec<Option<HeroSample>>) {
        leads.extend(requests.iter().map(|request| self.lenses[camera].lead_from_scene(request, self.raster)));
    }

    fn ray(lead: &HeroSample) -> Ray {
        lead.ray
    }

    fn sees_its_pixel(&self, request: &Request) -> bool {
        !is_astray(request)
    }

    fn carried(&self, camera: usize) -> usize {
        self.lenses[camera].packet_size()
    }

    fn add(&self, camera: usize, _: &Request, lead: &HeroSample, radiance: Rgb, light: &mut TileAccumulator) {
        add_splats(light, self.lenses[camera], &lead.splats, radiance);
    }
}
