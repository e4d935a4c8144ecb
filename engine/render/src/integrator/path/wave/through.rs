//! Paths through volumes: scattering, transmittance and emission along rays.

use super::super::choice::MisContext;
use super::super::notes::AovSink;
use super::super::{FastGi, Limits, transmittance};
use super::Path;
use super::found::Found;
use super::place::Shadow;
use crate::Rgb;
use crate::accel::{Hit, Ray};
use crate::integrator::PreparedScene;
use crate::integrator::aimed::AimedLights;
use crate::integrator::media::{Event, Stack, Stretch};
use crate::integrator::mis::power_heuristic;
use crate::lights::receiver::LightSampleContext;
use crate::lights::{LightHit, Line};
use crate::nodes::volume::Medium;
use crate::nodes::{RayCone, View};
use crate::sampler::hashed::HashedNumbers;
use crate::sampler::warp;
use crate::scene::Scene;
use crate::scene::visibility::Rays;
use crate::surface::SurfacePoint;
use glam::Vec3A;
use std::f32::consts::TAU;

/// The media that a path is in.
pub(super) struct MediumState {
    pub(super) stack: Stack,
    /// Scatterings in volumes so far.
    bounces: u32,
    /// Distance along the path's ray from the surface that it leaves to its origin, which is kept off the surface: media begin there.
    ahead: f32,
}

/// The media that a shadow ray starts in, and the seed of its random numbers.
pub(super) struct ShadowMedia {
    stack: Stack,
    seed: u64,
}

/// The result of a path's way through volumes.
pub(super) enum MediumEvent {
    /// Light comes to the hit of the path's ray.
    Passed,
    /// The path is scattered before the hit.
    Scattered,
    /// The path ends: the light is absorbed, or a limit or Russian roulette ends it.
    Ended,
}

/// True if the surface at a point is only the border of a volume.
pub(super) fn is_only_volume(stage: &PreparedScene, point: &SurfacePoint) -> bool {
    stage.scene.materials[point.material as usize].graph.is_only_volume()
}

impl MediumState {
    /// The media at the start of a path.
    pub(super) fn new(stage: &PreparedScene, path: &Path) -> Self {
        Self { stack: Stack::around(stage, &path.ray), bounces: 0, ahead: 0.0 }
    }

    /// The place at a distance along a ray that begins at the surface it leaves: not so near to it that rounding may put the place beyond.
    fn place(&self, ray: &Ray, distance: f32) -> Vec3A {
        /// The part of [`Self::ahead`] in which places are known: that is a bound on several roundings, this about one.
        const ONE_ROUNDING: f32 = 0.125;
        ray.origin + ray.direction * distance.max(ONE_ROUNDING * self.ahead)
    }

    /// The path's ray leaves a surface.
    fn start_at(&mut self, point: &SurfacePoint, path: &Path) {
        /// Least cosine to the normal at which the ray is followed back to the surface.
        const LEAST_SLANT: f32 = 0.05;
        let slant = path.ray.direction.dot(point.geometric_normal).abs();
        self.ahead = if slant > LEAST_SLANT { point.position_error / slant } else { 0.0 };
    }

    /// Crosses a surface that the path passed.
    pub(super) fn pass(&mut self, scene: &Scene, point: &SurfacePoint, path: &Path) {
        self.stack.cross(scene, point);
        self.start_at(point, path);
    }

    /// True if the limit of scatterings in volumes allows another.
    pub(super) fn may_scatter(&self, limits: &Limits) -> bool {
        self.bounces <= limits.kinds.volume
    }

