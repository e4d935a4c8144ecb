//! Small scenes before a camera at the origin that looks along -z, each with another kind of light.

use glam::{DMat4, DVec3, Vec2, Vec3};
use petzval_render::Rgb;
use petzval_render::integrator::PreparedScene;
use petzval_render::nodes::OF_MATERIALS;
use petzval_render::scene::closure::{Closure, Principled};
use petzval_render::scene::corners::Corners;
use petzval_render::scene::graph::Graph;
use petzval_render::scene::lamp::{Lamp, LampKind};
use petzval_render::scene::material::Material;
use petzval_render::scene::mesh::MeshDescription;
use petzval_render::scene::texture::Texture;
use petzval_render::scene::{SceneBuilder, visibility::Rays, world::World};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// A scene under construction, in a room of the kind that most of them share.
pub(crate) struct Room {
    pub(crate) builder: SceneBuilder,
}

pub(crate) fn plain(r: f32, g: f32, b: f32) -> Material {
    Material::diffuse("plain", Rgb::new(r, g, b), Rgb::ZERO)
}

pub(crate) fn glossy(metallic: f32, transmission: f32, roughness: f32) -> Material {
    let base_color = Rgb::new(0.9, 0.8, 0.7);
    let principled = Principled { base_color, metallic, transmission, roughness, ..Principled::default() };
    Material::principled("glossy", principled)
}

/// A square of side 2 in the xy plane that faces +z, with UVs.
pub(crate) fn square() -> MeshDescription {
    let positions = vec![
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::new(1.0, -1.0, 0.0),
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(-1.0, 1.0, 0.0),
    ];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let uvs = positions.iter().map(|p| (p.truncate() + Vec2::ONE) * 0.5).collect();
    MeshDescription {
        name: "square".into(),
        triangles,
        uv_maps: vec![("UVMap".into(), Corners::Vertices(uvs))],
        positions,
        ..Default::default()
    }
}

