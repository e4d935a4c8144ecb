//! Choosing and sampling what emits: lamps, emissive triangles, suns and the world.
//!
//! Knows where light leaves from; knows nothing of the surfaces that it arrives at, nor whether anything stands in
//! between.

pub mod bounds;
mod build;
pub mod emission;
pub mod lamp;
mod lamp_tree;
mod node;
pub mod receiver;
pub mod sky;
pub mod tree;
mod triangle;

use crate::nodes::Way;
use crate::scene::material::{Input, Material};
use crate::scene::mesh::Mesh;
use crate::scene::motion::MIDDLE;
use crate::scene::{
    Scene,
    lamp::LampKind,
    visibility::{Links, Rays, Sets},
};
use crate::{Rgb, luminance};
use bounds::LightBounds;
use glam::Vec3A;
use lamp::PreparedLamp;
use lamp_tree::LampTree;
use receiver::Receiver;
use sky::Sky;
use std::collections::{HashMap, HashSet};
use std::f32::consts::PI;
use std::sync::Arc;
use tree::LightTree;
use triangle::LitTriangle;

/// Light that reaches a point from one direction, if nothing stands in between.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit, towards the light.
    pub wi: Vec3A,
    /// Blender units; infinite for suns and the world.
    pub distance: f32,
    /// Radiance; for a light without extent, radiance times the solid angle that it has not.
    pub radiance: Rgb,
    /// Density per steradian, the choice of the light included; for a light without extent the choice alone.
    pub pdf: f32,
    /// Without extent: no ray finds it by chance.
    pub point_like: bool,
    /// Objects throw shadows in it.
    pub cast_shadow: bool,
    /// The kinds of ray that find it, and so the closures that it lights.
    pub reaches: Rays,
    /// What it lights, and what throws shadows in its light.
    pub sets: Sets,
    /// Of the surface that emits; lamps are none, and rays do not meet them.
    pub leaves: Option<Leaving>,
}

/// How light leaves a surface.
#[derive(Clone, Copy, Debug)]
pub struct Leaving {
    /// The cosine to its normal, positive.
    pub cos: f32,
    /// How far rounding may have put the surface from where it is, Blender units.
    pub error: f32,
}

impl LightSample {
    /// How far a ray goes that asks whether this light arrives, and whose start may be `error` from the place that it arrives at.
    /// Blender units.
    #[inline]
    pub fn reach(&self, error: f32) -> f32 {
        (self.distance - self.gap(error)).max(0.0)
    }

    /// How far from its end that is: before the surface that it comes from, which must not shadow itself.
    #[inline]
    pub fn gap(&self, error: f32) -> f32 {
        self.leaves.map_or(0.0, |leaves| (leaves.error + error) / leaves.cos)
    }
}

/// One of a scene's sources of light: lamps and emissive triangles, then the world and the suns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source(usize);

#[derive(Clone, Copy, Debug)]
enum Emitter<'a> {
    Triangle(&'a LitTriangle),
    Lamp(u32),
    /// As it is at the instance's own time, and by the number in [`Scene::moving`].
    Moving(&'a LitTriangle, u32),
}

impl<'a> Emitter<'a> {
    fn moving((triangle, number): &'a (LitTriangle, u32)) -> Self {
        Self::Moving(triangle, *number)
    }
}

/// The emitters within the scene, in the order of their numbers: lamps, then triangles, then those that move.
#[derive(Debug, Default)]
struct Local {
    lamps: Vec<u32>,
    triangles: Vec<LitTriangle>,
    moving: Vec<(LitTriangle, u32)>,
}

impl Local {
    fn len(&self) -> usize {
        self.lamps.len() + self.triangles.len() + self.moving.len()
    }

    #[inline]
    fn get(&self, index: usize) -> Option<Emitter<'_>> {
        match self.lamps.get(index) {
            Some(lamp) => Some(Emitter::Lamp(*lamp)),
            None => match self.triangles.get(index - self.lamps.len()) {
                Some(triangle) => Some(Emitter::Triangle(triangle)),
                None => self.moving.get(index - self.lamps.len() - self.triangles.len()).map(Emitter::moving),
            },
        }
    }

    fn iter(&self) -> impl Iterator<Item = Emitter<'_>> {
        let still =
            self.lamps.iter().map(|lamp| Emitter::Lamp(*lamp)).chain(self.triangles.iter().map(Emitter::Triangle));
        still.chain(self.moving.iter().map(Emitter::moving))
    }
}

