//! Lamps give the light that Blender's manual and Cycles' source of truth, closed forms, say.

use super::*;
use crate::sampler::warp;
use crate::scene::{SceneBuilder, lamp::Lamp, texture::Texture, world::World};
use glam::{DMat4, DVec3};
use std::f32::consts::PI;

fn lamp(kind: LampKind) -> Lamp {
    Lamp { object_name: "lamp".into(), kind, color: Rgb::new(10.0, 20.0, 30.0), ..Lamp::default() }
}

/// A lamp two units above the origin that shines down.
fn lights(kind: LampKind) -> (Scene, Lights) {
    let mut builder = SceneBuilder::new();
    builder.add_lamp(lamp(kind), DMat4::from_translation(DVec3::new(0.0, 0.0, 2.0))).unwrap();
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    (scene, lights)
}

fn at(lights: &Lights, position: Vec3A) -> Receiver {
    lights.receiver_between(position)
}

/// Irradiance on a floor at the origin that faces up, by samples.
fn irradiance(scene: &Scene, lights: &Lights) -> Rgb {
    let n = 4096;
    (0..n)
        .filter_map(|i| {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let s = lights.sample(scene, &at(lights, Vec3A::ZERO), u[0], [u[1], u[2]], Way::CAMERA)?;
            Some(s.radiance * s.wi.z.max(0.0) / s.pdf)
        })
        .sum::<Rgb>()
        / n as f32
}

#[test]
fn lamps_light_a_floor_as_closed_forms_say() {
    let watts = Rgb::new(10.0, 20.0, 30.0);
    // Intensity W / 4 pi, distance 2.
    let point = watts / (4.0 * PI) / 4.0;
    // Small square: radiance W / (pi A), solid angle A / 4.
    let small = watts / (4.0 * PI);
    // A disk of radius 1/2 seen face on from distance 2: radiance W / (pi A), irradiance pi L r^2 / (r^2 + d^2).
    let disk = watts / (4.0 * PI) / (0.25 + 4.0);
    // Sun of irradiance W, straight above.
    let cases = [
        (LampKind::Point { radius: 0.0, soft: false }, point),
        (LampKind::Point { radius: 0.01, soft: false }, point),
        (LampKind::Point { radius: 0.5, soft: false }, point),
        (LampKind::Point { radius: 0.5, soft: true }, disk),
        (LampKind::Spot { radius: 0.0, half_angle_rad: 0.5, blend: 0.1, soft: false }, point),
        (LampKind::Area { size: [0.02, 0.02], ellipse: false, half_spread_rad: PI / 2.0 }, small),
        (LampKind::Area { size: [0.02, 0.02], ellipse: true, half_spread_rad: PI / 2.0 }, small),
        (LampKind::Sun { half_angle_rad: 0.0 }, watts),
        (LampKind::Sun { half_angle_rad: 0.01 }, watts),
    ];
    for (kind, expected) in cases {
        let (scene, lights) = lights(kind);
        let found = irradiance(&scene, &lights);
        let ratio = found / expected;
        // A sphere lights a floor that it faces exactly like a point at its centre; samples are within 0.3 %.
        assert!((ratio - Rgb::ONE).abs().max_element() < 3e-3, "{kind:?}: {ratio}");
    }
}

