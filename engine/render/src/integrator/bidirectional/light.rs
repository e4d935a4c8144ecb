//! Paths that begin at the light, and the light that they send to the lens.

use super::vertex::{Vertex, Walk, passed};
use super::weights::{Partial, squared, weight};
use super::{FilmEnd, LightPath, Techniques, is_dark};
use crate::Rgb;
use crate::accel::{Hit, Ray};
use crate::camera::lens::from_scene::Landed;
use crate::integrator::PreparedScene;
use crate::integrator::path::{Limits, SURE_BOUNCES};
use crate::nodes::{PathState, RayCone, View};
use crate::sampler::PathSampler;
use crate::scene::visibility::Rays;
use crate::shading::Scattering;
use glam::Vec3A;
use std::cell::Cell;

/// Sets of four numbers before the light path's first step.
const LIGHT_SETS: u32 = 2;
/// The first of the sampler's sets for aiming at the lens: behind those of all steps.
const AIM_SETS: u32 = 4096;

/// Follows light from a source, as things are at a moment; its scattering places replace those in `path`. Gives the rays traced.
#[expect(clippy::too_many_lines, reason = "one loop over the vertices of a path")]
pub(super) fn trace(
    stage: &PreparedScene,
    limits: &Limits,
    mut sampler: PathSampler,
    moment: u16,
    path: &mut LightPath,
) -> u32 {
    path.places.clear();
    let [u_choice, u0, u1, u2] = sampler.next_4d();
    let [u3, ..] = sampler.next_4d();
    let Some(emitted) = stage.emission.sample(&stage.scene, &stage.lights, u_choice, [u0, u1], [u2, u3], moment) else {
        return 0;
    };
    let (mut kinds, most_bounces) = stage.emission.limits(&stage.scene, &stage.lights, &emitted);
    path.most_bounces = most_bounces;
    let mut walk = Walk { stage, sampler, first_set: LIGHT_SETS, step: 0, rays: 0 };
    let visible = |hit: &Hit| stage.scene.instances[hit.instance as usize].visible;
    // What casts no shadow is lit, and so is what stands behind it: chance decides for which of them the ray is.
    let casts_shadow = |hit: &Hit| visible(hit).any_of(Rays::SHADOW);
    let mut ray = emitted.ray;
    let mut shares = 1.0;
    let mut carried = Rgb::ZERO;
    let mut partial = Partial { ends: 0.0, before: 0.0 };
    for bounce in 0..=limits.max_bounces {
        let (passed, left) = (Cell::new(1.0), Cell::new(kinds));
        let way = if bounce == 0 { PathState::CAMERA.shadow() } else { PathState::BOUNCE };
        let stretch = walk.follow(ray, Rays::BOUNCE, way, |hit, u| {
            // What some kinds of bounces do not see lets them pass, and is itself a place where light goes on.
            let blocks = if bounce == 0 { casts_shadow(hit) } else { visible(hit).all_of(Rays::BOUNCE) };
            if blocks {
                return true;
            }
            passed.set(2.0 * passed.get());
            let stops = u < 0.5;
            if bounce > 0 && !stops {
                left.set(left.get().without(visible(hit)));
            }
            stops
        });
        if bounce == 0 {
            shares *= passed.get();
        } else {
            carried *= passed.get();
        }
        let Some((point, hit)) = stretch.end else { break };
        let back = -ray.direction;
        let cos_in = point.geometric_normal.dot(back).abs();
        if cos_in <= 0.0 {
            break;
        }
        partial = if bounce == 0 {
            let arrived =
                stage.emission.arrive(&stage.scene, &stage.lights, &emitted, point.position, stretch.distance);
            let Some(light) = arrived else { break };
            carried = light.radiance * (shares / light.density);
            let again = f64::from(u8::from(!light.point_like));
            Partial::first(f64::from(light.density * cos_in), f64::from(light.sample_pdf), again)
        } else {
            partial.arrived(stretch.distance, cos_in)
        };
        carried *= stretch.through;
        if is_dark(carried) {
            break;
        }
        let vertex = Vertex::new(stage, (point, stretch.kept), (back, PathState::BOUNCE), carried, partial, left.get());
        kinds = visible(&hit);
        let [u2, u3, u_split, u_end] = walk.sampler.next_4d();
        let next = scatter(stage, &vertex, u_split, [u2, u3]);
        ray = vertex.ray(next.as_ref().map_or(back, |n| n.direction));
        path.places.push(vertex);
        let Some(next) = next else { break };
        (carried, partial) = (next.carried, next.partial);
        if bounce + 1 > SURE_BOUNCES {
            // In units of what a light path brings along.
            let start = path.places[0].carried.max_element();
            let go_on = (carried.max_element() / start).min(1.0);
            if u_end >= go_on {
                break;
            }
            carried /= go_on;
        }
    }
    walk.rays
}