/// Every emitter of a scene, ready to be sampled.
pub struct Lights {
    local: Local,
    // The choice of local emitters by what they may send to a place. First that over all of them; then one for each way in which objects take part in links.
    trees: Vec<Option<LightTree>>,
    // By instance, which of these is for it; empty where there are no links.
    tree_of: Vec<u32>,
    // By instance: by triangle, 1 + its index in `local`; empty where the instance emits nothing.
    emitter_of: Vec<Arc<[u32]>>,
    lamps: Vec<PreparedLamp>,
    // Of those that rays meet.
    met: LampTree,
    sky: Sky,
    is_linked: bool,
}

/// The least chance of either the sky or the lights within the scene, where there are both: what stands in the way is
/// known on average only.
const LEAST_CHANCE: f32 = 0.1;

impl Lights {
    /// Finds the emitters of a scene.
    pub fn new(scene: &Scene) -> Self {
        let lamps: Vec<PreparedLamp> =
            scene.lamps.iter().map(|lamp| PreparedLamp::new(lamp, scene.origin.as_vec3a())).collect();
        let mut local = Local::default();
        let mut bounds = Vec::new();
        for (i, lamp) in lamps.iter().enumerate() {
            if !matches!(lamp.kind(), LampKind::Sun { .. }) {
                local.lamps.push(i as u32);
                bounds.push(lamp.bounds());
            }
        }
        let met = LampTree::new((0..).zip(local.lamps.iter().map(|&i| &lamps[i as usize])));
        let emitter_of = emissive_triangles(scene, &mut local, &mut bounds);
        let sky = Sky::new(scene, &lamps);
        let sets = lamps.iter().map(PreparedLamp::sets).chain(scene.instances.iter().map(|one| one.links.sets));
        let is_linked = sets.into_iter().any(|sets| sets != Sets::EVERYTHING);
        let mut trees = vec![LightTree::new(&bounds)];
        let tree_of = if is_linked { linked_trees(scene, &local, &lamps, &bounds, &mut trees) } else { Vec::new() };
        Self { local, trees, tree_of, emitter_of, lamps, met, sky, is_linked }
    }

    /// Whether any light lights some objects alone, or has shadows of some alone.
    #[inline]
    pub fn is_linked(&self) -> bool {
        self.is_linked
    }

    /// Whether anything shines from within the scene.
    pub fn has_local(&self) -> bool {
        self.local.len() > 0
    }

    /// The middle of something that shines from within the scene, and likely on a place there; `None` where nothing does.
    pub fn near(&self, to: &Receiver, u: f32) -> Option<Vec3A> {
        let chosen = self.tree(to).and_then(|tree| tree.sample(to, u)).map(|(index, _)| index);
        let count = self.local.len();
        // What shines past the place may still shine beside it.
        let index = chosen.unwrap_or(((u * count as f32) as usize).min(count.checked_sub(1)?));
        Some(match self.local.get(index)? {
            Emitter::Lamp(i) => self.lamps[i as usize].bounds().center(),
            Emitter::Triangle(triangle) | Emitter::Moving(triangle, _) => triangle.bounds().center(),
        })
    }

