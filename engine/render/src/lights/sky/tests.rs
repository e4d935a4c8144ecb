//! Light samples of the world's image: their densities, and the changes by MIS compensation.

use super::super::Lights;
use super::*;
use crate::sampler::warp;
use crate::scene::material::Material;
use crate::scene::mesh::MeshDescription;
use crate::scene::visibility::Rays;
use crate::scene::{SceneBuilder, world::World};
use glam::{DMat4, DVec3, Vec3};

/// A sky of even light with a bright patch above, over a triangle that these rays see.
fn scene(visible: Rays) -> Scene {
    let (w, h) = (64, 32);
    let pixels: Vec<f32> = (0..w * h)
        .flat_map(|i| {
            let is_patch = (20..24).contains(&(i % w)) && (24..28).contains(&(i / w));
            let value = if is_patch { 30.0 } else { 0.5 };
            [value, value, value, 1.0]
        })
        .collect();
    let mut builder = SceneBuilder::new();
    let texture = builder.add_texture(Texture::from_floats("sky", w, h, &pixels, false).unwrap());
    builder.set_world(World { color: Rgb::ONE, texture: Some(texture as u32), ..Default::default() }).unwrap();
    let material = builder.add_material(Material::default_grey());
    let mesh = MeshDescription {
        name: "pane".into(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(mesh).unwrap();
    builder.add_instance("pane", mesh, DMat4::from_translation(-DVec3::Z), &[material], true, true).unwrap();
    let mut scene = builder.build(DVec3::ZERO);
    scene.instances[0].visible = visible;
    scene
}

/// Mean and variance of the irradiance on a floor that faces up, by a light sample and a direction by the cosine each, weighted by the
/// power heuristic.
fn irradiance(scene: &Scene, lights: &Lights, to: &LightSampleContext) -> (f64, f64) {
    let weight = |a: f32, b: f32| a * a / (a * a + b * b);
    let along = |d: Vec3A| {
        let mut found = (0.0, 0.0);
        lights.sky_along(scene, d, PathState::BOUNCE, Some(to), |one| found = (one.radiance.x, one.pdf));
        found
    };
    let n = 1 << 16;
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..n {
        let u = sobol_burley::sample_4d(i, 0, 7);
        let mut value = 0.0;
        if let Some(light) = lights.sample(scene, to, 0.5, [u[0], u[1]], PathState::BOUNCE) {
            let (radiance, pdf) = along(light.wi);
            assert!((pdf / light.pdf - 1.0).abs() < 2e-3, "{pdf} {}", light.pdf);
            assert!((radiance - light.radiance.x).abs() <= 1e-2 * radiance);
            let cos = light.wi.z.max(0.0);
            value += light.radiance.x * cos / light.pdf * weight(light.pdf, cos / PI);
        }
        let d = warp::sample_cosine_hemisphere([u[2], u[3]]);
        let (radiance, pdf) = along(d);
        value += radiance * PI * weight(d.z / PI, pdf);
        sum += f64::from(value);
        squares += f64::from(value).powi(2);
    }
    let mean = sum / f64::from(n);
    (mean, squares / f64::from(n) - mean * mean)
}

/// Compensation gives the same light with less noise. Of the patch, 0.15 sr at 0.5 sr^-1 of even light, light samples find most; without compensation most of
/// them go to the even light, as often below the horizon as above.
#[test]
fn compensation_takes_noise_away_and_keeps_the_light() {
    let scene = scene(Rays::ALL);
    let lights = Lights::new(&scene);
    let to = lights.receiver(Vec3A::ZERO, Some(Vec3A::Z), 0.5);
    let (whole, noise) = irradiance(&scene, &lights, &to);
    let (compensated, less) = irradiance(&scene, &lights, &to.compensated(true));
    assert!((compensated / whole - 1.0).abs() < 2e-3, "{whole} {compensated}");
    assert!(less < 0.8 * noise, "{noise} {less}");
}

/// No compensation where shadow rays pass surfaces that rays of closures do not: the weights of both show in the picture, and are those of
/// the whole image.
#[test]
fn panes_that_throw_no_shadow_leave_the_whole_image() {
    for (visible, is_compensated) in [
        (Rays::ALL, true),
        (Rays::CAMERA, true),
        (Rays::ALL.without(Rays::CAMERA), true),
        (Rays::ALL.without(Rays::SHADOW), false),
        (Rays::ALL.without(Rays::DIFFUSE), false),
    ] {
        let scene = scene(visible);
        let lights = Lights::new(&scene);
        let to = lights.receiver(Vec3A::ZERO, Some(Vec3A::Z), 0.5);
        let pdf = |to: LightSampleContext| {
            let mut pdf = 0.0;
            let d = Vec3A::new(0.6, 0.0, 0.8);
            lights.sky_along(&scene, d, PathState::BOUNCE, Some(&to), |one| pdf = one.pdf);
            pdf
        };
        let [whole, other] = [to, to.compensated(true)].map(pdf);
        assert_eq!(other < 0.1 * whole, is_compensated, "{visible:?}: {whole} {other}");
        assert!(is_compensated || whole == other, "{visible:?}: {whole} {other}");
    }
}
