//! The emitters within a scene: its lamps and the triangles that may emit, with their bounds.

use super::bounds::LightBounds;
use super::lamp::PreparedLamp;
use super::receiver::NO_INSTANCE;
use super::tree::LightTree;
use super::triangle::LitTriangle;
use crate::nodes::{PathState, RayCone, View};
use crate::sampler::warp;
use crate::scene::material::{EmissionSampling, Material};
use crate::scene::mesh::Mesh;
use crate::scene::motion::MIDDLE;
use crate::scene::visibility::LightLinking;
use crate::scene::{Instance, Scene};
use crate::surface::{geometric_normal, mesh_of};
use crate::{Rgb, luminance, nodes};
use std::collections::{HashMap, HashSet};
use std::f32::consts::PI;
use std::sync::Arc;

/// An emitter at a finite distance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Emitter<'a> {
    Triangle(&'a LitTriangle),
    Lamp(u32),
    /// A triangle as it is at the instance's own time, and the number of its instance in [`Scene::moving`].
    Moving(&'a LitTriangle, u32),
}

impl<'a> Emitter<'a> {
    /// The instance that it is a part of; [`NO_INSTANCE`] of a lamp.
    pub(super) fn instance(self) -> u32 {
        match self {
            Self::Triangle(triangle) | Self::Moving(triangle, _) => triangle.instance,
            Self::Lamp(_) => NO_INSTANCE,
        }
    }

    fn moving((triangle, number): &'a (LitTriangle, u32)) -> Self {
        Self::Moving(triangle, *number)
    }
}

/// The emitters within the scene, in the order of their numbers: lamps, then triangles, then those that move.
#[derive(Debug, Default)]
pub(super) struct Local {
    pub(super) lamps: Vec<u32>,
    pub(super) triangles: Vec<LitTriangle>,
    pub(super) moving: Vec<(LitTriangle, u32)>,
}

impl Local {
    pub(super) fn len(&self) -> usize {
        self.lamps.len() + self.triangles.len() + self.moving.len()
    }

    /// True if the bounds of all emitters are those of others, each with the lamps that its numbers are of. Moving emitters are left out.
    pub(super) fn is_alike(&self, lamps: &[PreparedLamp], other: &Self, other_lamps: &[PreparedLamp]) -> bool {
        let bounds = |local: &Self, lamps: &[PreparedLamp]| -> Vec<LightBounds> {
            local.lamps.iter().map(|&lamp| lamps[lamp as usize].bounds()).collect()
        };
        self.moving.is_empty()
            && other.moving.is_empty()
            && self.triangles == other.triangles
            && bounds(self, lamps) == bounds(other, other_lamps)
    }

    #[inline]
    pub(super) fn get(&self, index: usize) -> Option<Emitter<'_>> {
        match self.lamps.get(index) {
            Some(lamp) => Some(Emitter::Lamp(*lamp)),
            None => match self.triangles.get(index - self.lamps.len()) {
                Some(triangle) => Some(Emitter::Triangle(triangle)),
                None => self.moving.get(index - self.lamps.len() - self.triangles.len()).map(Emitter::moving),
            },
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Emitter<'_>> {
        let still =
            self.lamps.iter().map(|lamp| Emitter::Lamp(*lamp)).chain(self.triangles.iter().map(Emitter::Triangle));
        still.chain(self.moving.iter().map(Emitter::moving))
    }
}

/// Appends a tree for each way in which objects take part in links, of the emitters that light these; gives by instance which
/// is for it.
pub(super) fn linked_trees(
    scene: &Scene,
    local: &Local,
    lamps: &[PreparedLamp],
    (bounds, owners): (&[LightBounds], &[u32]),
    trees: &mut Vec<Option<LightTree>>,
) -> Vec<u32> {
    let mut known = HashMap::new();
    let sets = |emitter: Emitter<'_>| match emitter {
        Emitter::Triangle(triangle) | Emitter::Moving(triangle, _) => triangle.sets(),
        Emitter::Lamp(lamp) => lamps[lamp as usize].sets(),
    };
    let tree_for = |links: &LightLinking| {
        *known.entry(links.receives).or_insert_with(|| {
            let reaching = local.iter().zip(bounds).map(|(emitter, bounds)| {
                let power = if links.takes_light_of(sets(emitter)) { bounds.power } else { 0.0 };
                LightBounds { power, ..*bounds }
            });
            trees.push(LightTree::new(&reaching.collect::<Vec<_>>(), owners));
            trees.len() as u32 - 1
        })
    };
    scene.instances.iter().map(|instance| &instance.links).map(tree_for).collect()
}

