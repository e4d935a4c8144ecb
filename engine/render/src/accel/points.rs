//! Points of clouds as the primitives of a tree: spheres, in leaves of up to eight.
//!
//! A cloud that stands in the scene once, and is as large along all its axes, is hit in render space; others in their own, where
//! balls are balls however they are stretched.

use super::balls::{Balls, Beam};
use super::block::LANES;
use super::bounds::Bounds;
use super::build::NamedLeaves;
use super::places::PlacedMesh;
use super::traverse::lanes;
use super::tree::{LocalHit, Primitives, SurfaceCoordinates, Tree, Visitor};
use crate::scene::mesh::Mesh;
use crate::scene::motion::{Pose, Poses};
use crate::scene::points::Points;
use crate::scene::{Instance, Scene};
use fearless_simd::Simd;
use glam::{Affine3A, Vec2, Vec3A, Vec4};
use std::ops::ControlFlow;

/// Axes are as long as one another to this part.
const EVEN: f32 = 1e-5;

/// Leaves of up to eight points.
#[derive(Debug, Default)]
pub(super) struct Spheres {
    leaves: Vec<Balls>,
    /// Positions at the next key while the shutter is open, leaf by leaf; empty where the points stay.
    to: Vec<Balls>,
}

/// The vector from the middle of a point to a hit, in the tree's space; of no certain length.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutwardVector(Vec3A);

impl SurfaceCoordinates for OutwardVector {
    const FIRST_COUNTS: bool = true;

    #[inline(always)]
    fn uv(self, instance: Option<&PlacedMesh>) -> [f32; 2] {
        unfolded(instance.map_or(self.0, |placed| placed.to_object.matrix3.inverse() * self.0))
    }
}

/// A cloud as a tree holds it.
struct Cloud<'a> {
    /// Index of the instance; undefined in trees of one cloud.
    instance: u32,
    points: &'a Points,
    /// The transform to render space, and the factor on balls there; `None`: in object space.
    place: Option<(&'a Affine3A, f32)>,
}

impl Cloud<'_> {
    fn ball(&self, point: u32) -> Vec4 {
        let own = self.points.points[point as usize];
        let Some((to_render, larger)) = self.place else { return own };
        to_render.transform_point3a(Vec3A::from_vec4(own)).extend(own.w * larger)
    }
}

/// A direction as the two numbers of a hit: the octahedron about the sphere, unfolded (Meyer, Suessmuth, Sussner, Stamminger and
/// Greiner 2010, "On Floating-Point Normal Vectors").
pub(crate) fn unfolded(direction: Vec3A) -> [f32; 2] {
    let [x, y, z] = direction.to_array();
    let size = x.abs() + y.abs() + z.abs();
    let flat = Vec2::new(x, y) / size;
    if z >= 0.0 { flat.into() } else { ((Vec2::ONE - Vec2::new(flat.y, flat.x).abs()) * sides(flat)).into() }
}

/// The unit direction that [`unfolded`] took.
pub(crate) fn folded([u, v]: [f32; 2]) -> Vec3A {
    let flat = Vec2::new(u, v);
    let z = 1.0 - u.abs() - v.abs();
    let flat = if z >= 0.0 { flat } else { (Vec2::ONE - Vec2::new(v, u).abs()) * sides(flat) };
    Vec3A::new(flat.x, flat.y, z).normalize()
}

fn sides(of: Vec2) -> Vec2 {
    Vec2::new(1f32.copysign(of.x), 1f32.copysign(of.y))
}

/// Factor of an instance on balls; `None` where they do not stay balls.
fn even_scale(instance: &Instance) -> Option<f32> {
    let m = &instance.to_render.matrix3;
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    let size = x.length_squared();
    let off = [y.length_squared() - size, z.length_squared() - size, x.dot(y), y.dot(z), z.dot(x)];
    off.iter().all(|off| off.abs() <= EVEN * size).then(|| size.sqrt())
}

impl Primitives for Spheres {
    type Ray = Beam;
    type Coordinates = OutwardVector;

