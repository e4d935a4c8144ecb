//! Instances below a tree of their boxes: their transforms and the tests of a ray before it enters the tree of one.

use super::Ray;
use super::bounds::Bounds;
use super::build::build;
use super::node::Node;
use crate::scene::{Instance, Scene};
use glam::{Affine3A, Vec3A};
use std::ops::Range;

/// The data of an instance that traversal needs.
#[derive(Clone, Copy)]
pub(super) struct PlacedMesh {
    pub(super) to_object: Affine3A,
    pub(super) mesh: u32,
    pub(super) instance: u32,
}

/// A ray in the object space of an instance.
pub(super) struct Within {
    pub(super) origin: Vec3A,
    /// Direction of the ray, unit.
    pub(super) direction: Vec3A,
    /// Factor of distances in object space.
    pub(super) scale: f32,
}

impl PlacedMesh {
    pub(super) fn new(scene: &Scene, i: u32) -> Self {
        let instance = &scene.instances[i as usize];
        Self { to_object: instance.to_object, mesh: instance.mesh, instance: i }
    }

    /// The ray in the instance's object space; `None` where that has no extent along it.
    #[inline(always)]
    pub(super) fn enter(&self, ray: &Ray) -> Option<Within> {
        let origin = self.to_object.transform_point3a(ray.origin);
        let direction = self.to_object.transform_vector3a(ray.direction);
        let scale = direction.length();
        (scale > 0.0 && scale.is_finite()).then(|| Within { origin, direction: direction / scale, scale })
    }
}

/// Instances that keep their places, and the tree over their boxes.
pub(super) struct PlacedMeshes {
    nodes: Vec<Node>,
    /// The instances, in the order of the leaves.
    placed: Vec<PlacedMesh>,
}

impl PlacedMeshes {
    /// The tree over these instances, by their indices; `bounds` are those of an instance's own tree, in object space.
    pub(super) fn new(scene: &Scene, instances: &[u32], bounds: impl Fn(&Instance) -> Option<Bounds>) -> Self {
        let mut boxes: Vec<Bounds> = instances
            .iter()
            .filter_map(|&i| {
                let instance = &scene.instances[i as usize];
                Some(bounds(instance)?.transformed(&instance.to_render).naming([i, 0]))
            })
            .filter(Bounds::is_within_reach)
            .collect();
        let tree = build(&mut boxes, 1);
        let place = |leaf: &Range<usize>| PlacedMesh::new(scene, boxes[leaf.start].name()[0]);
        Self { nodes: tree.nodes, placed: tree.leaves.iter().map(place).collect() }
    }

    /// The box around all instances; `None` if there are none.
    pub(super) fn bounds(&self) -> Option<Bounds> {
        self.nodes.first().map(Node::bounds)
    }

    #[inline(always)]
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The instance in a leaf.
    #[inline(always)]
    pub(super) fn placed(&self, leaf: usize) -> &PlacedMesh {
        &self.placed[leaf]
    }
}
