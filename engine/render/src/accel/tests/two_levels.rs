//! Two levels of trees against testing every primitive of every instance without boxes: for each kind of primitive, where instances
//! stand alone, where they share a mesh, where they move, and where they deform as they move.

use super::super::curves::Segments;
use super::super::node::Node;
use super::super::places::PlacedMesh;
use super::super::points::Spheres;
use super::super::tree::{LocalHit, Primitives, SurfaceCoordinates, Tree, Visitor};
use super::super::triangles::Triangles;
use super::against_all::Dice;
use super::*;
use crate::scene::curves::{CurveShape, CurvesDescription};
use crate::scene::motion::Poses;
use crate::scene::points::PointsDescription;
use fearless_simd::dispatch;
use glam::{DQuat, Vec4};
use std::cell::Cell;

/// Adds a mesh of one kind, which changes its shape while the shutter is open where that is asked and the kind can.
type Add = fn(&mut SceneBuilder, &mut Dice, bool) -> usize;

fn point(dice: &mut Dice) -> Vec3 {
    dice.vector().as_vec3()
}

fn add_triangles(builder: &mut SceneBuilder, dice: &mut Dice, deforms: bool) -> usize {
    let corners = |dice: &mut Dice| {
        let middle = point(dice);
        [0, 1, 2].map(|_| middle + 0.5 * point(dice))
    };
    let positions: Vec<Vec3> = (0..20).flat_map(|_| corners(dice)).collect();
    let mut shape = || positions.iter().map(|p| *p + 0.3 * point(dice)).collect();
    let poses = deforms.then(|| vec![shape(), positions.clone(), shape()]);
    let poses = poses.map(|positions| Poses { positions, corner_normals: None });
    let triangles = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    builder.add_mesh(MeshDescription { positions, triangles, poses, ..Default::default() }).unwrap()
}

fn add_curves(builder: &mut SceneBuilder, dice: &mut Dice, deforms: bool) -> usize {
    const STRANDS: u32 = 8;
    const KEYS: u32 = 5;
    let mut keys = vec![];
    for _ in 0..STRANDS {
        let (mut place, along) = (point(dice), 0.4 * point(dice));
        for _ in 0..KEYS {
            place += along + 0.1 * point(dice);
            keys.push(place.extend(0.02 + 0.1 * dice.roll() as f32));
        }
    }
    let mut shape = || keys.iter().map(|p: &Vec4| *p + (0.3 * point(dice)).extend(0.02)).collect();
    let poses = if deforms { vec![shape(), keys.clone(), shape()] } else { vec![] };
    let shapes = [CurveShape::Ribbon { pieces: 5 }, CurveShape::Thick, CurveShape::ThickLinear];
    let curves = CurvesDescription {
        name: "curves".into(),
        keys,
        first_keys: (0..=STRANDS).map(|strand| strand * KEYS).collect(),
        shape: shapes[dice.pick(3)],
        first_number: 0,
        uv_maps: vec![],
        attributes: vec![],
        moved_keys: None,
        poses,
    };
    builder.add_curves(curves).unwrap()
}

fn add_points(builder: &mut SceneBuilder, dice: &mut Dice, deforms: bool) -> usize {
    let points: Vec<Vec4> = (0..30).map(|_| point(dice).extend(0.02 + 0.2 * dice.roll() as f32)).collect();
    let mut shape = || points.iter().map(|p| *p + (0.3 * point(dice)).extend(0.02)).collect();
    let poses = if deforms { vec![shape(), points.clone(), shape()] } else { vec![] };
    builder.add_points(PointsDescription { name: "points".into(), points, poses, ..Default::default() }).unwrap()
}

/// A random placement; a stretched one changes the form of its mesh.
fn placement(dice: &mut Dice, is_stretched: bool) -> DMat4 {
    let turn = DQuat::from_axis_angle(dice.vector().normalize(), 3.0 * dice.roll());
    let mirror = [1.0, -1.0][dice.pick(2)];
    let stretch = if is_stretched { DVec3::ONE + 0.4 * dice.vector() } else { DVec3::ONE };
    DMat4::from_scale_rotation_translation(stretch * (0.5 + dice.roll()) * mirror, turn, 2.0 * dice.vector())
}