    /// What a source lights, and what throws shadows in its light.
    pub fn sets(&self, source: Source) -> Sets {
        match self.local.get(source.0) {
            Some(Emitter::Triangle(triangle) | Emitter::Moving(triangle, _)) => triangle.sets(),
            _ => self.lamp(source).map_or(Sets::EVERYTHING, PreparedLamp::sets),
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

    /// Whether a source is the sky, as far as it is no sun.
    pub fn is_world(&self, source: Source) -> bool {
        source.0 == self.local.len()
    }

    /// A place that light may reach. `openness` is the part of the sky that is seen from places in this picture on
    /// average: the sky is chosen in proportion to what it may bring, so far as nothing stands in its way.
    pub fn receiver(&self, position: Vec3A, normal: Option<Vec3A>, openness: f32) -> Receiver {
        self.receiver_by(0, position, normal, openness)
    }

    /// The same on an instance, which some lights may not light.
    #[inline]
    pub fn receiver_on(&self, instance: u32, position: Vec3A, normal: Option<Vec3A>, openness: f32) -> Receiver {
        let tree = if self.is_linked { self.tree_of[instance as usize] } else { 0 };
        self.receiver_by(tree, position, normal, openness)
    }

    #[inline]
    fn receiver_by(&self, tree: u32, position: Vec3A, normal: Option<Vec3A>, openness: f32) -> Receiver {
        let Some(of_tree) = &self.trees[tree as usize] else {
            let weights = [0.0; receiver::WIDTH];
            return Receiver { position, normal, tree, weights, total: 0.0, sky_chance: 1.0, moment: MIDDLE };
        };
        let mut to = Receiver { tree, ..of_tree.receiver(position, normal) };
        if !self.sky.is_dark() {
            let (sky, local) = (self.sky.irradiance() * openness, to.total / PI);
            let chance = if local > 0.0 { sky / (sky + local) } else { 1.0 };
            let least = if local > 0.0 { LEAST_CHANCE } else { 1.0 };
            to.sky_chance = if chance.is_finite() { chance.clamp(least, (1.0 - LEAST_CHANCE).max(least)) } else { 0.5 };
        }
        to
    }

    /// A place in the middle of a scene of which nothing is known, and that takes light from all sides: what light paths
    /// and paths from the camera must agree on.
    pub fn receiver_between(&self, position: Vec3A) -> Receiver {
        self.receiver(position, None, 0.5)
    }

    /// Light at a place that a path came to by `way`, as it is counted there; `None` where none was found.
    pub fn sample(&self, scene: &Scene, to: &Receiver, u_choice: f32, u: [f32; 2], way: Way) -> Option<LightSample> {
        self.sample_source(scene, to, u_choice, u, way).map(|(sample, _)| sample)
    }

    /// Light at a place, and where it comes from.
    #[inline(always)]
    pub fn sample_source(
        &self,
        scene: &Scene,
        to: &Receiver,
        u_choice: f32,
        u: [f32; 2],
        way: Way,
    ) -> Option<(LightSample, Source)> {
        let from = to.position;
        let chance = to.sky_chance;
        if u_choice < chance {
            let (mut sample, index) = self.sky.sample(scene, &self.lamps, u_choice / chance, u, way)?;
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
    /// `distance` away, met at `cos` to its normal.
    pub fn triangle_pdf(&self, scene: &Scene, to: &Receiver, hit: (u32, u32), distance: f32, cos: f32) -> f32 {
        let (Some(Source(index)), Some(tree)) = (self.triangle_source(hit.0, hit.1), self.tree(to)) else { return 0.0 };
        let area = match self.local.get(index) {
            Some(Emitter::Triangle(triangle)) => triangle.area,
            Some(Emitter::Moving(..)) => triangle::area(scene, hit.0, hit.1),
            Some(Emitter::Lamp(_)) | None => return 0.0,
        };
        let chance = tree.probability(to, index) * (1.0 - to.sky_chance);
        chance / area * distance * distance / cos.max(1e-6)
    }

    /// Calls `found(radiance, pdf)` for each lamp with extent that a ray from `from` along `d` meets before
    /// `t_max`; `to` is where a light sample would have been taken. Lamps do not hide what is behind them, as in
    /// Cycles.
    #[allow(clippy::too_many_arguments)]
    pub fn lamps_along(
        &self,
        scene: &Scene,
        from: Vec3A,
        d: Vec3A,
        t_max: f32,
        way: Way,
        to: Option<&Receiver>,
        mut found: impl FnMut(Rgb, f32),
    ) {
        self.lamp_sources_along(scene, from, d, t_max, way, to, |_, radiance, pdf| found(radiance, pdf));
    }

    /// The same with which of them it is.
    #[allow(clippy::too_many_arguments)]
    pub fn lamp_sources_along(
        &self,
        scene: &Scene,
        from: Vec3A,
        d: Vec3A,
        t_max: f32,
        way: Way,
        to: Option<&Receiver>,
        mut found: impl FnMut(Source, Rgb, f32),
    ) {
        self.lamps_between(scene, from, d, t_max, way, to, |source, radiance, pdf, _| found(source, radiance, pdf));
    }

    /// The same with how far away each is.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub fn lamps_between(
        &self,
        scene: &Scene,
        from: Vec3A,
        d: Vec3A,
        t_max: f32,
        way: Way,
        to: Option<&Receiver>,
        mut found: impl FnMut(Source, Rgb, f32, f32),
    ) {
        self.met.along(from, d, t_max, |place| {
            let index = place as usize;
            let lamp = &self.lamps[self.local.lamps[index] as usize];
            if !lamp.is_found_by(way) {
                return;
            }
            if let Some((radiance, pdf, t)) = lamp.hit(from, d, t_max) {
                let radiance = radiance * lamp.shine(scene, from, d, t, way.light());
                let chance = to.map_or(0.0, |to| {
                    self.tree(to).map_or(0.0, |tree| tree.probability(to, index) * (1.0 - to.sky_chance))
                });
                found(Source(index), radiance, pdf * chance, t);
            }
        });
    }

    /// Calls `found(radiance, pdf)` for what shines from infinity along `d`: the world, and suns with extent. `to` is
    /// where a light sample would have been taken.
    pub fn sky_along(&self, scene: &Scene, d: Vec3A, way: Way, to: Option<&Receiver>, mut found: impl FnMut(Rgb, f32)) {
        self.sky_sources_along(scene, d, way, to, |_, radiance, pdf| found(radiance, pdf));
    }

    /// The same with which of them it is.
    pub fn sky_sources_along(
        &self,
        scene: &Scene,
        d: Vec3A,
        way: Way,
        to: Option<&Receiver>,
        mut found: impl FnMut(Source, Rgb, f32),
    ) {
        let chance = to.map_or(0.0, |to| to.sky_chance);
        self.sky.along(scene, &self.lamps, d, way, |index, radiance, pdf| {
            found(self.sky_source(index), radiance, pdf * chance);
        });
    }

    #[inline]
    fn tree(&self, to: &Receiver) -> Option<&LightTree> {
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

/// Appends a tree for each way in which objects take part in links, of the emitters that light these; gives by instance which
/// is for it.
fn linked_trees(
    scene: &Scene,
    local: &Local,
    lamps: &[PreparedLamp],
    bounds: &[LightBounds],
    trees: &mut Vec<Option<LightTree>>,
) -> Vec<u32> {
    let mut known = HashMap::new();
    let sets = |emitter: Emitter<'_>| match emitter {
        Emitter::Triangle(triangle) | Emitter::Moving(triangle, _) => triangle.sets(),
        Emitter::Lamp(lamp) => lamps[lamp as usize].sets(),
    };
    let tree_for = |links: &Links| {
        *known.entry(links.receives).or_insert_with(|| {
            let reaching = local.iter().zip(bounds).map(|(emitter, bounds)| {
                let power = if links.takes_light_of(sets(emitter)) { bounds.power } else { 0.0 };
                LightBounds { power, ..*bounds }
            });
            trees.push(LightTree::new(&reaching.collect::<Vec<_>>()));
            trees.len() as u32 - 1
        })
    };
    scene.instances.iter().map(|instance| &instance.links).map(tree_for).collect()
}

/// Appends every triangle that may emit, with its bounds.
fn emissive_triangles(scene: &Scene, local: &mut Local, bounds: &mut Vec<LightBounds>) -> Vec<Arc<[u32]>> {
    let brightness: Vec<f32> = scene.materials.iter().map(|m| average_emission(scene, m)).collect();
    // By mesh, found when first needed.
    let mut closed: Vec<Option<bool>> = vec![None; scene.meshes.len()];
    let mut emitter_of = vec![Arc::<[u32]>::default(); scene.instances.len()];
    let mut moving = vec![None; scene.placed().len()];
    for (number, one) in scene.moving.iter().enumerate().filter(|(_, one)| one.first > 0) {
        moving[one.instance as usize] = Some(number as u32);
    }
    // What moves comes last.
    let (still, last): (Vec<usize>, Vec<usize>) = (0..moving.len()).partition(|&i| moving[i].is_none());
    for i in still.into_iter().chain(last) {
        let instance = &scene.instances[i];
        if instance.materials.iter().all(|&m| brightness[m as usize] == 0.0) {
            continue;
        }
        let mesh = &scene.meshes[instance.mesh as usize];
        // The inside of a closed surface is not seen from outside: only its front is worth a light sample.
        let two_sided = !*closed[instance.mesh as usize].get_or_insert_with(|| is_closed(mesh));
        let mut list = vec![0; mesh.triangles.len()];
        for (t, entry) in list.iter_mut().enumerate() {
            let b = brightness[instance.material(mesh.slot(t as u32)) as usize];
            let lit = LitTriangle::new(scene, i as u32, t as u32, b, two_sided);
            if lit.power > 0.0 {
                match moving[i] {
                    None => {
                        local.triangles.push(lit);
                        bounds.push(lit.bounds());
                    }
                    Some(number) => {
                        local.moving.push((lit, number));
                        bounds.push(swept(scene, &lit, number));
                    }
                }
                *entry = local.len() as u32;
            }
        }
        emitter_of[i] = list.into();
        if let Some(number) = moving[i] {
            let one = &scene.moving[number as usize];
            let list = emitter_of[i].clone();
            emitter_of[one.first as usize..][..one.count() as usize].fill(list);
        }
    }
    emitter_of
}

/// Around a triangle that moves: where it is and shines to at any of its moments.
fn swept(scene: &Scene, lit: &LitTriangle, moving: u32) -> LightBounds {
    /// Moments that are looked at; between them it goes on much as before.
    const MOST_LOOKS: u32 = 64;
    let one = &scene.moving[moving as usize];
    let step = (one.count() / MOST_LOOKS).max(1);
    let moments = (0..one.count()).step_by(step as usize).chain([one.count() - 1]);
    let mut all = moments.map(|i| lit.standing(scene, one.first + i).bounds()).reduce(|a, b| a.union(&b));
    if let Some(all) = &mut all {
        // What it comes to between two looks.
        let room = (all.max - all.min) * if step > 1 { 2.0 / MOST_LOOKS as f32 } else { 0.0 };
        (all.min, all.max, all.power) = (all.min - room, all.max + room, lit.power);
        all.normal_spread_rad = (all.normal_spread_rad + if step > 1 { 0.2 } else { 0.0 }).min(PI);
    }
    all.unwrap_or_else(|| lit.bounds())
}

/// Brightness of a material, for choosing; 0 only where it cannot emit.
fn average_emission(scene: &Scene, m: &Material) -> f32 {
    if !m.emits() {
        return 0.0;
    }
    if let Some(graph) = &m.graph {
        return graph.brightness();
    }
    if m.is_layered() {
        return m.layers.iter().map(|layer| layer.brightness(&scene.textures)).sum::<f32>().max(1e-6);
    }
    let color = match &m.emission_color {
        Input::Constant(c) => *c,
        Input::Image(image) => scene.textures[image.texture as usize].average(),
    };
    // A texture that is black on average may still glow somewhere.
    (luminance(color) * m.emission_strength).max(1e-6)
}

/// Whether every edge of a mesh is walked once each way by its triangles, corners told apart by position.
fn is_closed(mesh: &Mesh) -> bool {
    let mut open: HashSet<([u32; 3], [u32; 3])> = HashSet::new();
    // Plus zero makes -0 and 0 one place.
    let place = |i: u32| (mesh.positions[i as usize] + glam::Vec3::ZERO).to_array().map(f32::to_bits);
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (place(t[k]), place(t[(k + 1) % 3]));
            if !open.remove(&(b, a)) && !open.insert((a, b)) {
                return false;
            }
        }
    }
    open.is_empty()
}

#[cfg(test)]
mod tests;
