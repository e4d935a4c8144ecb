//! The shadow terminator of coarse smooth meshes: shadow rays start a little above the faces.
//!
//! A smooth normal sees light that the flat triangles of the mesh hide. As in Cycles, a ray to a light that grazes starts on a
//! curved surface over the triangle (Hanika 2021, "Hacking the shadow terminator", Ray Tracing Gems II), and a surface that is lit at a
//! grazing angle may be dimmed.

use crate::accel::{Ray, offset_origin};
use crate::lights::LightSample;
use crate::scene::Scene;
use crate::surface::{SurfacePoint, mesh_of};
use glam::Vec3A;

/// The part of light along `d` that counts, at a point whose shading normal a displacement may have bent to `normal`, where an object's
/// shading is dimmed towards the edge of light.
#[inline]
pub(super) fn dimmed(scene: &Scene, point: &SurfacePoint, normal: Vec3A, d: Vec3A) -> f32 {
    if scene.dims { dimmed_by_object(scene, point, normal, d) } else { 1.0 }
}

#[cold]
fn dimmed_by_object(scene: &Scene, point: &SurfacePoint, normal: Vec3A, d: Vec3A) -> f32 {
    let cos = normal.dot(d);
    let shadow_terminator = &scene.instances[point.instance as usize].shadow_terminator;
    if shadow_terminator.dims() && cos > 0.0 { shadow_terminator.left_at(cos) } else { 1.0 }
}

/// Light that grazes a smooth triangle so that its shadow is asked for from elsewhere.
#[derive(Clone, Copy)]
pub(super) struct Grazing {
    /// 1 where the light comes from the side of the point's normal.
    side: f32,
    /// The part of the way to the curved surface by which the ray's start is moved.
    amount: f32,
    /// True if the light is on different sides of the smooth normal and of the triangle's.
    pub(super) is_beyond: bool,
}

/// Grazing light along `d`, at a point whose shading normal a displacement may have bent to `normal`; `None` where it does not graze.
#[inline]
pub(super) fn grazing(scene: &Scene, point: &SurfacePoint, normal: Vec3A, d: Vec3A) -> Option<Grazing> {
    if point.shading_normal == point.geometric_normal {
        return None;
    }
    let below = scene.instances[point.instance as usize].shadow_terminator.lift_below;
    if below <= 0.0 {
        return None;
    }
    let cos = normal.dot(d);
    let (side, cos) = (cos.signum(), cos.abs());
    let flat = side * point.geometric_normal.dot(d);
    let amount = if cos < below { 2.0 - (flat + cos) / below } else { 1.0 - flat / below };
    (amount > 0.0).then(|| Grazing { side, amount: amount.min(1.0), is_beyond: flat < 0.0 })
}

impl Grazing {
    /// The shadow ray of the light, from above the triangle.
    #[cold]
    pub(super) fn ray(self, scene: &Scene, point: &SurfacePoint, light: &LightSample) -> Ray {
        let LightSample { wi: d, distance, .. } = *light;
        let (start, lift) = self.start(scene, point);
        let plain = Ray { t_max: distance, ..point.leaving(start + lift, d) };
        if distance == f32::INFINITY {
            return plain;
        }
        let way = d * distance - lift;
        let (length, gap) = (way.length(), light.gap(point.position_error));
        if length > 0.0 { Ray { direction: way / length, t_max: (length - gap).max(0.0), ..plain } } else { plain }
    }

    /// A ray along `d` without end, from above the triangle.
    #[cold]
    pub(super) fn along(self, scene: &Scene, point: &SurfacePoint, d: Vec3A) -> Ray {
        let (start, lift) = self.start(scene, point);
        point.leaving(start + lift, d)
    }

    /// A start just off the triangle, and the vector from there to the start of rays.
    fn start(self, scene: &Scene, point: &SurfacePoint) -> (Vec3A, Vec3A) {
        let start = offset_origin(point.position, point.geometric_normal * self.side, point.position_error);
        (start, height(scene, point, self.side) * self.amount)
    }
}