/// Meshes of one kind: one that stands alone, one of three instances, one that stands still and moves, and one that deforms.
fn any_scene(add: Add, dice: &mut Dice) -> Scene {
    let mut builder = SceneBuilder::new();
    for (deforms, still, moving) in [(false, 1, 0), (false, 3, 0), (false, 1, 2), (true, 0, 2)] {
        let mesh = add(&mut builder, dice, deforms);
        for number in 0..still + moving {
            let place = placement(dice, number >= still || still > 1);
            let is_seen = dice.pick(6) != 0;
            let index = builder.add_instance("any", mesh, place, &[], is_seen, true).unwrap().unwrap();
            if number >= still {
                let turn = DMat4::from_axis_angle(DVec3::Y, dice.roll());
                let keys = [-0.5, 0.0, 0.5].map(|part| DMat4::from_translation(part * DVec3::ONE) * place);
                builder.set_keys(index, &[keys[0], keys[1], keys[2] * turn]);
            }
        }
    }
    let mut scene = builder.build(DVec3::ZERO);
    scene.set_in_motion();
    scene
}

/// The hits of a ray on one instance.
struct Collected {
    instance: u32,
    /// Factor on distances in the tree's space.
    scale: f32,
    /// The primitive that was asked for last.
    part: Cell<u32>,
    hits: Vec<(f32, SelfHit)>,
}

impl<C: SurfaceCoordinates> Visitor<C> for Collected {
    fn wants(&self, _instance: u32, part: u32) -> bool {
        self.part.set(part);
        true
    }

    fn meet(&mut self, found: LocalHit<C>, end: f32) -> ControlFlow<(), f32> {
        self.hits.push((found.t / self.scale, SelfHit { instance: self.instance, part: self.part.get() }));
        ControlFlow::Continue(end)
    }
}

/// The primitives of an instance, and the space in which they are tested.
struct Tested<P> {
    /// Index of the instance.
    instance: u32,
    /// The trees by key where the mesh deforms, else one tree.
    trees: Vec<Tree<P>>,
    is_in_render_space: bool,
}

impl<P: Primitives> Tested<P> {
    /// All instances of a scene without the stand-ins for moments.
    fn all(scene: &Scene) -> Vec<Self> {
        let is_moving = |i: u32| scene.moving.iter().any(|one| one.instance == i);
        let count = 0..scene.placed().len() as u32;
        count
            .clone()
            .map(|i| {
                let mesh = scene.instances[i as usize].mesh;
                let is_same = |j: &u32| scene.instances[*j as usize].mesh == mesh && !is_moving(*j);
                let is_in_render_space = !is_moving(i) && count.clone().filter(is_same).count() == 1;
                let mesh = &scene.meshes[mesh as usize];
                let trees = match &mesh.poses {
                    Some(poses) => (1..poses.key_count()).map(|next| P::between_keys(mesh, poses, next - 1)).collect(),
                    None if is_in_render_space => vec![P::in_render_space(scene, &[i])],
                    None => vec![P::in_object_space(mesh)],
                };
                Self { instance: i, trees, is_in_render_space }
            })
            .collect()
    }

    /// Each hit of a ray on the instance as it stands at the ray's moment, and whose it is.
    fn hits(&self, scene: &Scene, ray: &Ray) -> Vec<(f32, SelfHit)> {
        let moving = scene.moving.iter().find(|one| one.instance == self.instance);
        let number = moving.map_or(self.instance, |one| one.at(ray.moment));
        let pose = scene.instances[number as usize].pose;
        let tree = self.trees.get(pose.key as usize).unwrap_or(&self.trees[0]);
        let (own, scale) = if self.is_in_render_space {
            (P::ray(ray.origin, ray.direction), 1.0)
        } else {
            let within = PlacedMesh::new(scene, number).enter(ray).unwrap();
            (P::ray(within.origin, within.direction), within.scale)
        };
        let leaves = tree.nodes.iter().flat_map(Node::children).filter(|child| child.is_leaf()).count();
        let mut found = Collected { instance: number, scale, part: Cell::new(0), hits: vec![] };
        for leaf in 0..leaves {
            let part = moving.map(|_| pose.part);
            let _ = dispatch!(Level::new(), simd => {
                tree.primitives.meet(simd, leaf, part, &own, f32::INFINITY, &mut found)
            });
        }
        found.hits
    }
}

