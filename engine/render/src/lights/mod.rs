//! Choosing and sampling emitters: lamps, emissive triangles, suns and the world.
//!
//! Knows the places that light leaves from; nothing of the surfaces that it arrives at, nor of occluders in between.

mod aimed;
mod along;
pub mod bounds;
mod build;
pub mod emission;
pub mod lamp;
mod lamp_tree;
mod local;
mod node;
pub mod receiver;
mod sample;
pub mod sky;
pub mod tree;
mod triangle;

use crate::nodes::PathState;
use crate::scene::Scene;
use crate::scene::motion::MIDDLE;
use crate::scene::visibility::LightSets;
pub use aimed::SourceGroup;
pub use along::{LightHit, Line};
use glam::Vec3A;
use lamp::PreparedLamp;
use lamp_tree::LampTree;
use local::{Emitter, Local, emissive_triangles, linked_trees};
use receiver::{LightSampleContext, NO_INSTANCE};
pub use sample::{Leaving, LightSample};
use sky::Sky;
use std::f32::consts::PI;
use std::sync::{Arc, OnceLock};
use tree::LightTree;

/// One of a scene's sources of light: lamps and emissive triangles, then the world and the suns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source(usize);

/// Every emitter of a scene, ready to be sampled.
pub struct Lights {
    local: Local,
    // The choice of local emitters by what they may send to a place. First that over all of them; then one for each way in which objects
    // take part in links.
    trees: Vec<Option<LightTree>>,
    // By instance, which of these is for it; empty where there are no links.
    tree_of: Vec<u32>,
    // By instance: by triangle, 1 + its index in `local`; empty where the instance emits nothing.
    emitter_of: Vec<Arc<[u32]>>,
    lamps: Vec<PreparedLamp>,
    // The lamps that rays can hit.
    met: LampTree,
    sky: Sky,
    is_linked: bool,
    // Those that the camera sees, once they are asked for: `aimed`.
    seen_groups: OnceLock<Vec<SourceGroup>>,
}

/// Least probability of either the sky or the lights within the scene, where there are both: occlusion is known on average only.
const LEAST_CHANCE: f32 = 0.1;

impl Lights {
    /// Finds the emitters of a scene.
    pub fn new(scene: &Scene) -> Self {
        Self::after(None, scene)
    }

    /// Finds the emitters of a scene like [`Self::new`]; of those of another frame or edit, tables that are still valid are reused.
    pub fn after(previous: Option<&Self>, scene: &Scene) -> Self {
        let lamps: Vec<PreparedLamp> =
            scene.lamps.iter().map(|lamp| PreparedLamp::new(lamp, scene.origin.as_vec3a())).collect();
        let mut local = Local::default();
        let mut bounds = Vec::new();
        for (i, lamp) in lamps.iter().enumerate() {
            if !lamp.is_at_infinity() {
                local.lamps.push(i as u32);
                bounds.push(lamp.bounds());
            }
        }
        let met = LampTree::new((0..).zip(local.lamps.iter().map(|&i| &lamps[i as usize])));
        let sky = Sky::new(previous.map(|previous| &previous.sky), scene, &lamps);
        let has_others = !lamps.is_empty() || sky.irradiance(None) > 0.0;
        let emitter_of = emissive_triangles(scene, &mut local, &mut bounds, has_others);
        let sets = lamps.iter().map(PreparedLamp::sets).chain(scene.instances.iter().map(|one| one.links.sets));
        let is_linked = sets.into_iter().any(|sets| sets != LightSets::EVERYTHING);
        let same = previous.filter(|previous| previous.local.is_alike(&previous.lamps, &local, &lamps));
        let owners: Vec<u32> = local.iter().map(|emitter| emitter.instance()).collect();
        let first = || LightTree::new(&bounds, &owners);
        let mut trees = vec![same.map_or_else(first, |previous| previous.trees[0].clone())];
        let about = (bounds.as_slice(), owners.as_slice());
        let tree_of = if is_linked { linked_trees(scene, &local, &lamps, about, &mut trees) } else { Vec::new() };
        let seen_groups = OnceLock::new();
        Self { local, trees, tree_of, emitter_of, lamps, met, sky, is_linked, seen_groups }
    }

