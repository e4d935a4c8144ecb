//! Paths that begin at the camera: their hits, their light samples, and the connections to light paths.

use super::vertex::{Vertex, Walk, material, passed};
use super::weights::{Partial, squared, weight};
use super::{CameraEnd, LightPath, is_dark};
use crate::Rgb;
use crate::accel::{Hit, Ray};
use crate::integrator::PreparedScene;
use crate::integrator::aimed::AimedLights;
use crate::integrator::path::{CAMERA_SETS, FirstSurface, Limits, PathResult, SURE_BOUNCES, transmittance};
use crate::lights::receiver::LightSampleContext;
use crate::lights::{LightHit, Line, Source};
use crate::nodes::{self, PathState, RayCone, View};
use crate::sampler::PathSampler;
use crate::scene::visibility::Rays;
use crate::shading::Scattering;
use crate::surface::SurfacePoint;
use glam::Vec3A;

/// Follows a ray from the camera.
#[expect(clippy::too_many_lines, reason = "one loop over the vertices of a path")]
pub(super) fn trace(
    stage: &PreparedScene,
    camera: &CameraEnd<'_>,
    limits: &Limits,
    sampler: PathSampler,
    light_path: &LightPath,
) -> PathResult {
    let mut result = PathResult::default();
    let mut walk = Walk { stage, sampler, first_set: CAMERA_SETS, step: 0, rays: 0 };
    let mut ray = camera.ray;
    let mut carried = Rgb::ONE;
    // Of the ray under way: no technique competes for what the camera sees directly.
    let mut partial = Partial { ends: 0.0, before: 0.0 };
    let mut way = PathState::CAMERA;
    for bounce in 0.. {
        let stretch = walk.follow(ray, way.rays(), way, |_, _| true);
        carried *= stretch.through;
        let lens = match camera.aimed {
            Some(aimed) if bounce == 0 => LensWeight::Shared(aimed, camera.density as f32),
            _ => LensWeight::Alone,
        };
        let met = HitLight { stage, ray: &ray, bounce, way, partial, lens };
        met.lamps(stretch.distance, |light, shared| {
            result.radiance += limits.clamp_met(carried * light, bounce) * shared;
            result.hit = true;
        });
        let Some((point, hit)) = stretch.end else {
            if !(bounce == 0 && limits.hide_sky) {
                met.sky(|light| result.radiance += limits.clamp_met(carried * light, bounce));
            }
            break;
        };
        result.hit = true;
        if bounce == 0 {
            result.first = Some(FirstSurface::from(&point));
        }
        if material(stage, &point).emits() {
            let (light, shared) = met.surface(&point, &hit, stretch.distance);
            result.radiance += limits.clamp_met(carried * light * stretch.kept, bounce) * shared;
        }
        let cos_in = point.geometric_normal.dot(ray.direction).abs();
        if bounce > limits.max_bounces || cos_in <= 0.0 {
            break;
        }
        partial = if bounce == 0 {
            // As the lens would have it if it stood still.
            let (at, to_lens) = match camera.way.map(|way| way.inverse()) {
                None => (point.position, -ray.direction),
                Some(back) => (back.transform_point3a(point.position), back.transform_vector3a(-ray.direction)),
            };
            let aim_pdf = camera.lens.aim_pdf(at, to_lens);
            Partial::first(camera.density * f64::from(cos_in), f64::from(aim_pdf), 0.0)
        } else {
            partial.arrived(stretch.distance, cos_in)
        };
        let vertex = Vertex::new(stage, (point, stretch.kept), (-ray.direction, way), carried, partial, Rays::ALL);
        let [u2, u3, u_split, u_end] = walk.sampler.next_4d();
        if !vertex.bsdf.is_mirror() {
            let found = direct(stage, &vertex, stretch.u_light, &mut walk.rays);
            result.radiance += limits.clamp(found, bounce);
            let left = limits.max_bounces.min(light_path.most_bounces).saturating_sub(bounce) as usize;
            for from_light in light_path.places.iter().take(left) {
                result.radiance += limits.clamp(connect(stage, &vertex, from_light, &mut walk.rays), bounce + 1);
            }
        }
        let Some(next) = vertex.bsdf.sample(u_split, [u2, u3]) else { break };
        carried *= next.weight;
        if bounce + 1 > SURE_BOUNCES {
            let go_on = carried.max_element().min(1.0);
            if u_end >= go_on {
                break;
            }
            carried /= go_on;
        }
        partial = if next.mirror {
            partial.mirrored(vertex.cos(next.wi))
        } else {
            let back_pdf = vertex.seen_from(stage, next.wi).evaluate(vertex.back).1;
            partial.scattered(next.pdf, vertex.cos(next.wi), back_pdf)
        };
        way = way.scattered(next.matte, next.mirror, next.transmitted);
        ray = vertex.ray(next.wi);
    }
    result.rays = walk.rays;
    result
}

