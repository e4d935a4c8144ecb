//! The scene that kernels are timed on: twenty bumpy bodies in five rows, diffuse, rough metal and glass, before a wall,
//! under a sky that varies, with small lamps between them. Metres, z up; the camera looks along +y.

#![allow(dead_code, reason = "each bench takes what it needs")]

use glam::{Affine3A, DMat4, DVec3, Vec3};
use petzval_optics::system::FocalLength;
use petzval_render::Rgb;
use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::integrator::PreparedScene;
use petzval_render::sampler::mix;
use petzval_render::scene::closure::Principled;
use petzval_render::scene::corners::Corners;
use petzval_render::scene::material::Material;
use petzval_render::scene::mesh::MeshDescription;
use petzval_render::scene::texture::Texture;
use petzval_render::scene::{Scene, SceneBuilder, world::World};
use std::f32::consts::{PI, TAU};

/// Quads along each side of a body: 20 thousand triangles in all.
pub(crate) const SMALL: u32 = 22;
/// A million triangles.
pub(crate) const LARGE: u32 = 158;

const EYE: DVec3 = DVec3::new(0.0, 0.0, 1.2);
const ROWS: [f32; 5] = [0.8, 2.0, 5.0, 12.0, 30.0];

/// Numbers in [0, 1) that come one after the other.
pub(crate) struct Dice(u32);

impl Dice {
    /// The numbers of a seed.
    pub(crate) fn new(seed: u32) -> Self {
        Self(mix(seed ^ 0x51ed_270b))
    }

    /// Returns the next random number, from 0 to below 1.
    pub(crate) fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        (mix(self.0) >> 8) as f32 / (1u32 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.roll()
    }
}

/// A closed surface over a grid of `n` by `n` quads; `place` takes two numbers from 0 to 1.
fn grid(n: u32, place: impl Fn(f32, f32) -> Vec3) -> MeshDescription {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let positions: Vec<Vec3> = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| (i, j)))
        .map(|(i, j)| place(i as f32 / n as f32, j as f32 / n as f32))
        .collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
    }
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|k| positions[k as usize]);
        let n = (b - a).cross(c - a);
        t.iter().for_each(|&k| normals[k as usize] += n);
    }
    let normals = normals.into_iter().map(|n| n.normalize_or(Vec3::Z)).collect();
    let corner_normals = Some(Corners::Vertices(normals));
    MeshDescription { positions, triangles, corner_normals, ..Default::default() }
}

fn bumpy_ball(n: u32, dice: &mut Dice) -> MeshDescription {
    let waves: Vec<(Vec3, f32)> = (0..12)
        .map(|_| {
            let k = Vec3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-1.0, 1.0));
            (k * dice.between(2.0, 9.0), dice.between(0.0, TAU))
        })
        .collect();
    grid(n, |u, v| {
        let (theta, phi) = (1e-3 + (PI - 2e-3) * u, TAU * v);
        let d = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        let bumps: f32 = waves.iter().map(|(k, phase)| (d.dot(*k) + phase).sin() / (2.0 + k.length())).sum();
        d * (1.0 + 0.23 * bumps)
    })
}

fn bumpy_ring(n: u32, dice: &mut Dice) -> MeshDescription {
    let phase = dice.between(0.0, TAU);
    grid(n, |u, v| {
        let (a, b) = (TAU * u, TAU * v);
        let r = 0.36 * (1.0 + 0.25 * (5.0 * a + phase).sin() * (3.0 * b).cos());
        Vec3::new((0.64 + r * b.cos()) * a.cos(), r * b.sin(), (0.64 + r * b.cos()) * a.sin())
    })
}

