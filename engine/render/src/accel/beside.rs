//! Trees that most scenes do not need: hair, point clouds, and moving instances. Scenes without these pay one test a
//! ray.

use super::bounds::Bounds;
use super::curves::CurveForest;
use super::moving::MovingForest;
use super::points::PointForest;
use super::source::Parts;
use super::{Hit, Ray};
use crate::scene::Scene;
use fearless_simd::{Level, Simd, dispatch};
use std::ops::ControlFlow;

/// Trees beside those of still triangles.
pub(super) trait Forest {
    /// The closest hit on a wanted instance if it is nearer than `nearest`, else `nearest`.
    fn closest_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        nearest: Option<Hit>,
        wanted: &impl Fn(u32) -> bool,
    ) -> Option<Hit>;

    /// Visits the hits on wanted instances between the ray's ends until `pass` returns false; `Break` if it did.
    fn each_between_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()>;

    /// [`Self::closest_with`] in the lanes that the processor has.
    #[inline(never)]
    fn closest(&self, level: Level, ray: &Ray, nearest: Option<Hit>, wanted: &impl Fn(u32) -> bool) -> Option<Hit> {
        dispatch!(level, simd => self.closest_with(simd, ray, nearest, wanted))
    }

    /// [`Self::each_between_with`] in the lanes that the processor has.
    #[inline(never)]
    fn each_between(
        &self,
        level: Level,
        ray: &Ray,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        dispatch!(level, simd => self.each_between_with(simd, ray, wanted, pass))
    }
}

/// The trees of a scene beside those of triangles.
pub(super) struct ExtraTrees {
    curves: Option<Box<CurveForest>>,
    points: Option<Box<PointForest>>,
    moving: Option<MovingForest>,
}

impl ExtraTrees {
    /// The trees of a scene beside those of triangles; `None` if there are none.
    pub(super) fn new(scene: &Scene, parts: &Parts) -> Option<Box<Self>> {
        let (curves, points) = (CurveForest::new(scene, parts), PointForest::new(scene, parts));
        let moving = MovingForest::new(scene);
        let has_any = curves.is_some() || points.is_some() || moving.is_some();
        has_any.then(|| Box::new(Self { curves, points, moving }))
    }

    pub(super) fn bounds(&self) -> Option<Bounds> {
        let of_curves = self.curves.as_ref().and_then(|curves| curves.bounds());
        let of_points = self.points.as_ref().and_then(|points| points.bounds());
        let all = of_curves.into_iter().chain(of_points).chain(self.moving.as_ref().and_then(MovingForest::bounds));
        all.reduce(|a, b| a.union(&b))
    }

    /// The closest hit in all of these trees; see [`Forest::closest_with`].
    pub(super) fn closest(
        &self,
        level: Level,
        ray: &Ray,
        mut nearest: Option<Hit>,
        wanted: impl Fn(u32) -> bool,
    ) -> Option<Hit> {
        if let Some(moving) = &self.moving {
            nearest = moving.closest(level, ray, nearest, &wanted);
        }
        if let Some(points) = &self.points {
            nearest = points.closest(level, ray, nearest, &wanted);
        }
        match &self.curves {
            Some(curves) => curves.closest(level, ray, nearest, &wanted),
            None => nearest,
        }
    }

    /// Visits the hits in all of these trees; see [`Forest::each_between_with`].
    pub(super) fn each_between(
        &self,
        level: Level,
        ray: &Ray,
        wanted: impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        if let Some(moving) = &self.moving {
            moving.each_between(level, ray, &wanted, pass)?;
        }
        if let Some(points) = &self.points {
            points.each_between(level, ray, &wanted, pass)?;
        }
        match &self.curves {
            Some(curves) => curves.each_between(level, ray, &wanted, pass),
            None => ControlFlow::Continue(()),
        }
    }
}
