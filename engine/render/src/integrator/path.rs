//! Path tracing with next-event estimation: at every surface one light is sampled and one direction, each
//! weighted by how well the other technique would have found the same light (power heuristic, Veach 1995).

use super::Stage;
use crate::accel::{Hit, Ray, RayKind, offset_origin};
use crate::lights::{LightSample, tree::Receiver};
use crate::nodes;
use crate::sampler::PathSampler;
use crate::shading::principled::Bsdf;
use crate::surface::SurfacePoint;
use crate::{Rgb, scene::Scene};
use glam::Vec3A;

/// Bounces before a path may be ended by chance.
pub(super) const SURE_BOUNCES: u32 = 3;
/// Surfaces that a path may pass unbent or scatter at, in all: a bound for stacks of transparent leaves.
pub(super) const MOST_STEPS: u32 = 512;
/// The sampler's sets of four numbers that the camera uses before the path begins.
pub const CAMERA_SETS: u32 = 3;
/// The last of them: its first number is the time.
pub const TIME_SET: u32 = 2;
/// Sets used at each surface.
pub(super) const SETS_PER_STEP: u32 = 3;

/// What one path found.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathResult {
    /// Radiance along the camera ray.
    pub radiance: Rgb,
    /// The ray reached something other than the world directly behind transparent surfaces.
    pub hit: bool,
    /// Rays traced, shadow rays included.
    pub rays: u32,
    /// The first surface that the ray did not pass.
    pub first: Option<FirstSurface>,
}

/// A surface that a camera ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstSurface {
    /// Render space.
    pub position: Vec3A,
    /// Unit, towards the ray's origin.
    pub normal: Vec3A,
    /// Index of the instance.
    pub instance: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Index of the material.
    pub material: u32,
    /// Barycentric weights of the second and third corner.
    pub barycentric: [f32; 2],
}

impl From<&SurfacePoint> for FirstSurface {
    fn from(p: &SurfacePoint) -> Self {
        let SurfacePoint { position, instance, triangle, material, barycentric, .. } = *p;
        Self { position, normal: p.shading_normal, instance, triangle, material, barycentric }
    }
}

/// How the current ray was chosen: what light it finds is weighted by this.
#[derive(Clone, Copy)]
enum Chosen {
    /// By the camera or a mirror: no light sample competes.
    Alone,
    /// By a surface's scattering, with this density per steradian; and where a light sample competed.
    WithPdf(f32, Receiver),
}

impl Chosen {
    /// The weight of light found by this ray that a light sample finds with density `light_pdf`.
    fn weight(self, light_pdf: f32) -> f32 {
        match self {
            Self::Alone => 1.0,
            Self::WithPdf(pdf, _) => power_heuristic(pdf, light_pdf),
        }
    }

    /// Where a light sample competed.
    fn receiver(&self) -> Option<&Receiver> {
        match self {
            Self::Alone => None,
            Self::WithPdf(_, to) => Some(to),
        }
    }
}

/// How far light is followed.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Bounces after the first surface.
    pub max_bounces: u32,
    /// Most radiance, in its brightest channel, that light after a bounce may add: fewer bright specks for less
    /// light. Infinite takes all of it.
    pub clamp_indirect: f32,
    /// The world and suns light the scene, but the camera does not see them.
    pub hide_sky: bool,
}

impl Limits {
    /// Light found after `bounce` bounces, as far as it counts.
    #[inline]
    pub(super) fn clamp(&self, light: Rgb, bounce: u32) -> Rgb {
        let most = light.max_element();
        if bounce > 0 && most > self.clamp_indirect { light * (self.clamp_indirect / most) } else { light }
    }
}

