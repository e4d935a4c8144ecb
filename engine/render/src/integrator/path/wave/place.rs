//! The light sample and the next direction at a place where a path scatters.

use super::super::choice::MisContext;
use super::super::notes::AovSink;
use super::super::{FastGi, Limits, leave, opening, terminator};
use super::Path;
use super::found::Found;
use crate::Rgb;
use crate::accel::Ray;
use crate::integrator::PreparedScene;
use crate::integrator::mis::power_heuristic;
use crate::lights::{LightSample, receiver::LightSampleContext};
use crate::nodes::{PathState, View};
use crate::sampler::warp;
use crate::scene::visibility::{LightSets, Rays};
use crate::shading::{BsdfSample, LobeDecomposition, LobeShares, Scattering};
use crate::surface::SurfacePoint;
use glam::Vec3A;

/// Light that arrives unless something stands in its way.
pub(super) struct Shadow<Of> {
    pub(super) path: u32,
    pub(super) ray: Ray,
    pub(super) light: Rgb,
    pub(super) way: PathState,
    pub(super) sets: LightSets,
    pub(super) of: Of,
}

/// A place where a path scatters.
#[derive(Clone, Copy)]
pub(super) struct ScatterPlace<'a> {
    pub(super) stage: &'a PreparedScene,
    pub(super) limits: &'a Limits,
    pub(super) point: &'a SurfacePoint,
    /// The shading normal, bent where a displacement bends it.
    pub(super) normal: Vec3A,
    /// The part of the paths that come there which scatter; a light sample is taken by all of them.
    pub(super) share: f32,
    /// Distance of the place along the path since its last scattering.
    pub(super) distance: f32,
}

/// Cosine between a normal and that of the triangle from which on light samples leave the even part of the sky to samples of the closures.
/// Where normals lean farther the two find different light, and the picture depends on the weights of both: as in Cycles, the sky's are
/// those of the whole image.
const LEAST_UPRIGHT: f32 = 0.9;

