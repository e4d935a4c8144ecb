//! Materials at several places at once have the bits that they have at each alone.

use super::*;
use crate::accel::Hit;
use crate::nodes::{OF_MATERIALS, PathState, RayCone, layers};
use crate::scene::corners::Corners;
use crate::scene::mesh::MeshDescription;
use crate::scene::{Scene, SceneBuilder};
use glam::{DMat4, DQuat, DVec3, Vec2, Vec3};
use petzval_nodes::{Graph as Shaders, random_of_pair};
use std::sync::Arc;

/// Noise, a map of normals over two UV maps of which a mesh may have none, a bump of noise, and a displacement of it.
const SHADERS: &str = r#"{"nodes": [
    {"type": "ShaderNodeTexNoise", "inputs": {"Scale": 5.0, "Detail": 2.5, "Roughness": 0.5, "Lacunarity": 2.0}},
    {"type": "ShaderNodeUVMap", "options": {"uv_map": "map"}},
    {"type": "ShaderNodeTexNoise", "inputs": {"Vector": {"node": 1, "socket": "UV"}, "Scale": 3.0, "Detail": 1.0, "Roughness": 0.5, "Lacunarity": 2.0}},
    {"type": "ShaderNodeNormalMap", "options": {"space": "TANGENT", "uv_map": "MAP"}, "inputs": {"Color": {"node": 0, "socket": "Color"}, "Strength": 0.8}},
    {"type": "ShaderNodeBump", "inputs": {"Height": {"node": 2, "socket": "Fac"}, "Normal": {"node": 3, "socket": "Normal"}, "Strength": 1.0, "Distance": 0.5}},
    {"type": "ShaderNodeBsdfPrincipled", "inputs": {"Base Color": {"node": 2, "socket": "Color"}, "Normal": {"node": 4, "socket": "Normal"}, "Roughness": 0.5}},
    {"type": "ShaderNodeDisplacement", "options": {"space": "OBJECT"}, "inputs": {"Height": HEIGHT, "Midlevel": 0.5, "Scale": 0.2}}
    ], "surface": {"node": 5, "socket": "BSDF"}, "volume": null, "displacement": {"node": 6, "socket": "Displacement"}}"#;

fn material(map: &str, height: &str, displacement: Displacement) -> Material {
    let text = SHADERS.replace("MAP", map).replace("HEIGHT", height);
    let (mut graph, _) = Graph::of(&Shaders::from_json(&text).unwrap(), 0, OF_MATERIALS);
    graph.displacement = displacement;
    Material::new("varied", Arc::new(graph))
}

/// Two meshes, of which only the first has normals and a map, the first in two poses.
fn scene() -> Scene {
    let mut builder = SceneBuilder::new();
    let unit = |i: u32, of: u32| random_of_pair([i, of]) * 2.0 - 1.0;
    let place = |i: u32| Vec3::new(unit(i, 1), unit(i, 2), unit(i, 3));
    let triangles: Vec<[u32; 3]> = (0..12).map(|i| [i, i + 1, i + 2]).collect();
    let plain = MeshDescription {
        name: "plain".into(),
        positions: (20..34).map(place).collect(),
        triangles: triangles.clone(),
        ..Default::default()
    };
    let mapped = MeshDescription {
        name: "mapped".into(),
        positions: (0..14).map(place).collect(),
        triangles,
        corner_normals: Some(Corners::Vertices((40..54).map(|i| place(i).normalize()).collect())),
        // The last triangles take no area of the map.
        uv_maps: vec![(
            "map".into(),
            Corners::Vertices((0..14).map(|i| Vec2::new(unit(i.min(9), 5), unit(i.min(9), 6))).collect()),
        )],
        ..Default::default()
    };
    let [mapped, plain] = [mapped, plain].map(|mesh| builder.add_mesh(mesh).unwrap());
    let turned =
        DMat4::from_scale_rotation_translation(DVec3::new(1.0, 2.0, 0.5), DQuat::from_rotation_x(0.7), DVec3::Y);
    for (mesh, pose) in [(mapped, DMat4::IDENTITY), (mapped, turned), (plain, turned)] {
        builder.add_instance("one", mesh, pose, &[], true, true).unwrap();
    }
    builder.build(DVec3::ZERO)
}

#[test]
fn a_place_among_others_is_a_place_alone() {
    let scene = scene();
    let view = View {
        direction: Vec3A::new(0.6, 0.0, -0.8),
        distance: 2.0,
        way: PathState::CAMERA,
        moment: 0,
        is_blurry: false,
        cone: RayCone { width: 0.01, spread: 1e-3 },
    };
    let at = |number: u32, instance: u32| {
        let [u, v] = [random_of_pair([number, 7]), random_of_pair([number, 8])].map(|share| share * 0.5);
        let hit = Hit { t: 2.0, u, v, instance, triangle: number % 12, moment: 0 };
        SurfacePoint::new(&scene, &hit, view.direction)
    };
    let noise = r#"{"node": 0, "socket": "Fac"}"#;
    let mut bent = 0;
    for (map, height, displacement) in [
        ("map", noise, Displacement::Bump),
        ("map", noise, Displacement::Both),
        ("map", "0.7", Displacement::Bump),
        ("map", "0.7", Displacement::Both),
        ("", noise, Displacement::Vertices),
        ("another", noise, Displacement::Vertices),
    ] {
        let material = material(map, height, displacement);
        let (mut at_once, mut found, mut alone) = (LaneValues::default(), Layers::default(), Layers::default());
        for round in 0..200 {
            // Of one object, of several, and fewer than there are lanes.
            let count = 1 + round as usize % LANES;
            let points: Vec<SurfacePoint> = (0..count as u32)
                .map(|lane| at(round * 8 + lane, if round % 2 == 0 { round % 3 } else { (round + lane) % 3 }))
                .collect();
            at_once.run(&material, (&scene).into(), points.iter().map(|point| (point, &view)));
            for (lane, point) in points.iter().enumerate() {
                at_once.layers(&material, lane, &mut found);
                layers(&material, (&scene).into(), point, &view, &mut alone);
                // Of numbers, these words are all their bits.
                assert_eq!(format!("{found:?}"), format!("{alone:?}"), "{map} {displacement:?}");
                assert!(!found.closures.is_empty());
                bent += u32::from(found.bent_normal.is_some());
            }
        }
    }
    // Three of six, the constant height of a mesh that nothing moved left out.
    assert_eq!(bent, 3 * 900);
}
