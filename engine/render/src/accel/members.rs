//! The instances of one kind of primitive, by the trees that hold them.

use super::source::Parts;
use super::tree::Primitives;
use crate::scene::Scene;
use crate::scene::mesh::Mesh;

/// Instances and meshes of one kind of primitive.
pub(super) struct Members {
    /// Instances in the common tree.
    pub(super) common: Vec<u32>,
    /// Still instances of trees in object space.
    pub(super) placed: Vec<u32>,
    /// Meshes with a tree in object space, by mesh.
    pub(super) rigid: Vec<bool>,
    /// Meshes with a tree in object space for each two keys, by mesh.
    pub(super) deforming: Vec<bool>,
}

impl Members {
    /// The members of a scene, whose still instances are sorted.
    pub(super) fn of<P: Primitives>(scene: &Scene, parts: &Parts) -> Self {
        let mesh_of = |i: u32| scene.instances[i as usize].mesh as usize;
        let is_own = |i: &u32| P::are_in(&scene.meshes[mesh_of(*i)]);
        let alone = parts.alone.iter().copied().filter(is_own);
        let (common, apart): (Vec<u32>, Vec<u32>) = alone.partition(|&i| P::keep_form(&scene.instances[i as usize]));
        let placed: Vec<u32> = parts.several.iter().copied().filter(is_own).chain(apart).collect();
        let moving = scene.moving.iter().map(|one| one.instance).filter(is_own);
        let mut is_shared = vec![false; scene.meshes.len()];
        placed.iter().copied().chain(moving).for_each(|i| is_shared[mesh_of(i)] = true);
        let deforms = |mesh: &Mesh| mesh.poses.is_some();
        let shared = || scene.meshes.iter().zip(&is_shared);
        let rigid = shared().map(|(mesh, &is_shared)| is_shared && !deforms(mesh)).collect();
        let deforming = shared().map(|(mesh, &is_shared)| is_shared && deforms(mesh)).collect();
        Self { common, placed, rigid, deforming }
    }
}
