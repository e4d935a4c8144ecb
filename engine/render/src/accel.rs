//! Finding what a ray meets: a tree of instances over a tree for each mesh (obvhs' compressed eight-wide BVH),
//! and triangle tests that leave no gap between neighbours (Woo, Benthin and Wald 2013).

use crate::scene::{Scene, mesh::Mesh};
use glam::{UVec2, Vec3, Vec3A};
use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    cwbvh::{CwBvh, builder::build_cwbvh},
};
use rayon::prelude::*;

/// A half line in render space.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start.
    pub origin: Vec3A,
    /// Unit direction.
    pub direction: Vec3A,
    /// Nothing farther than this counts, Blender units.
    pub t_max: f32,
}

impl Ray {
    /// Without end.
    pub fn new(origin: Vec3A, direction: Vec3A) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }
}

/// What kind of ray asks: objects can hide from some.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// Straight from the camera.
    Camera,
    /// After a bounce.
    Bounce,
    /// Towards a light.
    Shadow,
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance, Blender units.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32,
    /// Barycentric weight of the third.
    pub v: f32,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the mesh's triangles.
    pub triangle: u32,
}

/// The two-level tree of one scene.
pub struct Accel {
    meshes: Vec<MeshTree>,
    tree: CwBvh,
    // In the order of `tree`'s leaves.
    instances: Vec<PlacedMesh>,
}

/// One mesh's triangles in the order of its tree's leaves, so that a leaf reads consecutive memory.
struct MeshTree {
    tree: CwBvh,
    corners: Vec<[Vec3; 3]>,
    original: Vec<u32>,
    bounds: Aabb,
}

/// What traversal needs of an instance.
#[derive(Clone, Copy)]
struct PlacedMesh {
    to_object: glam::Affine3A,
    mesh: u32,
    instance: u32,
    visible_camera: bool,
    visible_shadow: bool,
}

/// The unit of distance in obvhs' box tests, in ours: they skip what lies nearer than 1e-4 of their units, which
/// then is a tenth of a micrometre in a scene in metres. A power of two, so that nothing rounds.
const FINE: f32 = 1.0 / 1024.0;

/// A ray for obvhs' box tests, distances in units of [`FINE`]. Its own constructor takes every component below
/// 1.2e-7 for that much: rays along an axis then leave a box sideways before they have crossed it.
#[inline]
fn slab_ray(origin: Vec3A, direction: Vec3A, t_max: f32) -> obvhs::ray::Ray {
    // Small enough to be straight over any distance, large enough that products with it stay finite.
    const STRAIGHT: f32 = 1e-18;
    // The box test asks `direction < 0` for the side to enter by, which -0.0 is not: make it +0.0.
    let direction = direction + Vec3A::ZERO;
    let inverse = |d: f32| 1.0 / (FINE * if d.abs() < STRAIGHT { STRAIGHT.copysign(d) } else { d });
    let inv_direction = Vec3A::new(inverse(direction.x), inverse(direction.y), inverse(direction.z));
    obvhs::ray::Ray { origin, direction, inv_direction, tmin: 0.0, tmax: t_max / FINE }
}