    /// Follows a path to its next hit, and adds the light of lamps on the way.
    #[expect(clippy::too_many_lines, clippy::too_many_arguments, reason = "a kernel")]
    pub(super) fn bring<N: AovSink>(
        &mut self,
        stage: &PreparedScene,
        limits: &Limits,
        aimed: Option<&AimedLights>,
        path: &mut Path,
        hit: Option<&Hit>,
        found: &mut Found<'_, N>,
        shades: (&mut Vec<Shadow<N::Of>>, &mut Vec<ShadowMedia>),
    ) -> MediumEvent {
        let t_max = hit.map_or(path.ray.t_max, |hit| hit.t);
        if hit.is_none() {
            self.stack.leave_objects();
        }
        let [u_first, u_second] = [path.sampler.next_4d(), path.sampler.next_4d()];
        let u_distance = path.sampler.next_4d();
        self.lamps(
            stage,
            limits,
            aimed,
            path,
            t_max,
            found,
            &mut HashedNumbers::new([u_distance[2], u_distance[3], u_first[0]]),
        );
        if self.stack.is_empty() {
            return MediumEvent::Passed;
        }
        // A last ray that hits nothing goes on through what fills all space, and may be scattered there; one that hits a surface
        // ends there.
        let is_last = limits.approximations.fast_gi.last_ray(path.way).is_some();
        let t_max = if is_last && hit.is_none() { f32::INFINITY } else { t_max };
        // Light of the volumes themselves is found by the camera's rays.
        let is_aimed = path.strategy.is_aimed();
        let may_scatter =
            if hit.is_some() { limits.scatters(path.way) } else { limits.scatters_before_the_sky(path.way) };
        let scatters = may_scatter && !is_aimed && self.may_scatter(limits);
        let origin = path.ray.origin - path.ray.direction * self.ahead;
        let ray = Ray { t_max: t_max + self.ahead, origin, ..path.ray };
        let stretch = Stretch { stage, stack: &self.stack, ray, way: path.way };
        let beside = if scatters {
            self.light_beside(limits, path, &stretch, found, (&mut *shades.0, &mut *shades.1))
        } else {
            None
        };
        let (event, emitted) = stretch.follow(&mut path.throughput, scatters, u_distance);
        if emitted != Rgb::ZERO && emitted.is_finite() && !is_aimed {
            let group = || self.stack.innermost().map_or(0, |i| stage.scene.instances[i as usize].light_group);
            let of = found.notes.met(found.path, path.way, false, group);
            found.add(of, limits.clamp_met(emitted, u32::from(path.way.depth)));
            found.result.hit = true;
        }
        match event {
            Event::Absorbed => {
                found.result.hit = true;
                MediumEvent::Ended
            }
            Event::Through if path.throughput == Rgb::ZERO => MediumEvent::Ended,
            Event::Through => MediumEvent::Passed,
            Event::Scattered { distance, medium, density } => {
                found.result.hit = true;
                let position = self.place(&ray, distance);
                let share = match beside {
                    None => 1.0,
                    Some(Beside::Pivot(pivot)) => density / (density + pivot.density(distance)),
                    Some(Beside::Scattered { part }) => part,
                };
                let at = VolumePlace { stage, limits, position, medium: &medium, share };
                let to = if let Some(Beside::Scattered { .. }) = beside {
                    // Its light sample has been taken.
                    self.receiver(stage, limits, position).at(path.ray.moment)
                } else {
                    let light = path.throughput * share;
                    let [_, u_seed, ..] = u_second;
                    self.light(&at, path, light, found, shades, [u_first[0], u_first[1], u_first[2], u_seed])
                };
                found.notes.turned_in_volume(found.path, path.way);
                self.turn(&at, path, to, [u_first[3], u_second[0], u_second[2], u_second[3]])
            }
        }
    }

    /// A light sample at a place on the ray that is chosen apart from the path's scattering: most paths go through thin media,
    /// and yet each sees the light that media scatter. The place is chosen by the angle under which a light sees it
    /// (Kulla and Fajardo 2012, "Importance Sampling Techniques for Path Tracing in Participating Media"), or, for light from
    /// infinity, as if the path were scattered for certain. `None` where the medium varies, so that the density along the ray is
    /// not known.
    fn light_beside<N: AovSink>(
        &self,
        limits: &Limits,
        path: &mut Path,
        stretch: &Stretch<'_>,
        found: &mut Found<'_, N>,
        shades: (&mut Vec<Shadow<N::Of>>, &mut Vec<ShadowMedia>),
    ) -> Option<Beside> {
        let stage = stretch.stage;
        if !stage.lights.any_is_sampled() {
            return None;
        }
        let medium = stretch.even_medium()?;
        let [u_choice, u_place, u_distance, u_seed] = path.sampler.next_4d();
        let [u_light, u0, u1, u_channel] = path.sampler.next_4d();
        let ray = &stretch.ray;
        // A light that is likely to shine on some place of what is well seen.
        let reach = ray.t_max.min(3.0 / medium.extinction.max_element().max(f32::MIN_POSITIVE)).min(1e6);
        let to = self.receiver(stage, limits, ray.origin + ray.direction * (reach * u_place));
        let (beside, distance) = if u_choice < to.sky_chance || !stage.lights.has_local() {
            let (distance, part) = stretch.even_scattering(&medium, path.throughput, [u_channel, u_distance])?;
            (Beside::Scattered { part }, distance)
        } else {
            let u = (u_choice - to.sky_chance) / (1.0 - to.sky_chance);
            let pivot = Pivot::new(ray, stage.lights.near(&to, u.min(1.0 - f32::EPSILON))?)?;
            (Beside::Pivot(pivot), pivot.sample(u_distance))
        };
        if !(distance > 0.0 && distance < ray.t_max) {
            return Some(beside);
        }
        let (left, by_following) = stretch.even_at(&medium, path.throughput, distance);
        // Of the places of light samples; and of that what following the path has, which competes by its directions.
        let (density, share) = match beside {
            Beside::Pivot(pivot) => {
                let density = pivot.density(distance) + by_following;
                (density, by_following / density)
            }
            Beside::Scattered { part } => (by_following / part, part),
        };
        let light = path.throughput * left / density;
        if light.is_finite() && light != Rgb::ZERO {
            let position = self.place(ray, distance);
            let at = VolumePlace { stage, limits, position, medium: &medium, share };
            self.light(&at, path, light, found, shades, [u_light, u0, u1, u_seed]);
        }
        Some(beside)
    }