/// A ball of radius 1, smooth.
pub(crate) fn ball(rings: u32) -> MeshDescription {
    let sectors = 2 * rings;
    let at = |i: u32, j: u32| {
        let (theta, phi) =
            (PI * f64::from(i) / f64::from(rings), 2.0 * PI * f64::from(j % sectors) / f64::from(sectors));
        Vec3::new((theta.sin() * phi.cos()) as f32, (theta.sin() * phi.sin()) as f32, theta.cos() as f32)
    };
    let mut d = MeshDescription { name: "ball".into(), ..Default::default() };
    let mut normals = Vec::new();
    for i in 0..rings {
        for j in 0..sectors {
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for t in [[0, 1, 2], [0, 2, 3]] {
                let first = d.positions.len() as u32;
                let corners: [Vec3; 3] = t.map(|k: usize| quad[k]);
                if (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() < 1e-9 {
                    continue;
                }
                d.positions.extend(corners);
                d.triangles.push([first, first + 1, first + 2]);
                normals.push(corners);
            }
        }
    }
    d.corner_normals = Some(Corners::Each(normals));
    d
}

pub(crate) fn lamp(kind: LampKind, watts: f32) -> Lamp {
    Lamp { object_name: "lamp".into(), kind, color: Rgb::new(1.0, 0.9, 0.7) * watts, ..Lamp::default() }
}

pub(crate) const DOWN: [f64; 3] = [-FRAC_PI_2, 0.0, 0.0];

/// Placed at `at`, turned about x, then y, then z.
pub(crate) fn place(at: [f64; 3], turn: [f64; 3], size: f64) -> DMat4 {
    let turned = DMat4::from_rotation_z(turn[2]) * DMat4::from_rotation_y(turn[1]) * DMat4::from_rotation_x(turn[0]);
    DMat4::from_translation(DVec3::from(at)) * turned * DMat4::from_scale(DVec3::splat(size))
}

impl Room {
    /// A floor at y = -0.6 and a wall at z = -5, y up.
    pub(crate) fn new() -> Self {
        let mut room = Self { builder: SceneBuilder::new() };
        room.put(square(), plain(0.7, 0.6, 0.5), place([0.0, -0.6, -3.0], DOWN, 4.0));
        room.put(square(), plain(0.4, 0.5, 0.7), place([0.0, 0.0, -5.0], [0.0; 3], 4.0));
        room
    }

    pub(crate) fn put(&mut self, mesh: MeshDescription, material: Material, place: DMat4) {
        let m = self.builder.add_material(material);
        let mesh = self.builder.add_mesh(mesh).unwrap();
        self.builder.add_instance("object", mesh, place, &[m], true, true).unwrap();
    }

    pub(crate) fn light(&mut self, lamp: Lamp, place: DMat4) {
        self.builder.add_lamp(lamp, place).unwrap();
    }

    pub(crate) fn finish(self) -> Arc<PreparedScene> {
        Arc::new(PreparedScene::new(self.builder.build(DVec3::ZERO)))
    }
}

fn area(side: f32, half_spread_rad: f32) -> LampKind {
    LampKind::Area { size: [side, 0.7 * side], ellipse: false, half_spread_rad }
}

/// Matte and glossy things under an area lamp; closed in by walls, so that light goes round.
pub(crate) fn box_under_a_lamp() -> Arc<PreparedScene> {
    let mut room = Room::new();
    room.put(square(), plain(0.8, 0.2, 0.2), place([-1.2, 0.0, -4.0], [0.0, FRAC_PI_2, 0.0], 2.0));
    room.put(square(), plain(0.2, 0.8, 0.2), place([1.2, 0.0, -4.0], [0.0, -FRAC_PI_2, 0.0], 2.0));
    room.put(ball(16), glossy(0.0, 0.0, 0.3), place([0.4, -0.3, -3.6], [0.0; 3], 0.3));
    room.put(ball(16), glossy(1.0, 0.0, 0.2), place([-0.4, -0.3, -3.9], [0.0; 3], 0.3));
    room.light(lamp(area(0.5, 1.0), 30.0), place([0.0, 0.9, -3.6], DOWN, 1.0));
    room.finish()
}

/// A glass ball and a mirror ball that gather light on the floor.
pub(crate) fn caustic(kind: LampKind) -> Arc<PreparedScene> {
    let mut room = Room::new();
    room.put(ball(24), glossy(0.0, 1.0, 0.0), place([0.3, -0.3, -3.2], [0.0; 3], 0.25));
    room.put(ball(24), glossy(1.0, 0.0, 0.0), place([-0.4, -0.35, -3.6], [0.0; 3], 0.25));
    room.light(lamp(kind, 40.0), place([1.2, 1.0, -3.0], [-1.2, 0.6, 0.0], 1.0));
    room.finish()
}

/// A rough glass ball and a rough mirror ball under an area lamp.
pub(crate) fn rough_caustic() -> Arc<PreparedScene> {
    let mut room = Room::new();
    room.put(ball(24), glossy(0.0, 1.0, 0.35), place([0.3, -0.3, -3.2], [0.0; 3], 0.25));
    room.put(ball(24), glossy(1.0, 0.0, 0.3), place([-0.4, -0.35, -3.6], [0.0; 3], 0.25));
    room.light(lamp(area(0.3, 1.5), 40.0), place([1.0, 1.0, -3.0], [-1.2, 0.6, 0.0], 1.0));
    room.finish()
}

/// Glowing meshes: an open one and a closed one.
pub(crate) fn emissive() -> Arc<PreparedScene> {
    let mut room = Room::new();
    let glowing = |strength: f32| Material::diffuse("glowing", Rgb::splat(0.5), Rgb::new(1.0, 0.6, 0.3) * strength);
    room.put(square(), glowing(6.0), place([0.6, 0.2, -4.0], [0.3, 0.5, 0.1], 0.3));
    room.put(ball(8), glowing(3.0), place([-0.5, -0.3, -3.6], [0.0; 3], 0.2));
    room.put(ball(16), glossy(0.0, 0.0, 0.1), place([0.1, -0.35, -3.0], [0.0; 3], 0.2));
    room.finish()
}

/// A sun, and a dim sky of one colour.
pub(crate) fn sun(half_angle_rad: f32) -> Arc<PreparedScene> {
    let mut room = Room::new();
    room.put(ball(24), glossy(0.0, 1.0, 0.0), place([0.3, -0.3, -3.2], [0.0; 3], 0.25));
    room.put(ball(16), plain(0.6, 0.6, 0.6), place([-0.4, -0.3, -3.4], [0.0; 3], 0.3));
    room.light(lamp(LampKind::Sun { half_angle_rad }, 2.0), place([0.0; 3], [-1.0, 0.4, 0.0], 1.0));
    room.builder.set_world(World { color: Rgb::new(0.1, 0.15, 0.2), ..Default::default() }).unwrap();
    room.finish()
}

/// A sky with a bright patch.
pub(crate) fn image_sky() -> Arc<PreparedScene> {
    let mut room = Room::new();
    let (w, h) = (32, 16);
    let bright = |i: usize| if (6..9).contains(&(i % w)) && (11..13).contains(&(i / w)) { 30.0 } else { 0.2 };
    let pixels: Vec<f32> = (0..w * h).flat_map(|i| [bright(i), 0.8 * bright(i), 0.6 * bright(i), 1.0]).collect();
    let t = room.builder.add_texture(Texture::from_floats("sky", w, h, &pixels, false).unwrap());
    let rotation = glam::Mat3A::from_rotation_x(-1.2);
    let world = World { color: Rgb::ONE, texture: Some(t as u32), rotation, ..Default::default() };
    room.builder.set_world(world).unwrap();
    room.put(ball(16), glossy(0.0, 0.0, 0.2), place([-0.3, -0.3, -3.4], [0.0; 3], 0.3));
    room.finish()
}

/// A leaf with an alpha map and a half-transparent sheet in the light of a lamp, one of them before the camera.
pub(crate) fn leaves() -> Arc<PreparedScene> {
    let mut room = Room::new();
    let (w, h) = (8, 8);
    let alpha = |i: usize| if (i % w + i / w).is_multiple_of(3) { 0.2 } else { 0.9 };
    let pixels: Vec<f32> = (0..w * h).flat_map(|i| [0.2, 0.7, 0.2, alpha(i)]).collect();
    let t = room.builder.add_texture(Texture::from_floats("leaf", w, h, &pixels, false).unwrap()) as u32;
    let nodes = format!(
        r#"{{"nodes": [
            {{"type": "ShaderNodeMixShader", "inputs": {{"Fac": {{"node": 3, "socket": "Alpha"}},
                "Shader": {{"node": 1, "socket": "BSDF"}}, "Shader_001": {{"node": 2, "socket": "BSDF"}}}}}},
            {{"type": "ShaderNodeBsdfTransparent", "inputs": {{"Color": [1, 1, 1]}}}},
            {{"type": "ShaderNodeBsdfDiffuse", "inputs": {{"Color": {{"node": 3, "socket": "Color"}}, "Roughness": 0}}}},
            {{"type": "ShaderNodeTexImage", "options": {{"image": {t}}}}}
        ], "surface": {{"node": 0, "socket": "Shader"}}}}"#
    );
    let (graph, reports) = Graph::of(&petzval_nodes::Graph::from_json(&nodes).unwrap(), 0, OF_MATERIALS);
    assert_eq!(reports, Vec::<String>::new());
    let leaf = Material::new("leaf", Arc::new(graph));
    room.put(square(), leaf.clone(), place([0.3, 0.2, -3.4], [-1.2, 0.2, 0.0], 0.5));
    room.put(square(), leaf, place([-0.4, 0.0, -2.8], [0.1, 0.3, 0.2], 0.3));
    let red = Closure::Diffuse { color: Rgb::new(0.8, 0.3, 0.3), roughness: 0.0 };
    let sheet = Material::even("sheet", [(0.4, red), (0.6, Closure::Transparent { color: Rgb::ONE })]);
    room.put(square(), sheet, place([0.0, 0.6, -3.6], DOWN, 0.6));
    room.light(lamp(area(0.4, 1.5), 30.0), place([0.2, 1.2, -3.5], DOWN, 1.0));
    room.finish()
}