struct Scattered {
    direction: Vec3A,
    carried: Rgb,
    partial: Partial,
}

/// A direction to go on in, away from the light.
fn scatter(stage: &PreparedScene, vertex: &Vertex, u_split: f32, u: [f32; 2]) -> Option<Scattered> {
    let next = vertex.bsdf.sample(u_split, u)?;
    let d = next.wi;
    if !next.mirror {
        let (sent, back_pdf) = vertex.sent(stage, d, vertex.way);
        let partial = vertex.partial.scattered(next.pdf, vertex.cos(d), back_pdf);
        return Some(Scattered { direction: d, carried: sent / next.pdf, partial });
    }
    let kind = if next.transmitted { Rays::TRANSMISSION } else { Rays::GLOSSY };
    if !vertex.kinds.any_of(kind) {
        return None;
    }
    let towards_camera = vertex.seen_from(stage, d);
    let (value, _) = towards_camera.mirror(next.transmitted, vertex.back);
    let (_, chance) = vertex.bsdf.mirror(next.transmitted, d);
    // Radiance is not scaled where the path tracer bends it; a beam's solid angle is, so its power must be.
    let bent = if next.transmitted { towards_camera.relative_index().powi(2) } else { 1.0 };
    let shading = towards_camera.cosine(vertex.back) / towards_camera.cosine(d).max(1e-6);
    let cosines = vertex.cos(d) / vertex.cos(vertex.back) * shading;
    let carried = vertex.carried * value * (bent * cosines / chance);
    let partial = vertex.partial.mirrored(vertex.cos(d));
    carried.is_finite().then_some(Scattered { direction: d, carried, partial })
}

/// Adds to the film the light of a light path's vertices, each seen directly by the camera.
pub(super) fn splat(
    stage: &PreparedScene,
    film: &FilmEnd<'_>,
    limits: &Limits,
    mut sampler: PathSampler,
    path: &LightPath,
    mut add: impl FnMut(u32, u32, Rgb),
) -> u32 {
    let FilmEnd { lens, raster, clip, techniques, way } = *film;
    let back = way.map(|way| way.inverse());
    // As the lens would have it if it stood still.
    let place = |p: Vec3A| back.map_or(p, |back| back.transform_point3a(p));
    let mut rays = 0;
    sampler.jump_to(AIM_SETS);
    for (bounce, vertex) in path.places.iter().enumerate() {
        if bounce as u32 > path.most_bounces {
            break;
        }
        let [u0, u1, u_column, u_row] = sampler.next_4d();
        let [u_set, ..] = sampler.next_4d();
        let is_seen = stage.scene.instances[vertex.point.instance as usize].visible.any_of(Rays::CAMERA);
        if vertex.bsdf.is_mirror() || !is_seen {
            continue;
        }
        let set = ((u_set * lens.sets() as f32) as usize).min(lens.sets() - 1);
        let from = place(vertex.point.position);
        let Some((aim, aim_pdf)) = lens.aim(from, [u0, u1]) else { continue };
        let d = way.map_or(aim, |way| way.transform_vector3a(aim).normalize());
        let (sent, back_pdf) = vertex.sent(stage, d, PathState::CAMERA);
        if is_dark(sent) {
            continue;
        }
        let Some(Landed { splats, density }) = lens.land(set, from, aim, raster, [u_column, u_row]) else {
            continue;
        };
        let others = vertex.partial.others(density * f64::from(vertex.cos(d)), back_pdf) / squared(aim_pdf);
        let light = sent * (techniques.weight(others) / aim_pdf);
        let mut ray = vertex.ray(d);
        ray.t_max = lens.distance_from(place(ray.origin), aim);
        if let Some(clip) = clip {
            let seen = Ray { origin: place(ray.origin), direction: aim, ..ray };
            let Some(way) = clip.way_to_camera(&seen) else { continue };
            ray.t_max = way;
        }
        let cone = RayCone::pixel(&stage.scene.viewport);
        let through = |hit: &Hit| passed(&stage.scene, hit, &View::along(&ray, cone, hit.t, PathState::CAMERA));
        rays += 1;
        let open = stage.accel.light_through(&ray, Rays::CAMERA, through);
        let light = light * open;
        if is_dark(light) {
            continue;
        }
        for splat in splats.as_slice() {
            let seen = lens.response(splat.wavelength) * (light * splat.weight);
            add(splat.x, splat.y, limits.clamp(seen, bounce as u32));
        }
    }
    rays
}

impl Techniques {
    /// The weight of light that ends in the lens.
    fn weight(self, others: f64) -> f32 {
        match self {
            Self::All => weight(others),
            Self::LightAlone => 1.0,
        }
    }
}