/// A ray that happens to meet a lamp reports the density with which it would have been sampled.
#[test]
fn densities_of_hits_are_those_of_samples() {
    for kind in [
        LampKind::Point { radius: 0.3, soft: false },
        LampKind::Point { radius: 0.3, soft: true },
        LampKind::Area { size: [0.7, 0.4], ellipse: false, half_spread_rad: 1.0 },
        LampKind::Area { size: [0.7, 0.4], ellipse: true, half_spread_rad: PI / 2.0 },
        LampKind::Sun { half_angle_rad: 0.05 },
    ] {
        let (scene, lights) = lights(kind);
        for i in 0..500 {
            let u = sobol_burley::sample_4d(i, 0, 5);
            let from = Vec3A::new(0.3, -0.2, 0.0);
            let s = lights
                .sample(&scene, &at(&lights, from), u[0], [u[1] * 0.98 + 0.01, u[2] * 0.98 + 0.01], Way::CAMERA)
                .unwrap();
            let mut found = None;
            lights.lamps_along(&scene, from, s.wi, f32::INFINITY, Way::BOUNCE, Some(&at(&lights, from)), |r, pdf| {
                found = Some((r, pdf))
            });
            lights.sky_along(&scene, s.wi, Way::BOUNCE, Some(&at(&lights, from)), |r, pdf| {
                if pdf > 0.0 {
                    found = Some((r, pdf));
                }
            });
            let (radiance, pdf) = found.unwrap_or_else(|| panic!("{kind:?}: missed"));
            assert!((pdf / s.pdf - 1.0).abs() < 2e-3, "{kind:?}: {pdf} {}", s.pdf);
            assert!((radiance - s.radiance).abs().max_element() < 1e-2 * s.radiance.max_element(), "{kind:?}");
        }
    }
}

/// The sky's samples integrate its image: irradiance of a sky with one bright patch and one dim half.
#[test]
fn the_sky_is_sampled_by_its_brightness() {
    let (w, h) = (64, 32);
    let pixels: Vec<f32> = (0..w * h)
        .flat_map(|i| {
            let (x, y) = (i % w, i / w);
            let v = if (20..22).contains(&x) && (24..26).contains(&y) {
                500.0
            } else if y > 16 {
                0.5
            } else {
                0.1
            };
            [v, 0.5 * v, 2.0 * v, 1.0]
        })
        .collect();
    let mut builder = SceneBuilder::new();
    let t = builder.add_texture(Texture::from_floats("sky", w, h, &pixels, false).unwrap());
    let world = World { color: Rgb::ONE, texture: Some(t as u32), ..Default::default() };
    builder.set_world(world).unwrap();
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    let sampled = irradiance(&scene, &lights);
    let n = 60_000;
    let mut uniform = glam::DVec3::ZERO;
    for i in 0..n {
        let u = sobol_burley::sample_4d(i, 0, 9);
        let d = warp::sample_sphere([u[0], u[1]]);
        uniform += (scene.world.radiance(d, &scene.textures) * d.z.max(0.0) / warp::SPHERE_PDF).as_dvec3() / n as f64;
    }
    let ratio = sampled.as_dvec3() / uniform;
    assert!((ratio - glam::DVec3::ONE).abs().max_element() < 0.03, "{ratio}");
}

/// Emissive triangles: a large square seen from close by has irradiance near pi L, however it is cut and scaled.
#[test]
fn emissive_triangles_are_sampled_by_area() {
    use crate::scene::material::{Input, Material};
    use crate::scene::mesh::MeshDescription;
    let mut builder = SceneBuilder::new();
    let glow = Material {
        emission_color: Input::Constant(Rgb::new(1.0, 2.0, 3.0)),
        emission_strength: 2.0,
        ..Material::default_grey()
    };
    let m = builder.add_material(glow).unwrap();
    let p = |x: f32, y: f32| glam::Vec3::new(x, y, 0.0);
    let mesh = builder
        .add_mesh(MeshDescription {
            name: "square".into(),
            positions: vec![p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        })
        .unwrap();
    let matrix = DMat4::from_translation(DVec3::Z) * DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0));
    builder.add_instance("square", mesh, matrix, &[m], true, true).unwrap();
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    let found = irradiance(&scene, &lights);
    // Irradiance of a parallel rectangle 2a x 2b at distance 1 over its centre (Howell, configuration B-4).
    let (a, b) = (1.0f32, 2.0f32);
    let term = |x: f32, y: f32| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    let expected = Rgb::new(2.0, 4.0, 6.0) * (2.0 * (term(a, b) + term(b, a)));
    assert!((found / expected - Rgb::ONE).abs().max_element() < 5e-3, "{found} {expected}");
}