/// Balls and spots of light, hard and soft, one of them without extent.
pub(crate) fn many_lamps() -> Arc<PreparedScene> {
    let mut room = Room::new();
    room.put(ball(16), glossy(1.0, 0.0, 0.15), place([0.0, -0.3, -3.5], [0.0; 3], 0.3));
    let kinds = [
        (LampKind::Point { radius: 0.1, soft: false }, [-0.9, 0.2, -4.0]),
        (LampKind::Point { radius: 0.15, soft: true }, [0.9, 0.1, -4.0]),
        (LampKind::Spot { radius: 0.05, half_angle_rad: 0.5, blend: 0.3, soft: false }, [0.5, 0.8, -3.5]),
        (LampKind::Spot { radius: 0.1, half_angle_rad: 0.6, blend: 0.2, soft: true }, [-0.5, 0.8, -3.2]),
        (LampKind::Spot { radius: 0.0, half_angle_rad: 0.4, blend: 0.1, soft: false }, [0.0, 0.9, -3.0]),
        (LampKind::Area { size: [0.3, 0.2], ellipse: true, half_spread_rad: 0.6 }, [0.8, 0.9, -3.2]),
    ];
    for (kind, at) in kinds {
        room.light(lamp(kind, 10.0), place(at, DOWN, 1.0));
    }
    room.finish()
}

