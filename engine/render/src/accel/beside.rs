//! Trees that most scenes do not need: hair and point clouds. Scenes without these pay one test a ray.

use super::bounds::Bounds;
use super::curves::Segments;
use super::points::Spheres;
use super::source::Parts;
use super::tree::Primitives;
use super::two_level::TwoLevel;
use super::{Hit, Ray};
use crate::scene::Scene;
use fearless_simd::Level;
use std::ops::ControlFlow;

/// The trees of a scene beside those of triangles.
pub(super) struct ExtraTrees {
    points: Option<Box<TwoLevel<Spheres>>>,
    curves: Option<Box<TwoLevel<Segments>>>,
}

impl ExtraTrees {
    /// The trees of a scene beside those of triangles; `None` if there are none.
    pub(super) fn new(scene: &Scene, parts: &Parts) -> Option<Box<Self>> {
        let (points, curves) = (TwoLevel::if_any(scene, parts), TwoLevel::if_any(scene, parts));
        (points.is_some() || curves.is_some()).then(|| Box::new(Self { points, curves }))
    }

    /// The box around everything in these trees; `None` if there is nothing.
    pub(super) fn bounds(&self) -> Option<Bounds> {
        let of_curves = self.curves.as_ref().and_then(|curves| curves.bounds());
        let of_points = self.points.as_ref().and_then(|points| points.bounds());
        of_curves.into_iter().chain(of_points).reduce(|a, b| a.union(&b))
    }

    /// Puts the closest hit in all of these trees into `nearest`; see [`TwoLevel::closest`].
    pub(super) fn closest(&self, level: Level, ray: &Ray, nearest: &mut Option<Hit>, wanted: &impl Fn(u32) -> bool) {
        if let Some(points) = &self.points {
            closest(points, level, ray, nearest, wanted);
        }
        if let Some(curves) = &self.curves {
            closest(curves, level, ray, nearest, wanted);
        }
    }

    /// Visits the hits in all of these trees; see [`TwoLevel::each_between`].
    pub(super) fn each_between(
        &self,
        level: Level,
        ray: &Ray,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        if let Some(points) = &self.points {
            each_between(points, level, ray, wanted, pass)?;
        }
        match &self.curves {
            Some(curves) => each_between(curves, level, ray, wanted, pass),
            None => ControlFlow::Continue(()),
        }
    }
}

/// [`TwoLevel::closest`], not inlined: the kernels of triangles are not the larger for these trees.
#[inline(never)]
fn closest<P: Primitives>(
    trees: &TwoLevel<P>,
    level: Level,
    ray: &Ray,
    nearest: &mut Option<Hit>,
    wanted: &impl Fn(u32) -> bool,
) {
    trees.closest(level, ray, nearest, wanted);
}

/// [`TwoLevel::each_between`], not inlined.
#[inline(never)]
fn each_between<P: Primitives>(
    trees: &TwoLevel<P>,
    level: Level,
    ray: &Ray,
    wanted: &impl Fn(u32) -> bool,
    pass: &mut dyn FnMut(&Hit) -> bool,
) -> ControlFlow<()> {
    trees.each_between(level, ray, wanted, pass)
}
