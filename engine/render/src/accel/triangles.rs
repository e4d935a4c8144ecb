//! Triangles as the primitives of a tree: those of a mesh as it is, and those on their way from one key of its shape to the next.

use super::block::{Block, LANES, Shear};
use super::bounds::Bounds;
use super::build::NamedLeaves;
use super::node::Node;
use super::source::TriangleSource;
use super::traverse::lanes;
use super::tree::{LocalHit, Primitives, Tree, Visitor};
use crate::scene::Scene;
use crate::scene::mesh::Mesh;
use crate::scene::motion::{Pose, Poses};
use fearless_simd::Simd;
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Leaves of up to eight triangles.
#[derive(Debug, Default)]
pub(super) struct Triangles {
    pub(super) blocks: Vec<Block>,
    /// The blocks at the next key while the shutter is open; empty where the mesh keeps its shape.
    to: Vec<Block>,
    /// Sum of half of the surface of all boxes when the tree was built.
    pub(super) surface: f32,
}

impl Triangles {
    /// Triangles of unchanging shape.
    pub(super) fn at_rest(blocks: Vec<Block>, surface: f32) -> Self {
        Self { blocks, to: Vec::new(), surface }
    }
}

impl Primitives for Triangles {
    type Ray = Shear;
    type Coordinates = [f32; 2];

    const IN_MOST_SCENES: bool = true;

    #[inline(always)]
    fn ray(origin: Vec3A, direction: Vec3A) -> Shear {
        Shear::new(origin, direction)
    }

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        leaf: usize,
        part: Option<f32>,
        ray: &Shear,
        mut end: f32,
        visitor: &mut impl Visitor<[f32; 2]>,
    ) -> ControlFlow<(), f32> {
        let mut block = &self.blocks[leaf];
        let now;
        if let Some(part) = part
            && let Some(to) = self.to.get(leaf)
        {
            now = block.towards(to, part);
            block = &now;
        }
        if let Some(met) = block.meet(simd, ray, end) {
            for lane in lanes(met.lanes) {
                let (t, instance, number) = (met.t[lane], block.instance[lane], block.triangle[lane]);
                if t < end && visitor.wants(instance, number) {
                    let coordinates = [met.u[lane], met.v[lane]];
                    end = visitor.meet(LocalHit { t, instance, number, coordinates }, end)?;
                }
            }
        }
        ControlFlow::Continue(end)
    }

    fn are_in(mesh: &Mesh) -> bool {
        mesh.is_of_triangles()
    }

    fn in_render_space(scene: &Scene, instances: &[u32]) -> Tree<Self> {
        Tree::of_triangles(&TriangleSource::placed(scene, instances))
    }

    fn in_object_space(mesh: &Mesh) -> Tree<Self> {
        Tree::of_triangles(&TriangleSource::Mesh(mesh))
    }

    fn between_keys(mesh: &Mesh, poses: &Poses, key: usize) -> Tree<Self> {
        let corners = |triangle: u32, part: f32| {
            let pose = Pose { key: key as u32, part };
            poses.corners(mesh.triangles[triangle as usize], pose)
        };
        let swept = |triangle: u32| {
            let [from, to] = [0.0, 1.0].map(|part| Bounds::of(&corners(triangle, part)));
            from.union(&to).naming([0, triangle])
        };
        let built = NamedLeaves::new((0..mesh.triangles.len() as u32).into_par_iter().map(swept).collect(), LANES);
        let blocks = |part: f32| built.leaves(|names| block(names, |[_, triangle]| corners(triangle, part)));
        let primitives = Self { blocks: blocks(0.0), to: blocks(1.0), surface: 0.0 };
        Tree { nodes: built.nodes, primitives }
    }
}

/// A block of triangles, by their names.
fn block(names: &[[u32; 2]], corners: impl Fn([u32; 2]) -> [Vec3; 3]) -> Block {
    let mut block = Block::EMPTY;
    for (lane, &name) in names.iter().enumerate() {
        block.set(lane, &corners(name), name);
    }
    block
}

impl Tree<Triangles> {
    /// The tree of the triangles of a source.
    pub(super) fn of_triangles(source: &TriangleSource<'_>) -> Self {
        let built = NamedLeaves::new(source.boxes(), LANES);
        let blocks = built.leaves(|names| block(names, |name| source.corners(name)));
        let surface = half_surface(&built.nodes);
        Self { nodes: built.nodes, primitives: Triangles::at_rest(blocks, surface) }
    }
}

/// Sum of half of the surface of all boxes of nodes.
pub(super) fn half_surface(nodes: &[Node]) -> f32 {
    nodes.iter().map(|node| node.boxes().map(|b| b.half_area()).sum::<f32>()).sum()
}
