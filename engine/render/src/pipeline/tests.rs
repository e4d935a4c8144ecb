//! Tests of each pipeline alone; that all take the same picture is tested in `tests/light_paths` and
//! `tests/exact_pictures`.

use super::*;
use crate::Rgb;
use crate::camera::tests::with_lens;
use crate::job::{Job, Settings};
use crate::scene::{SceneBuilder, mesh::MeshDescription, world::World};
use glam::{DMat4, DVec3, Vec3};
use std::sync::Arc;

const SIZE: [u32; 2] = [96, 64];

/// A glowing grey world, with glowing triangles of several colours before and behind the plane of focus.
fn stage() -> Arc<PreparedScene> {
    let mut builder = SceneBuilder::new();
    let glow = |r, g, b| crate::scene::material::Material::diffuse("glow", Rgb::ZERO, Rgb::new(r, g, b));
    let triangle = MeshDescription {
        name: "triangle".into(),
        positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(triangle).unwrap();
    let colours = [glow(2.0, 2.0, 2.0), glow(3.0, 0.2, 0.1), glow(0.1, 2.0, 0.3), glow(0.2, 0.3, 4.0)];
    let materials = colours.map(|m| builder.add_material(m));
    for i in 0..24 {
        let (x, y) = ((f64::from(i) * 0.618).fract() - 0.5, (f64::from(i) * 0.755).fract() - 0.5);
        let z = -1.0 - 5.0 * (f64::from(i) * 0.57).fract();
        let place = DMat4::from_translation(DVec3::new(4.0 * x * -z / 2.0, 3.0 * y * -z / 2.0, z));
        let m = materials[i as usize % 4];
        builder.add_instance("t", mesh, place * DMat4::from_scale(DVec3::splat(0.25)), &[m], true, true).unwrap();
    }
    builder.set_world(World { color: Rgb::splat(0.5), ..Default::default() }).unwrap();
    Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)))
}

fn settings(pipeline: Pipeline, samples: u32, seed: u32) -> Settings {
    let [width, height] = SIZE;
    Settings { width, height, samples, seed, max_bounces: 0, pipeline, with_data: true, ..Settings::default() }
}

/// Every pipeline renders the same bits, also where light lands in any order.
#[test]
fn the_same_bits_for_any_number_of_threads() {
    let stage = stage();
    for pipeline in [Pipeline::Hero, Pipeline::SceneFirst] {
        // A glass so unsharp that light lands beyond what a tile keeps.
        let one = |threads: usize| {
            let [width, height] = SIZE;
            let settings = Settings { threads, ..settings(pipeline, 3, 1) };
            let camera = with_lens("biconvex-50mm.lens", 5.0, 5.0 * f64::from(height) / f64::from(width), 0.0);
            let camera = Camera::new(&camera, width, height).unwrap();
            let job = Job::start(stage.clone(), camera, settings).unwrap();
            assert!(job.wait(std::time::Duration::from_secs(300)));
            assert_eq!(job.film().size(), (width, height));
            job.film().picture()
        };
        let first = one(1);
        assert!(first == one(2) && first == one(5), "{pipeline:?}");
    }
}
