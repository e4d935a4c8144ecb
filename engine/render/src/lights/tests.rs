//! Lamps give the light that Blender's manual and Cycles' source of truth, closed forms, say.

use super::*;
use crate::Rgb;
use crate::sampler::warp;
use crate::scene::lamp::{Lamp, LampKind};
use crate::scene::material::Material;
use crate::scene::mesh::MeshDescription;
use crate::scene::visibility::LightLinking;
use crate::scene::{SceneBuilder, texture::Texture, world::World};
use glam::{DMat4, DVec3, Vec3};
use std::f32::consts::PI;

fn lamp(kind: LampKind) -> Lamp {
    Lamp { object_name: "lamp".into(), kind, color: Rgb::new(10.0, 20.0, 30.0), ..Lamp::default() }
}

/// A lamp two units above the origin that emits downwards.
fn lights(kind: LampKind) -> (Scene, Lights) {
    let mut builder = SceneBuilder::new();
    builder.add_lamp(lamp(kind), DMat4::from_translation(DVec3::new(0.0, 0.0, 2.0))).unwrap();
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    (scene, lights)
}

fn at(lights: &Lights, position: Vec3A) -> LightSampleContext {
    lights.receiver_between(position)
}

/// Irradiance on a floor at the origin that faces up, by samples.
fn irradiance(scene: &Scene, lights: &Lights) -> Rgb {
    let n = 4096;
    (0..n)
        .filter_map(|i| {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let s = lights.sample(scene, &at(lights, Vec3A::ZERO), u[0], [u[1], u[2]], PathState::CAMERA)?;
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

/// A ray that happens to hit a lamp reports the density with which it would have been sampled.
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
                .sample(&scene, &at(&lights, from), u[0], [u[1] * 0.98 + 0.01, u[2] * 0.98 + 0.01], PathState::CAMERA)
                .unwrap();
            let mut found = None;
            let (line, to) = (Line { from, towards: s.wi, t_max: f32::INFINITY }, at(&lights, from));
            lights.lamps_along(&scene, line, PathState::BOUNCE, Some(&to), |one| found = Some((one.radiance, one.pdf)));
            lights.sky_along(&scene, s.wi, PathState::BOUNCE, Some(&to), |one| {
                if one.pdf > 0.0 {
                    found = Some((one.radiance, one.pdf));
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
    use crate::scene::material::Material;
    use crate::scene::mesh::MeshDescription;
    let mut builder = SceneBuilder::new();
    let m = builder.add_material(Material::diffuse("glow", Rgb::ONE, Rgb::new(2.0, 4.0, 6.0)));
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

/// A tree of two materials, copied until its leaves are more than light samples can know: these are left to closure samples, the fruit is
/// not. (A scene by others has 66 million emissive triangles of leaves, for which the lights took ten gigabytes.)
#[test]
fn leaves_beyond_number_take_no_memory() {
    const LEAVES: u32 = 4096;
    let mut builder = SceneBuilder::new();
    let materials =
        ["leaf", "fruit"].map(|name| builder.add_material(Material::diffuse(name, Rgb::ONE, Rgb::splat(1.0))));
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner * 0.01);
    let tree = MeshDescription {
        name: "tree".into(),
        positions: (0..=LEAVES).flat_map(|i| corners.map(|corner| corner + Vec3::Z * i as f32)).collect(),
        triangles: (0..=LEAVES).map(|i| [0, 1, 2].map(|corner| 3 * i + corner)).collect(),
        material_slots: Some((0..=LEAVES).map(|i| u32::from(i == LEAVES)).collect()),
        ..Default::default()
    };
    let tree = builder.add_mesh(tree).unwrap();
    for i in 0..1024 {
        let matrix = DMat4::from_translation(DVec3::X * f64::from(i));
        builder.add_instance("tree", tree, matrix, &materials, true, true).unwrap();
    }
    let lights = Lights::new(&builder.build(DVec3::ZERO));
    assert_eq!(lights.local.len(), 1024);
    assert!(lights.triangle_source(0, LEAVES).is_some() && lights.triangle_source(0, 0).is_none());
}

#[test]
fn materials_of_the_most_triangles_are_left_first() {
    let left = |most| {
        let mut brightness = [1.0, 2.0, 0.0, 3.0];
        local::leave_most(&mut brightness, &[10, 500, 10_000, 40], most);
        brightness
    };
    assert_eq!(left(550), [1.0, 2.0, 0.0, 3.0]);
    assert_eq!(left(549), [1.0, 0.0, 0.0, 3.0]);
    assert_eq!(left(49), [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(left(9), [0.0; 4]);
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
            let s = lights.sample(&scene, &to, u[0], [u[1], u[2]], PathState::CAMERA)?;
            Some((s.radiance * s.wi.z.max(0.0) / s.pdf).as_dvec3())
        };
        (0..n).filter_map(light).sum::<glam::DVec3>() / f64::from(n)
    };
    let (little, much) = (found(0.02), found(1.0));
    // Where a light gets few of the samples, its part of the noise of 2^15 is about a percent.
    assert!((little / much - 1.0).abs().max_element() < 0.02, "{little} {much}");
}

/// An object's light samples all go to lamps that light it, and the probabilities of these add up to one.
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
        builder.set_links(instance, LightLinking { receives: 1 << set, ..LightLinking::default() });
        for i in 0..3 {
            let sets = LightSets { receivers: set, blockers: 0 };
            let place = DVec3::new(f64::from(i), f64::from(set), 2.0);
            let lamp = Lamp { sets, ..lamp(LampKind::Point { radius: 0.1, soft: false }) };
            builder.add_lamp(lamp, DMat4::from_translation(place)).unwrap();
        }
    }
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    for (instance, links) in scene.instances.iter().map(|instance| instance.links).enumerate() {
        let to = lights.receiver_on(instance as u32, false, Vec3A::ZERO, None, 0.5);
        for i in 0..64 {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let (sample, source) = lights.sample_source(&scene, &to, u[0], [u[1], u[2]], PathState::CAMERA).unwrap();
            assert!(links.takes_light_of(sample.sets) && links.takes_light_of(lights.sets(source)));
        }
        let tree = lights.trees[to.tree as usize].as_ref().unwrap();
        let chances: f32 = (0..6).map(|lamp| tree.probability(&to, lamp)).sum();
        // Rounding of six products.
        assert!((chances - 1.0).abs() < 1e-5);
    }
}

/// A ceiling of lamps and triangles that face down, of powers that differ a thousandfold.
fn crowd(count: u32, unequal: bool, with_lamps: bool) -> (Scene, Lights) {
    let mut builder = SceneBuilder::new();
    let (mut positions, mut triangles, mut slots) = (Vec::new(), Vec::new(), Vec::new());
    let power = |u: f32| if unequal { 1000f32.powf(u) } else { 100.0 };
    for i in 0..count {
        let u = sobol_burley::sample_4d(i, 0, 21);
        let place = Vec3::new(u[0] * 10.0 - 5.0, u[1] * 10.0 - 5.0, 1.0 + u[2] * 2.0);
        if with_lamps && i % 2 == 0 {
            let kind = LampKind::Point { radius: 0.0, soft: false };
            let lamp = Lamp { color: Rgb::splat(1e-4 * power(u[3])), ..lamp(kind) };
            builder.add_lamp(lamp, DMat4::from_translation(place.as_dvec3())).unwrap();
        } else {
            let first = positions.len() as u32;
            positions.extend([Vec3::X, Vec3::Y, -Vec3::X].map(|corner| place + corner * 2e-3));
            triangles.push([first, first + 2, first + 1]);
            slots.push((u[3] * 8.0) as u32);
        }
    }
    let strength = |slot: u32| power((slot as f32 + 0.5) / 8.0);
    let materials: Vec<usize> = (0..8)
        .map(|slot| builder.add_material(Material::diffuse("lit", Rgb::ONE, Rgb::splat(strength(slot)))))
        .collect();
    let material_slots = Some(slots);
    let mesh = MeshDescription { name: "lit".into(), positions, triangles, material_slots, ..Default::default() };
    let mesh = builder.add_mesh(mesh).unwrap();
    builder.add_instance("lit", mesh, DMat4::IDENTITY, &materials, true, true).unwrap();
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    (scene, lights)
}

/// The light of each emitter of a crowd on a floor that faces up, by closed forms; that of the tiny triangles as if all were in their
/// middles.
fn brought(scene: &Scene, lights: &Lights, from: Vec3A) -> Vec<f64> {
    let of = |emitter: Emitter<'_>| {
        let (place, strength) = match emitter {
            Emitter::Lamp(i) => {
                let lamp = &scene.lamps[i as usize];
                (lamp.to_render.translation, f64::from(lamp.color.x) / (4.0 * f64::from(PI)))
            }
            Emitter::Triangle(triangle) | Emitter::Moving(triangle, _) => {
                let [a, b, c] = triangle::placed_corners(scene, triangle.instance, triangle.triangle);
                let slot = scene.meshes[0].slot(triangle.triangle);
                let material = &scene.materials[scene.instances[0].material(slot) as usize];
                let place = (a + b + c) / 3.0;
                let area = 0.5 * (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
                let cos = f64::from((place - from).normalize().z.abs());
                (place, f64::from(material.graph.brightness()) * area * cos)
            }
        };
        let to = (place - from).as_dvec3();
        strength * (to.z / to.length()).max(0.0) / to.length_squared()
    };
    lights.local.iter().map(of).collect()
}

/// The mean of light samples of ten thousand emitters of unequal power is the sum over all of them.
#[test]
fn samples_of_many_emitters_bring_what_all_bring_together() {
    let (scene, lights) = crowd(10_000, true, true);
    for from in [Vec3A::new(0.3, 0.2, 0.0), Vec3A::new(-4.5, 3.0, 0.5), Vec3A::new(1.0, -2.0, 2.0)] {
        let expected: f64 = brought(&scene, &lights, from).iter().sum();
        let to = lights.receiver(from, Some(Vec3A::Z), 0.5);
        let (mut sum, mut squares, n) = (0.0, 0.0, 1 << 16);
        for i in 0..n {
            let u = sobol_burley::sample_4d(i, 0, 31);
            let Some((s, source)) = lights.sample_source(&scene, &to, u[0], [u[1], u[2]], PathState::CAMERA) else {
                continue;
            };
            let light = f64::from(s.radiance.x * s.wi.z.max(0.0) / s.pdf);
            sum += light / f64::from(n);
            squares += light * light / f64::from(n);
            // A ray that hit the triangle would say the same of its density.
            if let Some(Emitter::Triangle(triangle)) = lights.local.get(source.0) {
                let hit = (triangle.instance, triangle.triangle);
                let pdf =
                    lights.triangle_pdf(&scene, &to, hit, s.distance / (1.0 - 1e-4), triangle.normal().dot(s.wi).abs());
                assert!((pdf / s.pdf - 1.0).abs() < 2e-3, "{pdf} {}", s.pdf);
            }
        }
        // Four times what random numbers leave; these are more even than random ones.
        let error = ((squares / (sum * sum) - 1.0) / f64::from(n)).sqrt();
        assert!((sum / expected - 1.0).abs() < 4.0 * error, "{from}: {sum} {expected} {error}");
        assert!(error < 4e-3, "{error}");
    }
}

/// Many emitters are chosen nearly in proportion to their light: relative variance of one light sample under triangles that
/// face down. It was 0.06 to 0.1 while parallel normals joined to a cone of all directions, and 0.03 while nothing looked into
/// the parts under the root.
#[test]
fn many_emitters_are_chosen_by_what_they_bring() {
    let (scene, lights) = crowd(10_000, false, false);
    let mut mean = 0.0;
    for k in 0..16 {
        let u = sobol_burley::sample_4d(k, 0, 41);
        let from = Vec3A::new(u[0] * 8.0 - 4.0, u[1] * 8.0 - 4.0, -0.5);
        let to = lights.receiver(from, Some(Vec3A::Z), 0.5);
        let tree = lights.tree(&to).unwrap();
        let light = brought(&scene, &lights, from);
        let total: f64 = light.iter().sum();
        let squares: f64 =
            light.iter().enumerate().map(|(i, light)| light * light / f64::from(tree.probability(&to, i))).sum();
        mean += (squares / (total * total) - 1.0) / 16.0;
    }
    assert!(mean < 0.02, "{mean}");
}

/// Suns by their light on a surface that faces up: those below its horizon are never chosen, and each sample of the others brings the
/// same but for the size of the discs.
#[test]
fn suns_are_chosen_by_what_they_give_here() {
    let mut builder = SceneBuilder::new();
    for (i, tilt) in [0.2, 0.9, 1.3, 1.5, 2.5].into_iter().enumerate() {
        let kind = LampKind::Sun { half_angle_rad: if i == 0 { 0.0 } else { 0.02 } };
        let turned = DMat4::from_rotation_z(1.3 * i as f64) * DMat4::from_rotation_x(tilt);
        builder.add_lamp(Lamp { color: Rgb::splat(1.0 + i as f32), ..lamp(kind) }, turned).unwrap();
    }
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    let to = lights.receiver(Vec3A::ZERO, Some(Vec3A::Z), 0.5);
    let (mut found, n) = (Vec::new(), 4096);
    for i in 0..n {
        let u = sobol_burley::sample_4d(i, 0, 3);
        let (s, source) = lights.sample_source(&scene, &to, u[0], [u[1], u[2]], PathState::CAMERA).unwrap();
        assert!(s.wi.z > 0.0);
        found.push(s.radiance.x * s.wi.z / s.pdf);
        // A ray that finds the sun gives the density of the sample.
        if !s.point_like {
            let mut met = None;
            lights.sky_along(&scene, s.wi, PathState::BOUNCE, Some(&to), |one| {
                met = met.or((one.source == source).then_some(one))
            });
            assert!((met.unwrap().pdf / s.pdf - 1.0).abs() < 1e-4);
        }
    }
    let mean = found.iter().sum::<f32>() / n as f32;
    let spread = (found.iter().map(|x| (x / mean - 1.0).powi(2)).sum::<f32>() / n as f32).sqrt();
    let truth = [0.2f32, 0.9, 1.3, 1.5].iter().enumerate().map(|(i, tilt)| (1.0 + i as f32) * tilt.cos()).sum::<f32>();
    assert!((mean / truth - 1.0).abs() < 2e-3, "{mean} {truth}");
    // Tilted by 1.5 rad, cosines in a disc of 0.02 rad differ by a quarter; that sun gives a twelfth.
    assert!(spread < 0.1, "{spread}");
}

/// A lamp in the plane of a ceiling lights the room below, wherever the room is: neither sample nor ray ends at the ceiling.
#[test]
fn a_lamp_in_the_plane_of_a_ceiling_is_not_hidden_by_it() {
    let kinds = [
        LampKind::Area { size: [0.7, 0.3], ellipse: false, half_spread_rad: PI / 2.0 },
        LampKind::Point { radius: 0.0, soft: false },
    ];
    for kind in kinds {
        for place in 0..40 {
            let away = DVec3::new(1.7, -0.9, 2.3) * f64::from(place);
            let mut builder = SceneBuilder::new();
            let material = builder.add_material(Material::default_grey());
            let corners = [[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]];
            let quad = MeshDescription {
                name: "ceiling".into(),
                positions: corners.map(Vec3::from_array).to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..Default::default()
            };
            let mesh = builder.add_mesh(quad).unwrap();
            // Turned, so that no coordinate of its plane is a round number.
            let turned = DMat4::from_translation(away) * DMat4::from_rotation_x(0.3) * DMat4::from_rotation_y(-0.2);
            builder.add_instance("ceiling", mesh, turned, &[material], true, true).unwrap();
            builder.add_lamp(lamp(kind), turned * DMat4::from_translation(DVec3::new(0.3, -0.4, 0.0))).unwrap();
            let scene = builder.build(DVec3::ZERO);
            let lights = Lights::new(&scene);
            let accel = crate::accel::Accel::new(&scene);
            for i in 0..64 {
                let u = sobol_burley::sample_4d(i, 0, 5);
                let below = DVec3::new(f64::from(u[0]) * 4.0 - 2.0, f64::from(u[1]) * 4.0 - 2.0, -2.5);
                let from = turned.transform_point3(below).as_vec3a();
                let to = lights.receiver_between(from);
                let Some(s) = lights.sample(&scene, &to, 0.5, [u[2], u[3]], PathState::CAMERA) else { continue };
                let ray = crate::accel::Ray { t_max: s.reach(0.0), ..crate::accel::Ray::new(from, s.wi) };
                assert!(accel.closest(&ray, crate::scene::visibility::Rays::SHADOW).is_none(), "{kind:?} {place} {i}");
                if s.point_like {
                    continue;
                }
                let hit = accel.closest(&crate::accel::Ray::new(from, s.wi), crate::scene::visibility::Rays::BOUNCE);
                let mut found = 0;
                let line = Line { from, towards: s.wi, t_max: hit.unwrap().t };
                lights.lamps_along(&scene, line, PathState::BOUNCE, Some(&to), |_| found += 1);
                assert_eq!(found, 1, "{kind:?} {place} {i}");
            }
        }
    }
}

/// The lights after an edit are as if they were found anew: whether nothing of them changed, an emitter moved, a lamp did, or the sky is
/// another.
#[test]
fn lights_of_an_edited_scene_are_those_of_a_new_one() {
    let sky = |bright: f32| {
        let pixels: Vec<f32> = (0..16 * 8).flat_map(|i| [0.5, 0.6, bright * (i % 7) as f32, 1.0]).collect();
        std::sync::Arc::new(Texture::from_floats("sky", 16, 8, &pixels, false).unwrap())
    };
    let (usual, other) = (sky(0.1), sky(2.0));
    let scene = |glow_at: f64, lamp_at: f64, sky: &std::sync::Arc<Texture>| {
        let mut builder = SceneBuilder::new();
        let m = builder.add_material(Material::diffuse("glow", Rgb::ONE, Rgb::new(2.0, 4.0, 6.0)));
        let positions: Vec<Vec3> = (0..40).map(|i| Vec3::new((i % 2) as f32, (i / 2) as f32, (i % 3) as f32)).collect();
        let triangles = (0..38).map(|i| [i, i + 1, i + 2]).collect();
        let mesh = MeshDescription { name: "glow".into(), positions, triangles, ..Default::default() };
        let mesh = builder.add_mesh(mesh).unwrap();
        let place = |x: f64| DMat4::from_translation(DVec3::new(x, 0.0, 3.0));
        builder.add_instance("glow", mesh, place(glow_at), &[m], true, true).unwrap();
        builder.add_lamp(lamp(LampKind::Point { radius: 0.1, soft: false }), place(lamp_at)).unwrap();
        let t = builder.add_texture(Texture::empty());
        builder.set_world(World { color: Rgb::ONE, texture: Some(t as u32), ..Default::default() }).unwrap();
        let mut scene = builder.build(DVec3::ZERO);
        scene.textures[t] = sky.clone();
        scene
    };
    let samples = |scene: &Scene, lights: &Lights| -> Vec<_> {
        let to = lights.receiver(Vec3A::new(1.0, 2.0, -1.0), Some(Vec3A::Z), 0.5);
        (0..256)
            .map(|i| {
                let u = sobol_burley::sample_4d(i, 0, 3);
                let found = lights.sample_source(scene, &to, u[0], [u[1], u[2]], PathState::CAMERA);
                found.map(|(s, source)| (s.wi, s.pdf, s.radiance, source))
            })
            .collect()
    };
    let before = scene(0.0, 4.0, &usual);
    let lights = Lights::new(&before);
    for (glow_at, lamp_at, sky) in [(0.0, 4.0, &usual), (0.5, 4.0, &usual), (0.0, 5.0, &usual), (0.0, 4.0, &other)] {
        let edited = scene(glow_at, lamp_at, sky);
        let (kept, anew) = (Lights::after(Some(&lights), &edited), Lights::new(&edited));
        assert_eq!(samples(&edited, &kept), samples(&edited, &anew), "{glow_at} {lamp_at}");
    }
}
