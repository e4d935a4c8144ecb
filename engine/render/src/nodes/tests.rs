//! Fields: those that a kind of point knows, its answers, and the warnings about the others.

use super::lamp::{Asked, LampPoint};
use super::*;
use crate::accel::Hit;
use crate::scene::curves::{CurveShape, CurvesDescription};
use crate::scene::graph::Graph;
use crate::scene::mesh::MeshDescription;
use crate::scene::points::PointsDescription;
use crate::scene::volume::Volume;
use crate::scene::{Scene, SceneBuilder};
use crate::surface::SurfacePoint;
use glam::{Affine3A, DMat4, DVec3, Vec2, Vec3, Vec3A, Vec4};
use petzval_nodes::{Field, Graph as Shaders, Program, Shift, random_of_pair};

/// Compares the answers of a point with the fields that its kind knows.
#[track_caller]
fn agrees<C: Context>(point: &C) {
    for &field in Field::ALL {
        assert_eq!(point.answer(field, Shift::NONE).is_some(), C::knows(field), "{field:?}");
    }
}

/// A scene of a triangle, a strand and a point of a cloud, an instance each in this order.
fn three() -> Scene {
    let mut builder = SceneBuilder::new();
    let (positions, triangles) = (vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
    let triangle = MeshDescription { name: "triangle".into(), positions, triangles, ..Default::default() };
    let strand = CurvesDescription {
        name: "hair".into(),
        keys: vec![Vec4::new(0.0, 0.0, 0.0, 0.1), Vec4::new(1.0, 0.0, 0.0, 0.1)],
        first_keys: vec![0, 2],
        shape: CurveShape::Ribbon { pieces: 5 },
        first_number: 0,
        uv_maps: vec![],
        attributes: vec![],
        moved_keys: None,
        poses: vec![],
    };
    let cloud = PointsDescription { name: "cloud".into(), points: vec![Vec4::ONE], ..Default::default() };
    let meshes =
        [builder.add_mesh(triangle).unwrap(), builder.add_curves(strand).unwrap(), builder.add_points(cloud).unwrap()];
    for mesh in meshes {
        builder.add_instance("one", mesh, DMat4::IDENTITY, &[], true, true).unwrap();
    }
    builder.build(DVec3::ZERO)
}

fn point(scene: &Scene, instance: u32) -> Point<'_> {
    let hit = Hit { t: 1.0, u: 0.2, v: 0.3, instance, triangle: 0, moment: 0 };
    let view = View {
        direction: -Vec3A::Z,
        distance: 1.0,
        way: PathState::CAMERA,
        moment: 0,
        is_blurry: false,
        cone: RayCone { width: 0.0, spread: 1e-3 },
    };
    Point::new(scene.into(), SurfacePoint::new(scene, &hit, view.direction), view, &[], 0.0, true)
}

fn infinity(scene: &Scene) -> Infinity<'_> {
    let (direction, way) = (Vec3A::Z, PathState::CAMERA);
    Infinity { direction, way, shows_sun: true, viewport: &scene.viewport, attributes: &[] }
}

#[test]
fn points_answer_what_they_know() {
    let scene = three();
    for instance in 0..3 {
        agrees(&point(&scene, instance));
    }
    agrees(&infinity(&scene));
    let lamp = LampPoint {
        position: Vec3A::X,
        normal: Vec3A::Z,
        direction: Vec3A::Z,
        distance: 1.0,
        uv: Vec2::ZERO,
        to_world: Affine3A::IDENTITY,
        way: PathState::LIGHT,
    };
    agrees(&Asked(&lamp, &[]));
    let volume = Volume { program: Program::default(), layers: vec![], pass_index: 0, is_even: true };
    let own = (&scene.instances[0], &*scene.meshes[0]);
    for own in [None, Some(own)] {
        let (position, direction, way) = (Vec3A::ZERO, Vec3A::Z, PathState::CAMERA);
        agrees(&VolumePoint { scene: &scene, own, volume: &volume, position, direction, way });
    }
}

#[test]
fn fields_of_a_kind_of_mesh_are_zero_on_the_others() {
    let scene = three();
    let read = |instance, field| point(&scene, instance).read(field, Shift::NONE);
    let [hair, ball] = [Field::IsStrand, Field::PointRadius];
    assert_eq!([0, 1, 2].map(|instance| read(instance, hair)), [Vec3A::ZERO, Vec3A::ONE, Vec3A::ZERO]);
    assert_eq!([0, 1].map(|instance| read(instance, ball)), [Vec3A::ZERO; 2]);
    assert!((read(2, ball) - Vec3A::ONE).length() < 1e-6);
}

/// The numbers by Cycles of Blender 5.2, from the picture of a world that shows them.
#[test]
fn a_world_has_what_cycles_gives_it() {
    let scene = three();
    let read = |field| infinity(&scene).read(field, Shift::NONE);
    let given = [
        (Field::Parametric, Vec3A::X),
        (Field::ObjectColour, Vec3A::ZERO),
        (Field::ObjectAlpha, Vec3A::ZERO),
        (Field::ParticleRandom, Vec3A::splat(0.860_312_76)),
        (Field::RayLength, Vec3A::splat(f32::MAX)),
        (Field::InstancerGenerated, Vec3A::Z),
        (Field::Reflection, -Vec3A::Z),
    ];
    for (field, value) in given {
        assert!((read(field) - value).length() < 1e-7, "{field:?}: {:?}", read(field));
    }
    assert_eq!(random_of_pair([0, 0]), read(Field::ParticleRandom).x);
}

fn reports(node: &str, socket: &str, answered: AnsweredFields) -> Vec<String> {
    let text = format!(
        r#"{{"nodes": [{{"type": "ShaderNodeEmission", "inputs": {{"Color": {{"node": 1, "socket": "{socket}"}}}}}},
        {{"type": "ShaderNode{node}"}}, {{"type": "ShaderNodeTexNoise"}}],
        "surface": {{"node": 0, "socket": "Emission"}}, "volume": null, "displacement": null}}"#
    );
    Graph::of(&Shaders::from_json(&text).unwrap(), 0, answered).1
}

#[test]
fn fields_that_nothing_answers_are_named() {
    let unknown = |knows: fn(Field) -> bool| Field::ALL.iter().filter(|&&field| !knows(field)).count();
    // Of instancers, particles and grids; the first two of these; the axes of a footprint.
    assert_eq!([OF_MATERIALS.on_surfaces, OF_MATERIALS.in_volumes, OF_WORLDS.on_surfaces].map(unknown), [14, 10, 2]);
    let named = ["Particle index is not supported yet, it is 0".to_owned()];
    assert_eq!(reports("ParticleInfo", "Index", OF_MATERIALS), named);
    assert!(reports("ParticleInfo", "Index", OF_WORLDS).is_empty());
    assert!(Field::ALL.iter().all(|&field| VolumePoint::knows(field) || !volume::varies(field)));
}
