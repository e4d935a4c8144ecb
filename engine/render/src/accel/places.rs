//! Instances below a tree of their boxes: what a ray asks of each before it goes into its own tree.

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

/// A tree over these instances, and they in the order of its leaves; `bounds` are those of an instance's own tree, object space.
pub(super) fn placed(
    scene: &Scene,
    instances: &[u32],
    bounds: impl Fn(&Instance) -> Option<Bounds>,
) -> (Vec<Node>, Vec<PlacedMesh>) {
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
    (tree.nodes, tree.leaves.iter().map(place).collect())
}
