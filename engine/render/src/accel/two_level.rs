//! The trees of all primitives of one kind, and the way of a ray through them: a common tree in render space first, then the trees of
//! instances that stand still, then those of instances that move, each with the length of the ray that is left.

use super::bounds::Bounds;
use super::members::Members;
use super::moving::MovingPlaces;
use super::node::{BoxRay, Node};
use super::places::{PlacedMesh, PlacedMeshes, Within};
use super::query::{Answer, ClosestHit, EachHit, Query};
use super::source::Parts;
use super::traverse::traverse;
use super::tree::{Primitives, Tree, TreeRay};
use super::{Hit, Ray};
use crate::scene::mesh::Mesh;
use crate::scene::motion::{Moving, Pose};
use crate::scene::{Instance, Scene};
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use std::borrow::Borrow;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The trees of one kind of primitive.
pub(super) struct TwoLevel<P: Primitives> {
    /// The tree in render space of meshes that stand in the scene once.
    pub(super) common: Tree<P>,
    /// Trees in object space, by mesh; empty for meshes that need none.
    pub(super) shared: Vec<Arc<Tree<P>>>,
    /// The instances of shared trees that stand still.
    places: PlacedMeshes,
    /// Instances that move or deform; boxed, as most scenes have none.
    moving: Option<Box<MovingTrees<P>>>,
}

/// Instances that move or deform.
struct MovingTrees<P> {
    places: MovingPlaces,
    /// Trees of the meshes that deform, by mesh, then by key: from there to the next.
    posed: Vec<Vec<Tree<P>>>,
}

/// The tree of a mesh in a pose.
#[inline(always)]
fn in_pose<'a, P>(shared: &'a [Arc<Tree<P>>], posed: &'a [Vec<Tree<P>>], mesh: u32, pose: Pose) -> &'a Tree<P> {
    posed[mesh as usize].get(pose.key as usize).unwrap_or(&shared[mesh as usize])
}

impl<P: Primitives> TwoLevel<P> {
    /// Builds the trees of a scene; `None` if it has no such primitives.
    pub(super) fn if_any(scene: &Scene, parts: &Parts) -> Option<Box<Self>> {
        scene.meshes.iter().any(|mesh| P::are_in(mesh)).then(|| Box::new(Self::new(scene, parts)))
    }

    /// Builds the trees of a scene.
    pub(super) fn new(scene: &Scene, parts: &Parts) -> Self {
        let members = Members::of::<P>(scene, parts);
        let common = P::in_render_space(scene, &members.common);
        let tree = |(mesh, &is_wanted): (&Arc<Mesh>, &bool)| {
            Arc::new(if is_wanted { P::in_object_space(mesh) } else { Tree::default() })
        };
        let shared = scene.meshes.par_iter().zip(&members.rigid).map(tree).collect();
        Self::over(scene, &members, common, shared)
    }

    /// The trees over a common tree and over trees of meshes.
    pub(super) fn over(scene: &Scene, members: &Members, common: Tree<P>, shared: Vec<Arc<Tree<P>>>) -> Self {
        let places = PlacedMeshes::new(scene, &members.placed, |instance| shared[instance.mesh as usize].bounds());
        let keys = |(mesh, &deforms): (&Arc<Mesh>, &bool)| match &mesh.poses {
            Some(poses) if deforms => {
                (1..poses.key_count()).map(|next| P::between_keys(mesh, poses, next - 1)).collect()
            }
            _ => Vec::new(),
        };
        let posed: Vec<Vec<Tree<P>>> = scene.meshes.par_iter().zip(&members.deforming).map(keys).collect();
        let is_own = |one: &Moving| P::are_in(&scene.meshes[scene.instances[one.instance as usize].mesh as usize]);
        let bounds = |now: &Instance| in_pose(&shared, &posed, now.mesh, now.pose).bounds();
        let moving = MovingPlaces::new(scene, is_own, bounds);
        let moving = moving.map(|places| Box::new(MovingTrees { places, posed }));
        Self { common, shared, places, moving }
    }

    /// The box around everything; `None` if there is nothing.
    pub(super) fn bounds(&self) -> Option<Bounds> {
        let moving = self.moving.as_ref().and_then(|moving| moving.places.bounds());
        let all = self.places.bounds().into_iter().chain(self.common.bounds()).chain(moving);
        all.reduce(|a, b| a.union(&b))
    }

