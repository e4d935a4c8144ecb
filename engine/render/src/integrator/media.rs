//! Participating media along rays: the media that a path is in, distances between collisions in them, and transmittance.
//!
//! Media that are spatially constant are crossed by closed forms, a channel chosen for each distance. In the others light
//! hits tentative particles at a rate that bounds their density cell by cell; those that are none do nothing (null
//! collisions). Bounds come from samples, so that a medium may be denser than its bound: the weights of Galtier et al. 2013
//! stay right there, negative for once, and [`Media::denser_than_bound`] counts it.

mod bound;
mod stack;

pub(crate) use stack::{Stack, StackedMedium};

use super::PreparedScene;
use crate::Rgb;
use crate::accel::Ray;
use crate::nodes::PathState;
use crate::nodes::volume::Medium;
use crate::sampler::hashed::HashedNumbers;
use crate::scene::Scene;
use bound::{Bound, Bounded};
use glam::Vec3A;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Tentative particles on one stretch of a ray; light from behind so many is taken undimmed.
const MOST_STEPS: u32 = 1024;
/// Tentative particles on a ray's way to infinity, which is empty as a rule.
const MOST_STEPS_OUT: u32 = 256;
/// Least part of the light without Russian roulette.
const FAINT: f32 = 0.02;

/// The media of a scene.
pub struct Media {
    bounds: HashMap<StackedMedium, Bound>,
    /// The medium that fills all space.
    world: Option<StackedMedium>,
    /// Objects that have media, and the boxes about them.
    objects: Vec<(u32, [Vec3A; 2])>,
    denser: AtomicU64,
}

impl Media {
    /// Finds the media of a scene that fills these bounds.
    pub(super) fn new(scene: &Scene, around: Option<(Vec3A, Vec3A)>) -> Self {
        let mut bounds = HashMap::new();
        let mut objects = Vec::new();
        for (index, instance) in scene.placed().iter().enumerate() {
            let index = index as u32;
            let of = |material: &u32| scene.materials[*material as usize].volume().is_some();
            let mut found = false;
            for &material in instance.materials.iter().filter(|material| of(material)) {
                let entry = StackedMedium { instance: index, material };
                bounds.entry(entry).or_insert_with(|| Bound::of_object(scene, entry));
                found = true;
            }
            if found {
                let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32));
                let corners = corners.map(|part| crate::nodes::volume::within_box(scene, index, part));
                let start = [Vec3A::INFINITY, Vec3A::NEG_INFINITY];
                objects.push((index, corners.fold(start, |[low, high], p| [low.min(p), high.max(p)])));
            }
        }
        for one in scene.moving.iter().filter(|one| one.first > 0) {
            let (own, owner) = (one.first..one.first + one.count(), &scene.instances[one.instance as usize]);
            let Some((_, around)) = objects.iter_mut().find(|(index, _)| *index == one.instance) else { continue };
            for index in own {
                let now = &scene.instances[index as usize];
                for &material in &owner.materials {
                    let known = bounds.get(&StackedMedium { instance: one.instance, material });
                    if let Some(bound) = known.map(|bound: &Bound| bound.standing(owner, now)) {
                        bounds.insert(StackedMedium { instance: index, material }, bound);
                    }
                }
                let there = now.to_render * owner.to_object;
                let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32));
                for part in corners {
                    let corner = there.transform_point3a(crate::nodes::volume::within_box(scene, one.instance, part));
                    *around = [around[0].min(corner), around[1].max(corner)];
                }
            }
        }
        let volume = scene.world.graph.as_ref().and_then(|graph| graph.volume.as_ref());
        let world = volume.map(|_| StackedMedium::WORLD);
        if world.is_some() {
            bounds.insert(StackedMedium::WORLD, Bound::of_world(scene, around));
        }
        Self { bounds, world, objects, denser: AtomicU64::new(0) }
    }

    /// True if the scene has no media.
    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    /// Takes all bounds for so much less.
    #[cfg(test)]
    fn loosen(&mut self, part: f32) {
        self.bounds.values_mut().for_each(|bound| bound.loosen(part));
    }

    /// A warning after a render in which media were denser than their bounds more than a few times.
    pub fn report(&self) -> Option<String> {
        const FEW: u64 = 10_000;
        let count = self.denser_than_bound();
        (count > FEW).then(|| {
            "Volumes: some are far denser in places than was found before the render; there the picture is noisier"
                .into()
        })
    }

    /// Number of times that light came to a place where a medium is denser than its bound, which was found before the render.
    pub fn denser_than_bound(&self) -> u64 {
        self.denser.load(Ordering::Relaxed)
    }
}

