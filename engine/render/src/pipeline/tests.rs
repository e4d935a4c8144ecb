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
fn stage(world: f32) -> Arc<PreparedScene> {
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
    builder.set_world(World { color: Rgb::splat(world), ..Default::default() }).unwrap();
    Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)))
}

fn settings(pipeline: Pipeline, samples: u32, seed: u32) -> Settings {
    let [width, height] = SIZE;
    Settings { width, height, samples, seed, max_bounces: 0, pipeline, with_data: true, ..Settings::default() }
}

/// Every pipeline renders the same bits, also where light lands in any order.
#[test]
fn the_same_bits_for_any_number_of_threads() {
    let stage = stage(0.5);
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

/// With independent pixels the mean picture is the same, and by hero neighbours share next to no noise where the lens disperses little.
#[test]
fn independent_pixels_share_no_noise() {
    const SEEDS: u32 = 48;
    // Far out of focus rays of a pixel meet a triangle or nothing: that is the noise.
    let stage = stage(0.0);
    let [width, height] = SIZE;
    let camera = with_lens("wide-angle-smith-f3.4.lens", 36.0, 24.0, 0.0).with(|c| c.focus.distance = Some(0.8));
    let camera = Camera::new(&camera, width, height).unwrap();
    for pipeline in [Pipeline::Hero, Pipeline::SceneFirst] {
        // The mean of each pixel over the seeds, its variance, and its covariance with its neighbour to the right.
        let found = [false, true].map(|independent_pixels| {
            let pictures: Vec<Vec<f64>> = (0..SEEDS)
                .map(|seed| {
                    let settings = Settings { independent_pixels, ..settings(pipeline, 2, seed) };
                    let job = Job::start(stage.clone(), camera.clone(), settings).unwrap();
                    assert!(job.wait(std::time::Duration::from_secs(300)));
                    job.film().picture().iter().map(|[r, g, b, _]| f64::from(r + g + b)).collect()
                })
                .collect();
            let n = f64::from(SEEDS);
            let mean: Vec<f64> =
                (0..pictures[0].len()).map(|i| pictures.iter().map(|picture| picture[i]).sum::<f64>() / n).collect();
            let covariance = |i: usize, j: usize| {
                pictures.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>() / (n - 1.0)
            };
            let pairs = (0..mean.len() - 1).filter(|i| i % width as usize + 1 < width as usize);
            let shared: f64 = pairs.map(|i| covariance(i, i + 1)).sum();
            let variance: Vec<f64> = (0..mean.len()).map(|i| covariance(i, i)).collect();
            (mean, shared / variance.iter().sum::<f64>(), variance)
        });
        let [(spread, shared_spread, spread_variance), (kept, shared, variance)] = &found;
        let (a, b): (f64, f64) = (spread.iter().sum(), kept.iter().sum());
        // Pixels that share noise err together: their sum has more than the sum of their variances.
        let sigma =
            ((spread_variance.iter().sum::<f64>() * 9.0 + variance.iter().sum::<f64>()) / f64::from(SEEDS)).sqrt();
        assert!((a - b).abs() < 4.0 * sigma, "{pipeline:?}: {a} {b}, sigma {sigma}");
        // Of each pixel, too: the mean square of normal numbers is 1, to four deviations of it.
        let count = kept.len() as f64;
        let z: f64 = (0..kept.len())
            .map(|i| {
                let v = (spread_variance[i] + variance[i]) / f64::from(SEEDS);
                if v > 1e-12 { (spread[i] - kept[i]).powi(2) / v } else { 1.0 }
            })
            .sum();
        assert!((z / count - 1.0).abs() < 0.25, "{pipeline:?}: {}", z / count);
        // Scene-first sends rays to pixels at random, of which one gets what others do not.
        let is_apart = shared.abs() < 0.02 && *shared_spread > 0.035;
        assert!(is_apart || pipeline == Pipeline::SceneFirst, "{shared_spread} {shared}");
    }
}

/// Counts of a file may be any numbers: their sum is no panic.
#[test]
fn the_largest_counts_add_up() {
    let most = std::time::Duration::MAX;
    let mut sum = Counts { rays: u64::MAX, camera_time: most, sample_time: most, ..Counts::default() };
    let other = sum;
    sum.add(&other);
    assert_eq!((sum.rays, sum.camera_time, sum.sample_time, sum.non_finite), (u64::MAX, most, most, 0));
}