    /// A light sample at a place that this much light comes to.
    fn light<N: AovSink>(
        &self,
        at: &VolumePlace<'_>,
        path: &Path,
        throughput: Rgb,
        found: &mut Found<'_, N>,
        (shadows, veils): (&mut Vec<Shadow<N::Of>>, &mut Vec<ShadowMedia>),
        [u_light, u0, u1, u_seed]: [f32; 4],
    ) -> LightSampleContext {
        let VolumePlace { stage, limits, position, medium, share } = *at;
        let to = self.receiver(stage, limits, position).at(path.ray.moment);
        let Some((light, source)) = stage.lights.sample_source(&stage.scene, &to, u_light, [u0, u1], path.way) else {
            return to;
        };
        if !light.reaches.any_of(Rays::VOLUME_SCATTER) || !self.takes(stage, light.sets) {
            return to;
        }
        let (value, pdf) = medium.phase(path.ray.direction.dot(light.wi), throughput);
        let is_alone = light.point_like || light.sets.blockers != 0;
        let weight = if is_alone { 1.0 } else { power_heuristic(light.pdf, pdf * share) };
        let arrives = throughput * value * light.radiance * (weight / light.pdf);
        if arrives == Rgb::ZERO || !arrives.is_finite() {
            return to;
        }
        let of = found.notes.sampled_in_volume(found.path, path.way, || stage.lights.group(&stage.scene, source));
        if light.cast_shadow {
            // Where it starts is not on a surface: no rounding moved it off one.
            let ray = Ray { t_max: light.reach(0.0), ..Ray::new(position, light.wi).at(path.ray.moment) };
            shadows.push(Shadow { path: found.path, ray, light: arrives, way: path.way, sets: light.sets, of });
            let stack = self.stack.shadowing(&stage.scene);
            veils.push(ShadowMedia { stack, seed: seed([u_seed, u_light, u0]) });
        } else {
            found.add(of, limits.clamp(arrives, u32::from(path.way.depth)));
        }
        to
    }

    /// A direction to go on in.
    fn turn(
        &mut self,
        at: &VolumePlace<'_>,
        path: &mut Path,
        to: LightSampleContext,
        [u_end, u_lobe, u_cos, u_around]: [f32; 4],
    ) -> MediumEvent {
        let Some(cos) = at.medium.sample(path.throughput, u_lobe, u_cos) else { return MediumEvent::Ended };
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (s, c) = (TAU * u_around).sin_cos();
        let wi = warp::to_world(&warp::frame(path.ray.direction), Vec3A::new(sin * c, sin * s, cos)).normalize();
        let (value, pdf) = at.medium.phase(cos, path.throughput);
        path.throughput *= value / pdf;
        path.way = path.way.scattered_in_volume();
        path.is_on_film = false;
        self.bounces += 1;
        if !path.throughput.is_finite() || !path.goes_on(at.limits, u_end) {
            return MediumEvent::Ended;
        }
        path.chosen = MisContext::WithPdf(pdf * at.share, to);
        path.least_pdf = path.least_pdf.min(pdf);
        if at.stage.needs_cones {
            let widening = at.limits.approximations.widening;
            // As wide as an even scattering, however far forward the medium scatters.
            path.cone = path.cone.scattered(path.ray.origin.distance(at.position) + path.travelled, widening, 1.0);
        }
        path.travelled = 0.0;
        self.ahead = 0.0;
        path.ray = Ray::new(at.position, wi).at(path.ray.moment);
        if let Some(last) = at.limits.approximations.fast_gi.last_ray(path.way) {
            let own = self.stack.innermost().map(|instance| &at.stage.scene.instances[instance as usize]);
            path.ray.t_max = own.map_or(last.distance, |instance| instance.last_ray_distance(last.distance));
        }
        path.start = at.position;
        path.from = self.stack.innermost().unwrap_or(0);
        MediumEvent::Scattered
    }

