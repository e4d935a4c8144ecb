//! Trees of a scene whose shapes move: the boxes are drawn anew around the same triangles in the same order, in a third
//! of a build's time; unless they have moved so far apart that rays would pay more for it.

use super::Accel;
use super::block::{Block, LANES};
use super::bounds::Bounds;
use super::members::Members;
use super::node::{Node, WIDTH};
use super::source::{Parts, TriangleSource};
use super::tree::Tree;
use super::triangles::{Triangles, half_surface};
use super::two_level::TwoLevel;
use crate::scene::Scene;
use arrayvec::ArrayVec;
use rayon::prelude::*;
use std::sync::Arc;

/// A tree whose boxes come to this many times the surface that they had when it was built is built anew: a ray hits
/// boxes in proportion to their surface (MacDonald and Booth 1990).
const WORSE: f32 = 1.25;

/// The properties of a scene that must be equal for trees to be kept.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Topology {
    /// The mesh of each instance.
    meshes: Vec<u32>,
    /// Number of triangles of each mesh.
    triangles: Vec<usize>,
    /// The instances that move.
    moving: Vec<u32>,
}

impl Topology {
    pub(super) fn of(scene: &Scene) -> Self {
        Self {
            meshes: scene.placed().iter().map(|instance| instance.mesh).collect(),
            triangles: scene.meshes.iter().map(|mesh| mesh.triangles.len()).collect(),
            moving: scene.moving.iter().map(|one| one.instance).collect(),
        }
    }
}

impl Accel {
    /// [`Self::new`] from the trees of a scene that had the same meshes and instances elsewhere or in other shapes, where
    /// that is worth it. Where two surfaces are equally far to the last bit, one that was built may answer with the other.
    pub fn new_after(previous: &Self, scene: &Scene) -> Self {
        let topology = Topology::of(scene);
        if previous.topology != topology {
            return Self::new(scene);
        }
        let mut reused = 0;
        let mut after = |tree: &Tree<Triangles>, source: &TriangleSource<'_>| {
            let kept = tree.refitted(source);
            reused += usize::from(kept.is_some());
            kept.unwrap_or_else(|| Tree::of_triangles(source))
        };
        let parts = Parts::of(scene);
        let members = Members::of::<Triangles>(scene, &parts);
        let before = &previous.triangles;
        let common = after(&before.common, &TriangleSource::placed(scene, &members.common));
        let sources = scene.meshes.iter().map(|mesh| TriangleSource::Mesh(mesh)).zip(&members.rigid);
        let shared = before
            .shared
            .iter()
            .zip(sources)
            .map(|(tree, (source, &is_wanted))| if is_wanted { Arc::new(after(tree, &source)) } else { Arc::default() })
            .collect();
        let triangles = TwoLevel::over(scene, &members, common, shared);
        Self { refitted: reused, ..Self::over(scene, triangles, &parts, topology) }
    }
}

impl Tree<Triangles> {
    /// This tree around the present places of its triangles; `None` where a build is the better choice.
    pub(super) fn refitted(&self, source: &TriangleSource<'_>) -> Option<Self> {
        let count: usize = self.primitives.blocks.par_iter().map(Block::len).sum();
        if self.nodes.is_empty() || count != source.count() {
            return None;
        }
        let block = |old: &Block| {
            let (mut block, mut bounds) = (Block::EMPTY, Bounds::EMPTY);
            for lane in 0..old.len() {
                let name = [old.instance[lane], old.triangle[lane]];
                let corners = source.corners(name);
                let own = Bounds::of(&corners);
                if !own.is_within_reach() {
                    return None;
                }
                bounds = bounds.union(&own);
                block.set(lane, &corners, name);
            }
            Some((block, bounds))
        };
        let (blocks, boxes): (Vec<Block>, Vec<Bounds>) =
            self.primitives.blocks.par_iter().map(block).collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let mut nodes = self.nodes.clone();
        let mut around = vec![Bounds::EMPTY; nodes.len()];
        // Children come after their parents.
        for (i, node) in nodes.iter_mut().enumerate().rev() {
            let parts: ArrayVec<Bounds, WIDTH> = node
                .children()
                .map(|child| if child.is_leaf() { boxes[child.index()] } else { around[child.index()] })
                .collect();
            *node = node.around(&parts);
            around[i] = parts.iter().fold(Bounds::EMPTY, |all, part| all.union(part));
        }
        let surface = self.primitives.surface;
        let is_worth_it = half_surface(&nodes) <= WORSE * surface;
        is_worth_it.then(|| Self { nodes, primitives: Triangles::at_rest(blocks, surface) })
    }
}

impl Block {
    /// Number of triangles in the block: those of the first lanes.
    fn len(&self) -> usize {
        (0..LANES).take_while(|&lane| self.holds(lane)).count()
    }
}