impl ScatterPlace<'_> {
    /// A sample of the lights. Gives the receiver that it was for; `None` of a surface that no light sample can light.
    #[inline(always)]
    pub(super) fn light<N: AovSink>(
        &self,
        path: &Path,
        found: &mut Found<'_, N>,
        shadows: &mut Vec<Shadow<N::Of>>,
        bsdf: &(impl Scattering + LobeDecomposition),
        [u_light, u0, u1]: [f32; 3],
    ) -> Option<LightSampleContext> {
        let Self { stage, limits, point, normal, share, .. } = *self;
        if bsdf.is_mirror() {
            return None;
        }
        let receiving = bsdf.receiving_normal();
        let emits = stage.lights.triangle_source(point.instance, point.triangle).is_some();
        let to = stage.lights.receiver_on(point.instance, emits, point.position, receiving, limits.openness);
        let upright = receiving.unwrap_or(normal).dot(point.geometric_normal).abs();
        let ends_early = matches!(limits.approximations.fast_gi, FastGi::Replace { .. });
        let to = to.at(point.moment).compensated(upright > LEAST_UPRIGHT && !ends_early);
        if let Some((light, source)) = stage.lights.sample_source(&stage.scene, &to, u_light, [u0, u1], path.way)
            && let Some(light) = self.linked(light)
        {
            let grazing = terminator::grazing(&stage.scene, point, normal, light.wi);
            let arrives = path.throughput
                * direct(bsdf, &light, share, grazing.is_some_and(|grazing| grazing.is_beyond))
                * terminator::dimmed(&stage.scene, point, normal, light.wi);
            let is_beyond = grazing.is_some_and(|grazing| grazing.is_beyond);
            let shares = || bsdf.shares(light.wi, light.reaches, is_beyond);
            let group = || stage.lights.group(&stage.scene, source);
            let of = found.notes.sampled(found.path, path.way, shares, group);
            if !light.cast_shadow {
                found.add(of, limits.clamp(arrives, u32::from(path.way.depth)));
            } else if arrives != Rgb::ZERO {
                let ray = match grazing {
                    None => {
                        let t_max = light.reach(point.position_error);
                        Ray { t_max, ..point.leaving(leave(point, light.wi), light.wi) }
                    }
                    Some(grazing) => grazing.ray(&stage.scene, point, &light),
                };
                let (way, sets) = (path.way, light.sets);
                shadows.push(Shadow { path: found.path, ray, light: arrives, way, sets, of });
            }
        }
        Some(to)
    }

    /// A light sample, if the light lights this object. Where it has shadows of its own it counts as if no ray found it: see
    /// [`Path::finds`].
    #[inline(always)]
    fn linked(&self, light: LightSample) -> Option<LightSample> {
        if !self.stage.lights.is_linked() {
            return Some(light);
        }
        let links = &self.stage.scene.instances[self.point.instance as usize].links;
        let point_like = light.point_like || light.sets.blockers != 0;
        links.takes_light_of(light.sets).then_some(LightSample { point_like, ..light })
    }

    /// Samples the direction in which the path goes on; false if it ends.
    #[inline(always)]
    pub(super) fn turn<N: AovSink>(
        &self,
        path: &mut Path,
        found: &mut Found<'_, N>,
        bsdf: &(impl Scattering + LobeDecomposition),
        to: Option<LightSampleContext>,
        [u_end, u_split, u2, u3]: [f32; 4],
    ) -> bool {
        let Some(next) = bsdf.sample(u_split, [u2, u3]) else { return false };
        path.throughput *= next.weight;
        if !next.transmitted {
            path.throughput *= terminator::dimmed(&self.stage.scene, self.point, self.normal, next.wi);
        }
        found.notes.turned(found.path, path.way, || {
            if next.mirror { LobeShares::mirror(next.transmitted) } else { bsdf.shares(next.wi, Rays::BOUNCE, false) }
        });
        path.way = path.way.scattered(next.matte, next.mirror, next.transmitted);
        path.is_on_film &= next.transmitted && self.is_film_glass(bsdf, &next);
        if !path.goes_on(self.limits, u_end) {
            return false;
        }
        path.chosen = match to.filter(|_| !next.mirror) {
            None => MisContext::Alone,
            Some(to) => {
                path.least_pdf = path.least_pdf.min(next.pdf);
                MisContext::WithPdf(next.pdf * self.share, to)
            }
        };
        if self.stage.needs_cones {
            let widening = self.limits.approximations.widening;
            let is_wide = next.mirror || path.cone.spread >= widening;
            let alpha_squared = if is_wide { 0.0 } else { bsdf.mean_alpha_squared(next.wi) };
            path.cone = path.cone.scattered(self.distance, widening, alpha_squared);
        }
        path.travelled = 0.0;
        path.ray = self.point.leaving(leave(self.point, next.wi), next.wi);
        if let Some(last) = self.limits.approximations.fast_gi.last_ray(path.way) {
            path.ray.t_max = self.stage.scene.instances[self.point.instance as usize].last_ray_distance(last.distance);
        }
        path.start = path.ray.origin;
        path.from = self.point.instance;
        true
    }

    /// True if a transparent film is seen through the refraction just sampled.
    fn is_film_glass(&self, bsdf: &impl LobeDecomposition, next: &BsdfSample) -> bool {
        let is_smooth = |most: f32| next.mirror || bsdf.mean_alpha_squared(next.wi) <= most;
        self.limits.film_glass.is_some_and(|most| !next.matte && is_smooth(most))
    }

    /// A ray of the ambient occlusion pass, as `integrate_surface_ao` in shade_surface.h of Cycles: spread by the cosine about the mean normal
    /// of the diffuse lobes. `kept` is the weight of the path where it is scattered.
    #[cold]
    #[inline(never)]
    pub(super) fn occlusion<Of>(
        &self,
        path: (u32, &Path),
        (distance, of): (f32, Of),
        shadows: &mut Vec<Shadow<Of>>,
        bsdf: &impl LobeDecomposition,
        (kept, view): (f32, &View),
        u: [f32; 2],
    ) {
        let (number, path) = path;
        let alpha = Rgb::ONE - opening(self.stage.around(), self.point, view).light;
        let (_, normal) = bsdf.diffuse();
        let d = warp::to_world(&warp::frame(normal), warp::sample_cosine_hemisphere(u)).normalize();
        let scene = &self.stage.scene;
        let ray = match terminator::grazing(scene, self.point, self.normal, d) {
            None => self.point.leaving(leave(self.point, d), d),
            Some(grazing) => grazing.along(scene, self.point, d),
        };
        let ray = Ray { t_max: distance, ..ray };
        let (light, way, sets) = (path.throughput * alpha * kept, path.way, LightSets::EVERYTHING);
        shadows.push(Shadow { path: number, ray, light, way, sets, of });
    }

    /// Light that [`FastGi::Add`] puts in where nothing is near, as `integrate_surface_ao` in shade_surface.h of Cycles: about the
    /// mean of the normals, in no pass but the whole picture.
    #[cold]
    #[inline(never)]
    pub(super) fn ambient<N: AovSink>(
        &self,
        path: &Path,
        found: &Found<'_, N>,
        shadows: &mut Vec<Shadow<N::Of>>,
        bsdf: &impl LobeDecomposition,
        u: [f32; 2],
    ) {
        let FastGi::Add { distance, factor } = self.limits.approximations.fast_gi else { return };
        let (colour, normal) = bsdf.diffuse();
        let light = path.throughput * colour * factor;
        if light == Rgb::ZERO || !light.is_finite() {
            return;
        }
        let d = warp::to_world(&warp::frame(normal), warp::sample_cosine_hemisphere(u)).normalize();
        let ray = Ray { t_max: distance, ..self.point.leaving(leave(self.point, d), d) };
        let (way, sets, of) = (path.way, LightSets::EVERYTHING, found.notes.outside_of_passes());
        shadows.push(Shadow { path: found.path, ray, light, way, sets, of });
    }
}