    fn receiver(&self, stage: &PreparedScene, limits: &Limits, position: Vec3A) -> LightSampleContext {
        let to = match self.stack.innermost() {
            Some(instance) => stage.lights.receiver_on(instance, false, position, None, limits.openness),
            None => stage.lights.receiver(position, None, limits.openness),
        };
        to.compensated(!matches!(limits.approximations.fast_gi, FastGi::Replace { .. }))
    }

    /// True if light of an emitter of these sets lights the object whose medium the path is in.
    fn takes(&self, stage: &PreparedScene, sets: crate::scene::visibility::LightSets) -> bool {
        let links = |instance: u32| &stage.scene.instances[instance as usize].links;
        !stage.lights.is_linked() || self.stack.innermost().is_none_or(|instance| links(instance).takes_light_of(sets))
    }

    /// Adds the light of lamps on this stretch of the ray, each as far as it comes through.
    #[expect(clippy::too_many_arguments, reason = "a part of `bring`")]
    fn lamps<N: AovSink>(
        &self,
        stage: &PreparedScene,
        limits: &Limits,
        aimed: Option<&AimedLights>,
        path: &Path,
        t_max: f32,
        found: &mut Found<'_, N>,
        numbers: &mut HashedNumbers,
    ) {
        if stage.scene.lamps.is_empty() {
            return;
        }
        let PreparedScene { scene, lights, .. } = stage;
        let (end, to) = (path.travelled + t_max, path.chosen.receiver());
        let line = Line { from: path.start, towards: path.ray.direction, t_max: end };
        lights.lamps_along(scene, line, path.way, to, |LightHit { source, radiance, pdf, distance }| {
            if distance <= path.travelled || !path.finds(stage, || lights.sets(source)) {
                return;
            }
            let ray = Ray { t_max: distance - path.travelled, ..path.ray };
            let left = if self.stack.is_empty() {
                Rgb::ONE
            } else {
                Stretch { stage, stack: &self.stack, ray, way: path.way }.transmittance(numbers)
            };
            let light = path.throughput * left * radiance * path.chosen.weight(pdf);
            let counts = path.lens_weight(stage, aimed, path.start + path.ray.direction * distance, || Some(source));
            let of = found.notes.met(found.path, path.way, false, || lights.group(scene, source));
            found.add(of, limits.clamp_met(light, u32::from(path.way.depth)) * counts);
            found.result.hit = true;
        });
    }

    /// Keeps the media of the shadow ray that was just added at a surface, if one was.
    pub(super) fn veil<Of>(
        &self,
        scene: &Scene,
        point: &SurfacePoint,
        shadows: &[Shadow<Of>],
        veils: &mut Vec<ShadowMedia>,
        u: [f32; 3],
    ) {
        if veils.len() < shadows.len()
            && let Some(shadow) = shadows.last()
        {
            let mut stack = self.stack.clone();
            if shadow.ray.direction.dot(point.geometric_normal) < 0.0 {
                stack.cross(scene, point);
            }
            veils.push(ShadowMedia { stack: stack.shadowing(scene), seed: seed(u) });
        }
    }

    /// Enters or leaves a body where the path went through its surface.
    pub(super) fn leave(&mut self, scene: &Scene, point: &SurfacePoint, path: &Path) {
        self.start_at(point, path);
        if path.ray.direction.dot(point.geometric_normal) < 0.0 {
            self.stack.cross(scene, point);
        }
    }
}

/// A place in a volume where light is scattered.
#[derive(Clone, Copy)]
struct VolumePlace<'a> {
    stage: &'a PreparedScene,
    limits: &'a Limits,
    position: Vec3A,
    medium: &'a Medium,
    /// The part of the density of light samples here that is due to following the path: its directions compete with all.
    share: f32,
}

/// The choice of a place for a light sample beside a path.
#[derive(Clone, Copy)]
enum Beside {
    /// Equiangular sampling about a light. Where the path is scattered there is a light sample, too: both share by their densities along
    /// the ray.
    Pivot(Pivot),
    /// Sampling as if the path were scattered for certain: it is this part of paths. Where the path is scattered there is no light sample.
    Scattered { part: f32 },
}

