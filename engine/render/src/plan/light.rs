//! Which sources send most light to the camera, seen in the picture or not: what reflections in the lens would come from.

use crate::accel::Ray;
use crate::integrator::Stage;
use crate::luminance;
use crate::nodes::Way;
use crate::sampler::evenly::Evenly;
use crate::scene::visibility::Rays;
use glam::{DVec3, Vec2, Vec3A};

/// Light samples at the camera's place.
const SAMPLES: u32 = 512;
/// Sources within this angle count as one.
const TOGETHER_RAD: f32 = 0.05;
/// Told of so many.
const MOST: usize = 64;

/// Light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightest {
    /// Render space, unit, towards it.
    pub towards: DVec3,
    /// What arrives of it on a surface that faces it, in the scene's units (luminance times steradians).
    pub irradiance: f32,
    /// The part of all light that arrives.
    pub part: f32,
    /// Where it is seen in the picture, fractions of its width and height from its centre; `None` outside of it.
    pub place: Option<Vec2>,
}

/// What sends most light to the camera's place, the strongest first. What stands in between is seen as hiding all.
pub(super) fn brightest(stage: &Stage) -> Vec<Brightest> {
    let to = stage.lights.receiver_between(Vec3A::ZERO);
    let mut found: Vec<(Vec3A, f32)> = Vec::new();
    let points = Evenly::<3>::default();
    for i in 0..SAMPLES {
        let [choice, u, v] = points.point(i).map(|u| u as f32);
        let Some(sample) = stage.lights.sample(&stage.scene, &to, choice, [u, v], Way::CAMERA) else { continue };
        let light = luminance(sample.radiance) / (sample.pdf * SAMPLES as f32);
        if !(light > 0.0 && light.is_finite()) {
            continue;
        }
        let mut ray = Ray::new(Vec3A::ZERO, sample.wi);
        ray.t_max = sample.distance * (1.0 - 1e-3);
        if stage.accel.transmittance_of(&ray, Rays::CAMERA, |_| 1.0) > 0.0 {
            found.push((sample.wi, light));
        }
    }
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