/// The sky is chosen the more, the more of it is seen and the farther the lamps are; and whatever it is told of the sky,
/// the light that it finds is the same.
#[test]
fn the_sky_is_chosen_by_what_it_brings() {
    let mut builder = SceneBuilder::new();
    let pixels: Vec<f32> = (0..16 * 8).flat_map(|i| [0.5, 0.6, 0.1 * (i % 7) as f32, 1.0]).collect();
    let t = builder.add_texture(Texture::from_floats("sky", 16, 8, &pixels, false).unwrap());
    builder.set_world(World { color: Rgb::ONE, texture: Some(t as u32), ..Default::default() }).unwrap();
    let place = DMat4::from_translation(DVec3::new(0.0, 0.0, 2.0));
    builder.add_lamp(lamp(LampKind::Point { radius: 0.1, soft: false }), place).unwrap();
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    let chance = |z: f32, openness: f32| lights.receiver(Vec3A::new(0.0, 0.0, z), None, openness).sky_chance;
    assert!(chance(1.8, 1.0) < 0.5 && chance(-20.0, 1.0) > 0.8);
    assert!(chance(0.0, 0.01) < chance(0.0, 0.5) && chance(0.0, 0.5) < chance(0.0, 1.0));
    assert!(chance(1.9, 0.0) >= LEAST_CHANCE && chance(-1e6, 1.0) <= 1.0 - LEAST_CHANCE);
    let found = |openness: f32| {
        let to = lights.receiver(Vec3A::ZERO, None, openness);
        let n = 1 << 15;
        let light = |i: u32| {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let s = lights.sample(&scene, &to, u[0], [u[1], u[2]], Way::CAMERA)?;
            Some((s.radiance * s.wi.z.max(0.0) / s.pdf).as_dvec3())
        };
        (0..n).filter_map(light).sum::<glam::DVec3>() / f64::from(n)
    };
    let (little, much) = (found(0.02), found(1.0));
    // Where a light gets few of the samples, its part of the noise of 2^15 is about a percent.
    assert!((little / much - 1.0).abs().max_element() < 0.02, "{little} {much}");
}

/// An object's light samples all go to lamps that light it, and their chances there add up to one.
#[test]
fn lamps_that_do_not_light_an_object_take_none_of_its_samples() {
    let mut builder = SceneBuilder::new();
    let quad = crate::scene::mesh::MeshDescription {
        name: "quad".into(),
        positions: vec![glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(quad).unwrap();
    for set in 1..3u8 {
        let instance = builder.add_instance("object", mesh, DMat4::IDENTITY, &[], true, true).unwrap().unwrap();
        builder.set_links(instance, Links { receives: 1 << set, ..Links::default() });
        for i in 0..3 {
            let sets = Sets { receivers: set, blockers: 0 };
            let place = DVec3::new(f64::from(i), f64::from(set), 2.0);
            let lamp = Lamp { sets, ..lamp(LampKind::Point { radius: 0.1, soft: false }) };
            builder.add_lamp(lamp, DMat4::from_translation(place)).unwrap();
        }
    }
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    for (instance, links) in scene.instances.iter().map(|instance| instance.links).enumerate() {
        let to = lights.receiver_on(instance as u32, Vec3A::ZERO, None, 0.5);
        for i in 0..64 {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let (sample, source) = lights.sample_source(&scene, &to, u[0], [u[1], u[2]], Way::CAMERA).unwrap();
            assert!(links.takes_light_of(sample.sets) && links.takes_light_of(lights.sets(source)));
        }
        let tree = lights.trees[to.tree as usize].as_ref().unwrap();
        let chances: f32 = (0..6).map(|lamp| tree.probability(&to, lamp)).sum();
        // Rounding of six products.
        assert!((chances - 1.0).abs() < 1e-5);
    }
}