/// Appends every triangle whose emission light samples are to find, with its bounds. `has_others`: there are lights beside these triangles.
pub(super) fn emissive_triangles(
    scene: &Scene,
    local: &mut Local,
    bounds: &mut Vec<LightBounds>,
    has_others: bool,
) -> Vec<Arc<[u32]>> {
    let brightness = sampled_emission(scene, has_others);
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

/// The bounds around a moving triangle: its positions and directions of emission at any of its moments.
fn swept(scene: &Scene, lit: &LitTriangle, moving: u32) -> LightBounds {
    /// Most moments that are looked at; between them the motion goes on much as before.
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

/// [`mean_emission`]; 0 also of materials that light samples leave to closure samples. Where these would be all that emits, light samples
/// find them, too, unless their materials say otherwise.
fn sampled_emission(scene: &Scene, has_others: bool) -> Vec<f32> {
    let mut brightness = mean_emission(scene);
    let used: HashSet<u32> = scene.placed().iter().flat_map(|one| one.materials.iter().copied()).collect();
    let is_bright = |&m: &u32| brightness[m as usize] > 0.0 && scene.materials[m as usize].is_worth_light_samples();
    let leaves_dim = has_others || used.iter().any(is_bright);
    for (brightness, material) in brightness.iter_mut().zip(&scene.materials) {
        let is_left = match material.emission_sampling {
            EmissionSampling::Never => true,
            _ => leaves_dim && !material.is_worth_light_samples(),
        };
        if is_left {
            *brightness = 0.0;
        }
    }
    let triangles_of = |instance: &Instance| scene.meshes[instance.mesh as usize].triangles.len() as u64;
    if scene.placed().iter().map(triangles_of).sum::<u64>() > MOST_TRIANGLES {
        leave_most(&mut brightness, &triangle_counts(scene), MOST_TRIANGLES);
    }
    brightness
}

/// Number of emissive triangles at most that light samples find: each takes 150 bytes while the tree over them is built.
const MOST_TRIANGLES: u64 = 1 << 22;

/// Sets the brightness of materials to 0, those of the most triangles first, until the others have `most` triangles at most. The light of
/// so many triangles comes from many sides, where closure samples find it.
pub(super) fn leave_most(brightness: &mut [f32], triangles: &[u64], most: u64) {
    let mut bright: Vec<usize> = (0..brightness.len()).filter(|&m| brightness[m] > 0.0).collect();
    let mut total: u64 = bright.iter().map(|&m| triangles[m]).sum();
    bright.sort_by_key(|&m| triangles[m]);
    while total > most {
        let Some(largest) = bright.pop() else { break };
        total -= triangles[largest];
        brightness[largest] = 0.0;
    }
}

/// Number of triangles of each material, over all instances.
fn triangle_counts(scene: &Scene) -> Vec<u64> {
    let mut counts = vec![0; scene.materials.len()];
    // By mesh the number of triangles of each slot, found when first needed.
    let mut of_slots: Vec<Option<Vec<u64>>> = vec![None; scene.meshes.len()];
    for instance in scene.placed() {
        let mesh = &scene.meshes[instance.mesh as usize];
        let slots = of_slots[instance.mesh as usize].get_or_insert_with(|| {
            let mut slots = vec![0; 1];
            for triangle in 0..mesh.triangles.len() as u32 {
                let slot = mesh.slot(triangle) as usize;
                slots.resize(slots.len().max(slot + 1), 0);
                slots[slot] += 1;
            }
            slots
        });
        for (slot, &count) in slots.iter().enumerate().filter(|(_, count)| **count > 0) {
            counts[instance.material(slot as _) as usize] += count;
        }
    }
    counts
}

/// Points at which the emission of a material is evaluated, for its mean.
const LOOKS: u64 = 64;
/// Least mean brightness of a material, as a part of that with its varying inputs white. Emission may be where no look fell.
const LEAST_SHARE: f32 = 0.01;

/// Luminance of the mean emitted radiance, by material, for choosing between lights; 0 only of a material that cannot emit.
fn mean_emission(scene: &Scene) -> Vec<f32> {
    let of_white = |material: &Material| if material.emits() { material.graph.brightness() } else { 0.0 };
    let mut brightness: Vec<f32> = scene.materials.iter().map(of_white).collect();
    let varies: Vec<bool> = scene.materials.iter().map(|m| m.emits() && !m.emits_evenly()).collect();
    // Triangles of each material that varies.
    let mut counts = vec![0; scene.materials.len()];
    for_each_triangle(scene, &varies, |material, _| counts[material] += 1);
    let mut sums = vec![(0, 0.0); scene.materials.len()];
    for_each_triangle(scene, &varies, |material, [instance, triangle]| {
        let (number, sum): &mut (u64, f32) = &mut sums[material];
        let looks_before = |triangles: u64| (triangles * LOOKS).div_ceil(counts[material]);
        for look in looks_before(*number)..looks_before(*number + 1) {
            *sum += luminance(look_at(scene, material, [instance, triangle], look).abs());
        }
        *number += 1;
    });
    for (brightness, (_, sum)) in
        brightness.iter_mut().zip(sums).zip(varies).filter_map(|(pair, varies)| varies.then_some(pair))
    {
        *brightness = (sum / LOOKS as f32).max(LEAST_SHARE * *brightness);
    }
    brightness
}

/// Calls `found(material, [instance, triangle])` for each triangle of the wanted materials.
fn for_each_triangle(scene: &Scene, wanted: &[bool], mut found: impl FnMut(usize, [u32; 2])) {
    for (i, instance) in scene.placed().iter().enumerate() {
        if !instance.materials.iter().any(|&material| wanted[material as usize]) {
            continue;
        }
        let mesh = &scene.meshes[instance.mesh as usize];
        for triangle in 0..mesh.triangles.len() as u32 {
            let material = instance.material(mesh.slot(triangle)) as usize;
            if wanted[material] {
                found(material, [i as u32, triangle]);
            }
        }
    }
}

/// Emission of a triangle at a place of it, seen from its front.
fn look_at(scene: &Scene, material: usize, [instance, triangle]: [u32; 2], look: u64) -> Rgb {
    // Roberts' R2 sequence.
    let u =
        [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|step: f64| (0.5 + step * look as f64).fract() as f32);
    let placed = &scene.instances[instance as usize];
    let normal = geometric_normal(placed, &placed.corners(mesh_of(scene, instance), triangle));
    let view = View {
        direction: -normal,
        distance: 1.0,
        way: PathState::LIGHT,
        moment: MIDDLE,
        is_blurry: true,
        cone: RayCone::pixel(&scene.viewport),
    };
    let radiance = nodes::emission(
        &scene.materials[material],
        scene.into(),
        [instance, triangle],
        warp::sample_triangle(u),
        &view,
    );
    if radiance.is_finite() { radiance } else { Rgb::ZERO }
}

/// True if every edge of a mesh is walked once each way by its triangles, corners told apart by position.
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
