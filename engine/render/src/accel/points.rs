//! Trees of point clouds, beside those of triangles: who has none pays nothing. Leaves hold eight balls.
//!
//! A cloud that stands in the scene once, and is as large along all its axes, is hit in render space; others in their own, where
//! balls are balls however they are stretched.

use super::balls::{Balls, Beam};
use super::beside::Forest;
use super::bounds::Bounds;
use super::build::build;
use super::moving::MovingPlaces;
use super::node::{BoxRay, Node};
use super::places::{PlacedMesh, Within, placed};
use super::source::Parts;
use super::traverse::{lanes, traverse};
use super::triangles::LANES;
use super::{Hit, Ray};
use crate::scene::motion::{Moving, Pose};
use crate::scene::points::Points;
use crate::scene::{Instance, Scene};
use fearless_simd::Simd;
use glam::{Affine3A, Vec2, Vec3A, Vec4};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// Axes are as long as one another to this part.
const EVEN: f32 = 1e-5;

/// All point clouds of a scene.
pub(super) struct PointForest {
    /// The tree in render space of the clouds that have one instance.
    common: PointTree,
    /// The trees in object space of the other clouds; by mesh.
    shared: Vec<PointTree>,
    /// Trees of the clouds whose points move, by mesh, then by key: from there to the next.
    posed: Vec<Vec<PointTree>>,
    places: Vec<Node>,
    placed: Vec<PlacedMesh>,
    /// The instances that move.
    moving: Option<MovingPlaces>,
}

/// Balls and the nodes above them.
#[derive(Default)]
struct PointTree {
    nodes: Vec<Node>,
    leaves: Vec<Balls>,
    /// Positions at the next key while the shutter is open, leaf by leaf; empty where the points stay.
    to: Vec<Balls>,
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

impl PointForest {
    /// The trees of the scene's points; `None` if it has none.
    pub(super) fn new(scene: &Scene, parts: &Parts) -> Option<Box<Self>> {
        if scene.meshes.iter().all(|mesh| mesh.points.is_none()) {
            return None;
        }
        let of = |i: u32| {
            let instance = &scene.instances[i as usize];
            scene.meshes[instance.mesh as usize].points.as_deref().map(|points| (instance, points))
        };
        let mut common = Vec::new();
        let mut several: Vec<u32> = parts.several.iter().copied().filter(|&i| of(i).is_some()).collect();
        for &i in &parts.alone {
            let Some((instance, points)) = of(i) else { continue };
            match even_scale(instance) {
                Some(larger) => common.push(Cloud { instance: i, points, place: Some((&instance.to_render, larger)) }),
                None => several.push(i),
            }
        }
        let mut is_shared = vec![false; scene.meshes.len()];
        let moving = scene.moving.iter().map(|one| one.instance).filter(|&i| of(i).is_some());
        several.iter().copied().chain(moving).for_each(|i| is_shared[scene.instances[i as usize].mesh as usize] = true);
        let meshes = || scene.meshes.par_iter().zip(&is_shared);
        let wanted = |points: &Points, is_shared: bool, moves: bool| is_shared && (points.key_count() > 0) == moves;
        let shared: Vec<PointTree> = meshes()
            .map(|(mesh, &is_shared)| match mesh.points.as_deref().filter(|one| wanted(one, is_shared, false)) {
                Some(points) => PointTree::new(&[Cloud { instance: 0, points, place: None }]),
                None => PointTree::default(),
            })
            .collect();
        let posed: Vec<Vec<PointTree>> = meshes()
            .map(|(mesh, &is_shared)| match mesh.points.as_deref().filter(|one| wanted(one, is_shared, true)) {
                Some(points) => (0..points.key_count() as u32 - 1).map(|key| PointTree::between(points, key)).collect(),
                None => Vec::new(),
            })
            .collect();
        let bounds = |now: &Instance| tree_of(&shared, &posed, now.mesh, now.pose).bounds();
        let (places, placed) = placed(scene, &several, bounds);
        let moves = |one: &Moving| of(one.instance).is_some();
        let moving = MovingPlaces::new(scene, moves, bounds);
        Some(Box::new(Self { common: PointTree::new(&common), shared, posed, places, placed, moving }))
    }