/// Follows a ray that a source sent to the lens, as the camera would have sent it.
pub(super) fn see(
    stage: &PreparedScene,
    ray: Ray,
    source: Source,
    limits: &Limits,
    sampler: PathSampler,
) -> PathResult {
    let mut result = PathResult::default();
    let mut walk = Walk { stage, sampler, first_set: CAMERA_SETS, step: 0, rays: 0 };
    let stretch = walk.follow(ray, Rays::CAMERA, PathState::CAMERA, |_, _| true);
    let met = HitLight {
        stage,
        ray: &ray,
        bounce: 0,
        way: PathState::CAMERA,
        partial: Partial { ends: 0.0, before: 0.0 },
        lens: LensWeight::From(source),
    };
    met.lamps(stretch.distance, |light, shared| {
        result.radiance += limits.clamp_met(stretch.through * light, 0) * shared;
    });
    if let Some((point, hit)) = stretch.end.filter(|(point, _)| material(stage, point).emits()) {
        let (light, shared) = met.surface(&point, &hit, stretch.distance);
        result.radiance += limits.clamp_met(stretch.through * light * stretch.kept, 0) * shared;
    }
    result.rays = walk.rays;
    result
}

/// The weight of light that goes straight from a source to the lens.
#[derive(Clone, Copy)]
enum LensWeight<'a> {
    /// No other technique finds it.
    Alone,
    /// The camera led to the ray, with a density per unit of etendue, and sources send rays to the lens.
    Shared(&'a AimedLights, f32),
    /// This source sent the ray: its light alone counts.
    From(Source),
}

/// Light that a ray hits by chance.
struct HitLight<'a> {
    stage: &'a PreparedScene,
    ray: &'a Ray,
    bounce: u32,
    /// The state of the path under way.
    way: PathState,
    partial: Partial,
    lens: LensWeight<'a>,
}

impl HitLight<'_> {
    /// Weight of light that a light sample where the ray began would find with `sample_pdf`, and light paths with
    /// `density` per unit of etendue.
    fn weight(&self, sample_pdf: f32, density: f32) -> f32 {
        weight(squared(sample_pdf) * self.partial.ends + squared(density) * self.partial.before)
    }

    /// The weight of light of a source that the ray hits at a point, beside rays that the source sends to the lens.
    fn lens_weight(&self, source: Option<Source>, at: Vec3A) -> f32 {
        match (self.lens, source) {
            (LensWeight::Shared(aimed, density), Some(source)) => {
                aimed.weight(self.stage, source, self.ray, at, density)
            }
            (LensWeight::From(target), source) => f32::from(u8::from(source == Some(target))),
            _ => 1.0,
        }
    }

    fn receiver(&self) -> Option<LightSampleContext> {
        (self.bounce > 0).then(|| self.stage.lights.receiver_between(self.ray.origin))
    }

    /// Gives the light of lamps to `found`, each with its weight beside rays that sources send to the lens.
    fn lamps(&self, t_max: f32, mut found: impl FnMut(Rgb, f32)) {
        let PreparedScene { scene, lights, emission, .. } = self.stage;
        let Ray { origin, direction, .. } = *self.ray;
        let to = self.receiver();
        let line = Line { from: origin, towards: direction, t_max };
        lights.lamps_along(scene, line, self.way, to.as_ref(), |LightHit { source, radiance, pdf, distance }| {
            // Every lamp that can be hit has extent: the distance does not matter for the density.
            let density = emission.density(scene, lights, source, direction, 1.0, self.ray.moment);
            let shared = self.lens_weight(Some(source), origin + direction * distance);
            found(radiance * self.weight(pdf, density), shared);
        });
    }

    fn sky(&self, mut found: impl FnMut(Rgb)) {
        let PreparedScene { scene, lights, emission, .. } = self.stage;
        let to = self.receiver();
        lights.sky_along(
            scene,
            self.ray.direction,
            self.way,
            to.as_ref(),
            |LightHit { source, radiance, pdf, .. }| {
                found(
                    radiance
                        * self.weight(
                            pdf,
                            emission.density(scene, lights, source, self.ray.direction, 1.0, self.ray.moment),
                        ),
                );
            },
        );
    }

    /// The light of the surface that the ray hits, and its weight beside rays that sources send to the lens.
    fn surface(&self, point: &SurfacePoint, hit: &Hit, distance: f32) -> (Rgb, f32) {
        let PreparedScene { scene, lights, emission, .. } = self.stage;
        let view = View::along(self.ray, RayCone::camera(&scene.viewport, self.ray), distance, self.way);
        let radiance = nodes::emission_at(material(self.stage, point), self.stage.around(), point, &view);
        let source = lights.triangle_source(hit.instance, hit.triangle);
        let (Some(to), Some(source)) = (self.receiver(), source) else {
            return (radiance, self.lens_weight(source, point.position));
        };
        let cos = point.geometric_normal.dot(self.ray.direction).abs();
        let pdf = lights.triangle_pdf(scene, &to, (hit.instance, hit.triangle), distance, cos);
        let density = emission.density(scene, lights, source, self.ray.direction, distance, self.ray.moment);
        (radiance * self.weight(pdf, density), 1.0)
    }
}

