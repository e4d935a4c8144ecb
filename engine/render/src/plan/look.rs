//! A look at the scene through a camera: the first hit of each place of the picture, its brightness, and the direction from which the light
//! comes from.

use super::coincident::CoincidentFaces;
use super::light::{Arriving, Brightest};
use crate::accel::Ray;
use crate::camera::clip::Clip;
use crate::integrator::PreparedScene;
use crate::integrator::path::{self, Approximations, CAMERA_SETS, KindLimits, Limits};
use crate::luminance;
use crate::sampler::PathSampler;
use crate::scene::visibility::Rays;
use glam::DVec3;
use rayon::prelude::*;

/// Number of rays that are followed as paths, to know the picture's brightness.
const FOLLOWED: usize = 512;
/// Bounces of the paths that are followed.
const BOUNCES: u32 = 3;
/// The part of the paths that is brightest does not count: a source in the picture is not its exposure.
const TRIMMED: f32 = 0.02;

/// The view of a camera.
#[derive(Clone, Debug)]
pub struct SceneProbe {
    /// The nearest and the farthest that it sees along its axis, Blender units; `None` if it sees nothing.
    pub depths: Option<[f64; 2]>,
    /// The part of the picture that sees nothing.
    pub open_part: f64,
    /// Mean luminance of the picture, without its brightest spots.
    pub exposure: f32,
    /// Irradiance on the lens's front, as if all of the front half of the world reached it: luminance times steradians. `None`
    /// where it was not asked for.
    pub front_irradiance: Option<f32>,
    /// The sources that send most light to the camera, the strongest first.
    pub brightest: Vec<Brightest>,
    /// The faces in the picture that lie on each other, those of the largest part of the picture first.
    pub coincident_faces: Vec<CoincidentFaces>,
}

impl SceneProbe {
    /// Irradiance on the front over that of a world as bright as the picture all over; `None` of a black picture, and where it was not
    /// asked for.
    pub fn front_light(&self) -> Option<f64> {
        let even = std::f64::consts::PI * f64::from(self.exposure);
        self.front_irradiance.filter(|_| even > 0.0).map(|front| f64::from(front) / even)
    }

    /// Looks along `rays` (render space) of places all over the picture. `backwards` is the camera's axis, from the scene to
    /// the film; `has_front` where there is a lens for light to arrive at. Also the hit of each ray.
    pub(super) fn along(
        stage: &PreparedScene,
        rays: &[Option<Ray>],
        clip: Option<Clip>,
        backwards: DVec3,
        has_front: bool,
    ) -> (Self, Vec<Option<DVec3>>) {
        let seen = |ray: &Ray| clip.map_or(*ray, |clip| clip.cut(*ray));
        let first = |ray: &Option<Ray>| {
            let ray = seen(ray.as_ref()?);
            let hit = stage.accel.closest(&ray, Rays::CAMERA)?;
            Some((ray.origin + ray.direction * hit.t).as_dvec3())
        };
        let met: Vec<Option<DVec3>> = rays.par_iter().map(first).collect();
        let seen_rays: Vec<Option<Ray>> = rays.iter().map(|ray| ray.as_ref().map(seen)).collect();
        let depths = met.iter().flatten().map(|point| -point.dot(backwards));
        let range = depths.fold(None, |range: Option<[f64; 2]>, depth| {
            Some(range.map_or([depth; 2], |[near, far]| [near.min(depth), far.max(depth)]))
        });
        let looking = rays.iter().flatten().count().max(1);
        let some: Vec<Ray> = rays.iter().flatten().step_by(looking.div_ceil(FOLLOWED)).map(seen).collect();
        let (arriving, forwards) = (Arriving::new(stage), -backwards.as_vec3a());
        let look = Self {
            depths: range,
            open_part: 1.0 - met.iter().flatten().count() as f64 / looking as f64,
            exposure: exposure(stage, &some),
            front_irradiance: has_front.then(|| arriving.irradiance(stage, forwards, |rays| luminances(stage, rays))),
            brightest: arriving.brightest(),
            coincident_faces: CoincidentFaces::along(stage, &seen_rays),
        };
        (look, met)
    }
}

/// Mean luminance along rays, without the brightest.
fn exposure(stage: &PreparedScene, rays: &[Ray]) -> f32 {
    let mut light = luminances(stage, rays);
    light.sort_by(f32::total_cmp);
    light.truncate(((1.0 - TRIMMED) * light.len() as f32).ceil() as usize);
    light.iter().sum::<f32>() / light.len().max(1) as f32
}

/// Luminance along each of the rays, of one path; zero where it is not finite.
fn luminances(stage: &PreparedScene, rays: &[Ray]) -> Vec<f32> {
    let limits = Limits {
        max_bounces: BOUNCES,
        kinds: KindLimits::default(),
        clamp_direct: f32::INFINITY,
        clamp_indirect: f32::INFINITY,
        approximations: Approximations::default(),
        hide_sky: false,
        film_glass: None,
        openness: 0.5,
        roulette: f32::INFINITY,
    };
    let light = |(chunk, rays): (usize, &[Ray])| -> Vec<f32> {
        let rays = rays.iter().enumerate().map(|(i, ray)| {
            let mut sampler = PathSampler::new((chunk * WAVE + i) as u32, 2, 0, 0);
            sampler.jump_to(CAMERA_SETS);
            (*ray, sampler)
        });
        let mut light = Vec::with_capacity(WAVE);
        let finite = |l: f32| if l.is_finite() { l } else { 0.0 };
        path::trace_all(stage, rays, &limits, |_, found| light.push(finite(luminance(found.radiance))));
        light
    };
    const WAVE: usize = 64;
    rays.par_chunks(WAVE).enumerate().flat_map_iter(light).collect()
}