    pub(super) fn bounds(&self) -> Option<Bounds> {
        let places = self.places.first().map(Node::bounds);
        let moving = self.moving.as_ref().and_then(MovingPlaces::bounds);
        places.into_iter().chain(self.common.bounds()).chain(moving).reduce(|a, b| a.union(&b))
    }

    /// Offers the balls of an instance that a ray hits to `met`, which gives the end of the ray from then on; gives it, too.
    #[inline(always)]
    fn follow_placed<S: Simd>(
        &self,
        simd: S,
        (placed, pose): (&PlacedMesh, Pose),
        ray: &Ray,
        mut t_max: f32,
        wanted: &impl Fn(u32) -> bool,
        mut met: impl FnMut(Hit, f32) -> ControlFlow<(), f32>,
    ) -> ControlFlow<(), f32> {
        if wanted(placed.instance)
            && let Some((boxes, beam, scale)) = enter(placed, ray)
        {
            let tree = tree_of(&self.shared, &self.posed, placed.mesh, pose);
            tree.follow(
                simd,
                (&boxes, &beam),
                pose.part,
                t_max * scale,
                #[inline(always)]
                |_, point| ray.skip.is(placed.instance, point),
                #[inline(always)]
                |_, point, t, outward, end| {
                    let outward = placed.to_object.matrix3.inverse() * outward;
                    let found = hit(t / scale, outward, placed.instance, point, ray.moment);
                    let before = t_max;
                    t_max = met(found, t_max)?;
                    ControlFlow::Continue(if t_max < before { t } else { end })
                },
            )?;
        }
        ControlFlow::Continue(t_max)
    }

    /// Offers all balls that a ray hits to `met`, as [`Self::follow_placed`].
    #[inline(always)]
    fn follow<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        t_max: f32,
        wanted: &impl Fn(u32) -> bool,
        mut met: impl FnMut(Hit, f32) -> ControlFlow<(), f32>,
    ) -> ControlFlow<()> {
        let here = BoxRay::new(ray.origin, ray.direction);
        let beam = Beam { origin: ray.origin, direction: ray.direction };
        let mut t_max = t_max;
        self.common.follow(
            simd,
            (&here, &beam),
            0.0,
            t_max,
            #[inline(always)]
            |instance, point| !wanted(instance) || ray.skip.is(instance, point),
            #[inline(always)]
            |instance, point, t, outward, end| {
                t_max = met(hit(t, outward, instance, point, ray.moment), end)?;
                ControlFlow::Continue(t_max)
            },
        )?;
        if !self.places.is_empty() {
            traverse(
                simd,
                &self.places,
                &here,
                t_max,
                #[inline(always)]
                |leaf, end| {
                    let still = (&self.placed[leaf], Pose::default());
                    t_max = self.follow_placed(simd, still, ray, end, wanted, &mut met)?;
                    ControlFlow::Continue(t_max)
                },
            )?;
        }
        let Some(moving) = &self.moving else { return ControlFlow::Continue(()) };
        traverse(
            simd,
            moving.nodes(ray.moment),
            &here,
            t_max,
            #[inline(always)]
            |leaf, end| {
                let (placed, pose) = moving.placed(leaf, ray.moment);
                self.follow_placed(simd, (&placed, pose), ray, end, wanted, &mut met)
            },
        )
    }
}

impl Forest for PointForest {
    #[inline(always)]
    fn closest_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        mut nearest: Option<Hit>,
        wanted: &impl Fn(u32) -> bool,
    ) -> Option<Hit> {
        let t_max = nearest.map_or(ray.t_max, |hit| hit.t);
        let _ = self.follow(
            simd,
            ray,
            t_max,
            wanted,
            #[inline(always)]
            |hit, end| {
                if hit.t < end {
                    nearest = Some(hit);
                }
                ControlFlow::Continue(end.min(hit.t))
            },
        );
        nearest
    }

    #[inline(always)]
    fn each_between_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        self.follow(
            simd,
            ray,
            ray.t_max,
            wanted,
            #[inline(always)]
            |hit, end| if pass(&hit) { ControlFlow::Continue(end) } else { ControlFlow::Break(()) },
        )
    }
}

#[inline(always)]
fn hit(t: f32, outward: Vec3A, instance: u32, point: u32, moment: u16) -> Hit {
    let [u, v] = unfolded(outward);
    Hit { t, u, v, instance, triangle: point, moment }
}