    /// Puts the closest hit on a wanted instance into `nearest`, unless that is a nearer one.
    #[inline(always)]
    pub(super) fn closest(&self, level: Level, ray: &Ray, nearest: &mut Option<Hit>, wanted: &impl Fn(u32) -> bool) {
        let _ = dispatch!(level, simd => {
            self.follow_still(simd, &mut Query { ray, wanted, answer: ClosestHit::new(ray, nearest) })
        });
        if let Some(moving) = &self.moving {
            self.closest_moving(moving, level, ray, nearest, wanted);
        }
    }

    /// [`Self::closest`] among moving instances. (A function of its own: kernels of scenes without motion are not the larger for it.)
    #[inline(never)]
    fn closest_moving(
        &self,
        moving: &MovingTrees<P>,
        level: Level,
        ray: &Ray,
        nearest: &mut Option<Hit>,
        wanted: &impl Fn(u32) -> bool,
    ) {
        let _ = dispatch!(level, simd => {
            self.follow_moving(simd, moving, &mut Query { ray, wanted, answer: ClosestHit::new(ray, nearest) })
        });
    }

    /// Gives the hits on wanted instances between the ray's ends to `pass`, in no order, until `pass` returns false; `Break` if it did.
    #[inline(always)]
    pub(super) fn each_between(
        &self,
        level: Level,
        ray: &Ray,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        dispatch!(level, simd => {
            self.follow_still(simd, &mut Query { ray, wanted, answer: EachHit::new(ray, pass) })
        })?;
        match &self.moving {
            None => ControlFlow::Continue(()),
            Some(moving) => self.each_moving_between(moving, level, ray, wanted, pass),
        }
    }

    /// [`Self::each_between`] among moving instances.
    #[inline(never)]
    fn each_moving_between(
        &self,
        moving: &MovingTrees<P>,
        level: Level,
        ray: &Ray,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        dispatch!(level, simd => {
            self.follow_moving(simd, moving, &mut Query { ray, wanted, answer: EachHit::new(ray, pass) })
        })
    }

    /// Asks a query of the common tree and of the instances that stand still.
    #[inline(always)]
    fn follow_still<S: Simd, W: Fn(u32) -> bool, A: Answer>(
        &self,
        simd: S,
        query: &mut Query<'_, W, A>,
    ) -> ControlFlow<()> {
        if !P::IN_MOST_SCENES && self.common.nodes.is_empty() && self.places.nodes().is_empty() {
            return ControlFlow::Continue(());
        }
        let here = TreeRay::<P>::new(query.ray.origin, query.ray.direction);
        let end = query.answer.end();
        self.common.follow(simd, &here, None, end, &mut query.within(None))?;
        follow_instances(
            simd,
            self.places.nodes(),
            &here.boxes,
            query,
            #[inline(always)]
            |leaf| {
                let placed = self.places.placed(leaf);
                (placed, &*self.shared[placed.mesh as usize], None)
            },
        )
    }

    /// Asks a query of the instances that move.
    #[inline(always)]
    fn follow_moving<S: Simd, W: Fn(u32) -> bool, A: Answer>(
        &self,
        simd: S,
        moving: &MovingTrees<P>,
        query: &mut Query<'_, W, A>,
    ) -> ControlFlow<()> {
        let moment = query.ray.moment;
        follow_instances(
            simd,
            moving.places.nodes(moment),
            &BoxRay::new(query.ray.origin, query.ray.direction),
            query,
            #[inline(always)]
            |leaf| {
                let (placed, pose) = moving.places.placed(leaf, moment);
                (placed, in_pose(&self.shared, &moving.posed, placed.mesh, pose), Some(pose.part))
            },
        )
    }
}

/// Asks a query of the instances in the leaves of `nodes`; `instance` gives the one of a leaf, its tree, and the part of the way to its
/// next key.
#[inline(always)]
fn follow_instances<'t, P: Primitives, M: Borrow<PlacedMesh>, S: Simd, W: Fn(u32) -> bool, A: Answer>(
    simd: S,
    nodes: &[Node],
    boxes: &BoxRay,
    query: &mut Query<'_, W, A>,
    instance: impl Fn(usize) -> (M, &'t Tree<P>, Option<f32>),
) -> ControlFlow<()> {
    let end = query.answer.end();
    traverse(
        simd,
        nodes,
        boxes,
        end,
        #[inline(always)]
        |leaf, _| {
            let (placed, tree, part) = instance(leaf);
            let placed = placed.borrow();
            if (query.wanted)(placed.instance)
                && let Some(Within { origin, direction, scale }) = placed.enter(query.ray)
            {
                let there = TreeRay::new(origin, direction);
                let end = query.answer.end() * scale;
                tree.follow(simd, &there, part, end, &mut query.within(Some((placed, scale))))?;
            }
            ControlFlow::Continue(query.answer.end())
        },
    )
}