/// The vector from the point to the surface over it, on one side (1: that of its normal).
fn height(scene: &Scene, point: &SurfacePoint, side: f32) -> Vec3A {
    let instance = &scene.instances[point.instance as usize];
    let mesh = mesh_of(scene, point.instance);
    let Some(normals) = instance.corner_normals(mesh, point.triangle) else { return Vec3A::ZERO };
    let side = if point.backfacing { -side } else { side };
    let [u, v] = point.barycentric;
    let weights = [1.0 - u - v, u, v];
    let corners = instance.corners(mesh, point.triangle).map(|p| instance.to_render.transform_point3a(Vec3A::from(p)));
    let normals = normals.map(|n| (instance.normal_to_render * Vec3A::from(n)).normalize_or_zero() * side);
    let (mut bulge, mut clear) = (0.0, f32::INFINITY);
    let mut normal = Vec3A::ZERO;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let k = 3 - i - j;
        normal += normals[i] * weights[i];
        // Phong tessellation's height over the triangle, edge by edge.
        bulge += weights[i] * weights[j] * (corners[i] - corners[j]).dot(normals[i] - normals[j]);
        // That of the plane along the surface at this corner, raised until no other corner is above it.
        let highest = (corners[j] - corners[i]).dot(normals[i]).max((corners[k] - corners[i]).dot(normals[i])).max(0.0);
        let here = (corners[j] - corners[i]).dot(normals[i]) * weights[j]
            + (corners[k] - corners[i]).dot(normals[i]) * weights[k];
        clear = clear.min((highest - here).max(0.0));
    }
    normal * clear.max(0.5 * bulge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rgb;
    use crate::accel::Hit;
    use crate::scene::SceneBuilder;
    use crate::scene::corners::Corners;
    use crate::scene::mesh::MeshDescription;
    use crate::scene::shadow_terminator::ShadowTerminator;
    use crate::scene::visibility::{LightSets, Rays};
    use glam::{DMat4, DVec3, Vec3};

    /// A triangle within the unit sphere, with the sphere's normals.
    fn scene(lift_below: f32) -> Scene {
        let corner = |turn: f32| Vec3::new(0.6 * turn.cos(), 0.6 * turn.sin(), 0.8);
        let positions: Vec<Vec3> = [0.0, 2.1, 4.2].map(corner).into();
        let corner_normals = Some(Corners::Vertices(positions.clone()));
        let triangles = vec![[0, 1, 2]];
        let mut builder = SceneBuilder::new();
        let mesh = MeshDescription { name: "cap".into(), positions, triangles, corner_normals, ..Default::default() };
        let mesh = builder.add_mesh(mesh).unwrap();
        let instance = builder.add_instance("cap", mesh, DMat4::IDENTITY, &[], true, true).unwrap().unwrap();
        builder.set_shadow_terminator(instance, ShadowTerminator::new(lift_below, 0.0));
        builder.build(DVec3::ZERO)
    }

    fn point(scene: &Scene, u: f32, v: f32) -> SurfacePoint {
        SurfacePoint::new(scene, &Hit { t: 1.0, u, v, instance: 0, triangle: 0, moment: 0 }, -Vec3A::Z)
    }

    #[test]
    fn rays_start_between_the_triangle_and_what_is_over_it() {
        let scene = scene(0.1);
        for (u, v) in [(0.3, 0.3), (0.1, 0.2), (0.8, 0.1), (0.49, 0.49)] {
            let point = point(&scene, u, v);
            let lift = height(&scene, &point, 1.0);
            let radius = (point.position + lift).length();
            assert!(radius > point.position.length());
            // The planes at the corners meet over the sphere: this one's not higher than their corner.
            assert!(radius < 1.3, "{radius}");
        }
        // A corner lies on the sphere.
        assert!(height(&scene, &point(&scene, 0.0, 0.0), 1.0).length() < 1e-6);
    }

    #[test]
    fn only_light_that_grazes_is_asked_for_from_above() {
        let scene = scene(0.1);
        let point = point(&scene, 0.45, 0.45);
        assert!(grazing(&scene, &point, point.shading_normal, point.geometric_normal).is_none());
        // Beyond the triangle's horizon, where the smooth normal still sees it.
        let (n, g) = (point.shading_normal, point.geometric_normal);
        let along = (n - g * n.dot(g)).normalize();
        let beyond = (along - 0.05 * g).normalize();
        assert!(n.dot(beyond) > 0.0);
        let found = grazing(&scene, &point, point.shading_normal, beyond).unwrap();
        assert!(found.is_beyond);
        let light = LightSample {
            wi: beyond,
            distance: 10.0,
            radiance: Rgb::ONE,
            pdf: 1.0,
            point_like: true,
            cast_shadow: true,
            reaches: Rays::ALL,
            sets: LightSets::EVERYTHING,
            leaves: None,
        };
        let ray = found.ray(&scene, &point, &light);
        assert!(g.dot(ray.origin - point.position) > 1e-3);
        // To the same place.
        let end = point.position + beyond * 10.0;
        assert!((ray.origin + ray.direction * ray.t_max - end).length() < 1e-4);
        let left_alone = self::scene(0.0);
        assert!(grazing(&left_alone, &point, point.shading_normal, beyond).is_none());
    }
}