fn quad(corners: [[f32; 3]; 4]) -> MeshDescription {
    MeshDescription {
        positions: corners.map(Vec3::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    }
}

fn plain(rgb: [f32; 3]) -> Material {
    Material::diffuse("plain", Rgb::from(rgb), Rgb::ZERO)
}

fn metal(rgb: [f32; 3], alpha: f32) -> Material {
    let base_color = Rgb::from(rgb);
    let metal = Principled { base_color, metallic: 1.0, roughness: alpha.sqrt(), ..Principled::default() };
    Material::principled("metal", metal)
}

fn glass() -> Material {
    let glass = Principled { base_color: Rgb::ONE, transmission: 1.0, roughness: 0.0, ..Principled::default() };
    Material::principled("glass", glass)
}

fn lamp(rgb: [f32; 3]) -> Material {
    Material::diffuse("lamp", Rgb::ZERO, Rgb::from(rgb) * 60.0)
}

/// The scene with `n` quads along each side of a body.
pub(crate) fn scene(n: u32) -> Scene {
    let mut builder = SceneBuilder::new();
    let mut dice = Dice::new(7);
    let mut add = |mesh: MeshDescription, material: Material| {
        let material = builder.add_material(material);
        let mesh = builder.add_mesh(mesh).unwrap();
        builder.add_instance("body", mesh, DMat4::IDENTITY, &[material], true, true).unwrap();
    };
    let flat = |y0: f32, y1: f32, z: f32| [[-60.0, y0, 0.0], [60.0, y0, 0.0], [60.0, y1, z], [-60.0, y1, z]];
    add(quad(flat(-10.0, 60.0, 0.0)), plain([0.32, 0.30, 0.28]));
    add(quad(flat(40.0, 40.0, 9.0)), plain([0.45, 0.42, 0.38]));
    let kinds = [
        plain([0.65, 0.12, 0.09]),
        metal([0.95, 0.72, 0.32], 0.09),
        plain([0.75, 0.75, 0.72]),
        plain([0.14, 0.50, 0.16]),
        metal([0.70, 0.71, 0.73], 0.16),
        glass(),
        plain([0.75, 0.75, 0.72]),
        plain([0.65, 0.12, 0.09]),
        metal([0.95, 0.72, 0.32], 0.09),
        plain([0.14, 0.50, 0.16]),
    ];
    for i in 0..20 {
        let (row, k) = (i / 4, (i % 4) as f32);
        let d = ROWS[row];
        let x = d * (-0.31 + 0.18 * k + 0.04 * (row % 3) as f32 + dice.between(-0.02, 0.02));
        let z = (1.2 + d * (-0.135 + 0.062 * row as f32 + dice.between(-0.015, 0.015))).max(0.05 * d);
        let mut body = if i % 3 == 2 { bumpy_ring(n, &mut dice) } else { bumpy_ball(n, &mut dice) };
        let to = Vec3::new(x, d * (1.0 + 0.08 * k), z);
        body.positions.iter_mut().for_each(|p| *p = *p * (0.058 * d) + to);
        add(body, kinds[i % kinds.len()].clone());
    }
    for k in 0..24 {
        let d = [1.1, 6.0, 9.0, 16.0, 24.0, 34.0][k % 6];
        let to = Vec3::new(d * dice.between(-0.33, 0.33), d, (1.2 + d * dice.between(-0.08, 0.19)).max(0.1));
        let mut body = grid(3, |u, v| {
            let (theta, phi) = (0.05 + (PI - 0.1) * u, TAU * v);
            Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        });
        body.corner_normals = None;
        body.positions.iter_mut().for_each(|p| *p = *p * (0.0035 * d) + to);
        add(body, lamp([1.0, dice.between(0.5, 1.0), dice.between(0.2, 1.0)]));
    }
    let (horizon, zenith) = (Vec3::new(0.9, 0.8, 0.7), Vec3::new(0.25, 0.4, 0.8));
    let pixels: Vec<f32> = (0..128)
        .flat_map(|row| std::iter::repeat_n(((row as f32 + 0.5) / 128.0 - 0.5) * PI, 256))
        .flat_map(|elevation| {
            let sky = if elevation < 0.0 { Vec3::new(0.10, 0.09, 0.08) } else { horizon.lerp(zenith, elevation.sin()) };
            [sky.x, sky.y, sky.z, 1.0]
        })
        .collect();
    let sky = builder.add_texture(Texture::from_floats("sky", 256, 128, &pixels, false).unwrap());
    let world = World { color: Rgb::ONE, texture: Some(sky as u32), ..World::default() };
    builder.set_world(world).unwrap();
    builder.build(EYE)
}

/// The stage of [`scene`]`(n)`, ready to be rendered.
pub(crate) fn stage(n: u32) -> PreparedScene {
    PreparedScene::new(scene(n))
}

/// 50 mm on 36 x 20.25 mm, f/2, focused at 2 m, as one of the camera models sees it; at one wavelength or at all.
pub(crate) fn camera(model: Model, wavelength_nm: Option<f64>, [width, height]: [u32; 2]) -> Camera {
    Camera::new(&description(model, wavelength_nm), width, height).unwrap()
}

/// The description of the camera at [`EYE`].
pub(crate) fn description(model: Model, wavelength_nm: Option<f64>) -> CameraDescription {
    let up = Affine3A::from_rotation_x(PI / 2.0);
    let matrix = DMat4::from_translation(EYE) * glam::Mat4::from(up).as_dmat4();
    CameraDescription {
        model,
        matrix_world: matrix,
        lens_path: format!("{}/../../lenses/double-gauss-f2-available.lens", env!("CARGO_MANIFEST_DIR")).into(),
        wavelength_nm,
        ..CameraDescription::default()
    }
    .with(|c| {
        c.lens.focal_length = FocalLength::Millimetres(50.0);
        c.lens.f_number = Some(2.0);
        c.focus.distance = Some(2.0);
        c.film.width_mm = 36.0;
        c.film.height_mm = 20.25;
    })
}