/// Follows a ray from the camera.
pub fn trace(stage: &Stage, camera_ray: Ray, limits: &Limits, sampler: &mut PathSampler) -> PathResult {
    let scene = &stage.scene;
    let mut result = PathResult::default();
    let mut ray = camera_ray;
    let mut throughput = Rgb::ONE;
    let mut chosen = Chosen::Alone;
    let mut bounce = 0;
    // Distance since the last scattering, over surfaces passed unbent: what densities by area need.
    let mut travelled = 0.0;
    let mut start = ray.origin;
    for step in 0..MOST_STEPS {
        let camera = bounce == 0;
        let kind = if camera { RayKind::Camera } else { RayKind::Bounce };
        result.rays += 1;
        let hit = stage.accel.closest(&ray, kind);
        let mut lamps_before = |t_max: f32| {
            // From where the ray was scattered, over all that it passed: there a light sample would have been taken.
            stage.lights.lamps_along(start, ray.direction, t_max, camera, chosen.receiver(), |radiance, pdf| {
                result.radiance += limits.clamp(throughput * radiance * chosen.weight(pdf), bounce);
                result.hit = true;
            });
        };
        let Some(hit) = hit else {
            lamps_before(f32::INFINITY);
            if camera && limits.hide_sky {
                break;
            }
            stage.lights.sky_along(scene, ray.direction, camera, |radiance, pdf| {
                result.radiance += limits.clamp(throughput * radiance * chosen.weight(pdf), bounce);
            });
            break;
        };
        sampler.jump_to(CAMERA_SETS + step * SETS_PER_STEP);
        let point = SurfacePoint::new(scene, &hit, ray.direction);
        let [u_alpha, u_end, u_light, u_lobe] = sampler.next_4d();
        if u_alpha >= opacity(scene, &hit) {
            travelled += hit.t;
            ray = Ray::new(offset_origin(point.position, -point.geometric_normal, point.position_error), ray.direction);
            continue;
        }
        lamps_before(travelled + hit.t);
        result.hit = true;
        if result.first.is_none() {
            result.first = Some(FirstSurface::from(&point));
        }
        let material = &scene.materials[point.material as usize];
        if material.emits() {
            let radiance = nodes::emission(material, scene, hit.instance, hit.triangle, point.barycentric);
            let cos = -point.geometric_normal.dot(ray.direction);
            let pdf = chosen.receiver().map_or(0.0, |to| {
                stage.lights.triangle_pdf(scene, to, (hit.instance, hit.triangle), travelled + hit.t, cos)
            });
            result.radiance += limits.clamp(throughput * radiance * chosen.weight(pdf), bounce);
        }
        if bounce > limits.max_bounces {
            break;
        }
        let values = nodes::evaluate(material, scene, &point);
        let bsdf = Bsdf::new(material, &values, &stage.tables[point.material as usize], &point, -ray.direction);
        let [u0, u1, u2, u3] = sampler.next_4d();
        if !bsdf.is_mirror() {
            let to = Receiver { position: point.position, normal: bsdf.receiving_normal() };
            let light = stage.lights.sample(scene, &to, u_light, [u0, u1]);
            if let Some(light) = light {
                let found = throughput * direct(stage, &point, &bsdf, &light, &mut result.rays);
                result.radiance += limits.clamp(found, bounce);
            }
        }
        let [u4, ..] = sampler.next_4d();
        let Some(next) = bsdf.sample(u_lobe, [u2, u3], u4) else { break };
        throughput *= next.weight;
        bounce += 1;
        if bounce > SURE_BOUNCES {
            let go_on = throughput.max_element().min(1.0);
            if u_end >= go_on {
                break;
            }
            throughput /= go_on;
        }
        chosen = if next.mirror {
            Chosen::Alone
        } else {
            Chosen::WithPdf(next.pdf, Receiver { position: point.position, normal: bsdf.receiving_normal() })
        };
        travelled = 0.0;
        ray = Ray::new(leave(&point, next.wi), next.wi);
        start = ray.origin;
    }
    result
}

/// Light from one sample that a surface scatters along the path.
fn direct(stage: &Stage, point: &SurfacePoint, bsdf: &Bsdf, light: &LightSample, rays: &mut u32) -> Rgb {
    let (value, pdf) = bsdf.evaluate(light.wi);
    let weight = if light.point_like { 1.0 } else { power_heuristic(light.pdf, pdf) };
    let contribution = value * light.radiance * (weight / light.pdf);
    if contribution == Rgb::ZERO || !contribution.is_finite() {
        return Rgb::ZERO;
    }
    if !light.cast_shadow {
        return contribution;
    }
    *rays += 1;
    let ray = Ray { origin: leave(point, light.wi), direction: light.wi, t_max: light.distance };
    contribution * stage.accel.transmittance(&ray, |hit| opacity(&stage.scene, hit))
}

/// A start for a ray that leaves a surface along `d`, on the side that it goes to.
pub(super) fn leave(point: &SurfacePoint, d: glam::Vec3A) -> glam::Vec3A {
    let n = point.geometric_normal;
    offset_origin(point.position, if n.dot(d) < 0.0 { -n } else { n }, point.position_error)
}

/// The share of light that a surface stops, 0 to 1.
#[inline]
pub(super) fn opacity(scene: &Scene, hit: &Hit) -> f32 {
    let instance = &scene.instances[hit.instance as usize];
    let slot = scene.meshes[instance.mesh as usize].slot(hit.triangle);
    let material = &scene.materials[instance.material(slot) as usize];
    if material.may_be_transparent() { nodes::alpha(scene, hit.instance, hit.triangle, [hit.u, hit.v]) } else { 1.0 }
}

/// Weight of a sample of density `a` where another technique has density `b` (exponent 2).
#[inline]
fn power_heuristic(a: f32, b: f32) -> f32 {
    if b == 0.0 {
        return 1.0;
    }
    // As a ratio: squares of large densities overflow.
    let r = b / a;
    1.0 / (1.0 + r * r)
}

#[cfg(test)]
mod tests;
