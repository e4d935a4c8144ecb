//! A surface interaction, from a ray's hit: its place, its normals, and its texture coordinates.

use crate::accel::curves::radius_scale;
use crate::accel::points::folded;
use crate::accel::{Across, Hit, Ray, SelfHit};
use crate::scene::curves::Curves;
use crate::scene::mesh::{GENERATED, Mesh};
use crate::scene::points::Points;
use crate::scene::{Instance, Scene};
use glam::{Vec2, Vec3, Vec3A, Vec4};

/// A point on a surface in render space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position in render space, Blender units.
    pub position: Vec3A,
    /// Bound of the rounding error of `position` from the surface, Blender units.
    pub position_error: f32,
    /// The triangle's own unit normal, on the side that the ray came from.
    pub geometric_normal: Vec3A,
    /// The interpolated unit normal, on the same side as the triangle's.
    pub shading_normal: Vec3A,
    /// True if the ray came from behind the triangle.
    pub backfacing: bool,
    /// Index of the instance.
    pub instance: u32,
    /// Index of the triangle in its mesh, the segment in its curves, or the point in its cloud.
    pub triangle: u32,
    /// Index of the material.
    pub material: u32,
    /// Barycentric weights of the second and third corner; on a strand of hair, along and across its segment; on a point,
    /// which way its surface looks, as in [`Hit`].
    pub barycentric: [f32; 2],
    /// The strand of hair in its curves, or the point in its cloud; [`NO_STRAND`] on a triangle.
    pub strand: u32,
    /// The moment at which a ray hit it, as in [`Ray::moment`].
    pub moment: u16,
}

/// The value of [`SurfacePoint::strand`] for triangles.
pub const NO_STRAND: u32 = u32::MAX;