struct Bounds(Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// A triangle, and how much its box is grown: box tests round, and a ray in the plane of a box's face must not
/// fall between two boxes.
struct Corners([Vec3; 3], f32);

impl Boundable for Corners {
    fn aabb(&self) -> Aabb {
        let exact = Aabb::from_points(&self.0.map(Vec3A::from));
        let grow = Vec3A::splat(self.1);
        Aabb { min: exact.min - grow, max: exact.max + grow }
    }
}

impl Accel {
    /// Builds all trees, the meshes' in parallel on the current rayon pool.
    pub fn new(scene: &Scene) -> Self {
        let meshes: Vec<MeshTree> = scene.meshes.par_iter().map(MeshTree::new).collect();
        let mut placed = Vec::with_capacity(scene.instances.len());
        let mut bounds = Vec::with_capacity(scene.instances.len());
        for (i, instance) in scene.instances.iter().enumerate() {
            let mesh = &meshes[instance.mesh as usize];
            if mesh.corners.is_empty() {
                continue;
            }
            bounds.push(Bounds(transformed(&mesh.bounds, &instance.to_render)));
            placed.push(PlacedMesh {
                to_object: instance.to_object,
                mesh: instance.mesh,
                instance: i as u32,
                visible_camera: instance.visible_camera,
                visible_shadow: instance.visible_shadow,
            });
        }
        let tree = build(&bounds);
        let instances = tree.primitive_indices.iter().map(|&i| placed[i as usize]).collect();
        Self { meshes, tree, instances }
    }

    /// The bounds of everything, `None` for an empty scene.
    pub fn bounds(&self) -> Option<(Vec3A, Vec3A)> {
        (!self.instances.is_empty()).then_some((self.tree.total_aabb.min, self.tree.total_aabb.max))
    }

    /// The nearest surface.
    pub fn closest(&self, ray: &Ray, kind: RayKind) -> Option<Hit> {
        let mut nearest = None;
        self.visit(ray, kind, |hit| {
            nearest = Some(hit);
            Visit::Shorten
        });
        nearest
    }

    /// The part of light that gets from one end of the ray to the other; `opacity` says how much of it each
    /// surface in between takes (1: all).
    pub fn transmittance(&self, ray: &Ray, opacity: impl FnMut(&Hit) -> f32) -> f32 {
        self.transmittance_of(ray, RayKind::Shadow, opacity)
    }

    /// The same for rays that ask for another reason than a light's shadow.
    pub fn transmittance_of(&self, ray: &Ray, kind: RayKind, mut opacity: impl FnMut(&Hit) -> f32) -> f32 {
        let mut left = 1.0;
        self.visit(ray, kind, |hit| {
            left *= 1.0 - opacity(&hit);
            if left <= 0.0 { Visit::Stop } else { Visit::Continue }
        });
        left
    }

    /// Offers triangles that the ray meets to `on_hit`, which says how to go on.
    #[inline]
    fn visit(&self, ray: &Ray, kind: RayKind, mut on_hit: impl FnMut(Hit) -> Visit) {
        if self.instances.is_empty() {
            return;
        }
        let mut top_ray = slab_ray(ray.origin, ray.direction, ray.t_max);
        let mut state = self.tree.new_traversal(top_ray.direction);
        let mut node;
        obvhs::traverse!(self.tree, node, state, node.intersect_ray(&top_ray, state.oct_inv4), {
            let placed = &self.instances[state.primitive_id as usize];
            let hidden = match kind {
                RayKind::Camera => !placed.visible_camera,
                RayKind::Shadow => !placed.visible_shadow,
                RayKind::Bounce => false,
            };
            if !hidden {
                let mesh = &self.meshes[placed.mesh as usize];
                match mesh.visit(placed, ray, top_ray.tmax * FINE, &mut on_hit) {
                    None => return,
                    Some(t) => top_ray.tmax = t / FINE,
                }
            }
        });
    }
}

/// How a traversal goes on after a hit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    /// Only nearer hits count from now on.
    Shorten,
    /// All hits count.
    Continue,
    /// No more are wanted.
    Stop,
}

impl MeshTree {
    fn new(mesh: &Mesh) -> Self {
        let reach = mesh.positions.iter().filter(|p| p.is_finite()).fold(0.0f32, |m, p| m.max(p.abs().max_element()));
        // Two steps of single precision at the mesh's own size.
        let grow = reach * 2.0 * f32::EPSILON;
        let list: Vec<Corners> =
            (0..mesh.triangles.len() as u32).into_par_iter().map(|i| Corners(mesh.corners(i), grow)).collect();
        let tree = build(&list);
        let corners = tree.primitive_indices.iter().map(|&i| list[i as usize].0).collect();
        let original = tree.primitive_indices.clone();
        let bounds = tree.total_aabb;
        Self { tree, corners, original, bounds }
    }

    /// Visits this mesh's triangles; gives the (perhaps shortened) end of the ray, or `None` to stop.
    #[inline]
    fn visit(&self, placed: &PlacedMesh, ray: &Ray, t_max: f32, on_hit: &mut impl FnMut(Hit) -> Visit) -> Option<f32> {
        let origin = placed.to_object.transform_point3a(ray.origin);
        let direction = placed.to_object.transform_vector3a(ray.direction);
        // Object space may be a thousand times larger or smaller: distances are scaled, so that the slab test
        // always sees a unit direction.
        let scale = direction.length();
        if !(scale > 0.0 && scale.is_finite()) {
            return Some(t_max);
        }
        let mut local = slab_ray(origin, direction / scale, t_max * scale);
        let shear = Shear::new(origin, local.direction);
        let mut state = self.tree.new_traversal(local.direction);
        let mut node;
        obvhs::traverse!(self.tree, node, state, node.intersect_ray(&local, state.oct_inv4), {
            let i = state.primitive_id as usize;
            if let Some((t, u, v)) = shear.intersect(&self.corners[i], local.tmax * FINE) {
                let hit = Hit { t: t / scale, u, v, instance: placed.instance, triangle: self.original[i] };
                match on_hit(hit) {
                    Visit::Shorten => local.tmax = t / FINE,
                    Visit::Continue => {}
                    Visit::Stop => return None,
                }
            }
        });
        let reached = local.tmax * FINE / scale;
        Some(if reached < t_max { reached } else { t_max })
    }
}