/// An event on a stretch of a ray.
pub(super) enum Event {
    /// Light comes to the end of the stretch.
    Through,
    /// Light is scattered before the end. Its weight is still to be multiplied by the scattering coefficient.
    Scattered {
        /// Distance from the ray's start.
        distance: f32,
        /// The medium that scatters it.
        medium: Box<Medium>,
        /// Density per unit of the scattering there; 0 where the medium varies and nothing competes.
        density: f32,
    },
    /// All light of the path is absorbed.
    Absorbed,
}

/// A stretch of a ray within media.
pub(super) struct Stretch<'a> {
    pub(super) stage: &'a PreparedScene,
    pub(super) stack: &'a Stack,
    pub(super) ray: Ray,
    pub(super) way: PathState,
}

impl Stretch<'_> {
    /// The medium of the stretch, if it is spatially constant and scatters.
    pub(super) fn even_medium(&self) -> Option<Medium> {
        if !self.is_even() {
            return None;
        }
        let medium = self.medium(self.ray.origin);
        (medium.scattering != Rgb::ZERO).then_some(medium)
    }

    /// The transmittance of a homogeneous medium over a distance, and the density with which [`Stretch::follow`] scatters it there.
    pub(super) fn even_at(&self, medium: &Medium, throughput: Rgb, distance: f32) -> (Rgb, f32) {
        let left = through(medium.extinction, distance);
        (left, channels(throughput).map_or(0.0, |chances| chances.dot(medium.extinction * left)))
    }

    /// A distance at which [`Stretch::follow`] scatters light of this throughput in something even, given that it does; and the part of
    /// light that it scatters. `None` where that is nothing.
    pub(super) fn even_scattering(&self, medium: &Medium, throughput: Rgb, u: [f32; 2]) -> Option<(f32, f32)> {
        let end = self.ray.t_max;
        let parts = medium.extinction.map(|rate| if rate > 0.0 { -(-rate * end).exp_m1() } else { 0.0 });
        let by_channel = channels(throughput)? * parts;
        let part = by_channel.element_sum();
        let left = u[0] * part;
        let channel = usize::from(left >= by_channel.x) + usize::from(left >= by_channel.x + by_channel.y);
        let rate = medium.extinction[channel];
        let distance = -(-u[1] * parts[channel]).ln_1p() / rate;
        (part > 0.0 && distance.is_finite()).then_some((distance, part))
    }

    /// Follows light of this throughput: the throughput that is left, and the light that the media add. `scatters`: else it is dimmed only.
    pub(super) fn follow(&self, throughput: &mut Rgb, scatters: bool, u: [f32; 4]) -> (Event, Rgb) {
        if self.is_even() {
            self.follow_even(throughput, scatters, u)
        } else {
            self.follow_varying(throughput, scatters, u)
        }
    }

    /// The part of light that gets through all of the stretch, on average.
    pub(super) fn transmittance(&self, numbers: &mut HashedNumbers) -> Rgb {
        if self.is_even() {
            return through(self.medium(self.ray.origin).extinction, self.ray.t_max);
        }
        let mut left = Rgb::ONE;
        let mut walk = self.walk();
        for _ in 0..self.most_steps() {
            let Some((distance, rate)) = walk.next(numbers.next()) else { break };
            let extinction = self.medium(self.at(distance)).extinction;
            self.note(&mut walk, extinction, rate);
            left *= Rgb::ONE - extinction / rate;
            let most = left.abs().max_element();
            if most < FAINT {
                if numbers.next() * FAINT >= most {
                    return Rgb::ZERO;
                }
                left *= FAINT / most;
            }
        }
        left
    }

    fn most_steps(&self) -> u32 {
        if self.ray.t_max.is_finite() { MOST_STEPS } else { MOST_STEPS_OUT }
    }

    fn is_even(&self) -> bool {
        self.stack.iter().all(|entry| self.stage.media.bounds.get(entry).is_none_or(Bound::is_even))
    }

    fn at(&self, distance: f32) -> Vec3A {
        self.ray.origin + self.ray.direction * distance
    }

    /// All media together at a place.
    fn medium(&self, position: Vec3A) -> Medium {
        let mut sum: Option<Medium> = None;
        for entry in self.stack.iter() {
            let found = entry.medium(&self.stage.scene, position, self.ray.direction, self.way);
            match &mut sum {
                None => sum = Some(found),
                Some(sum) => sum.add(&found),
            }
        }
        sum.unwrap_or_default()
    }

    fn walk(&self) -> Bounded<'_> {
        let bounds = self.stack.iter().filter_map(|entry| {
            let bound = self.stage.media.bounds.get(entry)?;
            let here = || entry.medium(&self.stage.scene, self.ray.origin, self.ray.direction, self.way);
            Some((bound, if bound.is_even() { self.rate_of(&here()) } else { 0.0 }))
        });
        Bounded::new(&self.ray, bounds)
    }

    /// The rate of tentative particles for a medium that is constant along the ray, among others that vary.
    fn rate_of(&self, medium: &Medium) -> f32 {
        let shines = medium.emission.max_element() > 0.0 && self.ray.t_max.is_finite();
        medium.extinction.max_element().max(if shines { bound::LOOKS / self.ray.t_max } else { 0.0 })
    }

    /// Counts a place that is denser than its bound, and raises the rate behind it.
    fn note(&self, walk: &mut Bounded<'_>, extinction: Rgb, rate: f32) {
        let density = extinction.max_element();
        if density > rate * 1.0001 {
            self.stage.media.denser.fetch_add(1, Ordering::Relaxed);
            walk.raise(density, rate);
        }
    }

    fn follow_even(&self, throughput: &mut Rgb, scatters: bool, u: [f32; 4]) -> (Event, Rgb) {
        let medium = self.medium(self.ray.origin);
        let (extinction, t) = (medium.extinction, self.ray.t_max);
        let left = through(extinction, t);
        let emitted = if medium.emission == Rgb::ZERO {
            Rgb::ZERO
        } else {
            *throughput * medium.emission * length_seen(extinction, t)
        };
        if !scatters || medium.scattering == Rgb::ZERO {
            *throughput *= left;
            return (Event::Through, emitted);
        }
        // A channel by what it carries; the others are weighted as if each had been chosen (Veach's balance heuristic).
        let Some(chances) = channels(*throughput) else { return (Event::Absorbed, emitted) };
        let channel = usize::from(u[0] >= chances.x) + usize::from(u[0] >= chances.x + chances.y);
        let rate = extinction[channel.min(2)];
        let distance = if rate > 0.0 { -(1.0 - u[1]).ln() / rate } else { f32::INFINITY };
        if distance >= t {
            *throughput *= left / chances.dot(left);
            let event = if throughput.is_finite() { Event::Through } else { Event::Absorbed };
            return (event, emitted);
        }
        let left = through(extinction, distance);
        let density = chances.dot(extinction * left);
        *throughput *= left / density;
        if !throughput.is_finite() {
            return (Event::Absorbed, emitted);
        }
        (Event::Scattered { distance, medium: Box::new(medium), density }, emitted)
    }

    fn follow_varying(&self, throughput: &mut Rgb, scatters: bool, u: [f32; 4]) -> (Event, Rgb) {
        let mut numbers = HashedNumbers::new([u[0], u[1], u[2]]);
        let mut emitted = Rgb::ZERO;
        let mut walk = self.walk();
        let start = throughput.abs().max_element();
        let mut first = Some(u[3]);
        for _ in 0..self.most_steps() {
            let u = first.take().unwrap_or_else(|| numbers.next());
            let Some((distance, rate)) = walk.next(u) else { break };
            let medium = self.medium(self.at(distance));
            self.note(&mut walk, medium.extinction, rate);
            emitted += *throughput * medium.emission / rate;
            let null = Rgb::splat(rate) - medium.extinction;
            let weights = throughput.abs();
            let by_scattering = if scatters { weights.dot(medium.scattering) } else { 0.0 };
            let by_null = weights.dot(null.abs());
            let total = by_scattering + by_null;
            if total <= 0.0 || !total.is_finite() {
                return (Event::Absorbed, emitted);
            }
            let chance = by_scattering / total;
            if numbers.next() < chance {
                *throughput /= rate * chance;
                return (Event::Scattered { distance, medium: Box::new(medium), density: 0.0 }, emitted);
            }
            *throughput *= null / (rate * (1.0 - chance));
            let most = throughput.abs().max_element();
            if most < FAINT * start {
                if numbers.next() * FAINT * start >= most {
                    return (Event::Absorbed, emitted);
                }
                *throughput *= FAINT * start / most;
            }
        }
        (Event::Through, emitted)
    }
}

/// The probabilities of the channels, by the light that they carry; `None` if there is none.
fn channels(throughput: Rgb) -> Option<Rgb> {
    let weights = throughput.abs();
    let total = weights.element_sum();
    (total > 0.0 && total.is_finite()).then(|| weights / total)
}

/// The transmittance of a homogeneous medium over a distance, which may be infinite.
fn through(extinction: Rgb, t: f32) -> Rgb {
    extinction.map(|rate| if rate > 0.0 { (-rate * t).exp() } else { 1.0 })
}

/// The integral of the transmittance ([`through`]) over a length of a homogeneous medium.
fn length_seen(extinction: Rgb, t: f32) -> Rgb {
    extinction.map(|rate| {
        let depth = rate * t;
        if depth > 1e-3 {
            -(-depth).exp_m1() / rate
        } else if t.is_finite() {
            t * (1.0 - 0.5 * depth)
        } else {
            // Light without end from a medium that hides nothing: as Cycles, none.
            0.0
        }
    })
}

#[cfg(test)]
mod tests;
