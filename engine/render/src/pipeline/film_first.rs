//! The traditional pipeline (Kolb, Mitchell and Hanrahan 1995; Wu et al. 2011, section 5.3 and figure 5): a point
//! of the film, a point of the pupil, out through the lens, into the scene. One wavelength a path.

use super::Shot;
use super::stretch::Leads;
use crate::Rgb;
use crate::accel::Ray;
use crate::camera::batch::LensBatch;
use crate::camera::packet::Request;
use crate::camera::{Camera, CameraRay};
use crate::film::Patch;

/// Rays from any camera.
pub(super) struct FilmFirst<'a> {
    /// With memory for those that work by batches.
    cameras: Vec<(&'a Camera, Option<LensBatch>)>,
}

impl<'a> FilmFirst<'a> {
    pub(super) fn new(shot: &Shot<'a>) -> Self {
        Self { cameras: shot.cameras.iter().map(|c| (c, c.traced_lens().map(|lens| lens.batch()))).collect() }
    }
}

impl Leads for FilmFirst<'_> {
    type Lead = CameraRay;

    fn ask(&mut self, camera: usize, requests: &[Request], leads: &mut Vec<Option<CameraRay>>) {
        match &mut self.cameras[camera] {
            (Camera::Lens(lens), Some(batch)) => lens.sample_batch(requests, batch, leads),
            (camera, _) => leads.extend(requests.iter().map(|r| camera.sample(r.place, r.u_lens, r.u_wavelength))),
        }
    }

    fn ray(lead: &CameraRay) -> Ray {
        lead.ray
    }

    fn add(&self, _: usize, request: &Request, lead: &CameraRay, radiance: Rgb, light: &mut Patch) {
        light.add(request.pixel[0], request.pixel[1], lead.weight * radiance);
    }
}