/// Places along a ray, evenly by the angle under which a point beside it sees them.
#[derive(Clone, Copy)]
struct Pivot {
    /// Distance along the ray at which it comes closest to the point.
    closest: f32,
    /// Distance of the point from the ray.
    away: f32,
    /// The angles of the ends of the ray.
    angles: [f32; 2],
}

impl Pivot {
    fn new(ray: &Ray, point: Vec3A) -> Option<Self> {
        let to = point - ray.origin;
        let closest = to.dot(ray.direction);
        // Nearer than that it would be a spike that rounding moves about.
        let away = (to - ray.direction * closest).length().max(1e-4 * to.length()).max(1e-12);
        let angle = |t: f32| ((t - closest) / away).atan();
        let angles = [angle(0.0), angle(ray.t_max)];
        (point.is_finite() && angles[1] > angles[0]).then_some(Self { closest, away, angles })
    }

    fn sample(self, u: f32) -> f32 {
        let [first, last] = self.angles;
        self.closest + self.away * (first + (last - first) * u).tan()
    }

    /// Per unit along the ray.
    fn density(self, distance: f32) -> f32 {
        let off = distance - self.closest;
        self.away / ((self.angles[1] - self.angles[0]) * (self.away * self.away + off * off))
    }
}

fn seed(u: [f32; 3]) -> u64 {
    let bits = |i: usize| u64::from(u[i].to_bits());
    bits(0) ^ (bits(1) << 21) ^ (bits(2) << 42)
}

impl ShadowMedia {
    /// The part of a light sample's light that surfaces and volumes let through.
    pub(super) fn light_through<Of>(&self, stage: &PreparedScene, limits: &Limits, shadow: &Shadow<Of>) -> Rgb {
        let Shadow { ray, way, sets, .. } = shadow;
        let scene = &stage.scene;
        let mut left = limits.shadows_pass(*way);
        let cone = RayCone::pixel(&scene.viewport);
        let mut borders: Vec<(f32, SurfacePoint)> = Vec::new();
        let free = stage.accel.light_through(ray, Rays::SHADOW, |hit| {
            let instance = &scene.instances[hit.instance as usize];
            if sets.blockers != 0 && !instance.links.blocks_light_of(*sets) {
                return Rgb::ONE;
            }
            let point = SurfacePoint::new(scene, hit, ray.direction);
            if scene.materials[point.material as usize].volume().is_some() {
                borders.push((hit.t, point));
            }
            if is_only_volume(stage, &point) {
                return Rgb::ONE;
            }
            if left == 0 {
                return Rgb::ZERO;
            }
            left -= 1;
            transmittance(scene, hit, &View::along(ray, cone, hit.t, way.shadow()))
        });
        if free == Rgb::ZERO || (borders.is_empty() && self.stack.is_empty()) {
            return free;
        }
        borders.sort_by(|(a, p), (b, q)| a.total_cmp(b).then((p.instance, p.triangle).cmp(&(q.instance, q.triangle))));
        let mut numbers = HashedNumbers::seeded(self.seed);
        let (mut stack, mut from, mut free) = (self.stack.clone(), 0.0, free);
        let mut dim = |stack: &Stack, from: f32, to: f32| {
            if stack.is_empty() || to <= from {
                return Rgb::ONE;
            }
            let part = Ray { t_max: to - from, origin: ray.origin + ray.direction * from, ..*ray };
            Stretch { stage, stack, ray: part, way: way.shadow() }.transmittance(&mut numbers)
        };
        for (t, point) in &borders {
            free *= dim(&stack, from, *t);
            if free == Rgb::ZERO {
                return free;
            }
            stack.cross(scene, point);
            from = *t;
        }
        if ray.t_max.is_infinite() {
            stack.leave_objects();
        }
        free * dim(&stack, from, ray.t_max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    /// Distances of samples follow their density, beside the point, before it and behind it.
    #[test]
    fn distances_to_a_point_follow_their_density() {
        for (point, length) in [([0.3, 0.0, 2.0], 5.0f32), ([0.02, 0.0, 1.0], 1.0), ([1.0, 0.0, -1.0], 3.0)] {
            let mut ray = Ray::new(Vec3A::ZERO, Vec3A::Z);
            ray.t_max = length;
            let pivot = Pivot::new(&ray, Vec3A::from_array(point)).unwrap();
            let sample = |random: &mut sampling::Random| Some(pivot.sample(random.numbers::<1>()[0]).into());
            let density = |distance: f64| pivot.density(distance as f32).into();
            sampling::values(&format!("pivot {point:?}"), 1 << 16, [0.0, length.into()], sample, density);
        }
    }
}
