//! A point of hair as shader graphs ask for it.

use crate::accel::Across;
use crate::accel::curves::radius_scale;
use crate::scene::Instance;
use crate::scene::curves::{CURVE_NORMAL, Curves};
use crate::surface::{SurfacePoint, strand_slope, tangent_of_strand};
use glam::{Vec2, Vec3A, Vec4};
use petzval_nodes::{AttributeKind, Field, answers};

/// A place of hair; where there is none, its fields are zero.
pub(super) struct Hair<'a> {
    pub(super) curves: Option<&'a Curves>,
    pub(super) instance: &'a Instance,
    pub(super) surface: &'a SurfacePoint,
    /// Place along the segment, 0 to 1.
    pub(super) u: f32,
    /// Direction of the ray that came there, unit.
    pub(super) direction: Vec3A,
}

impl Hair<'_> {
    fn number(&self, of: impl Fn(&Curves) -> f32) -> Vec3A {
        Vec3A::splat(self.curves.map_or(0.0, of))
    }

    answers! {
        /// A field that only strands have.
        pub(super) fn answer(&self, field: Field) -> Vec3A {
            let (segment, u) = (self.surface.triangle, self.u);
            match field {
                IsStrand => self.number(|_| 1.0),
                StrandIntercept => self.number(|curves| curves.intercept(segment, u).0),
                StrandLength => self.number(|curves| curves.intercept(segment, u).1),
                StrandThickness => self.number(|curves| {
                    curves.thickness(segment, u, self.instance.pose) * radius_scale(self.instance)
                }),
                StrandRandom => self.number(|curves| curves.random(segment)),
                // The part of the view across the strand.
                StrandNormal => self.curves.map_or(Vec3A::ZERO, |curves| {
                    let along = tangent_of_strand(self.instance, curves, self.surface);
                    (-self.direction).reject_from_normalized(along).normalize_or_zero()
                }),
                StrandOffset => self.number(|_| {
                    let Across { sine, is_within, .. } = Across::of(self.surface.barycentric[1]);
                    if is_within { sine } else { -sine }
                }),
                StrandAxis => self.curves.map_or(Vec3A::ZERO, |curves| {
                    let along = tangent_of_strand(self.instance, curves, self.surface);
                    let normal = curves.attribute(CURVE_NORMAL, segment, u).unwrap_or(Vec4::ZERO);
                    let normal = self.instance.normal_to_render * Vec3A::from_vec4(normal);
                    normal.reject_from_normalized(along).try_normalize().unwrap_or_else(|| any_axis(along))
                }),
                _ => [],
            }
        }
    }
}

/// The axis of a strand without one, as in Cycles.
fn any_axis(along: Vec3A) -> Vec3A {
    let [x, y, z] = along.to_array();
    let minor = Vec3A::new(z - y, x - z, y - x).try_normalize().unwrap_or_else(|| along.any_orthonormal_vector());
    along.cross(minor)
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
    let slope = instance.to_render.transform_vector3a(Vec3A::from_vec4(strand_slope(instance, curves, surface)));
    let length2 = slope.length_squared();
    vectors.map(|v| Vec2::new(if length2 > 0.0 { v.dot(slope) / length2 } else { 0.0 }, 0.0))
}
