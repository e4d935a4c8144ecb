//! Queries of a ray: the nearest hit, or every hit. Each is asked of many trees in turn, and gathers hits in render space.

use super::places::PlacedMesh;
use super::tree::{LocalHit, SurfaceCoordinates, Visitor};
use super::{Hit, Ray};
use std::ops::ControlFlow;

/// The answer to a query, gathered hit by hit.
pub(super) trait Answer {
    /// True if the ray ends at a hit: nothing behind it counts.
    const ENDS_RAY: bool;

    /// The end of the ray in render space, Blender units.
    fn end(&self) -> f32;

    /// Takes a hit; `Break` ends the query.
    fn take(&mut self, hit: Hit) -> ControlFlow<()>;
}

/// The nearest hit so far.
pub(super) struct ClosestHit<'a> {
    nearest: &'a mut Option<Hit>,
    end: f32,
}

impl<'a> ClosestHit<'a> {
    /// The answer at the start of a query, where a nearest hit may be known from other trees.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, nearest: &'a mut Option<Hit>) -> Self {
        let end = nearest.map_or(ray.t_max, |hit| hit.t);
        Self { nearest, end }
    }
}

impl Answer for ClosestHit<'_> {
    const ENDS_RAY: bool = true;

    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }

    #[inline(always)]
    fn take(&mut self, hit: Hit) -> ControlFlow<()> {
        // A distance of less than a normal number in an instance may be rounded up by more than it was nearer.
        self.end = self.end.min(hit.t);
        *self.nearest = Some(hit);
        ControlFlow::Continue(())
    }
}

/// Each hit before the end of the ray, handed on until the receiver returns false.
pub(super) struct EachHit<'a> {
    pass: &'a mut dyn FnMut(&Hit) -> bool,
    end: f32,
}

impl<'a> EachHit<'a> {
    /// The answer that hands hits on to `pass`.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, pass: &'a mut dyn FnMut(&Hit) -> bool) -> Self {
        Self { pass, end: ray.t_max }
    }
}

impl Answer for EachHit<'_> {
    const ENDS_RAY: bool = false;

    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }

    #[inline(always)]
    fn take(&mut self, hit: Hit) -> ControlFlow<()> {
        if (self.pass)(&hit) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

/// A ray and its answer.
pub(super) struct Query<'a, W, A> {
    pub(super) ray: &'a Ray,
    /// The instances that the ray can hit.
    pub(super) wanted: &'a W,
    pub(super) answer: A,
}

impl<'a, W, A> Query<'a, W, A> {
    /// The query in the tree of an instance, where distances are longer by a factor; `None`: in a tree in render space.
    #[inline(always)]
    pub(super) fn within<'q>(&'q mut self, instance: Option<(&'q PlacedMesh, f32)>) -> InTree<'q, 'a, W, A> {
        InTree { query: self, instance }
    }
}

/// A query in the space of one tree.
pub(super) struct InTree<'q, 'a, W, A> {
    query: &'q mut Query<'a, W, A>,
    /// The instance, and the factor on distances; `None` in render space.
    instance: Option<(&'q PlacedMesh, f32)>,
}

impl<C: SurfaceCoordinates, W: Fn(u32) -> bool, A: Answer> Visitor<C> for InTree<'_, '_, W, A> {
    #[inline(always)]
    fn wants(&self, instance: u32, part: u32) -> bool {
        let skip = self.query.ray.skip;
        match self.instance {
            None => (self.query.wanted)(instance) && !skip.is(instance, part),
            Some((placed, _)) => !skip.is(placed.instance, part),
        }
    }

    #[inline(always)]
    fn meet(&mut self, found: LocalHit<C>, end: f32) -> ControlFlow<(), f32> {
        // Refuses NaN, too.
        let is_nearer = found.t < end;
        if A::ENDS_RAY && !is_nearer {
            return ControlFlow::Continue(end);
        }
        let (t, instance) = match self.instance {
            None => (found.t, found.instance),
            Some((placed, scale)) => (found.t / scale, placed.instance),
        };
        let is_first = t < self.query.answer.end();
        if A::ENDS_RAY && C::FIRST_COUNTS && !is_first {
            return ControlFlow::Continue(end);
        }
        let [u, v] = found.coordinates.uv(self.instance.map(|(placed, _)| placed));
        let moment = self.query.ray.moment;
        self.query.answer.take(Hit { t, u, v, instance, triangle: found.number, moment })?;
        ControlFlow::Continue(if A::ENDS_RAY { found.t } else { end })
    }
}
