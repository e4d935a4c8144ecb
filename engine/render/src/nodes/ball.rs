//! A point of a cloud as shader graphs ask for it.

use crate::scene::points::Points;
use crate::scene::{Instance, Scene};
use crate::surface::SurfacePoint;
use glam::{Vec3A, Vec4};
use petzval_nodes::{AttributeKind, Field};

/// A field that only points have; zero for the rest.
pub(super) fn read(field: Field, instance: &Instance, points: &Points, surface: &SurfacePoint, scene: &Scene) -> Vec3A {
    let ball = || points.at(surface.triangle, instance.pose);
    match field {
        Field::PointPosition => {
            instance.to_render.transform_point3a(Vec3A::from_vec4(ball())) + scene.origin.as_vec3a()
        }
        // Of one that is stretched, along the middle of its object's axes, as in Cycles.
        Field::PointRadius => {
            let diagonal = Vec3A::splat(ball().w * 3f32.sqrt().recip());
            Vec3A::splat(instance.to_render.transform_vector3a(diagonal).length())
        }
        Field::PointRandom => Vec3A::splat(points.random(surface.triangle)),
        _ => Vec3A::ZERO,
    }
}

/// An attribute that a program asks for; a missing one is zero, as are UV maps.
pub(super) fn attribute(points: &Points, kind: &AttributeKind, name: &str, point: u32) -> Vec4 {
    match kind {
        AttributeKind::Uv | AttributeKind::Colour | AttributeKind::Geometry => points.attribute(name, point),
        AttributeKind::Tangent | AttributeKind::Object | AttributeKind::Instancer | AttributeKind::ViewLayer => None,
    }
    .unwrap_or(Vec4::ZERO)
}
