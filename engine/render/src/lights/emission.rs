//! Light as it leaves its sources: rays chosen by power, for paths that begin at the light.
//!
//! Three numbers tell a path all about the source of an arriving ray: the radiance, the density with which a light
//! sample taken there would have chosen it, and the density with which light paths choose it, per unit of etendue
//! (Blender units squared times steradians, at right angles to the ray). Of a source without extent both densities
//! leave out the same delta, so that their ratio is right (Veach 1997, section 10.3.5).

use super::lamp::shape::on_disk;
use super::triangle::LitTriangle;
use super::{Emitter, Lights, Source};
use crate::accel::{Hit, Ray, offset_origin};
use crate::nodes::{PathState, RayCone, View};
use crate::sampler::{distribution::AliasTable, warp};
use crate::scene::Scene;
use crate::scene::motion::MIDDLE;
use crate::scene::visibility::Rays;
use crate::surface::SurfacePoint;
use crate::{Rgb, luminance};
use glam::Vec3A;
use std::f32::consts::PI;

/// The choice of a source by its power.
pub struct Emission {
    /// The choice by [`Source`]; `None` where nothing emits, or nothing is there to be lit.
    choice: Option<AliasTable>,
    /// A ball around everything.
    center: Vec3A,
    radius: f32,
}

/// A ray that left a source.
#[derive(Clone, Copy, Debug)]
pub struct EmittedRay {
    /// The ray, render space.
    pub ray: Ray,
    source: Source,
    /// Radiance; intensity of a lamp without extent, irradiance of a sun without extent.
    strength: Rgb,
    /// The cosine of the ray to a triangle's normal.
    cos: f32,
}

/// The light that a ray from a source brings to the place where it arrives.
#[derive(Clone, Copy, Debug)]
pub struct ArrivedLight {
    /// Radiance; for a source without extent, radiance times the solid angle that it has not.
    pub radiance: Rgb,
    /// Density per steradian of [`Lights::sample_source`] at this place, for a receiver without normal.
    pub sample_pdf: f32,
    /// Density of light paths per unit of etendue.
    pub density: f32,
    /// True if no ray can hit the source: it has no extent.
    pub point_like: bool,
}

impl Emission {
    /// The choice among the sources of a scene within `bounds`.
    pub fn new(scene: &Scene, lights: &Lights, bounds: Option<(Vec3A, Vec3A)>) -> Self {
        let Some((low, high)) = bounds else { return Self { choice: None, center: Vec3A::ZERO, radius: 0.0 } };
        // Grown a little: rays that only just touch the outermost corner must not be missing.
        let (center, radius) = (0.5 * (low + high), 0.5005 * (high - low).length());
        let disk = PI * radius * radius;
        let mut powers: Vec<f32> = lights
            .local
            .iter()
            .map(|emitter| match emitter {
                Emitter::Triangle(triangle) | Emitter::Moving(triangle, _) => triangle.power,
                Emitter::Lamp(i) => lights.lamps[i as usize].emission_power(1.0),
            })
            .collect();
        let average = scene.world.texture.map_or(Rgb::ONE, |t| scene.textures[t as usize].average());
        powers.push(luminance((scene.world.color * average).abs()) * 4.0 * PI * disk);
        powers.extend(lights.sky.suns().iter().map(|&i| lights.lamps[i as usize].emission_power(disk)));
        Self { choice: AliasTable::new(&powers), center, radius }
    }

