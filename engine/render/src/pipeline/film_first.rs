//! The traditional pipeline (Kolb, Mitchell and Hanrahan 1995; Wu et al. 2011, section 5.3 and figure 5): a point
//! of the film, a point of the pupil, out through the lens, into the scene. One wavelength a path.

use super::RenderContext;
use super::stretch::CameraSampler;
use crate::Rgb;
use crate::accel::Ray;
use crate::camera::lens::real_lens::batch::LensBatch;
use crate::camera::lens::real_lens::packet::Request;
use crate::camera::{Camera, CameraRay};
use crate::film::TileAccumulator;

/// Rays from any camera.
pub(super) struct FilmFirst<'a> {
    /// The cameras, with memory for those that work by batches.
    cameras: Vec<(&'a Camera, Option<LensBatch>)>,
}

impl<'a> FilmFirst<'a> {
    pub(super) fn new(shot: &RenderContext<'a>) -> Self {
        Self { cameras: shot.cameras.iter().map(|camera| (camera, camera.batch())).collect() }
    }
}

impl CameraSampler for FilmFirst<'_> {
    type Lead = CameraRay;

    fn ask(&mut self, camera: usize, requests: &[Request], leads: &mut Vec<Option<CameraRay>>) {
        let (camera, batch) = &mut self.cameras[camera];
        camera.sample_batch(requests, batch.as_mut(), leads);
    }

    fn ray(lead: &CameraRay) -> Ray {
        lead.ray
    }

    fn add(&self, _: usize, request: &Request, lead: &CameraRay, radiance: Rgb, light: &mut TileAccumulator) {
        light.add(request.pixel[0], request.pixel[1], lead.weight * radiance);
    }
}