    /// True if any light lights only some objects, or has shadows of only some.
    #[inline]
    pub fn is_linked(&self) -> bool {
        self.is_linked
    }

    /// True if anything within the scene emits.
    pub fn has_local(&self) -> bool {
        self.local.len() > 0
    }

    /// True if light samples find anything: a world of one colour is not sampled.
    pub fn any_is_sampled(&self) -> bool {
        self.has_local() || self.sky.irradiance(None) > 0.0
    }

    /// The middle of an emitter within the scene that likely lights a place; `None` where there is none.
    pub fn near(&self, to: &LightSampleContext, u: f32) -> Option<Vec3A> {
        let chosen = self.tree(to).and_then(|tree| tree.sample(to, u)).map(|(index, _)| index);
        let count = self.local.len();
        // What shines past the place may still shine beside it.
        let index = chosen.unwrap_or(((u * count as f32) as usize).min(count.checked_sub(1)?));
        Some(match self.local.get(index)? {
            Emitter::Lamp(i) => self.lamps[i as usize].bounds().center(),
            Emitter::Triangle(triangle) | Emitter::Moving(triangle, _) => triangle.bounds().center(),
        })
    }

    /// The objects that a source lights, and those that cast shadows in its light.
    pub fn sets(&self, source: Source) -> LightSets {
        match self.local.get(source.0) {
            Some(Emitter::Triangle(triangle) | Emitter::Moving(triangle, _)) => triangle.sets(),
            _ => self.lamp(source).map_or(LightSets::EVERYTHING, PreparedLamp::sets),
        }
    }

    /// The number of the light group that a source is in; 0 is none.
    pub fn group(&self, scene: &Scene, source: Source) -> u16 {
        let of_lamp = |lamp: u32| scene.lamps[lamp as usize].light_group;
        match self.local.get(source.0) {
            Some(Emitter::Triangle(triangle) | Emitter::Moving(triangle, _)) => {
                scene.instances[triangle.instance as usize].light_group
            }
            Some(Emitter::Lamp(lamp)) => of_lamp(lamp),
            None => match source.0 - self.local.len() {
                0 => scene.world.light_group,
                sun => of_lamp(self.sky.suns()[sun - 1]),
            },
        }
    }

    /// True if a source is the sky, apart from suns.
    pub fn is_world(&self, source: Source) -> bool {
        source.0 == self.local.len()
    }

    /// A place that light may reach. `openness` is the part of the sky that is seen from places in this picture on
    /// average: the sky is chosen in proportion to its possible light, so far as nothing stands in its way.
    pub fn receiver(&self, position: Vec3A, normal: Option<Vec3A>, openness: f32) -> LightSampleContext {
        self.receiver_by((0, NO_INSTANCE), position, normal, openness)
    }

    /// A place on an instance that light may reach; some lights may not light the instance. `emits`: the place itself emits, so that the light
    /// of the instance's other emitters hardly shows there. See [`Self::receiver`].
    #[inline]
    pub fn receiver_on(
        &self,
        instance: u32,
        emits: bool,
        position: Vec3A,
        normal: Option<Vec3A>,
        openness: f32,
    ) -> LightSampleContext {
        let tree = if self.is_linked { self.tree_of[instance as usize] } else { 0 };
        self.receiver_by((tree, if emits { instance } else { NO_INSTANCE }), position, normal, openness)
    }

