//! Scenes with a known answer.

use super::*;
use crate::sampler::warp;
use crate::scene::closure::{Closure, Principled};
use crate::scene::lamp::{Lamp, LampKind};
use crate::scene::material::Material;
use crate::scene::mesh::MeshDescription;
use crate::scene::{SceneBuilder, world::World};
use glam::{DMat4, DVec3, Vec3, Vec3A};
use std::f64::consts::PI;

fn limits(max_bounces: u32) -> Limits {
    Limits {
        max_bounces,
        kinds: KindLimits::default(),
        clamp_direct: f32::INFINITY,
        clamp_indirect: f32::INFINITY,
        approximations: Approximations::default(),
        hide_sky: false,
        film_glass: None,
        openness: 0.5,
        roulette: f32::INFINITY,
    }
}

fn cube() -> MeshDescription {
    let positions =
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - Vec3::ONE).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    MeshDescription { name: "cube".into(), positions, triangles, ..Default::default() }
}

fn stage(material: Material, world: Rgb, size: f64) -> PreparedScene {
    let mut builder = SceneBuilder::new();
    let m = builder.add_material(material);
    let mesh = builder.add_mesh(cube()).unwrap();
    builder.add_instance("cube", mesh, DMat4::from_scale(DVec3::splat(size)), &[m], true, true).unwrap();
    builder.set_world(World { color: world, ..Default::default() }).unwrap();
    PreparedScene::new(builder.build(DVec3::ZERO))
}

fn mean(stage: &PreparedScene, origin: Vec3A, max_bounces: u32, n: u32) -> Rgb {
    let mut sum = glam::DVec3::ZERO;
    for i in 0..n {
        let mut sampler = PathSampler::new(0, 0, i, 1);
        let u = sampler.next_4d();
        let d = warp::sample_sphere([u[0], u[1]]);
        sum += trace(stage, Ray::new(origin, d), &limits(max_bounces), &mut sampler).radiance.as_dvec3();
    }
    (sum / n as f64).as_vec3()
}

fn plain(albedo: f32, emission: f32) -> Material {
    Material::diffuse("plain", Rgb::splat(albedo), Rgb::splat(emission))
}

/// A closed box that emits radiance 1 and reflects half: 1 + 1/2 + 1/4 ... = 2, seen from anywhere inside.
/// Every bounce is found by light samples and by scattering; their weights must add to one.
#[test]
fn a_glowing_box_sums_its_series() {
    for size in [1e-3, 1.0, 1e4] {
        let stage = stage(plain(0.5, 1.0), Rgb::ZERO, size);
        let inside = Vec3A::new(0.3, -0.2, 0.5) * size as f32;
        for (bounces, expected) in [(0, 1.5), (1, 1.75), (2, 1.875), (100, 2.0)] {
            let found = mean(&stage, inside, bounces, 8192);
            // 8192 stratified paths of a smooth integrand.
            assert!((found - Rgb::splat(expected)).abs().max_element() < 0.01, "{size} {bounces}: {found}");
        }
    }
}