/// The ray in the object space of an instance, and how much longer distances are there.
#[inline(always)]
fn enter(placed: &PlacedMesh, ray: &Ray) -> Option<(BoxRay, Beam, f32)> {
    let Within { origin, direction, scale } = placed.enter(ray)?;
    Some((BoxRay::new(origin, direction), Beam { origin, direction }, scale))
}

#[inline(always)]
fn tree_of<'a>(shared: &'a [PointTree], posed: &'a [Vec<PointTree>], mesh: u32, pose: Pose) -> &'a PointTree {
    posed[mesh as usize].get(pose.key as usize).unwrap_or(&shared[mesh as usize])
}

impl PointTree {
    fn new(of: &[Cloud<'_>]) -> Self {
        let boxes = of.iter().enumerate().flat_map(|(number, cloud)| {
            (0..cloud.points.points.len() as u32)
                .map(move |point| Bounds::around(&[cloud.ball(point)]).naming([number as u32, point]))
        });
        let (nodes, names) = built(boxes.collect());
        let leaf = |names: &Vec<[u32; 2]>| {
            let mut leaf = Balls::EMPTY;
            for (lane, &[number, point]) in names.iter().enumerate() {
                let cloud = &of[number as usize];
                leaf.set(lane, cloud.ball(point), [cloud.instance, point]);
            }
            leaf
        };
        Self { nodes, leaves: names.iter().map(leaf).collect(), to: Vec::new() }
    }

    /// The tree of points on their way from a key to the next, object space: boxes hold all of it.
    fn between(points: &Points, key: u32) -> Self {
        let ball = |point: u32, part: f32| points.at(point, Pose { key, part });
        let swept = |point: u32| Bounds::around(&[ball(point, 0.0), ball(point, 1.0)]).naming([0, point]);
        let (nodes, names) = built((0..points.points.len() as u32).map(swept).collect());
        let leaves = |part: f32| {
            let leaf = |names: &Vec<[u32; 2]>| {
                let mut leaf = Balls::EMPTY;
                names.iter().enumerate().for_each(|(lane, name)| leaf.set(lane, ball(name[1], part), *name));
                leaf
            };
            names.iter().map(leaf).collect()
        };
        Self { nodes, leaves: leaves(0.0), to: leaves(1.0) }
    }

    fn bounds(&self) -> Option<Bounds> {
        self.nodes.first().map(Node::bounds)
    }

    /// Offers what a ray hits of balls that it does not pass by: instance, point, distance, from the middle outwards, and the
    /// ray's end, which `met` gives anew.
    #[inline(always)]
    fn follow<S: Simd>(
        &self,
        simd: S,
        (boxes, beam): (&BoxRay, &Beam),
        part: f32,
        t_max: f32,
        passes_by: impl Fn(u32, u32) -> bool,
        mut met: impl FnMut(u32, u32, f32, Vec3A, f32) -> ControlFlow<(), f32>,
    ) -> ControlFlow<()> {
        traverse(
            simd,
            &self.nodes,
            boxes,
            t_max,
            #[inline(always)]
            |leaf, mut end| {
                let mut balls = &self.leaves[leaf];
                let now;
                if let Some(to) = self.to.get(leaf) {
                    now = balls.towards(to, part);
                    balls = &now;
                }
                let Some(found) = balls.meet(simd, beam, end) else { return ControlFlow::Continue(end) };
                for lane in lanes(found.lanes) {
                    let (t, instance, point) = (found.t[lane], balls.instance[lane], balls.point[lane]);
                    if t < end && !passes_by(instance, point) {
                        end = met(instance, point, t, found.outward(lane), end)?;
                    }
                }
                ControlFlow::Continue(end)
            },
        )
    }
}

/// The nodes above boxes, and by leaf what these name.
fn built(mut boxes: Vec<Bounds>) -> (Vec<Node>, Vec<Vec<[u32; 2]>>) {
    boxes.retain(Bounds::is_within_reach);
    let built = build(&mut boxes, LANES);
    let names = |leaf: &Range<usize>| boxes[leaf.clone()].iter().map(Bounds::name).collect();
    (built.nodes, built.leaves.iter().map(names).collect())
}