    /// A place by its light tree and the instance that emits there.
    #[inline]
    fn receiver_by(
        &self,
        (tree, emitter): (u32, u32),
        position: Vec3A,
        normal: Option<Vec3A>,
        openness: f32,
    ) -> LightSampleContext {
        let sky = self.sky.irradiance(normal);
        let Some(of_tree) = &self.trees[tree as usize] else {
            let weights = [0.0; receiver::WIDTH];
            return LightSampleContext {
                position,
                normal,
                tree,
                emitter,
                weights,
                total: 0.0,
                sky,
                sky_chance: 1.0,
                moment: MIDDLE,
                is_compensated: false,
            };
        };
        let mut to = LightSampleContext { tree, sky, ..of_tree.receiver(position, normal, emitter) };
        if sky > 0.0 {
            let (sky, local) = (sky * openness, to.total / PI);
            let chance = if local > 0.0 { sky / (sky + local) } else { 1.0 };
            let least = if local > 0.0 { LEAST_CHANCE } else { 1.0 };
            to.sky_chance = if chance.is_finite() { chance.clamp(least, (1.0 - LEAST_CHANCE).max(least)) } else { 0.5 };
        }
        to
    }

    /// A place in the middle of a scene of which nothing is known, and that takes light from all sides: light paths
    /// and paths from the camera must agree on it.
    pub fn receiver_between(&self, position: Vec3A) -> LightSampleContext {
        self.receiver(position, None, 0.5)
    }

    /// Light at a place that a path came to by `way`, as it is counted there; `None` where none was found.
    pub fn sample(
        &self,
        scene: &Scene,
        to: &LightSampleContext,
        u_choice: f32,
        u: [f32; 2],
        way: PathState,
    ) -> Option<LightSample> {
        self.sample_source(scene, to, u_choice, u, way).map(|(sample, _)| sample)
    }

    /// Light at a place, and its source.
    #[inline(always)]
    pub fn sample_source(
        &self,
        scene: &Scene,
        to: &LightSampleContext,
        u_choice: f32,
        u: [f32; 2],
        way: PathState,
    ) -> Option<(LightSample, Source)> {
        let from = to.position;
        let chance = to.sky_chance;
        if u_choice < chance {
            let (mut sample, index) = self.sky.sample(scene, &self.lamps, to, (u_choice / chance, u), way)?;
            sample.pdf *= chance;
            return Some((sample, self.sky_source(index)));
        }
        let rest = ((u_choice - chance) / (1.0 - chance)).min(1.0 - f32::EPSILON);
        let (index, probability) = self.tree(to)?.sample(to, rest)?;
        let mut sample = match self.local.get(index)? {
            Emitter::Lamp(i) => self.lamps[i as usize].light(scene, from, u, way)?,
            Emitter::Triangle(triangle) => triangle.sample(scene, from, u, way)?,
            Emitter::Moving(triangle, moving) => {
                triangle.standing(scene, scene.moving[moving as usize].at(to.moment)).sample(scene, from, u, way)?
            }
        };
        sample.pdf *= probability * (1.0 - chance);
        Some((sample, Source(index)))
    }

    /// The density with which [`Lights::sample`] at `to` would have found a point on an emissive triangle:
    /// `distance` away, hit at `cos` to its normal.
    pub fn triangle_pdf(
        &self,
        scene: &Scene,
        to: &LightSampleContext,
        hit: (u32, u32),
        distance: f32,
        cos: f32,
    ) -> f32 {
        let (Some(Source(index)), Some(tree)) = (self.triangle_source(hit.0, hit.1), self.tree(to)) else { return 0.0 };
        let area = match self.local.get(index) {
            Some(Emitter::Triangle(triangle)) => triangle.area,
            Some(Emitter::Moving(..)) => triangle::area(scene, hit.0, hit.1),
            Some(Emitter::Lamp(_)) | None => return 0.0,
        };
        let chance = tree.probability(to, index) * (1.0 - to.sky_chance);
        chance / area * distance * distance / cos.max(1e-6)
    }

    #[inline]
    fn tree(&self, to: &LightSampleContext) -> Option<&LightTree> {
        self.trees[to.tree as usize].as_ref()
    }

    fn sky_source(&self, index: usize) -> Source {
        Source(self.local.len() + index)
    }

    /// The source that an emissive triangle is, if it is one.
    pub fn triangle_source(&self, instance: u32, triangle: u32) -> Option<Source> {
        let index = self.emitter_of[instance as usize].get(triangle as usize).copied().unwrap_or(0);
        (index > 0).then(|| Source(index as usize - 1))
    }
}

#[cfg(test)]
mod tests;
