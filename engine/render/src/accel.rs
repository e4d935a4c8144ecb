//! Finding what a ray hits. Meshes that stand in the scene once share one tree in render space; those that stand in
//! it several times have one each, in object space, below a tree of their instances. docs/design/tree.md says why.

mod apart;
mod balls;
mod beside;
mod bounds;
mod build;
mod capsules;
pub(crate) mod curves;
mod divide;
mod moving;
mod node;
mod places;
pub(crate) mod points;
mod posed;
mod refit;
mod segment;
mod source;
mod traverse;
mod triangles;

use crate::Rgb;
use crate::scene::{Scene, curves::Controls, motion::MIDDLE, visibility::Rays};
use beside::ExtraTrees;
use bounds::Bounds;
use build::build;
use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3A;
use node::Node;
use places::{PlacedMesh, placed};
use rayon::prelude::*;
use refit::Topology;
use source::{Parts, TriangleSource};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use traverse::{Found, TreeRay, TriangleTree, traverse};
use triangles::{Block, LANES};

/// A half line in render space.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin of the ray.
    pub origin: Vec3A,
    /// Direction of the ray, unit.
    pub direction: Vec3A,
    /// Nothing farther than this counts, Blender units.
    pub t_max: f32,
    /// The triangle, strand or point that it leaves.
    pub skip: SelfHit,
    /// The moment: from 0, as the shutter opens, to 65535, as it is closed.
    pub moment: u16,
}

impl Ray {
    /// A ray without end, in the middle of the exposure.
    #[inline]
    pub fn new(origin: Vec3A, direction: Vec3A) -> Self {
        Self { origin, direction, t_max: f32::INFINITY, skip: SelfHit::NONE, moment: MIDDLE }
    }

    /// This ray at another moment.
    #[inline]
    pub fn at(self, moment: u16) -> Self {
        Self { moment, ..self }
    }
}

/// A triangle, a strand of hair or a point of a cloud that a ray does not hit, as in Cycles: what leaves it does not come back to it.
/// A triangle is flat, but the distance to a large one is known less well than how far from it a ray starts; a ribbon that turns to
/// every ray would hide from itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SelfHit {
    /// Index of its instance.
    pub instance: u32,
    /// The number of the triangle, strand or point in its mesh, its curves, or its cloud.
    pub part: u32,
}

impl SelfHit {
    /// The skip of a ray that leaves no surface.
    pub const NONE: Self = Self { instance: u32::MAX, part: u32::MAX };

    #[inline(always)]
    fn is(self, instance: u32, part: u32) -> bool {
        self.part == part && self.instance == instance
    }
}

/// Added to [`Hit::v`] where a round strand is hit from within.
const FROM_WITHIN: f32 = 3.0;
/// Added to [`Hit::v`] where the normal leans as it does not of a cylinder.
const LEANS_AWAY: f32 = 6.0;

/// A hit of a ray on a triangle, a segment of a curve, or a point of a cloud.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray from its origin, Blender units.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner; along a segment, 0 to 1 (beyond on a round end, by
    /// which way the normal leans there). Of a point this and `v` are which way its surface looks: [`points::folded`].
    pub u: f32,
    /// Barycentric weight of the third; across a segment, -1 to 1, and more where a round strand is hit from within or its normal
    /// leans the other way: see [`Across`].
    pub v: f32,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the mesh's triangles, or a segment's or point's number.
    pub triangle: u32,
    /// The moment of the ray: from 0, as the shutter opens, to 65535, as it is closed.
    pub moment: u16,
}

/// The meaning of [`Hit::v`] on a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Across {
    /// The sine of the angle between the outward normal and the view, -1 to 1.
    pub sine: f32,
    /// True if the ray hits a round strand from within.
    pub is_within: bool,
    /// True if the part of the outward normal that is neither across nor along the strand leans away from the view.
    pub leans_away: bool,
}

impl Across {
    /// The meaning of a hit's `v` on a strand.
    pub fn of(v: f32) -> Self {
        // By how many steps of 3 it is moved.
        let code = (v / FROM_WITHIN).round().clamp(0.0, 3.0);
        let is_within = code == 1.0 || code == 3.0;
        Self { sine: (v - FROM_WITHIN * code).clamp(-1.0, 1.0), is_within, leans_away: (code >= 2.0) != is_within }
    }
}