/// A small square that emits light close to a floor, far from where numbers are fine: it must not shadow its own light.
#[test]
fn what_glows_nearby_lights_fully() {
    let square = |half: f32, z: f32| MeshDescription {
        name: "square".into(),
        positions: [[-1, -1], [1, -1], [1, 1], [-1, 1]]
            .map(|[x, y]| Vec3::new(x as f32 * half, y as f32 * half, z))
            .into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    };
    // What a square sends to a place under its middle that is half a side away, of all that it could (Howell, A Catalog of Radiation
    // Heat Transfer Configuration Factors, B-4).
    let expected = 4.0 / PI * 0.5f64.sqrt() * 0.5f64.sqrt().atan();
    for distance in [3e-3, 0.03, 1.0] {
        let mut builder = SceneBuilder::new();
        let [floor, glow] = [plain(1.0, 0.0), plain(0.0, 1.0)].map(|m| builder.add_material(m));
        let place = DMat4::from_translation(DVec3::new(3.1, -2.3, 1.7));
        for (half, z, material) in [(9.0, 0.0, floor), (distance, distance, glow)] {
            let mesh = builder.add_mesh(square(half, z)).unwrap();
            builder.add_instance("square", mesh, place, &[material], true, true).unwrap();
        }
        let stage = PreparedScene::new(builder.build(DVec3::ZERO));
        let (n, mut sum) = (4096, 0.0);
        for i in 0..n {
            let mut sampler = PathSampler::new(0, 0, i, 1);
            let from = Vec3A::new(3.1, -2.3, 1.7 + 0.5 * distance);
            sum += f64::from(trace(&stage, Ray::new(from, Vec3A::NEG_Z), &limits(0), &mut sampler).radiance.x);
        }
        let found = sum / f64::from(n);
        // A ray's start is moved by a two hundredth of the least distance; and noise.
        assert!((found / expected - 1.0).abs() < 0.01, "{distance}: {found} for {expected}");
    }
}

/// A white object in a uniform white world is invisible: matte exactly, mixtures within their tables.
#[test]
fn white_furnace() {
    let glossy = |metallic: f32, transmission: f32, roughness: f32| {
        let white = Principled { base_color: Rgb::ONE, metallic, transmission, roughness, ..Principled::default() };
        Material::principled("glossy", white)
    };
    let cases = [
        (plain(1.0, 0.0), 0.005),
        (glossy(1.0, 0.0, 0.5), 0.02),
        (glossy(1.0, 0.0, 0.0), 0.005),
        (glossy(0.0, 1.0, 0.0), 0.005),
        // Light goes through rough glass many times; each passage has the tables' error.
        (glossy(0.0, 1.0, 0.5), 0.06),
        (glossy(0.0, 0.0, 0.5), 0.02),
    ];
    for (k, (material, tolerance)) in cases.into_iter().enumerate() {
        let stage = stage(material, Rgb::ONE, 1.0);
        let found = mean(&stage, Vec3A::new(0.0, 0.0, 3.0), 200, 8192);
        assert!((found - Rgb::ONE).abs().max_element() < tolerance, "case {k}: {found}");
    }
}