/// A ray turned so that it runs along +z: what the watertight test needs, worked out once a ray and mesh.
struct Shear {
    origin: Vec3,
    kx: usize,
    ky: usize,
    kz: usize,
    sx: f32,
    sy: f32,
    sz: f32,
}

impl Shear {
    #[inline]
    fn new(origin: Vec3A, direction: Vec3A) -> Self {
        let a = direction.abs();
        let kz = if a.x > a.y && a.x > a.z {
            0
        } else if a.y > a.z {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let d = direction.to_array();
        // Keeps the winding when the ray runs backwards.
        if d[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        Self { origin: origin.into(), kx, ky, kz, sx: d[kx] / d[kz], sy: d[ky] / d[kz], sz: 1.0 / d[kz] }
    }

    /// Distance and the weights of the second and third corner, of either side.
    #[inline]
    fn intersect(&self, corners: &[Vec3; 3], t_max: f32) -> Option<(f32, f32, f32)> {
        let local = corners.map(|p| (p - self.origin).to_array());
        let skew = |p: &[f32; 3]| (p[self.kx] - self.sx * p[self.kz], p[self.ky] - self.sy * p[self.kz]);
        let ((ax, ay), (bx, by), (cx, cy)) = (skew(&local[0]), skew(&local[1]), skew(&local[2]));
        let mut u = cx * by - cy * bx;
        let mut v = ax * cy - ay * cx;
        let mut w = bx * ay - by * ax;
        if u == 0.0 || v == 0.0 || w == 0.0 {
            // On an edge as single precision sees it: double decides, the same way for both neighbours.
            let cross = |px: f32, py: f32, qx: f32, qy: f32| (px as f64 * qy as f64 - py as f64 * qx as f64) as f32;
            u = cross(cx, cy, bx, by);
            v = cross(ax, ay, cx, cy);
            w = cross(bx, by, ax, ay);
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let z = |p: &[f32; 3]| self.sz * p[self.kz];
        let t = (u * z(&local[0]) + v * z(&local[1]) + w * z(&local[2])) / det;
        // Also refuses NaN, which a triangle seen exactly edge-on can give.
        (t > 0.0 && t < t_max).then(|| (t, v / det, w / det))
    }
}

fn build<T: Boundable>(primitives: &[T]) -> CwBvh {
    if primitives.is_empty() {
        return CwBvh::default();
    }
    build_cwbvh(primitives, BvhBuildParams::medium_build(), &mut std::time::Duration::default())
}

/// The bounds of a moved box, grown by what single precision may lose on the way.
fn transformed(bounds: &Aabb, m: &glam::Affine3A) -> Aabb {
    let mut out = Aabb::empty();
    for i in 0..8 {
        let pick = |bit: usize, lo: f32, hi: f32| if i & bit == 0 { lo } else { hi };
        let corner = Vec3A::new(
            pick(1, bounds.min.x, bounds.max.x),
            pick(2, bounds.min.y, bounds.max.y),
            pick(4, bounds.min.z, bounds.max.z),
        );
        out.extend(m.transform_point3a(corner));
    }
    let reach = out.min.abs().max(out.max.abs()).max_element().max(m.translation.abs().max_element());
    let grow = Vec3A::splat(reach * 4.0 * f32::EPSILON);
    Aabb { min: out.min - grow, max: out.max + grow }
}

/// A start just off a surface, on the side that `normal` points to: `error` away, which bounds how far rounding
/// may have put `p` from the surface.
#[inline]
pub fn offset_origin(p: Vec3A, normal: Vec3A, error: f32) -> Vec3A {
    p + normal * error
}

#[cfg(test)]
mod tests;