    /// A ray that leaves a source at a moment, chosen by five uniform numbers; `None` where nothing is emitted in that
    /// direction.
    pub fn sample(
        &self,
        scene: &Scene,
        lights: &Lights,
        u_choice: f32,
        u_place: [f32; 2],
        u_direction: [f32; 2],
        moment: u16,
    ) -> Option<EmittedRay> {
        let (index, _, _) = self.choice.as_ref()?.sample(u_choice.min(1.0 - f32::EPSILON));
        let source = Source(index);
        if let Some(lamp) = lights.lamp(source) {
            let r = lamp.emit(u_place, u_direction, (self.center, self.radius));
            let ray = Ray::new(r.origin, r.direction).at(moment);
            return Some(EmittedRay { ray, source, strength: r.strength, cos: 1.0 }).filter(EmittedRay::shines);
        }
        let mut emitted = match lights.triangle_at(scene, source, moment) {
            Some(triangle) => emit_triangle(scene, source, &triangle, u_place, u_direction),
            None => self.emit_world(scene, lights, source, u_place, u_direction)?,
        };
        emitted.ray.moment = moment;
        Some(emitted).filter(EmittedRay::shines)
    }

    fn emit_world(
        &self,
        scene: &Scene,
        lights: &Lights,
        source: Source,
        u_place: [f32; 2],
        u_direction: [f32; 2],
    ) -> Option<EmittedRay> {
        let (towards, strength) = if lights.sky.has_image() {
            let sample = lights.sky.sample_image(scene, None, u_direction)?;
            (sample.wi, sample.radiance)
        } else {
            let d = warp::sample_sphere(u_direction);
            (d, scene.world.radiance(d, &scene.textures))
        };
        let origin = self.center + on_disk(towards, self.radius, u_place) + towards * self.radius;
        Some(EmittedRay { ray: Ray::new(origin, -towards), source, strength, cos: 1.0 })
    }

    /// The light that a ray brings to a place that it reaches after `distance`; `None` if its source, seen from there,
    /// is dark.
    pub fn arrive(
        &self,
        scene: &Scene,
        lights: &Lights,
        emitted: &EmittedRay,
        at: Vec3A,
        distance: f32,
    ) -> Option<ArrivedLight> {
        let source = emitted.source;
        let direction = emitted.ray.direction;
        let chance = lights.source_chance(source, at);
        let (mut radiance, mut point_like) = (emitted.strength, false);
        let from_lamp = match lights.lamp(source) {
            Some(lamp) => {
                let pdf = lamp.arrival_pdf(at, direction, distance)?;
                radiance *= lamp.shine(scene, at, -direction, distance, PathState::LIGHT);
                point_like = lamp.is_point_like();
                if point_like && source.0 < lights.local.len() {
                    radiance /= distance * distance;
                }
                Some(pdf)
            }
            None => None,
        };
        let pdf = match from_lamp {
            Some(pdf) => pdf,
            None => match lights.triangle_at(scene, source, emitted.ray.moment) {
                Some(triangle) => distance * distance / (emitted.cos.max(1e-6) * triangle.area),
                None => lights.sky.image_pdf(scene, -direction),
            },
        };
        let density = self.density(scene, lights, source, -direction, distance, emitted.ray.moment);
        let is_usable = density > 0.0 && density.is_finite() && radiance.is_finite();
        is_usable.then_some(ArrivedLight { radiance, sample_pdf: pdf * chance, density, point_like })
    }

    /// The density, per unit of etendue, with which light paths choose a ray that comes from `source`, `distance` away
    /// along `wi` at a moment.
    pub fn density(
        &self,
        scene: &Scene,
        lights: &Lights,
        source: Source,
        wi: Vec3A,
        distance: f32,
        moment: u16,
    ) -> f32 {
        let Some(choice) = &self.choice else { return 0.0 };
        let chance = choice.probability(source.0);
        if chance == 0.0 {
            return 0.0;
        }
        let density = if let Some(lamp) = lights.lamp(source) {
            lamp.emission_density(distance, self.radius)
        } else if let Some(triangle) = lights.triangle_at(scene, source, moment) {
            let is_front = triangle.normal().dot(wi) < 0.0;
            let share = if triangle.two_sided { 0.5 } else { f32::from(u8::from(is_front)) };
            share / (PI * triangle.area)
        } else {
            let per_sr = if lights.sky.has_image() { lights.sky.image_pdf(scene, wi) } else { warp::SPHERE_PDF };
            per_sr / (PI * self.radius * self.radius)
        };
        chance * density
    }
}

