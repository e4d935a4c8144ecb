//! One tree: nodes over leaves of primitives of one kind.

use super::bounds::Bounds;
use super::node::{BoxRay, Node};
use super::places::PlacedMesh;
use super::traverse::traverse;
use crate::scene::mesh::Mesh;
use crate::scene::motion::Poses;
use crate::scene::{Instance, Scene};
use fearless_simd::Simd;
use glam::Vec3A;
use std::ops::ControlFlow;

/// Primitives of one kind in the leaves of a tree, the test of a ray against those of one leaf, and the building of such trees.
///
/// An implementation is all that [`super::two_level::TwoLevel`] needs to know of a kind of primitive.
pub(super) trait Primitives: Default + Send + Sync + 'static {
    /// A ray in the form that the test of a leaf takes.
    type Ray;
    /// The place of a hit on its primitive.
    type Coordinates: SurfaceCoordinates;

    /// True if some of these primitives stand still in nearly every scene: rays go to them without asking.
    const IN_MOST_SCENES: bool = false;

    /// Makes the ray of the leaves' test; `direction` has length one.
    fn ray(origin: Vec3A, direction: Vec3A) -> Self::Ray;

    /// Offers the hits of a ray before `end` on wanted primitives of a leaf; gives the end of the ray from then on. `part` is the part
    /// of the way to the next key, for trees of [`Self::between_keys`]; `None` in a kernel for trees of unchanging shape.
    fn meet<S: Simd>(
        &self,
        simd: S,
        leaf: usize,
        part: Option<f32>,
        ray: &Self::Ray,
        end: f32,
        visitor: &mut impl Visitor<Self::Coordinates>,
    ) -> ControlFlow<(), f32>;

    /// True if a mesh consists of these primitives.
    fn are_in(mesh: &Mesh) -> bool;

    /// True if an instance keeps the primitives' form: only such an instance can stand in a tree in render space.
    fn keep_form(_instance: &Instance) -> bool {
        true
    }

    /// The tree in render space of instances, by their indices.
    fn in_render_space(scene: &Scene, instances: &[u32]) -> Tree<Self>;

    /// The tree of a mesh in object space.
    fn in_object_space(mesh: &Mesh) -> Tree<Self>;

    /// The tree in object space of a mesh that deforms, for the time from a key to the next: the boxes hold the way between both. By
    /// default the tree of the mesh as it is, for primitives that have no shapes over time.
    fn between_keys(mesh: &Mesh, _poses: &Poses, _key: usize) -> Tree<Self> {
        Self::in_object_space(mesh)
    }
}

/// The place of a hit on its primitive, as the test of a leaf gives it.
pub(super) trait SurfaceCoordinates: Copy {
    /// True if of hits in instances at one distance in render space the first that is found counts, else the last.
    const FIRST_COUNTS: bool = false;

    /// The numbers [`super::Hit::u`] and [`super::Hit::v`]; of a hit in the tree of an instance if there is one, else in render space.
    fn uv(self, instance: Option<&PlacedMesh>) -> [f32; 2];
}

impl SurfaceCoordinates for [f32; 2] {
    #[inline(always)]
    fn uv(self, _instance: Option<&PlacedMesh>) -> [f32; 2] {
        self
    }
}

/// A hit of a ray in the space of a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalHit<C> {
    /// Distance in the tree's space.
    pub(super) t: f32,
    /// Index of the instance; undefined in trees of one mesh.
    pub(super) instance: u32,
    /// The number [`super::Hit::triangle`].
    pub(super) number: u32,
    /// The place on the primitive.
    pub(super) coordinates: C,
}

/// The receiver of a ray's hits in one tree.
pub(super) trait Visitor<C> {
    /// True if hits on a primitive count, by the instance in its leaf and by the number that [`super::SelfHit::part`] has.
    fn wants(&self, instance: u32, part: u32) -> bool;

    /// Takes a hit on a wanted primitive; gives the end of the ray from then on, which was `end` so far.
    fn meet(&mut self, found: LocalHit<C>, end: f32) -> ControlFlow<(), f32>;
}

/// Primitives and the nodes above them.
#[derive(Debug, Default)]
pub(super) struct Tree<P> {
    pub(super) nodes: Vec<Node>,
    pub(super) primitives: P,
}

/// A ray in the space of a tree.
pub(super) struct TreeRay<P: Primitives> {
    pub(super) boxes: BoxRay,
    own: P::Ray,
}

impl<P: Primitives> TreeRay<P> {
    /// A ray for a tree's tests; `direction` has length one.
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A) -> Self {
        Self { boxes: BoxRay::new(origin, direction), own: P::ray(origin, direction) }
    }
}

impl<P: Primitives> Tree<P> {
    /// The box around everything; `None` of an empty tree.
    pub(super) fn bounds(&self) -> Option<Bounds> {
        self.nodes.first().map(Node::bounds)
    }

    /// Offers the hits of a ray before `end`, leaf by leaf, roughly near ones first; `part` as in [`Primitives::meet`].
    #[inline(always)]
    pub(super) fn follow<S: Simd>(
        &self,
        simd: S,
        ray: &TreeRay<P>,
        part: Option<f32>,
        end: f32,
        visitor: &mut impl Visitor<P::Coordinates>,
    ) -> ControlFlow<()> {
        traverse(
            simd,
            &self.nodes,
            &ray.boxes,
            end,
            #[inline(always)]
            |leaf, end| self.primitives.meet(simd, leaf, part, &ray.own, end, visitor),
        )
    }
}
