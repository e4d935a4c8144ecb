//! Intersection of rays with the scene. Meshes that stand in the scene once share one tree in render space; those that stand in
//! it several times have one each, in object space, below a tree of their instances. docs/design/tree.md says why.

mod apart;
mod balls;
mod beside;
mod block;
mod bounds;
mod build;
mod capsules;
pub(crate) mod curves;
mod divide;
mod members;
mod moving;
mod node;
mod places;
pub(crate) mod points;
mod query;
mod refit;
mod segment;
mod source;
mod traverse;
mod tree;
mod triangles;
mod two_level;

use crate::Rgb;
use crate::scene::{Scene, motion::MIDDLE, visibility::Rays};
use beside::ExtraTrees;
use bounds::Bounds;
use fearless_simd::Level;
use glam::Vec3A;
use refit::Topology;
use source::Parts;
use std::ops::ControlFlow;
use triangles::Triangles;
use two_level::TwoLevel;

/// A half line in render space.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin of the ray.
    pub origin: Vec3A,
    /// Direction of the ray, unit.
    pub direction: Vec3A,
    /// The distance beyond which no hit counts, Blender units.
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

/// A triangle, a strand of hair or a point of a cloud that a ray does not hit, as in Cycles: the origin of the ray, which no ray from it
/// hits again. A triangle is flat, but the distance to a large one is known less well than how far from it a ray starts; a ribbon that
/// turns to every ray would hide from itself.
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
    triangles: TwoLevel<Triangles>,
    /// Trees of hair and point clouds, if there are any.
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
        Self::over(scene, TwoLevel::new(scene, &parts), &parts, Topology::of(scene))
    }

    /// The trees of a scene over those of its triangles.
    fn over(scene: &Scene, triangles: TwoLevel<Triangles>, parts: &Parts, topology: Topology) -> Self {
        let visible: Vec<Rays> = scene.instances.iter().map(|instance| instance.visible).collect();
        let all_visible = visible.iter().fold(Rays::ALL, |all, one| all.common(*one));
        let beside = ExtraTrees::new(scene, parts);
        let bounds = triangles.bounds().into_iter().chain(beside.as_ref().and_then(|beside| beside.bounds()));
        let bounds = bounds.reduce(|a, b| a.union(&b));
        let (level, refitted) = (Level::new(), 0);
        Self { level, triangles, beside, visible, all_visible, bounds, topology, refitted }
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
        let shows = move |instance| self.shows(instance, kind);
        let mut nearest = None;
        self.triangles.closest(self.level, ray, &mut nearest, &shows);
        if let Some(beside) = &self.beside {
            beside.closest(self.level, ray, &mut nearest, &shows);
        }
        nearest
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

    /// The part of light, by channel, that gets from one end of the ray to the other; `through` gives the transmittance of each surface in
    /// between.
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
        let shows = move |instance| self.shows(instance, kind);
        let end = self.triangles.each_between(self.level, ray, &shows, pass);
        if let (ControlFlow::Continue(()), Some(beside)) = (end, &self.beside) {
            let _ = beside.each_between(self.level, ray, &shows, pass);
        }
    }

    /// True if all instances are visible to all of these kinds of rays.
    pub fn shows_all_to(&self, kinds: Rays) -> bool {
        self.all_visible.all_of(kinds)
    }

    #[inline(always)]
    fn shows(&self, instance: u32, kind: Rays) -> bool {
        self.all_visible.all_of(kind) || self.visible[instance as usize].any_of(kind)
    }
}

/// A start just off a surface, on the side that `normal` points to: `error` away, which bounds the distance that rounding
/// may have put `p` from the surface.
#[inline]
pub fn offset_origin(p: Vec3A, normal: Vec3A, error: f32) -> Vec3A {
    p + normal * error
}

#[cfg(test)]
mod tests;