/// The trees of one scene.
pub struct Accel {
    level: Level,
    /// The tree in render space of all meshes that have one instance.
    common: TriangleTree,
    /// The trees in object space of the other meshes.
    meshes: Vec<Arc<TriangleTree>>,
    /// The nodes over the instances of the meshes with trees of their own.
    places: Vec<Node>,
    /// The instances, in the order of the leaves of `places`.
    placed: Vec<PlacedMesh>,
    /// Trees of hair, point clouds and moving instances, if there are any.
    beside: Option<Box<ExtraTrees>>,
    /// The kinds of ray that see it, by instance.
    visible: Vec<Rays>,
    /// The kinds of ray that nothing is hidden from.
    all_visible: Rays,
    bounds: Option<Bounds>,
    topology: Topology,
    refitted: usize,
}

impl Accel {
    /// Builds all trees on the current rayon pool.
    pub fn new(scene: &Scene) -> Self {
        let parts = Parts::of(scene);
        let common = TriangleTree::new(&TriangleSource::placed(scene, &parts.alone));
        let tree = |source: Option<TriangleSource<'_>>| {
            Arc::new(source.map_or_else(TriangleTree::default, |s| TriangleTree::new(&s)))
        };
        let meshes = parts.shared_meshes(scene).into_par_iter().map(tree).collect();
        Self::over(scene, common, meshes, &parts, Topology::of(scene))
    }

    /// The trees of a scene over `common` and `meshes`.
    fn over(
        scene: &Scene,
        common: TriangleTree,
        meshes: Vec<Arc<TriangleTree>>,
        parts: &Parts,
        topology: Topology,
    ) -> Self {
        let (places, placed) = placed(scene, &parts.several, |instance| meshes[instance.mesh as usize].bounds());

        let visible: Vec<Rays> = scene.instances.iter().map(|instance| instance.visible).collect();
        let all_visible = visible.iter().fold(Rays::ALL, |all, one| all.common(*one));
        let beside = ExtraTrees::new(scene, parts);
        let bounds = places.first().map(Node::bounds).into_iter().chain(common.bounds());
        let bounds = bounds.chain(beside.as_ref().and_then(|beside| beside.bounds())).reduce(|a, b| a.union(&b));
        let (level, refitted) = (Level::new(), 0);
        Self { level, common, meshes, places, placed, beside, visible, all_visible, bounds, topology, refitted }
    }

    /// Number of the trees that were there before, see [`Self::new_after`].
    pub fn refitted(&self) -> usize {
        self.refitted
    }

    /// The bounds of everything, `None` for an empty scene.
    pub fn bounds(&self) -> Option<(Vec3A, Vec3A)> {
        self.bounds.map(|b| (b.low(), b.high()))
    }

    /// The closest hit of a ray of this kind.
    pub fn closest(&self, ray: &Ray, kind: Rays) -> Option<Hit> {
        let found = dispatch!(self.level, simd => self.closest_with(simd, ray, kind));
        match &self.beside {
            None => found,
            Some(beside) => beside.closest(self.level, ray, found, |instance| self.shows(instance, kind)),
        }
    }

    /// The transmittance between the ends of the ray; `opacity` gives the part of the light that each surface in between takes (1: all).
    pub fn transmittance(&self, ray: &Ray, opacity: impl FnMut(&Hit) -> f32) -> f32 {
        self.transmittance_of(ray, Rays::SHADOW, opacity)
    }

    /// [`Self::transmittance`] of a ray of any kind.
    pub fn transmittance_of(&self, ray: &Ray, kind: Rays, mut opacity: impl FnMut(&Hit) -> f32) -> f32 {
        let mut left = 1.0;
        self.each_between(ray, kind, |hit| {
            left *= 1.0 - opacity(hit);
            left > 0.0
        });
        left
    }

    /// The part of light, by channel, that gets from one end of the ray to the other; `through` says what each surface in between leaves.
    pub fn light_through(&self, ray: &Ray, kind: Rays, mut through: impl FnMut(&Hit) -> Rgb) -> Rgb {
        let mut left = Rgb::ONE;
        self.each_between(ray, kind, |hit| {
            left *= through(hit);
            left != Rgb::ZERO
        });
        left
    }

    /// Gives every surface between the ray's ends to `pass`, in any order, until `pass` returns false.
    fn each_between(&self, ray: &Ray, kind: Rays, mut pass: impl FnMut(&Hit) -> bool) {
        self.each_between_dyn(ray, kind, &mut pass);
    }

    /// [`Self::each_between`] of one type for all callers: the kernels are compiled once, not once for each type of `pass`.
    fn each_between_dyn(&self, ray: &Ray, kind: Rays, pass: &mut dyn FnMut(&Hit) -> bool) {
        let end = dispatch!(self.level, simd => self.each_between_with(simd, ray, kind, pass));
        if let (ControlFlow::Continue(()), Some(beside)) = (end, &self.beside) {
            let _ = beside.each_between(self.level, ray, |instance| self.shows(instance, kind), pass);
        }
    }

    #[inline(always)]
    fn shows(&self, instance: u32, kind: Rays) -> bool {
        self.all_visible.all_of(kind) || self.visible[instance as usize].any_of(kind)
    }

    #[inline(always)]
    fn closest_with<S: Simd>(&self, simd: S, ray: &Ray, kind: Rays) -> Option<Hit> {
        let here = TreeRay::new(ray.origin, ray.direction);
        let found = self.common.closest(
            simd,
            &here,
            ray.t_max,
            #[inline(always)]
            |instance, triangle| self.shows(instance, kind) && !ray.skip.is(instance, triangle),
        );
        let mut nearest = found.map(|found| hit(found, 1.0, found.instance, ray.moment));
        if !self.places.is_empty() {
            let t_max = nearest.map_or(ray.t_max, |hit| hit.t);
            let _ = traverse(
                simd,
                &self.places,
                &here.boxes,
                t_max,
                #[inline(always)]
                |leaf, mut t_max| {
                    if let Some((placed, there, scale)) = self.enter(leaf, ray, kind)
                        && let Some(found) = self.meshes[placed.mesh as usize].closest(
                            simd,
                            &there,
                            t_max * scale,
                            #[inline(always)]
                            |_, triangle| !ray.skip.is(placed.instance, triangle),
                        )
                    {
                        let hit = hit(found, scale, placed.instance, ray.moment);
                        // Not so where the division rounds up.
                        t_max = t_max.min(hit.t);
                        nearest = Some(hit);
                    }
                    ControlFlow::Continue(t_max)
                },
            );
        }
        nearest
    }

    #[inline(always)]
    fn each_between_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        kind: Rays,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        let mut pass = |hit: Hit| {
            let goes_on = ray.skip.is(hit.instance, hit.triangle) || pass(&hit);
            if goes_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let here = TreeRay::new(ray.origin, ray.direction);
        self.common.visit(
            simd,
            &here,
            ray.t_max,
            #[inline(always)]
            |found| {
                if self.shows(found.instance, kind) {
                    pass(hit(found, 1.0, found.instance, ray.moment))
                } else {
                    ControlFlow::Continue(())
                }
            },
        )?;
        if self.places.is_empty() {
            return ControlFlow::Continue(());
        }
        traverse(
            simd,
            &self.places,
            &here.boxes,
            ray.t_max,
            #[inline(always)]
            |leaf, t_max| {
                if let Some((placed, there, scale)) = self.enter(leaf, ray, kind) {
                    let tree = &self.meshes[placed.mesh as usize];
                    tree.visit(
                        simd,
                        &there,
                        t_max * scale,
                        #[inline(always)]
                        |found| pass(hit(found, scale, placed.instance, ray.moment)),
                    )?;
                }
                ControlFlow::Continue(t_max)
            },
        )
    }

    /// The ray in the object space of an instance, and how much longer distances are there; `None` where the ray
    /// cannot see it.
    #[inline(always)]
    fn enter(&self, leaf: usize, ray: &Ray, kind: Rays) -> Option<(&PlacedMesh, TreeRay, f32)> {
        let placed = &self.placed[leaf];
        let within = placed.enter(ray).filter(|_| self.shows(placed.instance, kind))?;
        Some((placed, TreeRay::new(within.origin, within.direction), within.scale))
    }
}

