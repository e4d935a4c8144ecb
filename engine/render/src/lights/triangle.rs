//! A placed triangle that emits, with the data for sampling a point of it, worked out once.

use super::bounds::LightBounds;
use super::{Leaving, LightSample};
use crate::nodes::{PathState, RayCone, View};
use crate::scene::Scene;
use crate::scene::motion::MIDDLE;
use crate::scene::visibility::{LightSets, Rays};
use crate::surface::{area_vector, geometric_normal, mesh_of, position_error};
use crate::{Rgb, nodes, sampler::warp};
use glam::{Vec3, Vec3A};
use std::f32::consts::{FRAC_PI_2, PI};

/// The view for emission that does not depend on the direction.
const FROM_LIGHTS: View = View {
    direction: Vec3A::NEG_Z,
    distance: 1.0,
    way: PathState::LIGHT,
    moment: MIDDLE,
    is_blurry: true,
    // About that of a pixel.
    cone: RayCone { width: 1e-3, spread: 0.0 },
};

/// A triangle that emits, render space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LitTriangle {
    /// Index of the instance.
    pub(super) instance: u32,
    /// Index of the triangle in its mesh.
    pub(super) triangle: u32,
    /// True if the triangle's back is worth a light sample, too.
    pub(super) two_sided: bool,
    /// The kinds of ray that its object shows itself to.
    reaches: Rays,
    sets: LightSets,
    /// Emitted power, for choosing.
    pub(super) power: f32,
    /// Area, Blender units squared.
    pub(super) area: f32,
    /// Unit, on the front.
    normal: Vec3,
    corner: Vec3,
    edges: [Vec3; 2],
    /// Bound of the rounding error of its position, Blender units.
    error: f32,
    /// Radiance of the triangle, if that is spatially constant.
    radiance: Option<Vec3>,
}

impl LitTriangle {
    /// `brightness` is the mean radiance of its material.
    pub(super) fn new(scene: &Scene, instance: u32, triangle: u32, brightness: f32, two_sided: bool) -> Self {
        let [a, b, c] = placed_corners(scene, instance, triangle);
        let area = 0.5 * area_vector([a, b, c]).length();
        let placed = &scene.instances[instance as usize];
        let mesh = mesh_of(scene, instance);
        let material = &scene.materials[placed.material(mesh.slot(triangle)) as usize];
        let is_even = material.emits_evenly();
        Self {
            instance,
            triangle,
            two_sided,
            reaches: placed.visible,
            sets: placed.links.sets,
            power: brightness * area * PI * if two_sided { 2.0 } else { 1.0 },
            area,
            normal: geometric_normal(placed, &placed.corners(mesh, triangle)).into(),
            corner: a.into(),
            edges: [(b - a).into(), (c - a).into()],
            error: mesh.corners(triangle).map(|p| position_error(placed, p.into())).into_iter().fold(0.0, f32::max),
            radiance: is_even
                .then(|| nodes::emission(material, scene.into(), [instance, triangle], [0.0; 2], &FROM_LIGHTS)),
        }
    }

    /// This emitter on another instance, one that stands for a moment of its own.
    pub(super) fn standing(&self, scene: &Scene, instance: u32) -> Self {
        let [a, b, c] = placed_corners(scene, instance, self.triangle);
        let placed = &scene.instances[instance as usize];
        let corners = placed.corners(mesh_of(scene, instance), self.triangle);
        Self {
            instance,
            area: 0.5 * area_vector([a, b, c]).length(),
            normal: geometric_normal(placed, &corners).into(),
            corner: a.into(),
            edges: [(b - a).into(), (c - a).into()],
            error: corners.map(|p| position_error(placed, p.into())).into_iter().fold(0.0, f32::max),
            ..*self
        }
    }

    /// The objects that the triangle lights, and those that cast shadows in its light.
    pub(super) fn sets(&self) -> LightSets {
        self.sets
    }

    /// The kinds of ray that its object shows itself to.
    pub(super) fn reaches(&self) -> Rays {
        self.reaches
    }

    /// The point at the weights of the second and third corner.
    pub(super) fn point(&self, [v, w]: [f32; 2]) -> Vec3A {
        (self.corner + self.edges[0] * v + self.edges[1] * w).into()
    }

    /// Unit, on the front.
    pub(super) fn normal(&self) -> Vec3A {
        self.normal.into()
    }

    /// The triangle's position and directions of emission.
    pub(super) fn bounds(&self) -> LightBounds {
        let corners = [self.corner, self.corner + self.edges[0], self.corner + self.edges[1]].map(Vec3A::from);
        LightBounds {
            min: corners[0].min(corners[1]).min(corners[2]),
            max: corners[0].max(corners[1]).max(corners[2]),
            power: self.power,
            axis: self.normal(),
            normal_spread_rad: 0.0,
            emission_spread_rad: FRAC_PI_2,
            two_sided: self.two_sided,
        }
    }

    /// The radiance that leaves a point of the triangle towards either side, for a view along that way.
    pub(super) fn radiance(&self, scene: &Scene, barycentric: [f32; 2], view: &View) -> Rgb {
        if let Some(radiance) = self.radiance {
            return radiance;
        }
        let slot = mesh_of(scene, self.instance).slot(self.triangle);
        let material = &scene.materials[scene.instances[self.instance as usize].material(slot) as usize];
        nodes::emission(material, scene.into(), [self.instance, self.triangle], barycentric, view)
    }

    /// Samples the light that arrives at `from`.
    #[inline]
    pub(super) fn sample(&self, scene: &Scene, from: Vec3A, u: [f32; 2], way: PathState) -> Option<LightSample> {
        let [v, w] = warp::sample_triangle(u);
        let to = self.point([v, w]) - from;
        let distance2 = to.length_squared();
        let distance = distance2.sqrt();
        let wi = to / distance;
        let cos = self.normal().dot(wi).abs();
        if !(cos > 1e-6 && self.area > 0.0 && distance > 0.0) {
            return None;
        }
        Some(LightSample {
            wi,
            distance,
            radiance: self.radiance(
                scene,
                [v, w],
                &View {
                    direction: wi,
                    distance,
                    way: way.light(),
                    moment: MIDDLE,
                    is_blurry: true,
                    cone: RayCone::pixel(&scene.viewport),
                },
            ),
            pdf: distance2 / (cos * self.area),
            point_like: false,
            cast_shadow: true,
            reaches: self.reaches,
            sets: self.sets,
            leaves: Some(Leaving { cos, error: self.error }),
        })
    }
}

/// A triangle's corners in render space.
pub(super) fn placed_corners(scene: &Scene, instance: u32, triangle: u32) -> [Vec3A; 3] {
    let placed = &scene.instances[instance as usize];
    placed.corners(mesh_of(scene, instance), triangle).map(|p| placed.to_render.transform_point3a(Vec3A::from(p)))
}

/// The area of a triangle, Blender units squared.
pub(super) fn area(scene: &Scene, instance: u32, triangle: u32) -> f32 {
    0.5 * area_vector(placed_corners(scene, instance, triangle)).length()
}
