//! Light that goes straight from a source to the lens, found from the source: small lamps far out of focus, which few camera rays hit.
//!
//! The strategy that light tracing has for paths without scattering (Veach 1997, section 10.3): a source, a place on it, a direction
//! to the entrance pupil; the ray is traced forwards through the lens at the wavelengths of a set, and its light counts where each of
//! them arrives on the film. Its density and that with which the camera leads to the same ray are both known per unit of etendue
//! ([`crate::camera::lens::from_scene`]), so that camera rays and these share the light by the power heuristic, source by source.
//!
//! Which sources are worth it is measured before the render (`pipeline/aiming.rs`).

use super::PreparedScene;
use super::mis::power_heuristic;
use crate::accel::Ray;
use crate::camera::lens::from_scene::Landed;
use crate::camera::lens::real_lens::RealLens;
use crate::camera::lens::real_lens::packet::Splats;
use crate::camera::shutter::Exposure;
use crate::lights::{Source, SourceGroup};
use crate::sampler::{PathSampler, mix, raster::Raster};
use glam::{Affine3A, Vec3A};
use std::sync::Arc;

/// Rays of a round, about: fewer share them out less well, more leave a group without light in a render's first samples.
const ROUND: f32 = 256.0;
/// The seed of the numbers of aimed rays.
const SEED: u32 = 0x6d2b_79f5;

/// The lights that send rays to the lens.
pub struct AimedLights {
    lens: Arc<RealLens>,
    exposure: Option<Exposure>,
    groups: Vec<AimedGroup>,
    /// The group of each ray of a round: every round has the same number of rays of each group.
    round: Vec<u32>,
    /// Rays for each camera ray.
    rays_per_sample: f64,
    /// Rays of each source for each pixel of the picture and sample, by the source's number.
    rays_of: Vec<f32>,
    seed: u32,
}

/// A lamp or an object that sends rays to the lens.
struct AimedGroup {
    sources: Vec<Source>,
    /// Sums of the parts of its rays that the sources get; the last is 1.
    ends: Vec<f32>,
    /// The first of its rays in a round, and their number.
    first: u32,
    rays: u32,
}

/// A ray from a source, turned round: as the camera would have sent it.
#[derive(Clone, Copy, Debug)]
pub struct AimedRay {
    /// The ray from the lens to the source, where the lens stands in the middle of the exposure.
    pub ray: Ray,
    /// The source that the ray left: its light alone counts.
    pub source: Source,
    /// Contributions of radiance along the ray.
    pub splats: Splats,
}

/// A ray from a source with its densities.
pub(crate) struct Flight {
    pub(crate) ray: Ray,
    pub(crate) splats: Splats,
    /// Density of the choice of the ray, the source given, per unit of etendue.
    pub(crate) density: f32,
    /// Density with which the camera leads to the ray, likewise.
    pub(crate) camera_density: f32,
}

/// The lens, where it stands.
#[derive(Clone, Copy)]
pub(crate) struct StandingLens<'a> {
    pub(crate) lens: &'a RealLens,
    way: Option<Affine3A>,
}

impl<'a> StandingLens<'a> {
    /// The lens at a moment of the exposure.
    pub(crate) fn at_moment(lens: &'a RealLens, exposure: Option<&Exposure>, moment: u16) -> Self {
        Self { lens, way: exposure.and_then(|exposure| exposure.way(moment)) }
    }

    /// A place as the lens would have it if it stood still.
    pub(crate) fn place(self, p: Vec3A) -> Vec3A {
        self.way.map_or(p, |way| way.inverse().transform_point3a(p))
    }

    /// The middle of the entrance pupil.
    pub(crate) fn at(self) -> Vec3A {
        let at = self.lens.entrance_at();
        self.way.map_or(at, |way| way.transform_point3a(at))
    }

    fn direction(self, d: Vec3A) -> Vec3A {
        self.way.map_or(d, |way| way.inverse().transform_vector3a(d))
    }

    /// A ray of a source to the lens. `u` chooses the direction, the place and the pixels.
    pub(crate) fn fly(
        self,
        stage: &PreparedScene,
        raster: &Raster,
        source: Source,
        [u_direction, u_place, u_pixels]: [[f32; 2]; 3],
        u_set: f32,
        moment: u16,
    ) -> Option<Flight> {
        let (lens, lights, scene) = (self.lens, &stage.lights, &stage.scene);
        let place = lights.aim_place(scene, source, u_place, self.at(), moment)?;
        let origin = self.place(place);
        let (d, pdf) = lens.aim(origin, u_direction)?;
        let there = self.way.map_or(d, |way| way.transform_vector3a(d).normalize());
        let (_, per_area) = lights.aimed_hit(scene, source, (place, there), self.at(), moment)?;
        let set = ((u_set * lens.sets() as f32) as usize).min(lens.sets() - 1);
        let Landed { splats, density } = lens.land(set, origin, d, raster, u_pixels)?;
        let front = origin + d * lens.distance_from(origin, d);
        let flight = Flight {
            ray: Ray::new(front, -d).at(moment),
            splats,
            density: per_area * pdf,
            camera_density: density as f32,
        };
        (flight.density > 0.0 && flight.density.is_finite()).then_some(flight)
    }
}