/// Half-transparent walls around a point let light of the world and of lamps through by their alpha.
#[test]
fn alpha_lets_light_through() {
    let black = Closure::Diffuse { color: Rgb::ZERO, roughness: 0.0 };
    let material = Material::even("sheet", [(0.25, black), (0.75, Closure::Transparent { color: Rgb::ONE })]);
    let see_through = stage(material.clone(), Rgb::ONE, 1.0);
    let found = mean(&see_through, Vec3A::ZERO, 10, 8192);
    assert!((found - Rgb::splat(0.75)).abs().max_element() < 0.01, "{found}");

    // A floor lit by a lamp through a sheet of that: the lamp's irradiance times 3/4 over pi.
    let mut builder = SceneBuilder::new();
    let sheet = builder.add_material(material);
    let floor = builder.add_material(plain(1.0, 0.0));
    let square = MeshDescription {
        name: "square".into(),
        positions: vec![
            Vec3::new(-9.0, -9.0, 0.0),
            Vec3::new(9.0, -9.0, 0.0),
            Vec3::new(9.0, 9.0, 0.0),
            Vec3::new(-9.0, 9.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(square).unwrap();
    builder.add_instance("floor", mesh, DMat4::IDENTITY, &[floor], true, true).unwrap();
    builder.add_instance("sheet", mesh, DMat4::from_translation(DVec3::Z), &[sheet], true, true).unwrap();
    let lamp = Lamp {
        object_name: "lamp".into(),
        kind: LampKind::Point { radius: 0.0, soft: false },
        color: Rgb::splat(100.0),
        ..Lamp::default()
    };
    builder.add_lamp(lamp, DMat4::from_translation(DVec3::new(0.0, 0.0, 2.0))).unwrap();
    let stage = PreparedScene::new(builder.build(DVec3::ZERO));
    let mut sampler = PathSampler::new(0, 0, 0, 1);
    // Off the diagonal, where two triangles of the sheet meet.
    let ray = Ray::new(Vec3A::new(0.02, 0.01, 0.5), -Vec3A::Z);
    let found = trace(&stage, ray, &limits(0), &mut sampler).radiance.x;
    let pi = std::f32::consts::PI;
    let expected = 100.0 / (4.0 * pi) / 4.0 / pi * 0.75;
    // The floor is hit 0.02 off the lamp's axis: cos^4 of a hundredth of a radian.
    assert!((found / expected - 1.0).abs() < 5e-4, "{found} {expected}");
}

/// Light that is seen or scattered once is clamped by one limit, light that is scattered more often by the other.
#[test]
fn clamping_tells_direct_light_from_indirect() {
    let stage = stage(plain(0.5, 100.0), Rgb::ZERO, 1.0);
    let one = |max_bounces: u32, clamp_direct: f32, clamp_indirect: f32| {
        let mut sampler = PathSampler::new(0, 0, 0, 1);
        let limits = Limits { clamp_direct, clamp_indirect, ..limits(max_bounces) };
        trace(&stage, Ray::new(Vec3A::new(0.3, -0.2, 0.5), Vec3A::X), &limits, &mut sampler).radiance.x
    };
    let no_limit = f32::INFINITY;
    // Glow 100, seen directly, and what is scattered once: found by a light sample, and hit by the path.
    let direct = one(0, no_limit, 1e-3);
    assert!(direct > 101.0, "{direct}");
    let clamped = one(0, 1.0, no_limit);
    assert!(clamped > 1.0 && clamped < 3.0 + 1e-5, "{clamped}");
    // One scattering more is two such parts more.
    let (free, clamped) = (one(1, no_limit, no_limit), one(1, no_limit, 1e-3));
    assert!(free > direct + 1.0 && clamped > direct && clamped < direct + 2e-3 + 1e-4, "{direct} {free} {clamped}");
}

/// Inside a closed box nothing of the sky is seen; from the outside of one that stands alone, all of it.
#[test]
fn openness_is_what_is_seen_of_the_sky() {
    let stage = stage(plain(0.5, 0.0), Rgb::ONE, 1.0);
    let rays = |from: Vec3A, sign: f32| {
        (0..200)
            .map(move |i| {
                let u = PathSampler::new(i, 0, 0, 1).next_4d();
                let d = warp::sample_sphere([u[0], u[1]]);
                Ray::new(from + d * (1.0 - sign) * 5.0, d * sign)
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(openness(&stage, &rays(Vec3A::new(0.1, 0.2, 0.3), 1.0)), 0.0);
    assert_eq!(openness(&stage, &rays(Vec3A::ZERO, -1.0)), 1.0);
    assert_eq!(openness(&stage, &[]), 0.5);
}

/// Paths find the same light however soon Russian roulette ends them: a box of albedo 0.8 that emits light, where each bounce counts.
#[test]
fn paths_that_end_by_chance_find_the_same_light() {
    let stage = stage(plain(0.8, 1.0), Rgb::ZERO, 1.0);
    for roulette in [0.6, 2.0, f32::INFINITY] {
        let limits = Limits { roulette, ..limits(40) };
        let n = 1 << 15;
        let one = |i: u32| {
            let mut sampler = PathSampler::new(0, 0, i, 1);
            let u = sampler.next_4d();
            let ray = Ray::new(Vec3A::new(0.3, -0.2, 0.5), warp::sample_sphere([u[0], u[1]]));
            f64::from(trace(&stage, ray, &limits, &mut sampler).radiance.x)
        };
        let found = (0..n).map(one).sum::<f64>() / f64::from(n);
        // 1 / (1 - 0.8); paths that end soon find 5 with a deviation of about as much: 2^15 of them within 3 %, and 0.8^40 is nothing.
        assert!((found / 5.0 - 1.0).abs() < 0.08, "{roulette}: {found}");
    }
}