impl SurfacePoint {
    /// The point of a hit by a ray along `direction`.
    pub fn new(scene: &Scene, hit: &Hit, direction: Vec3A) -> Self {
        let instance = &scene.instances[hit.instance as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        if mesh.is_special {
            return Self::on_special(instance, mesh, hit, direction);
        }
        let normals = mesh.normals(hit.triangle);
        Self::on_triangle(instance, mesh, hit, direction, mesh.corners(hit.triangle), normals.as_ref())
    }

    /// A point on hair, on a point of a cloud, or on a mesh that changes its shape.
    #[inline(never)]
    fn on_special(instance: &Instance, mesh: &Mesh, hit: &Hit, direction: Vec3A) -> Self {
        if let Some(curves) = &mesh.curves {
            return Self::on_strand(instance, curves, hit, direction);
        }
        if let Some(points) = &mesh.points {
            return Self::on_ball(instance, points, hit, direction);
        }
        let normals = instance.corner_normals(mesh, hit.triangle);
        Self::on_triangle(instance, mesh, hit, direction, instance.corners(mesh, hit.triangle), normals.as_ref())
    }

    #[inline(always)]
    fn on_triangle(
        instance: &Instance,
        mesh: &Mesh,
        hit: &Hit,
        direction: Vec3A,
        corners: [Vec3; 3],
        normals: Option<&[Vec3; 3]>,
    ) -> Self {
        let [w0, w1, w2] = weights([hit.u, hit.v]);
        let local = corners[0] * w0 + corners[1] * w1 + corners[2] * w2;
        let position = instance.to_render.transform_point3a(Vec3A::from(local));
        let position_error = position_error(instance, Vec3A::from(local));
        let outward = geometric_normal(instance, &corners);
        let backfacing = outward.dot(direction) > 0.0;
        let geometric_normal = if backfacing { -outward } else { outward };
        let shading_normal = match normals {
            None => geometric_normal,
            Some(n) => {
                let [w0, w1, w2] = if instance.is_stretched { evened(instance, n, [w0, w1, w2]) } else { [w0, w1, w2] };
                let mixed = n[0] * w0 + n[1] * w1 + n[2] * w2;
                // Flipped with the triangle. Where interpolation gives nothing, or a normal behind the
                // triangle itself, the triangle's own stands in.
                let world = (instance.normal_to_render * Vec3A::from(mixed)).normalize_or_zero();
                let sided = if backfacing { -world } else { world };
                if sided.dot(geometric_normal) > 0.0 { sided } else { geometric_normal }
            }
        };
        Self {
            position,
            position_error,
            geometric_normal,
            shading_normal,
            backfacing,
            instance: hit.instance,
            triangle: hit.triangle,
            material: instance.material(mesh.slot(hit.triangle)),
            barycentric: [hit.u, hit.v],
            strand: NO_STRAND,
            moment: hit.moment,
        }
    }

    /// A point on hair. Its normals are those of a round strand, of ribbons, too: light is scattered as if these were round.
    #[inline(never)]
    fn on_strand(instance: &Instance, curves: &Curves, hit: &Hit, direction: Vec3A) -> Self {
        let strand = curves.strand_of(hit.triangle);
        let controls = curves.controls(strand, hit.triangle, instance.pose);
        let u = hit.u.clamp(0.0, 1.0);
        let (middle, slope) = (controls.at(u), controls.slope(u));
        let along = along_strand(instance, slope.truncate(), direction);
        let across = along.cross(-direction).try_normalize().unwrap_or_else(|| along.any_orthonormal_vector());
        let Across { sine: v, is_within, leans_away } = Across::of(hit.v);
        // Beyond its ends: the part of the normal along the strand.
        let lengthwise = hit.u - u;
        let upwards = (1.0 - v * v - lengthwise * lengthwise).max(0.0).sqrt();
        let upwards = if leans_away { -upwards } else { upwards };
        let outwards = (across * v + along * lengthwise + across.cross(along) * upwards).normalize();
        let shading_normal = if is_within { -outwards } else { outwards };
        let local = Vec3A::from_vec4(middle);
        let radius = middle.w * radius_scale(instance);
        let outwards = if curves.is_flat() { across * v } else { outwards };
        Self {
            position: instance.to_render.transform_point3a(local) + outwards * radius,
            position_error: position_error(instance, local),
            geometric_normal: shading_normal,
            shading_normal,
            backfacing: is_within,
            instance: hit.instance,
            triangle: hit.triangle,
            material: instance.material(0),
            barycentric: [hit.u, hit.v],
            strand,
            moment: hit.moment,
        }
    }

    /// A point on a point of a cloud. The normal, also where its object is stretched, leads away from the middle, as in Cycles.
    #[inline(never)]
    fn on_ball(instance: &Instance, points: &Points, hit: &Hit, direction: Vec3A) -> Self {
        let ball = points.at(hit.triangle, instance.pose);
        let outward = folded([hit.u, hit.v]);
        let away = ball.w / (instance.to_object.matrix3 * outward).length();
        let local = Vec3A::from_vec4(ball);
        let backfacing = outward.dot(direction) > 0.0;
        let normal = if backfacing { -outward } else { outward };
        Self {
            position: instance.to_render.transform_point3a(local) + outward * away,
            position_error: position_error(instance, local.abs() + ball.w),
            geometric_normal: normal,
            shading_normal: normal,
            backfacing,
            instance: hit.instance,
            triangle: hit.triangle,
            material: instance.material(0),
            barycentric: [hit.u, hit.v],
            strand: hit.triangle,
            moment: hit.moment,
        }
    }

    /// A ray without end that leaves it at `origin`: it does not hit the triangle, strand or point that it leaves.
    #[inline(always)]
    pub fn leaving(&self, origin: Vec3A, direction: Vec3A) -> Ray {
        let part = if self.strand == NO_STRAND { self.triangle } else { self.strand };
        let skip = SelfHit { instance: self.instance, part };
        Ray { origin, direction, t_max: f32::INFINITY, skip, moment: self.moment }
    }

    /// True if the point is on hair or a point, and a ray hit the same strand or point.
    pub fn is_on_strand_of(&self, scene: &Scene, hit: &Hit) -> bool {
        let met = |curves: &Curves| curves.strand_of(hit.triangle);
        self.strand != NO_STRAND
            && hit.instance == self.instance
            && mesh_of(scene, hit.instance).curves.as_deref().map_or(hit.triangle, met) == self.strand
    }

    /// This point seen along another ray, which leaves it along `d`.
    pub fn seen_from(&self, d: Vec3A) -> Self {
        if self.geometric_normal.dot(d) >= 0.0 {
            return *self;
        }
        Self {
            geometric_normal: -self.geometric_normal,
            shading_normal: -self.shading_normal,
            backfacing: !self.backfacing,
            ..*self
        }
    }

    /// Texture coordinates in the UV map of that name (`None`: the first); zero where the mesh has none.
    pub fn uv(&self, scene: &Scene, map: Option<&str>) -> Vec2 {
        uv(mesh_of(scene, self.instance), self.triangle, self.barycentric, map)
    }
}

/// Weights of a triangle's corner normals, object space, that interpolate them as if each were made unit in render space.
#[cold]
fn evened(instance: &Instance, normals: &[Vec3; 3], weights: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| {
        let length = (instance.normal_to_render * Vec3A::from(normals[i])).length();
        if length > 0.0 { weights[i] / length } else { 0.0 }
    })
}