impl AimedLights {
    /// No lights yet, and so many rays from them for each camera ray.
    pub(crate) fn new(lens: &Arc<RealLens>, exposure: Option<&Exposure>, rays_per_sample: f32, seed: u32) -> Self {
        Self {
            lens: Arc::clone(lens),
            exposure: exposure.cloned(),
            groups: Vec::new(),
            round: Vec::new(),
            rays_per_sample: f64::from(rays_per_sample),
            rays_of: Vec::new(),
            seed: seed ^ SEED,
        }
    }

    /// Rays from the lights for each camera ray.
    pub fn rays_per_sample(&self) -> f32 {
        self.rays_per_sample as f32
    }

    /// Adds a group, with its part of all rays.
    fn push(&mut self, group: &SourceGroup, part: f32) {
        let area: f32 = group.sources.iter().map(|(_, area)| area).sum();
        let mut sum = 0.0;
        let (mut sources, mut ends) = (Vec::new(), Vec::new());
        for (source, its) in &group.sources {
            sum += its / area;
            sources.push(*source);
            ends.push(sum);
        }
        let (first, rays) = (self.round.len() as u32, ((part * ROUND) as u32).max(1));
        self.round.extend(std::iter::repeat_n(self.groups.len() as u32, rays as usize));
        self.groups.push(AimedGroup { sources, ends, first, rays });
    }

    /// Shares out the rays among groups, each with its part of them; camera rays come from a part of the picture.
    pub(crate) fn share_out<'a>(&mut self, groups: impl Iterator<Item = (&'a SourceGroup, f32)>, rendered: f32) {
        groups.for_each(|(group, part)| self.push(group, part));
        let per_ray = self.rays_per_sample() * rendered / self.round.len() as f32;
        for group in &self.groups {
            let mut before = 0.0;
            for (source, end) in group.sources.iter().zip(&group.ends) {
                self.rays_of.resize(self.rays_of.len().max(source.index() + 1), 0.0);
                self.rays_of[source.index()] = per_ray * group.rays as f32 * (end - before);
                before = *end;
            }
        }
    }

    fn lens_at(&self, moment: u16) -> StandingLens<'_> {
        StandingLens::at_moment(&self.lens, self.exposure.as_ref(), moment)
    }

    /// The ray that belongs to a camera ray, by its number among all of the picture; `None` for most, where they are few.
    pub fn ray(
        &self,
        stage: &PreparedScene,
        raster: &Raster,
        number: u64,
        moment: u16,
    ) -> Option<(AimedRay, PathSampler)> {
        let before = |number: u64| (number as f64 * self.rays_per_sample) as u64;
        let own = before(number);
        if before(number + 1) == own {
            return None;
        }
        // Each group has a sequence of its own, of which a round takes the next points.
        let (round, place) = (own / self.round.len() as u64, own % self.round.len() as u64);
        let index = self.round[place as usize];
        let group = &self.groups[index as usize];
        let point = round * u64::from(group.rays) + (place - u64::from(group.first));
        let mut sampler = PathSampler::numbered(point as u32, self.seed ^ mix(index));
        // The place in the disc and the choice of the pixel are stratified together: they decide how much each pixel gets.
        let [u0, u1, u_column, u_row] = sampler.next_4d();
        let [u_source, u2, u3, u_set] = sampler.next_4d();
        let source = group.sources[group.ends.partition_point(|end| *end <= u_source).min(group.sources.len() - 1)];
        let numbers = [[u0, u1], [u2, u3], [u_column, u_row]];
        let flight = self.lens_at(moment).fly(stage, raster, source, numbers, u_set, moment)?;
        let density = self.rays_of[source.index()] * flight.density;
        let splats = flight.splats.scaled(power_heuristic(density, flight.camera_density) / density);
        Some((AimedRay { ray: flight.ray, source, splats }, sampler))
    }

    /// The weight of light that a camera ray, which the camera led to with a density per unit of etendue, finds at a point of a source.
    pub fn weight(&self, stage: &PreparedScene, source: Source, ray: &Ray, at: Vec3A, camera_density: f32) -> f32 {
        let rays = self.rays_of.get(source.index()).copied().unwrap_or(0.0);
        if rays == 0.0 {
            return 1.0;
        }
        let lens = self.lens_at(ray.moment);
        let hit = stage.lights.aimed_hit(&stage.scene, source, (at, -ray.direction), lens.at(), ray.moment);
        let Some((place, per_area)) = hit else { return 1.0 };
        let pdf = lens.lens.aim_pdf(lens.place(place), lens.direction(-ray.direction));
        power_heuristic(camera_density, rays * per_area * pdf)
    }
}