impl Emission {
    /// The kinds of rays of a path from the camera that may reach the source of a ray; with the bounces after which the source lights nothing
    /// more.
    pub fn limits(&self, scene: &Scene, lights: &Lights, emitted: &EmittedRay) -> (Rays, u32) {
        if let Some(lamp) = lights.lamp(emitted.source) {
            return (lamp.reaches(), lamp.most_bounces());
        }
        let triangle = lights.triangle_at(scene, emitted.source, emitted.ray.moment);
        (triangle.map_or(scene.world.visible, |triangle| triangle.reaches()), u32::MAX)
    }
}

impl EmittedRay {
    fn shines(&self) -> bool {
        self.strength != Rgb::ZERO && self.strength.is_finite()
    }
}

impl super::lamp::PreparedLamp {
    /// Power for choosing; of a sun, through a disk of that area.
    fn emission_power(&self, area: f32) -> f32 {
        if self.emits_rays() { self.power() * area } else { 0.0 }
    }
}

impl Lights {
    /// The lamp that a source is, if it is one.
    pub(super) fn lamp(&self, source: Source) -> Option<&super::lamp::PreparedLamp> {
        let index = match self.local.get(source.0) {
            Some(Emitter::Lamp(i)) => i,
            Some(Emitter::Triangle(_) | Emitter::Moving(..)) => return None,
            None => self.sky.suns()[source.0.checked_sub(self.local.len() + 1)?],
        };
        Some(&self.lamps[index as usize])
    }

    /// The triangle that a source is, if it is one, where it stands at a moment.
    pub(super) fn triangle_at(&self, scene: &Scene, source: Source, moment: u16) -> Option<LitTriangle> {
        match self.local.get(source.0)? {
            Emitter::Triangle(triangle) => Some(*triangle),
            Emitter::Moving(triangle, moving) => {
                Some(triangle.standing(scene, scene.moving[moving as usize].at(moment)))
            }
            Emitter::Lamp(_) => None,
        }
    }

    /// The probability with which [`Lights::sample_source`] at [`Lights::receiver_between`] chooses a source.
    fn source_chance(&self, source: Source, at: Vec3A) -> f32 {
        let to = self.receiver_between(at);
        match (source.0.checked_sub(self.local.len()), self.tree(&to)) {
            (Some(index), _) => self.sky.chance(Some(&to), index) * to.sky_chance,
            (None, Some(tree)) => tree.probability(&to, source.0) * (1.0 - to.sky_chance),
            (None, None) => 0.0,
        }
    }
}

/// Cosine-distributed, from the front or from both sides.
fn emit_triangle(
    scene: &Scene,
    source: Source,
    triangle: &LitTriangle,
    u_place: [f32; 2],
    mut u_direction: [f32; 2],
) -> EmittedRay {
    let [u, v] = warp::sample_triangle(u_place);
    let mut out = triangle.normal();
    if triangle.two_sided {
        u_direction[0] *= 2.0;
        if u_direction[0] >= 1.0 {
            u_direction[0] -= 1.0;
            out = -out;
        }
    }
    let local = warp::sample_cosine_hemisphere(u_direction);
    let direction = warp::to_world(&warp::frame(out), local).normalize();
    let hit = Hit { t: 0.0, u, v, instance: triangle.instance, triangle: triangle.triangle, moment: MIDDLE };
    let point = SurfacePoint::new(scene, &hit, -out);
    let strength = triangle.radiance(
        scene,
        [u, v],
        &View {
            direction: -direction,
            distance: 1.0,
            way: PathState::LIGHT,
            moment: MIDDLE,
            is_blurry: true,
            cone: RayCone::pixel(&scene.viewport),
        },
    );
    let origin = offset_origin(point.position, out, point.position_error);
    EmittedRay { ray: Ray::new(origin, direction), source, strength, cos: local.z }
}

#[cfg(test)]
mod tests;