/// The direction of the facets of a brushed surface by default: around the z axis of the object's generated coordinates, as in Blender; of
/// a mesh that does not bring them they go by its bounds.
pub fn tangent_about_z(scene: &Scene, point: &SurfacePoint) -> Vec3A {
    let instance = &scene.instances[point.instance as usize];
    let mesh = mesh_of(scene, point.instance);
    if let Some(curves) = &mesh.curves {
        return tangent_of_strand(instance, curves, point);
    }
    if mesh.points.is_some() {
        return tangent_of_ball(point);
    }
    let part = match mesh.attribute(GENERATED) {
        Some(values) => {
            let [a, b, c] = values.at(mesh.numbers(), point.triangle);
            let [wa, wb, wc] = weights(point.barycentric);
            (a * wa + b * wb + c * wc).truncate() - 0.5
        }
        None => {
            let [low, high] = mesh.bounds;
            let local = Vec3::from(instance.to_object.transform_point3a(point.position));
            (local - 0.5 * (low + high)) / (high - low).max(Vec3::splat(1e-12))
        }
    };
    let outward = instance.normal_to_render * Vec3A::new(-part.y, part.x, 0.0);
    point.shading_normal.cross(outward.cross(point.shading_normal).normalize_or_zero())
}

/// Data of hair at a point: its direction, and the place across it.
#[derive(Clone, Copy, Debug)]
pub struct Strand {
    /// Direction along the strand, unit. A mesh with a hair shader has its triangles' first edges.
    pub along: Vec3A,
    /// The direction that the older Hair shader takes instead: a triangle's other edge; `None` of real hair.
    pub edge: Option<Vec3A>,
    /// Place of the hit across its width, -1 to 1; `None` where the surface's normal tells it.
    pub offset: Option<f32>,
    /// Radius, Blender units; infinite where there is no strand.
    pub radius: f32,
}

/// The strand at a point.
pub fn strand(scene: &Scene, point: &SurfacePoint) -> Strand {
    let instance = &scene.instances[point.instance as usize];
    let mesh = mesh_of(scene, point.instance);
    if let Some(curves) = &mesh.curves {
        let along = tangent_of_strand(instance, curves, point);
        let Across { sine, is_within, .. } = Across::of(point.barycentric[1]);
        // From within the normal is turned round.
        let offset = if is_within { sine } else { -sine };
        let u = point.barycentric[0].clamp(0.0, 1.0);
        let radius = 0.5 * curves.thickness(point.triangle, u, instance.pose) * radius_scale(instance);
        return Strand { along, edge: None, offset: Some(offset), radius };
    }
    if mesh.points.is_some() {
        return Strand { along: tangent_of_ball(point), edge: None, offset: None, radius: f32::INFINITY };
    }
    let corners = instance.corners(mesh, point.triangle);
    let side = if point.backfacing { -1.0 } else { 1.0 };
    let edge = |to: usize| {
        let edge = instance.to_render.transform_vector3a(Vec3A::from(corners[to] - corners[0]));
        edge.normalize_or(Vec3A::X) * side
    };
    Strand { along: edge(1), edge: Some(edge(2)), offset: None, radius: f32::INFINITY }
}