/// Matte things alone, lit by an area lamp that the camera does not see.
pub(crate) fn matte() -> Arc<PreparedScene> {
    let mut room = Room::new();
    room.put(ball(16), plain(0.8, 0.4, 0.2), place([0.5, -0.2, -3.4], [0.0; 3], 0.35));
    room.put(square(), plain(0.2, 0.3, 0.8), place([-0.5, 0.4, -3.8], [0.2, 0.4, 0.3], 0.3));
    let unseen = Lamp { reaches: Rays::ALL.without(Rays::CAMERA), ..lamp(area(0.5, 1.6), 30.0) };
    room.light(unseen, place([0.2, 1.2, -2.5], [-1.2, 0.0, 0.0], 1.0));
    room.finish()
}

/// A small matte square above and to the right, under a sun behind the camera.
pub(crate) fn small_square() -> Arc<PreparedScene> {
    let mut room = Room { builder: SceneBuilder::new() };
    room.put(square(), plain(0.8, 0.8, 0.8), place([0.6, 0.35, -3.5], [0.0; 3], 0.05));
    room.light(lamp(LampKind::Sun { half_angle_rad: 0.0 }, 100.0), place([0.0; 3], [0.0; 3], 1.0));
    room.finish()
}

/// Glowing triangles of several colours before and behind the plane of focus, in a grey glowing world: nothing is lit,
/// all is seen.
pub(crate) fn triangles() -> Arc<PreparedScene> {
    let triangle = MeshDescription {
        name: "triangle".into(),
        positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let colours = [[2.0, 2.0, 2.0], [3.0, 0.2, 0.1], [0.1, 2.0, 0.3], [0.2, 0.3, 4.0]];
    let mut room = Room { builder: SceneBuilder::new() };
    for i in 0..24 {
        let part = |factor: f64| (f64::from(i) * factor).fract();
        let depth = 1.0 + 5.0 * part(0.57);
        let at = [2.0 * (part(0.618) - 0.5) * depth, 1.5 * (part(0.755) - 0.5) * depth, -depth];
        let glow = Material::diffuse("glow", Rgb::ZERO, Rgb::from(colours[i as usize % 4]));
        room.put(triangle.clone(), glow, place(at, [0.0; 3], 0.25));
    }
    room.builder.set_world(World { color: Rgb::splat(0.5), ..Default::default() }).unwrap();
    room.finish()
}
