//! The light that arrives at the camera, from sources that are seen in the picture and from others: the light that reflections in the lens
//! and scattering would come from.

use crate::accel::Ray;
use crate::integrator::PreparedScene;
use crate::lights::Line;
use crate::luminance;
use crate::nodes::PathState;
use crate::sampler::evenly::Evenly;
use crate::scene::visibility::Rays;
use glam::{DVec3, Vec2, Vec3A};
use std::f32::consts::{PI, TAU};

/// Light samples at the camera's place.
const SAMPLES: u32 = 512;
/// Paths from the lens's front into the scene.
const FRONT_RAYS: u32 = 512;
/// Sources within this angle count as one.
const TOGETHER_RAD: f32 = 0.05;
/// The most directions that are reported.
const MOST: usize = 64;

/// Light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightest {
    /// Render space, unit, towards it.
    pub towards: DVec3,
    /// Irradiance by it on a surface that faces it, in the scene's units (luminance times steradians).
    pub irradiance: f32,
    /// The part of all arriving light.
    pub part: f32,
    /// Place of the light in the picture, fractions of the width and height from the centre; `None`: outside of the picture.
    pub place: Option<Vec2>,
}

/// Light of a source at the camera's place.
struct IncidentLight {
    /// Direction in render space, unit.
    towards: Vec3A,
    /// The source's part of the irradiance on a surface that faces it.
    light: f32,
    /// Density of the sample, where a ray into the scene may find the same light in the sky; otherwise zero.
    sky_pdf: f32,
}

/// Light of all sources at the camera's place. Surfaces between a source and the camera are taken as opaque.
pub(super) struct Arriving(Vec<IncidentLight>);

impl Arriving {
    /// Samples the lights of the scene.
    pub(super) fn new(stage: &PreparedScene) -> Self {
        let to = stage.lights.receiver_between(Vec3A::ZERO);
        let points = Evenly::<3>::default();
        let sample = |i: u32| {
            let [choice, u, v] = points.point(i).map(|u| u as f32);
            let sample = stage.lights.sample(&stage.scene, &to, choice, [u, v], PathState::CAMERA)?;
            let light = luminance(sample.radiance) / (sample.pdf * SAMPLES as f32);
            if !(light > 0.0 && light.is_finite()) {
                return None;
            }
            let mut ray = Ray::new(Vec3A::ZERO, sample.wi);
            ray.t_max = sample.reach(0.0);
            let is_seen = stage.accel.transmittance_of(&ray, Rays::CAMERA, |_| 1.0) > 0.0;
            let sky_pdf = if sample.distance.is_infinite() && !sample.point_like { sample.pdf } else { 0.0 };
            is_seen.then_some(IncidentLight { towards: sample.wi, light, sky_pdf })
        };
        Self((0..SAMPLES).filter_map(sample).collect())
    }

    /// Irradiance on a surface at the camera's place that looks `forwards`, in luminance times steradians: that of sources, of the
    /// sky, and of light that surfaces scatter. `luminances` follows rays as paths.
    pub(super) fn irradiance(
        &self,
        stage: &PreparedScene,
        forwards: Vec3A,
        luminances: impl Fn(&[Ray]) -> Vec<f32>,
    ) -> f32 {
        let of_samples = |one: &IncidentLight| {
            let cos = one.towards.dot(forwards).max(0.0);
            let share = if one.sky_pdf > 0.0 { one.sky_pdf / (one.sky_pdf + cos / PI) } else { 1.0 };
            one.light * cos * share
        };
        self.0.iter().map(of_samples).sum::<f32>() + of_rays(stage, forwards, luminances)
    }

    /// The brightest sources, the strongest first.
    pub(super) fn brightest(self) -> Vec<Brightest> {
        brightest(self.0.into_iter().map(|one| (one.towards, one.light)).collect())
    }
}

/// The part of the irradiance that rays find: their share of the sky, and light of surfaces that are no sources.
fn of_rays(stage: &PreparedScene, forwards: Vec3A, luminances: impl Fn(&[Ray]) -> Vec<f32>) -> f32 {
    let to = stage.lights.receiver_between(Vec3A::ZERO);
    let (right, up) = forwards.any_orthonormal_pair();
    let points = Evenly::<2>::default();
    let mut light = 0.0;
    let (mut rays, mut of_lamps) = (Vec::new(), Vec::new());
    for i in 0..FRONT_RAYS {
        // By the cosine, so that all count alike.
        let [u, v] = points.point(i).map(|u| u as f32);
        let ((sin, cos), cos_front) = ((TAU * v).sin_cos(), (1.0 - u).sqrt());
        let ray = Ray::new(Vec3A::ZERO, u.sqrt() * (right * cos + up * sin) + cos_front * forwards);
        let Some(hit) = stage.accel.closest(&ray, Rays::CAMERA) else {
            stage.lights.sky_along(&stage.scene, ray.direction, PathState::CAMERA, Some(&to), |one| {
                light += luminance(one.radiance) * cos_front / (cos_front + PI * one.pdf);
            });
            continue;
        };
        if stage.lights.triangle_source(hit.instance, hit.triangle).is_some() {
            continue;
        }
        let mut lamps = 0.0;
        let line = Line { from: ray.origin, towards: ray.direction, t_max: hit.t };
        stage.lights.lamps_along(&stage.scene, line, PathState::CAMERA, None, |one| lamps += luminance(one.radiance));
        rays.push(ray);
        of_lamps.push(lamps);
    }
    light += luminances(&rays).iter().zip(of_lamps).map(|(all, lamps)| (all - lamps).max(0.0)).sum::<f32>();
    PI * light / FRONT_RAYS as f32
}

fn brightest(mut found: Vec<(Vec3A, f32)>) -> Vec<Brightest> {
    let total: f32 = found.iter().map(|one| one.1).sum();
    let mut groups: Vec<(Vec3A, f32)> = Vec::new();
    // The strongest samples gather the others around them.
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (towards, light) in found {
        let near = groups.iter_mut().find(|group| group.0.normalize().dot(towards) > TOGETHER_RAD.cos());
        match near {
            Some(group) => *group = (group.0 + towards * light, group.1 + light),
            None => groups.push((towards * light, light)),
        }
    }
    groups.sort_by(|a, b| b.1.total_cmp(&a.1));
    groups.truncate(MOST);
    let one = |(sum, light): (Vec3A, f32)| Brightest {
        towards: sum.as_dvec3().normalize_or(DVec3::Z),
        irradiance: light,
        part: light / total,
        place: None,
    };
    groups.into_iter().map(one).collect()
}
