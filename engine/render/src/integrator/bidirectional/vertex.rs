//! A place where a path from either side scatters, and the stretch of a ray that leads to one.

use super::weights::Partial;
use crate::accel::{Hit, Ray, RayKind, offset_origin};
use crate::integrator::Stage;
use crate::integrator::path::{MOST_STEPS, leave, opacity};
use crate::nodes::{self, MaterialValues};
use crate::sampler::PathSampler;
use crate::shading::principled::Bsdf;
use crate::surface::SurfacePoint;
use crate::{Rgb, scene::material::Material};
use glam::Vec3A;

/// The sampler's sets of four numbers used at each surface.
const SETS_PER_STEP: u32 = 3;

/// Where a path scatters.
pub(super) struct Vertex {
    /// Seen from the side that made it.
    pub(super) point: SurfacePoint,
    values: MaterialValues,
    /// Seen from there.
    pub(super) bsdf: Bsdf,
    /// Unit direction to where the path came from.
    pub(super) back: Vec3A,
    /// From the camera: what radiance that leaves towards it counts. From the light: the power that arrives.
    pub(super) carried: Rgb,
    pub(super) partial: Partial,
}

impl Vertex {
    pub(super) fn new(stage: &Stage, point: SurfacePoint, back: Vec3A, carried: Rgb, partial: Partial) -> Self {
        let values = nodes::evaluate(material(stage, &point), &stage.scene, &point);
        let bsdf = bsdf(stage, &values, &point, back);
        Self { point, values, bsdf, back, carried, partial }
    }

    /// The scattering there, seen from the other end of `d`.
    pub(super) fn seen_from(&self, stage: &Stage, d: Vec3A) -> Bsdf {
        bsdf(stage, &self.values, &self.point.seen_from(d), d)
    }

    /// Cosine to the triangle's own normal.
    pub(super) fn cos(&self, d: Vec3A) -> f32 {
        self.point.geometric_normal.dot(d).abs()
    }

    /// A ray that leaves it.
    pub(super) fn ray(&self, d: Vec3A) -> Ray {
        Ray::new(leave(&self.point, d), d)
    }

    /// Power that arrived from a light and leaves along `d`, towards the camera, as radiance times area at right angles
    /// to the ray; and the density per steradian with which a path from the camera would go on to the light.
    ///
    /// The scattering function is taken in the camera's sense, as it is not symmetric; the cosines are those that turn
    /// radiance into power and back, of the triangle itself (Veach 1997, section 5.3).
    pub(super) fn sent(&self, stage: &Stage, d: Vec3A) -> (Rgb, f32) {
        let (value, pdf) = self.seen_from(stage, d).evaluate(self.back);
        (self.carried * value * (self.cos(d) / self.cos(self.back)), pdf)
    }
}

fn bsdf(stage: &Stage, values: &MaterialValues, point: &SurfacePoint, wo: Vec3A) -> Bsdf {
    Bsdf::new(material(stage, point), values, &stage.tables[point.material as usize], point, wo)
}

pub(super) fn material<'a>(stage: &'a Stage, point: &SurfacePoint) -> &'a Material {
    &stage.scene.materials[point.material as usize]
}

/// A ray from one scattering to the next.
pub(super) struct Stretch {
    /// Where it ends, if anywhere.
    pub(super) end: Option<(SurfacePoint, Hit)>,
    /// From its start; infinite where it leaves the scene.
    pub(super) distance: f32,
    /// Numbers for what happens at its end.
    pub(super) u_end: f32,
    pub(super) u_light: f32,
    pub(super) u_lobe: f32,
}

/// A walk through the scene from either end, with its own random numbers.
pub(super) struct Walk<'a> {
    pub(super) stage: &'a Stage,
    pub(super) sampler: PathSampler,
    /// Set of the sampler with which its first step begins.
    pub(super) first_set: u32,
    pub(super) step: u32,
    pub(super) rays: u32,
}

impl Walk<'_> {
    /// Follows a ray over surfaces that let it pass unbent. `stops` may turn a hit away, given a uniform number.
    pub(super) fn follow(&mut self, ray: Ray, kind: RayKind, stops: impl Fn(&Hit, f32) -> bool) -> Stretch {
        let mut ray = ray;
        let mut distance = 0.0;
        while self.step < MOST_STEPS {
            self.rays += 1;
            let Some(hit) = self.stage.accel.closest(&ray, kind) else { break };
            self.sampler.jump_to(self.first_set + self.step * SETS_PER_STEP);
            self.step += 1;
            let point = SurfacePoint::new(&self.stage.scene, &hit, ray.direction);
            let [u_alpha, u_end, u_light, u_lobe] = self.sampler.next_4d();
            distance += hit.t;
            let opacity = opacity(&self.stage.scene, &hit);
            if u_alpha < opacity && stops(&hit, u_alpha / opacity) {
                return Stretch { end: Some((point, hit)), distance, u_end, u_light, u_lobe };
            }
            let origin = offset_origin(point.position, -point.geometric_normal, point.position_error);
            ray = Ray::new(origin, ray.direction);
        }
        Stretch { end: None, distance: f32::INFINITY, u_end: 0.0, u_light: 0.0, u_lobe: 0.0 }
    }
}
