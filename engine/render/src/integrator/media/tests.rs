//! Media with a known answer.

use crate::Rgb;
use crate::accel::Ray;
use crate::integrator::PreparedScene;
use crate::integrator::path::{Approximations, KindLimits, Limits, trace, trace_all};
use crate::nodes::OF_MATERIALS;
use crate::sampler::PathSampler;
use crate::scene::SceneBuilder;
use crate::scene::graph::Graph;
use crate::scene::lamp::{Lamp, LampKind};
use crate::scene::material::Material;
use crate::scene::mesh::MeshDescription;
use crate::scene::world::World;
use glam::{DMat4, DVec3, Vec3, Vec3A};
use petzval_nodes::Graph as Shaders;
use std::f64::consts::PI;
use std::sync::Arc;

fn limits(bounces: u32) -> Limits {
    Limits {
        max_bounces: 1000,
        kinds: KindLimits { volume: bounces, ..KindLimits::default() },
        clamp_direct: f32::INFINITY,
        clamp_indirect: f32::INFINITY,
        approximations: Approximations::default(),
        hide_sky: false,
        film_glass: None,
        openness: 0.5,
        roulette: f32::INFINITY,
    }
}

/// A cube from -1 to 1 on each side.
fn cube() -> MeshDescription {
    let positions =
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - Vec3::ONE).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    MeshDescription { name: "cube".into(), positions, triangles, ..Default::default() }
}

/// The nodes of a volume; the first is the shader, its inputs as JSON.
fn volume(kind: &str, inputs: &str, more: &str) -> Material {
    let text = format!(
        r#"{{"nodes": [{{"type": "ShaderNode{kind}", "name": "shader", "options": {{}}, "inputs": {{{inputs}}}}}{more}],
        "surface": null, "volume": {{"node": 0, "socket": "Volume"}}, "displacement": null}}"#
    );
    let (graph, reports) = Graph::of(&Shaders::from_json(&text).unwrap(), 0, OF_MATERIALS);
    assert_eq!(reports, Vec::<String>::new());
    Material::new(kind, Arc::new(graph))
}

/// Nodes that give the place's z in the object, as node 1's density times `slope` plus `base`.
fn rising(base: f32, slope: f32) -> String {
    format!(
        r#", {{"type": "ShaderNodeMath", "name": "sum", "options": {{"operation": "MULTIPLY_ADD"}},
        "inputs": {{"Value": {{"node": 2, "socket": "Z"}}, "Value_001": {slope}, "Value_002": {base}}}}},
        {{"type": "ShaderNodeSeparateXYZ", "name": "parts", "options": {{}},
        "inputs": {{"Vector": {{"node": 3, "socket": "Object"}}}}}},
        {{"type": "ShaderNodeTexCoord", "name": "where", "options": {{}}, "inputs": {{}}}}"#
    )
}

const FROM_RISING: &str = r#""Density": {"node": 1, "socket": "Value"}"#;

fn stage(material: Material, world: f32, sun: f32) -> PreparedScene {
    let mut builder = SceneBuilder::new();
    let m = builder.add_material(material);
    let mesh = builder.add_mesh(cube()).unwrap();
    builder.add_instance("cube", mesh, DMat4::IDENTITY, &[m], true, true).unwrap();
    builder.set_world(World { color: Rgb::splat(world), ..Default::default() }).unwrap();
    let kind = LampKind::Sun { half_angle_rad: 0.0 };
    // Shines along its -z: from +x.
    let turned = DMat4::from_rotation_y(std::f64::consts::FRAC_PI_2);
    builder.add_lamp(Lamp { kind, color: Rgb::splat(sun), ..Lamp::default() }, turned).unwrap();
    PreparedScene::new(builder.build(DVec3::ZERO))
}

/// The mean along a ray down the middle of the cube, or from its inside.
fn down(stage: &PreparedScene, from: f32, bounces: u32, samples: u32) -> Rgb {
    let mut sum = DVec3::ZERO;
    for i in 0..samples {
        let ray = Ray::new(Vec3A::new(0.05, -0.03, from), Vec3A::NEG_Z);
        sum += trace(stage, ray, &limits(bounces), &mut PathSampler::new(0, 0, i, 1)).radiance.as_dvec3();
    }
    (sum / f64::from(samples)).as_vec3()
}

#[track_caller]
fn close(found: Rgb, expected: Rgb, tolerance: f32) {
    assert!((found - expected).abs().max_element() < tolerance, "{found}, not {expected}");
}

