//! A point of hair as shader graphs ask for it.

use crate::accel::curves::radius_scale;
use crate::scene::Instance;
use crate::scene::curves::Curves;
use crate::surface::{SurfacePoint, strand_slope, tangent_of_strand};
use glam::{Vec2, Vec3A, Vec4};
use petzval_nodes::{AttributeKind, Field};

/// A field that only strands have; zero for the rest.
pub(super) fn read(
    field: Field,
    instance: &Instance,
    curves: &Curves,
    surface: &SurfacePoint,
    u: f32,
    direction: Vec3A,
) -> Vec3A {
    let (segment, number) = (surface.triangle, Vec3A::splat);
    match field {
        Field::IsStrand => number(1.0),
        Field::StrandIntercept => number(curves.intercept(segment, u).0),
        Field::StrandLength => number(curves.intercept(segment, u).1),
        Field::StrandThickness => number(curves.thickness(segment, u) * radius_scale(instance)),
        Field::StrandRandom => number(curves.random(segment)),
        // What is left of the view across the strand.
        Field::StrandNormal => {
            let along = tangent_of_strand(instance, curves, surface);
            (-direction).reject_from_normalized(along).normalize_or_zero()
        }
        _ => Vec3A::ZERO,
    }
}

/// A value of curves by name: an attribute, or the root's place in a UV map.
pub(super) fn named(curves: &Curves, name: &str, segment: u32, u: f32) -> Option<Vec4> {
    let uv = || curves.uv_map(Some(name)).map(|map| root(curves, map, segment));
    curves.attribute(name, segment, u).or_else(uv)
}

/// An attribute that a program asks for; a missing one is zero, as are tangents of UV maps.
pub(super) fn attribute(curves: &Curves, kind: &AttributeKind, name: &str, segment: u32, u: f32) -> Vec4 {
    match kind {
        AttributeKind::Uv => {
            let map = curves.uv_map((!name.is_empty()).then_some(name));
            map.map_or_else(|| curves.attribute(name, segment, u), |map| Some(root(curves, map, segment)))
        }
        AttributeKind::Colour | AttributeKind::Geometry => named(curves, name, segment, u),
        AttributeKind::Tangent | AttributeKind::Object | AttributeKind::Instancer | AttributeKind::ViewLayer => None,
    }
    .unwrap_or(Vec4::ZERO)
}

fn root(curves: &Curves, map: usize, segment: u32) -> Vec4 {
    curves.uv(map, segment).extend(0.0).extend(1.0)
}

/// The derivatives of the place along the segment along two vectors of render space.
pub(super) fn weights_along(
    instance: &Instance,
    curves: &Curves,
    surface: &SurfacePoint,
    vectors: &[Vec3A; 2],
) -> [Vec2; 2] {
    let slope = instance.to_render.transform_vector3a(Vec3A::from_vec4(strand_slope(curves, surface)));
    let length2 = slope.length_squared();
    vectors.map(|v| Vec2::new(if length2 > 0.0 { v.dot(slope) / length2 } else { 0.0 }, 0.0))
}