/// Rays from anywhere to anywhere, at any moment.
fn any_ray(dice: &mut Dice) -> Ray {
    let origin = (4.0 * dice.vector()).as_vec3a();
    let target = (2.5 * dice.vector()).as_vec3a();
    Ray::new(origin, (target - origin).normalize_or(Vec3A::Z)).at((dice.roll() * 65536.0) as u16)
}

/// Rays through a random scene: the nearest hit, every hit, and the nearest but one of the primitive that a ray leaves, are those of
/// testing everything, to the last bit. Gives the number of hits, by where these are: standing alone, shared, and moving.
fn agrees<P: Primitives>(add: Add, seed: u32) -> Result<[usize; 3], TestCaseError> {
    let mut dice = Dice(seed);
    let scene = any_scene(add, &mut dice);
    let (accel, tested) = (Accel::new(&scene), Tested::<P>::all(&scene));
    let mut counts = [0; 3];
    for i in 0..100 {
        let ray = any_ray(&mut dice);
        let kind = [Rays::CAMERA, Rays::BOUNCE][i % 2];
        let shows = |one: &&Tested<P>| scene.instances[one.instance as usize].visible.any_of(kind);
        let mut want: Vec<(f32, SelfHit)> = vec![];
        for one in tested.iter().filter(shows) {
            let hits = one.hits(&scene, &ray);
            let is_moving = scene.moving.iter().any(|moving| moving.instance == one.instance);
            counts[if one.is_in_render_space { 0 } else { 1 + usize::from(is_moving) }] += hits.len();
            want.extend(hits);
        }
        want.sort_by(|a, b| a.0.total_cmp(&b.0));
        let nearest = accel.closest(&ray, kind).map(|hit| hit.t);
        prop_assert_eq!(nearest, want.first().map(|hit| hit.0), "{:?}", ray);
        let mut all = vec![];
        accel.each_between(&ray, kind, |hit| {
            all.push(hit.t);
            true
        });
        all.sort_by(f32::total_cmp);
        prop_assert_eq!(all, want.iter().map(|hit| hit.0).collect::<Vec<_>>(), "{:?}", ray);
        if let Some(&(_, skip)) = want.first() {
            let next = accel.closest(&Ray { skip, ..ray }, kind).map(|hit| hit.t);
            let others = want.iter().find(|hit| hit.1 != skip);
            prop_assert_eq!(next, others.map(|hit| hit.0), "{:?}", ray);
            let end = want[want.len() / 2].0;
            let shorter = accel.closest(&Ray { t_max: 0.999 * end, ..ray }, kind).map(|hit| hit.t);
            prop_assert_eq!(shorter, want.first().map(|hit| hit.0).filter(|t| *t < 0.999 * end), "{:?}", ray);
        }
    }
    Ok(counts)
}

/// A hundred random scenes of a kind; hits on everything that stands alone, is shared or moves are many.
fn agree_always<P: Primitives>(add: Add) {
    let mut all = [0; 3];
    for seed in 0..100u32 {
        let counts = agrees::<P>(add, seed << 12).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        (0..3).for_each(|i| all[i] += counts[i]);
    }
    assert!(all.iter().all(|&count| count > 1000), "{all:?}");
}

#[test]
fn triangles_are_those_of_testing_all() {
    agree_always::<Triangles>(add_triangles);
}

#[test]
fn curves_are_those_of_testing_all() {
    agree_always::<Segments>(add_curves);
}

#[test]
fn points_are_those_of_testing_all() {
    agree_always::<Spheres>(add_points);
}