/// Light of a light sample at a vertex.
fn direct(stage: &PreparedScene, vertex: &Vertex, [u_choice, u0, u1]: [f32; 3], rays: &mut u32) -> Rgb {
    let PreparedScene { scene, lights, emission, .. } = stage;
    let to = lights.receiver_between(vertex.point.position).at(vertex.point.moment);
    let Some((light, source)) = lights.sample_source(scene, &to, u_choice, [u0, u1], vertex.way) else {
        return Rgb::ZERO;
    };
    let (value, pdf) = vertex.bsdf.evaluate_kinds(light.wi, light.reaches);
    let found = vertex.carried * value * light.radiance / light.pdf;
    if is_dark(found) {
        return Rgb::ZERO;
    }
    let density =
        emission.density(scene, lights, source, light.wi, light.distance, vertex.point.moment) * vertex.cos(light.wi);
    let back_pdf = if density > 0.0 { vertex.seen_from(stage, light.wi).evaluate(vertex.back).1 } else { 0.0 };
    let by_chance = if light.point_like { 0.0 } else { squared(pdf) };
    let others = (by_chance + vertex.partial.others(f64::from(density), back_pdf)) / squared(light.pdf);
    let found = found * weight(others);
    if !light.cast_shadow {
        return found;
    }
    *rays += 1;
    let mut ray = vertex.ray(light.wi);
    ray.t_max = light.reach(vertex.point.position_error);
    let cone = RayCone::pixel(&scene.viewport);
    let through = |hit: &Hit| transmittance(scene, hit, &View::along(&ray, cone, hit.t, vertex.way.shadow()));
    found * stage.accel.light_through(&ray, Rays::SHADOW, through)
}

/// Light that a vertex of a light path sends to a vertex of the camera's path.
fn connect(stage: &PreparedScene, eye: &Vertex, light: &Vertex, rays: &mut u32) -> Rgb {
    if light.bsdf.is_mirror() {
        return Rgb::ZERO;
    }
    let to: Vec3A = light.point.position - eye.point.position;
    let distance2 = to.length_squared();
    let distance = distance2.sqrt();
    let d = to / distance;
    let visible = stage.scene.instances[light.point.instance as usize].visible;
    let (value, pdf) = eye.bsdf.evaluate_kinds(d, visible);
    if value == Rgb::ZERO || !d.is_finite() {
        return Rgb::ZERO;
    }
    let (sent, light_back_pdf) = light.sent(stage, -d, light.way);
    let found = eye.carried * sent / distance2;
    if is_dark(found * value) {
        return Rgb::ZERO;
    }
    let (_, light_pdf) = light.bsdf.evaluate(-d);
    let (_, eye_back_pdf) = eye.seen_from(stage, d).evaluate(eye.back);
    let per_area = |pdf: f32, at: &Vertex| f64::from(pdf) * f64::from(at.cos(d) / distance2);
    let others = eye.partial.others(per_area(light_pdf, eye), eye_back_pdf)
        + light.partial.others(per_area(pdf, light), light_back_pdf);
    let origin = eye.ray(d).origin;
    let gap = light.ray(-d).origin - origin;
    // Both ends stand clear of their surfaces.
    let ray = Ray { t_max: gap.length(), ..eye.point.leaving(origin, gap.normalize_or(d)) };
    let cone = RayCone::pixel(&stage.scene.viewport);
    // The path from the camera would come here by a bounce.
    let through = |hit: &Hit| {
        // A strand of hair does not hide itself.
        if light.point.is_on_strand_of(&stage.scene, hit) {
            return Rgb::ONE;
        }
        passed(&stage.scene, hit, &View::along(&ray, cone, hit.t, PathState::BOUNCE))
    };
    let found = found * weight(others);
    if stage.accel.shows_all_to(Rays::BOUNCE) {
        *rays += 1;
        return found * value * stage.accel.light_through(&ray, Rays::BOUNCE, through);
    }
    // What stands in between hides from some kinds of rays.
    let mut light = Rgb::ZERO;
    for kind in [Rays::DIFFUSE, Rays::GLOSSY, Rays::TRANSMISSION].into_iter().filter(|kind| visible.any_of(*kind)) {
        let (value, _) = eye.bsdf.evaluate_some(d, kind);
        if value != Rgb::ZERO {
            *rays += 1;
            light += found * value * stage.accel.light_through(&ray, kind, through);
        }
    }
    light
}