/// Beer and Lambert: the transmittance of a length of 2, by channel; half of it from the middle.
#[test]
fn light_is_absorbed_by_the_length_of_its_way() {
    let rates = Rgb::new(0.8, 0.5, 0.1);
    let even = stage(volume("VolumeAbsorption", r#""Color": [0.2, 0.5, 0.9], "Density": 1.0"#, ""), 1.0, 0.0);
    close(down(&even, 3.0, 0, 16), (rates * -2.0).map(f32::exp), 1e-5);
    close(down(&even, 0.0, 0, 16), (rates * -1.0).map(f32::exp), 1e-5);
    // Density 1 + z: the same in all, but by null collisions.
    let inputs = format!(r#""Color": [0.2, 0.5, 0.9], {FROM_RISING}"#);
    let rising = stage(volume("VolumeAbsorption", &inputs, &rising(1.0, 1.0)), 1.0, 0.0);
    // Ratio tracking of 4096 stratified samples.
    close(down(&rising, 3.0, 0, 4096), (rates * -2.0).map(f32::exp), 0.01);
    close(down(&rising, 0.0, 0, 4096), (rates * -0.5).map(f32::exp), 0.01);
    assert_eq!(rising.media.denser_than_bound(), 0);
}

/// A medium that absorbs nothing is invisible in a white world, however it scatters, from outside and from within.
#[test]
fn white_furnace() {
    let shaders = [
        (r#""Color": [1, 1, 1], "Density": 1.5"#.to_owned(), String::new()),
        (r#""Color": [1, 1, 1], "Density": 3.0, "Anisotropy": 0.7"#.to_owned(), String::new()),
        (format!(r#""Color": [1, 1, 1], "Anisotropy": -0.4, {FROM_RISING}"#), rising(1.5, 1.4)),
    ];
    for (inputs, more) in shaders {
        let stage = stage(volume("VolumeScatter", &inputs, &more), 1.0, 0.0);
        for from in [3.0, 0.2] {
            close(down(&stage, from, 1000, 4096), Rgb::ONE, 0.01);
        }
    }
}

/// A medium that scatters four fifths of the light, under a white sky, is as bright as a half space of it however dense it is: also where
/// free paths are as short as places are known.
#[test]
fn dense_media_give_back_the_light_of_a_half_space() {
    for density in [50.0, 3e3, 3e4] {
        let inputs = format!(r#""Color": [0.8, 0.8, 0.8], "Density": {density}"#);
        let dense = stage(volume("VolumePrincipled", &inputs, ""), 1.0, 0.0);
        let truth = petzval_testkit::half_space::reflectance(0.8) as f32;
        // Six deviations of the mean of numbers from 0 to 1.
        const SAMPLES: u32 = 1 << 16;
        let deviation = (truth * (1.0 - truth) / SAMPLES as f32).sqrt();
        close(down(&dense, 3.0, 1000, SAMPLES), Rgb::splat(truth), 6.0 * deviation);
    }
}

/// A sun from the side, scattered once: the integral over the ray is known. Coloured media have a closed form, rising ones a
/// sum.
#[test]
fn light_is_scattered_once() {
    let g = 0.5;
    // Across: a cosine of 0.
    let phase = (1.0 - g * g) / (4.0 * PI * (1.0f64 + g * g).powf(1.5));
    let sun = 3.0;
    let even = volume("VolumeScatter", r#""Color": [0.9, 0.5, 0.1], "Density": 1.5, "Anisotropy": 0.5"#, "");
    // The sun's light comes 1 - 0.05 through the cube to the ray.
    let expected = |rate: f64| sun * phase * (1.0 - (-2.0 * rate).exp()) * (-0.95 * rate).exp();
    let expected = Rgb::new(expected(1.35) as f32, expected(0.75) as f32, expected(0.15) as f32);
    close(down(&stage(even, 0.0, sun as f32), 3.0, 0, 8192), expected, 0.01 * expected.max_element());

    let inputs = format!(r#""Color": [0.8, 0.8, 0.8], "Anisotropy": 0.5, {FROM_RISING}"#);
    let rising = volume("VolumeScatter", &inputs, &rising(1.0, 1.0));
    const STEPS: usize = 2000;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / STEPS as f64;
        let rate = 0.8 * (1.0 + z);
        // Of density 1 + z from z up to 1.
        let above = 0.8 * ((1.0 - z) + 0.5 * (1.0 - z * z));
        sum += rate * (-above - 0.95 * rate).exp() * 2.0 / STEPS as f64;
    }
    let expected = Rgb::splat((sun * phase * sum) as f32);
    close(down(&stage(rising, 0.0, sun as f32), 3.0, 0, 65_536), expected, 0.01 * expected.x);
}

/// Sunlight in a thin medium, which scatters one path in fifty: every path takes a light sample, so that 16 paths are enough.
#[test]
fn thin_media_are_lit_for_every_path() {
    let thin = volume("VolumeScatter", r#""Color": [0.9, 0.5, 0.1], "Density": 0.01"#, "");
    let expected = [0.009f64, 0.005, 0.001].map(|rate| {
        let phase = 1.0 / (4.0 * PI);
        (3.0 * phase * (1.0 - (-2.0 * rate).exp()) * (-0.95 * rate).exp()) as f32
    });
    let expected = Rgb::from_array(expected);
    // Channels are chosen by what they carry, each a third of paths or more.
    close(down(&stage(thin, 0.0, 3.0), 3.0, 0, 16), expected, 0.01 * expected.max_element());
}

/// Emission over a length of 2, dimmed by the medium itself where it absorbs.
#[test]
fn what_shines_adds_up() {
    let glow = volume("Emission", r#""Color": [1.0, 0.5, 0.2], "Strength": 0.7"#, "");
    let mut glow = glow;
    glow.name = "glow".into();
    close(down(&stage(glow, 0.0, 0.0), 3.0, 0, 4), Rgb::new(1.4, 0.7, 0.28), 1e-4);
    let inputs = r#""Absorption Coefficients": [1.0, 0.5, 0.0], "Scatter Coefficients": [0, 0, 0],
        "Emission Coefficients": [1.0, 1.0, 1.0]"#;
    let both = stage(volume("VolumeCoefficients", inputs, ""), 0.0, 0.0);
    let expected = Rgb::new(1.0 - (-2.0f32).exp(), 2.0 * (1.0 - (-1.0f32).exp()), 2.0);
    close(down(&both, 3.0, 0, 4), expected, 1e-4);
    // Strength 0.5 + 0.5 z, by points on the way.
    let inputs = r#""Color": [1, 1, 1], "Strength": {"node": 1, "socket": "Value"}"#;
    let rising = stage(volume("Emission", inputs, &rising(0.5, 0.5)), 0.0, 0.0);
    close(down(&rising, 3.0, 0, 8192), Rgb::ONE, 0.01);
}

/// The result of a path does not depend on the paths that are traced with it.
#[test]
fn paths_know_nothing_of_each_other() {
    let inputs = format!(r#""Color": [0.9, 0.7, 0.5], "Anisotropy": 0.3, {FROM_RISING}"#);
    let stage = stage(volume("VolumeScatter", &inputs, &rising(1.5, 1.4)), 0.3, 2.0);
    let rays: Vec<_> = (0..64)
        .map(|i| {
            let x = i as f32 / 40.0 - 0.8;
            (Ray::new(Vec3A::new(x, 0.3 * x, 3.0), Vec3A::NEG_Z), PathSampler::new(i, 0, 0, 1))
        })
        .collect();
    let mut together = Vec::new();
    trace_all(&stage, rays.iter().cloned(), &limits(20), |_, found| together.push(found.radiance));
    for ((ray, mut sampler), together) in rays.into_iter().zip(together) {
        assert_eq!(trace(&stage, ray, &limits(20), &mut sampler).radiance, together);
    }
}

/// A cube that absorbs everywhere, and far more above a height; the bounds are too low by a factor.
fn spike(dense: f32, above: f32, part: f32) -> PreparedScene {
    let steep = format!(
        r#", {{"type": "ShaderNodeMath", "name": "times", "options": {{"operation": "MULTIPLY_ADD"}},
        "inputs": {{"Value": {{"node": 2, "socket": "Value"}}, "Value_001": {dense}, "Value_002": 0.5}}}},
        {{"type": "ShaderNodeMath", "name": "above", "options": {{"operation": "GREATER_THAN"}},
        "inputs": {{"Value": {{"node": 3, "socket": "Z"}}, "Value_001": {above}}}}},
        {{"type": "ShaderNodeSeparateXYZ", "name": "parts", "options": {{}},
        "inputs": {{"Vector": {{"node": 4, "socket": "Object"}}}}}},
        {{"type": "ShaderNodeTexCoord", "name": "where", "options": {{}}, "inputs": {{}}}}"#
    );
    let inputs = format!(r#""Color": [0, 0, 0], {FROM_RISING}"#);
    let mut stage = stage(volume("VolumeAbsorption", &inputs, &steep), 1.0, 0.0);
    stage.media.loosen(part);
    stage
}

/// A spike that no sample found before the render is hit all the same, on average rightly; and counted.
#[test]
fn what_is_denser_than_its_bound_is_no_bias() {
    // Density 0.5, and 40 more in the last hundredth.
    let spike = spike(40.0, 0.99, 0.5);
    let found = down(&spike, 3.0, 0, 65_536);
    // Weights of both signs: noisier than where the bound holds.
    close(found, Rgb::splat((-1.0f32 - 0.4).exp()), 0.03);
    assert!(spike.media.denser_than_bound() > 0);
}

/// A place that is a thousand times denser than its bound dims light, and no weight grows without end: no light comes through 4000 per
/// unit over a length of 0.1.
#[test]
fn weights_stay_finite_where_a_bound_is_far_too_low() {
    let spike = spike(4000.0, 0.9, 1e-3);
    // A first particle has a weight of 800; one in 1300 rays keeps it: a standard error of 0.09.
    close(down(&spike, 3.0, 0, 65_536), Rgb::ZERO, 0.4);
    assert!(spike.media.denser_than_bound() > 0);
}
