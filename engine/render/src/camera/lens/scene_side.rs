//! Rays that are chosen in the scene: from a point that is sharp to a point of the entrance pupil (Wu et al. 2011, section
//! 5.3 and figure 6), and on through the lens to the film.

use super::real_lens::RealLens;
use super::real_lens::packet::{HeroSample, Request, Splats};
use crate::sampler::raster::Raster;
use glam::Vec2;
use petzval_optics::trace::Ray as LensRay;

/// Part of the samples that is spread over more than the picture, for light that the lens brings into it from beyond.
const DEFENSIVE_SHARE: f32 = 0.05;
/// The margin of that area about the picture, as a part of each side.
const BEYOND: f32 = 0.15;

/// True if the ray from the scene is one of those that are spread over more than the picture: it has nothing to do with its pixel.
pub fn is_astray(request: &Request) -> bool {
    request.u_beyond < DEFENSIVE_SHARE
}

impl RealLens {
    /// Prepares the data that every ray from the scene needs, once for all threads.
    pub fn prepare_for_scene_first(&self) {
        self.focal_surface();
    }

    /// A ray for a pixel that is chosen in the scene, with the contributions of all wavelengths of a set; `None` where it is lost
    /// at all of them.
    pub fn lead_from_scene(&self, request: &Request, raster: &Raster) -> Option<HeroSample> {
        let place =
            if is_astray(request) { (Vec2::from(request.u_place) - 0.5) * (1.0 + 2.0 * BEYOND) } else { request.place };
        let is_near = place.abs().max_element() <= 0.5 + BEYOND;
        let spread = if is_near { (1.0 + 2.0 * BEYOND).powi(-2) } else { 0.0 };
        // For each pixel's area, where every pixel has one sample.
        let samples = DEFENSIVE_SHARE * spread + (1.0 - DEFENSIVE_SHARE) * raster.density(place);
        let film = self.mount.film_at(place);
        let focal = self.focal_surface().point(film.point, film.normal)?;
        let aim = self.entrance().sample(focal.point, request.u_lens.map(f64::from))?;
        // Etendue: the surface's element as the ray sees it, times the solid angle.
        let seen = aim.direction.dot(focal.area_per_film_area).abs() * film.area;
        let density = f64::from(samples) * aim.pdf_per_sr / seen;
        let (set, _) = self.leader(request.u_wavelength);
        let start = self.entrance().before(focal.point, aim.direction);
        let arrivals =
            self.arrivals(set, LensRay { origin: start, direction: aim.direction }, raster, request.u_pixels);
        let share = (density * self.packet_size() as f64).recip();
        if !(share.is_finite() && share > 0.0 && arrivals.iter().any(Option::is_some)) {
            return None;
        }
        let splats = Splats::new(&arrivals, set, self.spectrum.sets(), share as f32);
        let out = LensRay { origin: start, direction: -aim.direction };
        Some(HeroSample { ray: self.mount.to_render(&out), splats, set, density: density * self.packet_size() as f64 })
    }
}
