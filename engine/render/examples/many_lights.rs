//! The cost of many emitters: `cargo run --release -p petzval-render --example many_lights`.
//!
//! A floor of 10 x 10 under lamps or emitting triangles that hang at random over it and send as much light all together, however many they
//! are. Prints the time of a sample, and its noise: relative mean squared error times samples; the least time of some rounds, place by
//! place, which others on the machine disturb least. Beside many that shine, as many of which ten do: what more things in the scene cost,
//! whatever shines. A number in the command is their largest count.

use glam::{DMat4, DVec3, Vec3, Vec3A};
use petzval_render::Rgb;
use petzval_render::accel::Ray;
use petzval_render::integrator::PreparedScene;
use petzval_render::integrator::path::{Approximations, KindLimits, Limits, Wavefront};
use petzval_render::sampler::PathSampler;
use petzval_render::scene::SceneBuilder;
use petzval_render::scene::lamp::{Lamp, LampKind};
use petzval_render::scene::material::Material;
use petzval_render::scene::mesh::MeshDescription;
use std::time::Instant;

/// Number of the floor's places that are looked at, along each side.
const SIDE: u32 = 16;
const SAMPLES: u32 = 128;
const ROUNDS: u32 = 30;

fn place(i: u32) -> DVec3 {
    let u = sobol_burley::sample_4d(i % 65_536, 0, i / 65_536);
    DVec3::new(f64::from(u[0]) * 10.0 - 5.0, f64::from(u[1]) * 10.0 - 5.0, 1.5 + f64::from(u[2]) * 2.0)
}

fn quad(half: f32) -> MeshDescription {
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, 0.0);
    MeshDescription {
        name: "quad".into(),
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    }
}

/// A room with `count` objects of which `shining` emit.
fn room(kind: &str, count: u32, shining: u32) -> Result<PreparedScene, Box<dyn std::error::Error>> {
    let mut builder = SceneBuilder::new();
    let floor = builder.add_mesh(quad(5.0))?;
    builder.add_instance("floor", floor, DMat4::IDENTITY, &[], true, true)?;
    let (part, brightness) = (1.0 / count as f32, count as f32 / shining as f32);
    // Those that shine lie all over the list.
    let shines = |i: u32| i.is_multiple_of(count / shining) && i / (count / shining) < shining;
    if kind == "triangles" {
        // One mesh, as a lit sign or a chandelier is.
        let half = 0.05 * part.sqrt() * 10f32.sqrt();
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for i in 0..count {
            let at = place(i).as_vec3();
            let first = positions.len() as u32;
            positions.extend([Vec3::X, Vec3::Y, -Vec3::X].map(|corner| at + corner * half));
            triangles.push([first, first + 2, first + 1]);
        }
        let lit = Material::diffuse("lit", Rgb::splat(0.8), Rgb::splat(1000.0 * brightness));
        let materials = [lit, Material::default_grey()].map(|material| builder.add_material(material));
        let material_slots = Some((0..count).map(|i| u32::from(!shines(i))).collect());
        let lit = MeshDescription { name: "lit".into(), positions, triangles, material_slots, ..Default::default() };
        let mesh = builder.add_mesh(lit)?;
        builder.add_instance("lit", mesh, DMat4::IDENTITY, &materials, true, true)?;
    } else {
        let radius = if kind == "points" { 0.0 } else { 0.05 * part.sqrt() * 10f32.sqrt() };
        for i in 0..count {
            let kind = LampKind::Point { radius, soft: false };
            let watts = if shines(i) { 1000.0 * part * brightness } else { 0.0 };
            let lamp = Lamp { kind, color: Rgb::splat(watts), ..Lamp::default() };
            builder.add_lamp(lamp, DMat4::from_translation(place(i)))?;
        }
    }
    Ok(PreparedScene::new(builder.build(DVec3::ZERO)))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let limits = Limits {
        max_bounces: 2,
        kinds: KindLimits::default(),
        clamp_direct: f32::INFINITY,
        clamp_indirect: f32::INFINITY,
        approximations: Approximations::default(),
        hide_sky: false,
        film_glass: None,
        openness: 0.5,
        roulette: f32::INFINITY,
    };
    let most: u32 = std::env::args().nth(1).map_or(Ok(1_000_000), |word| word.parse())?;
    let only = std::env::args().nth(2);
    for kind in
        ["points", "balls", "triangles"].into_iter().filter(|kind| only.as_ref().is_none_or(|only| only == kind))
    {
        for count in [10, 10_000, 1_000_000].into_iter().filter(|&count| count <= most) {
            // Points that do not shine are nowhere.
            let has_others = count > 10 && kind != "points";
            for shining in has_others.then_some(10).into_iter().chain([count]) {
                let begun = Instant::now();
                let stage = room(kind, count, shining)?;
                let built = begun.elapsed().as_secs_f64();
                let mut least = vec![f64::INFINITY; (SIDE * SIDE) as usize];
                let noise = (0..ROUNDS).map(|_| look(&stage, &limits, &mut least)).fold(0.0, f64::max);
                let us = least.iter().sum::<f64>() * 1e6 / f64::from(SIDE * SIDE * SAMPLES);
                let of = format!("{shining} of {count}");
                println!("{of:>18} {kind:9}: {us:.2} us a sample, noise {noise:.4}, ready in {built:.2} s");
            }
        }
    }
    Ok(())
}

/// Follows all paths; gives their noise, and notes where a place took less time than ever.
fn look(stage: &PreparedScene, limits: &Limits, least: &mut [f64]) -> f64 {
    let mut wave: Wavefront = Wavefront::default();
    let mut noise = 0.0;
    for pixel in 0..SIDE * SIDE {
        let begun = Instant::now();
        wave.clear();
        let target = |k: u32| (k as f32 + 0.5) / SIDE as f32 * 8.0 - 4.0;
        let at = Vec3A::new(target(pixel % SIDE), target(pixel / SIDE), 0.0);
        for index in 0..SAMPLES {
            let mut sampler = PathSampler::new(pixel, 0, index, 1);
            sampler.jump_to(petzval_render::integrator::path::CAMERA_SETS);
            wave.start(Ray::new(at + Vec3A::Z, -Vec3A::Z), sampler);
        }
        wave.follow(stage, limits);
        let least = &mut least[pixel as usize];
        *least = least.min(begun.elapsed().as_secs_f64());
        let light = |i: u32| f64::from(wave.found(i as usize).radiance.x);
        let mean = (0..SAMPLES).map(light).sum::<f64>() / f64::from(SAMPLES);
        let square = (0..SAMPLES).map(|i| (light(i) - mean).powi(2)).sum::<f64>() / f64::from(SAMPLES - 1);
        noise += square / (mean * mean) / f64::from(SIDE * SIDE);
    }
    noise
}