    #[inline(always)]
    fn ray(origin: Vec3A, direction: Vec3A) -> Beam {
        Beam { origin, direction }
    }

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        leaf: usize,
        part: Option<f32>,
        ray: &Beam,
        mut end: f32,
        visitor: &mut impl Visitor<OutwardVector>,
    ) -> ControlFlow<(), f32> {
        let mut balls = &self.leaves[leaf];
        let now;
        if let Some(part) = part
            && let Some(to) = self.to.get(leaf)
        {
            now = balls.towards(to, part);
            balls = &now;
        }
        if let Some(met) = balls.meet(simd, ray, end) {
            for lane in lanes(met.lanes) {
                let (t, instance, number) = (met.t[lane], balls.instance[lane], balls.point[lane]);
                if t < end && visitor.wants(instance, number) {
                    let coordinates = OutwardVector(met.outward(lane));
                    end = visitor.meet(LocalHit { t, instance, number, coordinates }, end)?;
                }
            }
        }
        ControlFlow::Continue(end)
    }

    fn are_in(mesh: &Mesh) -> bool {
        mesh.points.is_some()
    }

    fn keep_form(instance: &Instance) -> bool {
        even_scale(instance).is_some()
    }

    fn in_render_space(scene: &Scene, instances: &[u32]) -> Tree<Self> {
        let cloud = |&i: &u32| {
            let instance = &scene.instances[i as usize];
            let points = scene.meshes[instance.mesh as usize].points.as_deref()?;
            Some(Cloud { instance: i, points, place: Some((&instance.to_render, even_scale(instance)?)) })
        };
        Tree::of_clouds(&instances.iter().filter_map(cloud).collect::<Vec<_>>())
    }

    fn in_object_space(mesh: &Mesh) -> Tree<Self> {
        let cloud = |points| Cloud { instance: 0, points, place: None };
        Tree::of_clouds(&mesh.points.as_deref().map(cloud).into_iter().collect::<Vec<_>>())
    }

    fn between_keys(mesh: &Mesh, _poses: &Poses, key: usize) -> Tree<Self> {
        let Some(points) = mesh.points.as_deref() else { return Tree::default() };
        let ball = |point: u32, part: f32| points.at(point, Pose { key: key as u32, part });
        let swept = |point: u32| Bounds::around(&[ball(point, 0.0), ball(point, 1.0)]).naming([0, point]);
        let built = NamedLeaves::new((0..points.points.len() as u32).map(swept).collect(), LANES);
        let leaves = |part: f32| built.leaves(|names| balls(names, |[_, point]| (ball(point, part), [0, point])));
        Tree { primitives: Self { leaves: leaves(0.0), to: leaves(1.0) }, nodes: built.nodes }
    }
}

/// The leaf of some points; `ball` gives the ball that a name stands for, and its instance and number.
fn balls(names: &[[u32; 2]], ball: impl Fn([u32; 2]) -> (Vec4, [u32; 2])) -> Balls {
    let mut leaf = Balls::EMPTY;
    for (lane, &name) in names.iter().enumerate() {
        let (ball, name) = ball(name);
        leaf.set(lane, ball, name);
    }
    leaf
}

impl Tree<Spheres> {
    /// The tree of the points of clouds.
    fn of_clouds(clouds: &[Cloud<'_>]) -> Self {
        let boxes = clouds.iter().enumerate().flat_map(|(number, cloud)| {
            (0..cloud.points.points.len() as u32)
                .map(move |point| Bounds::around(&[cloud.ball(point)]).naming([number as u32, point]))
        });
        let built = NamedLeaves::new(boxes.collect(), LANES);
        let ball = |[number, point]: [u32; 2]| {
            let cloud = &clouds[number as usize];
            (cloud.ball(point), [cloud.instance, point])
        };
        let leaves = built.leaves(|names| balls(names, ball));
        Self { nodes: built.nodes, primitives: Spheres { leaves, to: Vec::new() } }
    }
}
