//! A mesh that changes its shape: a tree for the time between each two of its keys. Boxes hold what triangles sweep, leaves both
//! ends of it.

use super::bounds::Bounds;
use super::build::build;
use super::traverse::{Found, TreeRay, TriangleTree, traverse};
use super::triangles::{Block, LANES};
use crate::scene::mesh::Mesh;
use crate::scene::motion::{Pose, Poses};
use fearless_simd::Simd;
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// The triangles of a mesh between two keys. The blocks of the tree are those of the first key.
pub(super) struct PosedTree {
    pub(super) tree: TriangleTree,
    /// The blocks at the next key.
    to: Vec<Block>,
}

impl PosedTree {
    /// The tree for the time from a key to the next.
    pub(super) fn new(mesh: &Mesh, poses: &Poses, key: usize) -> Self {
        let corners = |triangle: u32, part: f32| {
            let pose = Pose { key: key as u32, part };
            poses.corners(mesh.triangles[triangle as usize], pose)
        };
        let swept = |triangle: u32| {
            let [from, to] = [0.0, 1.0].map(|part| Bounds::of(&corners(triangle, part)));
            from.union(&to).naming([0, triangle])
        };
        let mut items: Vec<Bounds> = (0..mesh.triangles.len() as u32).into_par_iter().map(swept).collect();
        items.retain(Bounds::is_within_reach);
        let built = build(&mut items, LANES);
        let block = |leaf: &Range<usize>, part: f32| {
            let mut block = Block::EMPTY;
            for (lane, item) in items[leaf.clone()].iter().enumerate() {
                block.set(lane, &corners(item.name()[1], part), item.name());
            }
            block
        };
        let blocks = |part: f32| built.leaves.iter().map(|leaf| block(leaf, part)).collect();
        let tree = TriangleTree { blocks: blocks(0.0), nodes: built.nodes, surface: 0.0 };
        Self { tree, to: built.leaves.iter().map(|leaf| block(leaf, 1.0)).collect() }
    }

    /// [`TriangleTree::closest`] after a part of the time.
    #[inline(always)]
    pub(super) fn closest<S: Simd>(
        &self,
        simd: S,
        ray: &TreeRay,
        part: f32,
        t_max: f32,
        wanted: impl Fn(u32, u32) -> bool,
    ) -> Option<Found> {
        let mut nearest = None;
        let _ = traverse(
            simd,
            &self.tree.nodes,
            &ray.boxes,
            t_max,
            #[inline(always)]
            |leaf, mut t_max| {
                for found in self.meet(simd, leaf, ray, part, t_max) {
                    if found.t < t_max && wanted(found.instance, found.triangle) {
                        t_max = found.t;
                        nearest = Some(found);
                    }
                }
                ControlFlow::Continue(t_max)
            },
        );
        nearest
    }

    /// [`TriangleTree::visit`] after a part of the time.
    #[inline(always)]
    pub(super) fn visit<S: Simd>(
        &self,
        simd: S,
        ray: &TreeRay,
        part: f32,
        t_max: f32,
        mut on_hit: impl FnMut(Found) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        traverse(
            simd,
            &self.tree.nodes,
            &ray.boxes,
            t_max,
            #[inline(always)]
            |leaf, t_max| {
                for found in self.meet(simd, leaf, ray, part, t_max) {
                    on_hit(found)?;
                }
                ControlFlow::Continue(t_max)
            },
        )
    }

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        leaf: usize,
        ray: &TreeRay,
        part: f32,
        t_max: f32,
    ) -> impl Iterator<Item = Found> + use<S> {
        let block = self.tree.blocks[leaf].towards(&self.to[leaf], part);
        let met = block.meet(simd, &ray.shear, t_max);
        met.into_iter().flat_map(move |met| {
            (0..LANES).filter(move |lane| met.lanes >> lane & 1 == 1).map({
                let (instance, triangle) = (block.instance, block.triangle);
                let (t, u, v) = (met.t, met.u, met.v);
                move |lane| Found {
                    t: t[lane],
                    u: u[lane],
                    v: v[lane],
                    instance: instance[lane],
                    triangle: triangle[lane],
                }
            })
        })
    }
}