/// A first surface that scatters less than this is treated as if it scattered so much.
const LEAST_FIRST_THROUGHPUT: f32 = 0.02;

impl Path {
    /// Ends faint paths by Russian roulette; true if this one goes on. A path is faint if it has lost much of its light since the first
    /// scattering: the pixel of a dark surface is dark itself, and its noise counts by that.
    #[inline(always)]
    pub(super) fn goes_on(&mut self, limits: &Limits, u_end: f32) -> bool {
        let brightest = self.throughput.max_element();
        if brightest <= 0.0 {
            return false;
        }
        if self.first_throughput == 0.0 {
            self.first_throughput = brightest.max(LEAST_FIRST_THROUGHPUT);
        }
        let go_on = brightest / self.first_throughput * limits.roulette;
        if go_on < 1.0 {
            if u_end >= go_on {
                return false;
            }
            self.throughput /= go_on;
        }
        true
    }
}

/// Light from one sample that a surface scatters along the path, if nothing stands in between, times the `share` of the paths that are
/// scattered. `is_beyond`: it comes to the other side of the triangle than of the smooth surface.
#[inline(always)]
fn direct(bsdf: &impl Scattering, light: &LightSample, share: f32, is_beyond: bool) -> Rgb {
    let (value, pdf) = if is_beyond {
        bsdf.evaluate_smooth(light.wi, light.reaches)
    } else if light.reaches.all_of(Rays::BOUNCE) {
        bsdf.evaluate(light.wi)
    } else {
        bsdf.evaluate_some(light.wi, light.reaches)
    };
    let weight = if light.point_like { 1.0 } else { power_heuristic(light.pdf, pdf * share) };
    let contribution = value * light.radiance * (share * weight / light.pdf);
    if contribution.is_finite() { contribution } else { Rgb::ZERO }
}