#[inline(always)]
fn hit(found: Found, scale: f32, instance: u32, moment: u16) -> Hit {
    Hit { t: found.t / scale, u: found.u, v: found.v, instance, triangle: found.triangle, moment }
}

impl TriangleTree {
    fn new(source: &TriangleSource<'_>) -> Self {
        let mut items = source.boxes();
        items.retain(Bounds::is_within_reach);
        let built = build(&mut items, LANES);
        // The boxes take four times the memory of their names, and blocks are yet to come.
        let names: Vec<[u32; 2]> = items.iter().map(Bounds::name).collect();
        drop(items);
        let block = |leaf: Range<usize>| {
            let mut block = Block::EMPTY;
            for (lane, name) in names[leaf].iter().enumerate() {
                block.set(lane, &source.corners(*name), *name);
            }
            block
        };
        let blocks = built.leaves.into_par_iter().map(block).collect();
        let tree = Self { nodes: built.nodes, blocks, surface: 0.0 };
        Self { surface: tree.surface_now(), ..tree }
    }

    fn bounds(&self) -> Option<Bounds> {
        self.nodes.first().map(Node::bounds)
    }
}

/// A start just off a surface, on the side that `normal` points to: `error` away, which bounds how far rounding
/// may have put `p` from the surface.
#[inline]
pub fn offset_origin(p: Vec3A, normal: Vec3A, error: f32) -> Vec3A {
    p + normal * error
}

#[cfg(test)]
mod tests;
