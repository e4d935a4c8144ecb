//! A point of a cloud as shader graphs ask for it.

use crate::scene::points::Points;
use crate::scene::{Instance, Scene};
use glam::{Vec3A, Vec4};
use petzval_nodes::{AttributeKind, Field, answers};

/// A point of a cloud; where there is none, its fields are zero.
pub(super) struct Ball<'a> {
    pub(super) points: Option<&'a Points>,
    pub(super) instance: &'a Instance,
    pub(super) number: u32,
    pub(super) scene: &'a Scene,
}

impl Ball<'_> {
    fn position(&self, points: &Points) -> Vec3A {
        let middle = Vec3A::from_vec4(points.at(self.number, self.instance.pose));
        self.instance.to_render.transform_point3a(middle) + self.scene.origin.as_vec3a()
    }

    /// The radius; of a point that is stretched, along the middle of its object's axes, as in Cycles.
    fn radius(&self, points: &Points) -> f32 {
        let diagonal = Vec3A::splat(points.at(self.number, self.instance.pose).w * 3f32.sqrt().recip());
        self.instance.to_render.transform_vector3a(diagonal).length()
    }

    answers! {
        /// A field that only points of clouds have.
        pub(super) fn answer(&self, field: Field) -> Vec3A {
            match field {
                PointPosition => self.points.map_or(Vec3A::ZERO, |points| self.position(points)),
                PointRadius => Vec3A::splat(self.points.map_or(0.0, |points| self.radius(points))),
                PointRandom => Vec3A::splat(self.points.map_or(0.0, |points| points.random(self.number))),
                _ => [],
            }
        }
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