/// A tangent of a point of a cloud, as Cycles has it where nothing tells one direction from another.
fn tangent_of_ball(point: &SurfacePoint) -> Vec3A {
    let [x, y, z] = point.geometric_normal.to_array();
    Vec3A::new(z - y, x - z, y - x).try_normalize().unwrap_or_else(|| point.geometric_normal.any_orthonormal_vector())
}

/// The tangent along the strand at a point of hair, unit, render space.
pub fn tangent_of_strand(instance: &Instance, curves: &Curves, point: &SurfacePoint) -> Vec3A {
    let slope = strand_slope(instance, curves, point).truncate();
    along_strand(instance, slope, -point.geometric_normal)
}

/// The derivative of place and radius along the segment at a point of hair, object space.
pub fn strand_slope(instance: &Instance, curves: &Curves, point: &SurfacePoint) -> Vec4 {
    curves.controls(point.strand, point.triangle, instance.pose).slope(point.barycentric[0].clamp(0.0, 1.0))
}

/// A slope of object space as a unit direction; where it has none, any across the view.
fn along_strand(instance: &Instance, slope: Vec3, view: Vec3A) -> Vec3A {
    let along = instance.to_render.transform_vector3a(slope.into());
    along.try_normalize().unwrap_or_else(|| view.any_orthonormal_vector())
}

/// A bound on the rounding error of a point on its way from object to render space and, as a ray's start, back:
/// the sum of absolute values (Higham 2002, section 3.1), with room for interpolation and the ray's own transform.
pub fn position_error(instance: &Instance, local: Vec3A) -> f32 {
    // Roundings on the way; fewer let surfaces shadow themselves, more let light leak under thin ones.
    const ROUNDINGS: f32 = 24.0;
    let m = &instance.to_render;
    let [x, y, z] = local.abs().to_array();
    let size = m.matrix3.x_axis.abs() * x + m.matrix3.y_axis.abs() * y + m.matrix3.z_axis.abs() * z;
    ROUNDINGS * f32::EPSILON * (size + m.translation.abs()).max_element()
}

/// The mesh of an instance.
pub fn mesh_of(scene: &Scene, instance: u32) -> &Mesh {
    &scene.meshes[scene.instances[instance as usize].mesh as usize]
}

/// Texture coordinates at a point of a triangle.
pub fn uv(mesh: &Mesh, triangle: u32, barycentric: [f32; 2], map: Option<&str>) -> Vec2 {
    if let Some(curves) = &mesh.curves {
        return curves.uv_map(map).map_or(Vec2::ZERO, |index| curves.uv(index, triangle));
    }
    let Some(index) = mesh.uv_map(map) else { return Vec2::ZERO };
    let c = mesh.uv_maps[index].1.at(mesh.numbers(), triangle);
    let [w0, w1, w2] = weights(barycentric);
    c[0] * w0 + c[1] * w1 + c[2] * w2
}

/// Twice the area of a triangle, along its normal.
///
/// The product is computed number by number, not in a register: there glam fuses the product and the difference where it is compiled for a
/// processor that can, and the picture would depend on that.
pub fn area_vector([a, b, c]: [Vec3A; 3]) -> Vec3A {
    Vec3::from(b - a).cross(Vec3::from(c - a)).into()
}

/// The unit normal of a placed triangle, on its front side.
pub fn geometric_normal(instance: &Instance, corners: &[Vec3; 3]) -> Vec3A {
    let [a, b, c] = corners.map(|p| instance.to_render.transform_vector3a(Vec3A::from(p)));
    let n = area_vector([a, b, c]);
    let n = n.try_normalize().unwrap_or_else(|| {
        // So small that its square vanishes in single precision.
        let (e, f) = ((b - a).as_dvec3(), (c - a).as_dvec3());
        e.cross(f).normalize_or(glam::DVec3::Z).as_vec3a()
    });
    if instance.mirrored { -n } else { n }
}

#[inline]
fn weights([u, v]: [f32; 2]) -> [f32; 3] {
    [1.0 - u - v, u, v]
}
