//! The assignment of triangles to trees.

use super::bounds::Bounds;
use crate::scene::{Scene, mesh::Mesh};
use glam::Vec3;
use rayon::prelude::*;

/// The still instances, sorted by the tree that holds them.
pub(super) struct Parts {
    /// Instances whose mesh has no tree of its own.
    pub(super) alone: Vec<u32>,
    pub(super) several: Vec<u32>,
}

impl Parts {
    /// Meshes that stand there once go together.
    pub(super) fn of(scene: &Scene) -> Self {
        Self::shared_from(2, scene)
    }

    /// Every mesh has a tree of its own.
    pub(super) fn apart(scene: &Scene) -> Self {
        Self::shared_from(1, scene)
    }

    /// Meshes of at least so many instances have a tree of their own.
    fn shared_from(sharing: u32, scene: &Scene) -> Self {
        let mut is_still = vec![true; scene.placed().len()];
        scene.moving.iter().for_each(|one| is_still[one.instance as usize] = false);
        let still = || (0..is_still.len() as u32).filter(|&i| is_still[i as usize]);
        let mut uses = vec![0u32; scene.meshes.len()];
        still().for_each(|i| uses[scene.instances[i as usize].mesh as usize] += 1);
        let of_mesh = |&i: &u32| uses[scene.instances[i as usize].mesh as usize];
        let (alone, several) = still().partition(|instance| of_mesh(instance) < sharing);
        Self { alone, several }
    }
}

/// The triangles of a tree, by name: an instance and a triangle of its mesh.
pub(super) enum TriangleSource<'a> {
    /// Triangles of instances, in render space.
    Placed { scene: &'a Scene, instances: &'a [u32] },
    /// Triangles of a mesh, in object space; the instance is undefined.
    Mesh(&'a Mesh),
}

impl<'a> TriangleSource<'a> {
    pub(super) fn placed(scene: &'a Scene, instances: &'a [u32]) -> Self {
        Self::Placed { scene, instances }
    }

    pub(super) fn count(&self) -> usize {
        match self {
            Self::Placed { scene, instances } => {
                instances.iter().map(|&i| scene.meshes[scene.instances[i as usize].mesh as usize].triangles.len()).sum()
            }
            Self::Mesh(mesh) => mesh.triangles.len(),
        }
    }

    pub(super) fn corners(&self, [i, triangle]: [u32; 2]) -> [Vec3; 3] {
        match self {
            Self::Placed { scene, .. } => {
                let instance = &scene.instances[i as usize];
                let corners = scene.meshes[instance.mesh as usize].corners(triangle);
                corners.map(|p| instance.to_render.transform_point3(p))
            }
            Self::Mesh(mesh) => mesh.corners(triangle),
        }
    }

    /// Boxes around all triangles.
    pub(super) fn boxes(&self) -> Vec<Bounds> {
        let mut boxes = Vec::with_capacity(self.count());
        let mut add = |instance: u32, mesh: &Mesh| {
            let triangles = (0..mesh.triangles.len() as u32).into_par_iter();
            let name = |triangle| [instance, triangle];
            boxes.par_extend(triangles.map(|t| Bounds::of(&self.corners(name(t))).naming(name(t))));
        };
        match self {
            Self::Placed { scene, instances } => {
                instances.iter().for_each(|&i| add(i, &scene.meshes[scene.instances[i as usize].mesh as usize]));
            }
            Self::Mesh(mesh) => add(0, mesh),
        }
        boxes
    }
}