impl Node {
    /// A node with the children of this one and with these boxes.
    fn around(&self, boxes: &[Bounds]) -> Self {
        let (first_node, first_leaf) = self.first_children();
        Self::new(boxes, self.inner_count()).pointing_to(first_node, first_leaf)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Ray;
    use super::*;
    use crate::scene::visibility::Rays;
    use crate::scene::{SceneBuilder, mesh::MeshDescription};
    use glam::{DMat4, DVec3, Vec3, Vec3A};

    /// A sheet of hills, twice as two objects of their own and thrice as instances of one mesh.
    fn scene(phase: f32, moved: f64, columns: u32) -> Scene {
        let sheet = |phase: f32| {
            let at = |i: u32, j: u32| {
                let (x, y) = (i as f32 / 40.0, j as f32 / 40.0);
                Vec3::new(x, y, 0.1 * (9.0 * x + phase).sin() * (7.0 * y - phase).cos())
            };
            let place = |i: u32, j: u32| i * 41 + j;
            let cells = || (0..columns).flat_map(|i| (0..40).map(move |j| (i, j)));
            MeshDescription {
                name: "sheet".into(),
                positions: (0..=columns).flat_map(|i| (0..=40).map(move |j| at(i, j))).collect(),
                triangles: cells()
                    .flat_map(|(i, j)| {
                        [
                            [place(i, j), place(i + 1, j), place(i + 1, j + 1)],
                            [place(i, j), place(i + 1, j + 1), place(i, j + 1)],
                        ]
                    })
                    .collect(),
                ..Default::default()
            }
        };
        let mut builder = SceneBuilder::new();
        let shared = builder.add_mesh(sheet(2.0 * phase)).unwrap();
        let mut add = |mesh, x: f64, z: f64| {
            builder
                .add_instance("sheet", mesh, DMat4::from_translation(DVec3::new(x, 0.0, z)), &[], true, true)
                .unwrap();
        };
        (0..3).for_each(|i| add(shared, f64::from(i), -1.0 + 0.1 * moved));
        let own = [sheet(phase), sheet(-phase)].map(|mesh| builder.add_mesh(mesh).unwrap());
        for (i, mesh) in own.into_iter().enumerate() {
            let matrix = DMat4::from_translation(DVec3::new(i as f64 + moved, 0.0, 0.0));
            builder.add_instance("own", mesh, matrix, &[], true, true).unwrap();
        }
        builder.build(DVec3::ZERO)
    }

    fn rays() -> impl Iterator<Item = Ray> {
        (0..4000u32).map(|i| {
            let u = |by: f64| (f64::from(i) * by).fract() as f32;
            let direction = Vec3A::new(0.3 * u(0.73) - 0.15, 0.3 * u(0.41) - 0.15, -1.0).normalize();
            Ray::new(Vec3A::new(3.0 * u(0.618), u(0.755), 2.0), direction)
        })
    }

    #[test]
    fn answers_are_those_of_new_trees() {
        let first = Accel::new(&scene(0.0, 0.0, 40));
        let mut last = Accel::new_after(&first, &scene(0.0, 0.0, 40));
        for step in 1..6 {
            let now = scene(0.2 * step as f32, 0.02 * f64::from(step), 40);
            let (refitted, built) = (Accel::new_after(&last, &now), Accel::new(&now));
            assert_eq!((refitted.refitted(), built.refitted()), (2, 0));
            let mut hits = 0;
            for ray in rays() {
                let [a, b] = [&refitted, &built].map(|accel| accel.closest(&ray, Rays::CAMERA));
                assert_eq!(a.map(|hit| hit.t), b.map(|hit| hit.t), "{ray:?}");
                hits += usize::from(a.is_some());
            }
            assert!(hits > 2000, "{hits}");
            last = refitted;
        }
    }

    /// Triangles moved at random, others that are new, and trees over nothing are built.
    #[test]
    fn what_does_not_fit_is_built_anew() {
        let first = Accel::new(&scene(0.0, 0.0, 40));
        assert_eq!(Accel::new_after(&first, &scene(0.0, 0.0, 39)).refitted(), 0);
        // The two objects leave each other: their boxes are of one tree. The mesh of instances is as it was.
        let far = scene(0.0, 50.0, 40);
        let mut apart = far;
        let mut scattered = apart.instances.pop().unwrap();
        scattered.to_render = glam::Affine3A::from_scale(Vec3::splat(30.0)) * scattered.to_render;
        apart.instances.push(scattered);
        assert_eq!(Accel::new_after(&first, &apart).refitted(), 1);
        let empty = SceneBuilder::new().build(DVec3::ZERO);
        assert_eq!(Accel::new_after(&Accel::new(&empty), &empty).refitted(), 0);
    }
}
