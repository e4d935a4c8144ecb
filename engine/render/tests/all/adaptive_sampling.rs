//! Pictures whose pixels have as many samples as they need: true in the mean, the same for any number of threads.

use crate::cameras::camera;
use glam::{DMat4, DVec3, Vec3};
use petzval_optics::system::FocalLength;
use petzval_render::Rgb;
use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::integrator::{Integrator, PreparedScene};
use petzval_render::job::{Job, Settings, Statistics};
use petzval_render::pipeline::Pipeline;
use petzval_render::scene::material::Material;
use petzval_render::scene::mesh::MeshDescription;
use petzval_render::scene::{SceneBuilder, world::World};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 32;
/// Side of the blocks whose counts are decided together, and whose means are compared.
const BLOCK: u32 = 8;
const CHANNELS: usize = 3;

fn description(model: Model, lens: &str) -> CameraDescription {
    CameraDescription {
        model,
        lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../lenses/{lens}.lens")),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.lens.focal_length = FocalLength::Millimetres(50.0);
        c.focus.distance = Some(3.0);
        c.film.width_mm = 36.0;
        c.film.height_mm = 24.0;
    })
}

fn settings(samples: u32, noise_threshold: f32, seed: u32) -> Settings {
    Settings {
        width: WIDTH,
        height: HEIGHT,
        samples,
        seed,
        noise_threshold,
        threads: 2,
        max_bounces: 2,
        ..Settings::default()
    }
}

fn glow(r: f32, g: f32, b: f32) -> Material {
    Material::diffuse("glow", Rgb::ZERO, Rgb::new(r, g, b))
}

/// Triangles of one material: place and size.
fn stage(groups: &[(Material, Vec<(DVec3, f64)>)], world: f32) -> Arc<PreparedScene> {
    let mut builder = SceneBuilder::new();
    let triangle = MeshDescription {
        name: "triangle".into(),
        positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(triangle).unwrap();
    for (material, places) in groups {
        let material = builder.add_material(material.clone());
        for &(place, size) in places {
            let at = DMat4::from_translation(place) * DMat4::from_scale(DVec3::splat(size));
            builder.add_instance("triangle", mesh, at, &[material], true, true).unwrap();
        }
    }
    builder.set_world(World { color: Rgb::splat(world), ..Default::default() }).unwrap();
    Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)))
}

fn part(i: u32, step: f64) -> f64 {
    (f64::from(i) * step).fract()
}

/// Sparks that are far smaller than a pixel, as rare to samples as they are bright.
fn sparks() -> Arc<PreparedScene> {
    // A pixel is 0.045 wide at this distance; a triangle is a 25th of that.
    let place = |i: u32| DVec3::new(2.0 * (part(i, 0.618) - 0.5), 1.3 * (part(i, 0.7548) - 0.5), -3.0);
    stage(&[(glow(400.0, 400.0, 400.0), (0..40).map(|i| (place(i), 0.0064)).collect())], 0.1)
}

/// Bodies of many colours before and behind the plane of focus; grey ones, lit by the others, in one half of the picture.
fn bodies() -> Arc<PreparedScene> {
    let place = |i: u32| {
        let z = 1.0 + 5.0 * part(i, 0.57);
        (DVec3::new(0.7 * (part(i, 0.618) - 0.5) * z, 0.5 * (part(i, 0.755) - 0.5) * z, -z), 0.04 * z)
    };
    let group = |material: Material, k: u32| (material, (0..10).map(|i| place(4 * i + k)).collect());
    let wall = (Material::diffuse("wall", Rgb::splat(0.8), Rgb::ZERO), vec![(DVec3::new(-1.5, 0.0, -7.0), 2.0)]);
    let colours = [glow(2.0, 2.0, 2.0), glow(9.0, 0.2, 0.1), glow(0.1, 6.0, 0.3), glow(0.2, 0.3, 12.0)];
    let mut groups: Vec<_> = colours.into_iter().zip(0..).map(|(m, k)| group(m, k)).collect();
    groups.push(wall);
    stage(&groups, 0.2)
}

struct Done {
    picture: Vec<[f32; 4]>,
    counts: Vec<u32>,
    statistics: Statistics,
}

fn finished(stage: &Arc<PreparedScene>, d: &CameraDescription, s: Settings) -> Job {
    let job = Job::start(stage.clone(), camera(d, s.width, s.height), s).unwrap();
    assert!(job.wait(Duration::from_secs(600)));
    let statistics = job.statistics();
    assert!(statistics.failure.is_none() && statistics.counts.non_finite == 0, "{statistics:?}");
    job
}

fn render(stage: &Arc<PreparedScene>, d: &CameraDescription, s: Settings) -> Done {
    let job = finished(stage, d, s);
    Done { picture: job.film().picture(), counts: job.film().sample_counts(), statistics: job.statistics() }
}

/// Means of the channels over each block; the last are the whole picture's.
fn blocks(picture: &[[f32; 4]]) -> Vec<f64> {
    let (columns, rows) = (WIDTH / BLOCK, HEIGHT / BLOCK);
    let mut sums = vec![0.0; CHANNELS * (columns * rows + 1) as usize];
    let last = sums.len() - CHANNELS;
    for (i, pixel) in (0..).zip(picture) {
        let block = (i / WIDTH / BLOCK * columns + i % WIDTH / BLOCK) as usize;
        for c in 0..CHANNELS {
            sums[CHANNELS * block + c] += f64::from(pixel[c]) / f64::from(BLOCK * BLOCK);
            sums[last + c] += f64::from(pixel[c]) / f64::from(WIDTH * HEIGHT);
        }
    }
    sums
}

/// Mean and its squared standard error, entry by entry.
fn mean_of(lists: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let n = lists.len() as f64;
    let entry = |i: usize| {
        let mean = lists.iter().map(|list| list[i]).sum::<f64>() / n;
        let squares: f64 = lists.iter().map(|list| (list[i] - mean).powi(2)).sum();
        (mean, squares / (n * (n - 1.0)))
    };
    (0..lists[0].len()).map(entry).collect()
}

/// The naive method, which must not be used: a block has enough samples when its own say so.
fn naive(stage: &Arc<PreparedScene>, d: &CameraDescription, threshold: f32, most: u32, seed: u32) -> Vec<[f32; 4]> {
    let whole = |from: u32, to: u32| {
        render(stage, d, Settings { sample_offset: from, ..settings(to - from, 0.0, seed) }).picture
    };
    let pixels = (WIDTH * HEIGHT) as usize;
    let (mut sums, mut squares) = (vec![[0.0f32; 4]; pixels], vec![0.0f32; pixels]);
    let mut counts = vec![0u32; pixels];
    let mut goes_on = vec![true; pixels];
    let batch = 2;
    for first in (0..most).step_by(batch as usize) {
        for (i, mean) in whole(first, first + batch).into_iter().enumerate().filter(|(i, _)| goes_on[*i]) {
            sums[i].iter_mut().zip(mean).for_each(|(s, m)| *s += m * batch as f32);
            squares[i] += mean[0] * mean[0] * batch as f32;
            counts[i] += batch;
        }
        let n = first + batch;
        if n < 4 || !n.is_power_of_two() {
            continue;
        }
        let block = |i: usize| (i as u32 / WIDTH / BLOCK, i as u32 % WIDTH / BLOCK);
        let spread = |i: usize| {
            (squares[i] - sums[i][0] * sums[i][0] / n as f32) / (n * (n / batch - 1)) as f32 / (sums[i][0] / n as f32)
        };
        for i in (0..pixels)
            .filter(|&i| (i as u32 % WIDTH).is_multiple_of(BLOCK) && (i as u32 / WIDTH).is_multiple_of(BLOCK))
        {
            let own: Vec<usize> = (0..pixels).filter(|&k| block(k) == block(i)).collect();
            let error = own.iter().map(|&k| spread(k)).sum::<f32>() / own.len() as f32;
            if error < threshold * threshold {
                own.into_iter().for_each(|k| goes_on[k] = false);
            }
        }
    }
    sums.iter().zip(counts).map(|(sum, n)| sum.map(|s| s / n as f32)).collect()
}

/// Sparks that few blocks find in their first samples. The mean of many adaptive pictures is that of the picture with the
/// same count everywhere; stopping by one's own samples makes it dark, for a block that finds a spark thins it out by
/// samples more, and one that finds none stops.
#[test]
fn rare_light_is_kept_in_the_mean() {
    let (stage, d) = (sparks(), description(Model::Pinhole, "biconvex-50mm"));
    let (most, threshold) = (64, 0.05);
    let whole = |picture: &[[f32; 4]]| vec![*blocks(picture).last().unwrap()];
    let truth = *blocks(&render(&stage, &d, settings(1 << 13, 0.0, 1)).picture).last().unwrap();
    assert!(truth > 0.15, "sparks are half of the light: {truth}");
    let (mut found, mut samples) = (Vec::new(), 0.0);
    for seed in 0..400 {
        let done = render(&stage, &d, Settings { min_samples: 4, ..settings(most, threshold, seed) });
        samples += done.statistics.mean_samples / 400.0;
        found.push(whole(&done.picture));
    }
    let (mean, error) = mean_of(&found)[0];
    // Most blocks stop early, some go on.
    assert!(samples > 5.0 && samples < 0.6 * f64::from(most), "{samples}");
    println!("truth {truth:.4}, adaptive {mean:.4} +- {:.4} by {samples:.1} samples", error.sqrt());
    // Four standard errors; these are a few hundredths of the sparks' light.
    assert!((mean - truth).abs() < 4.0 * error.sqrt(), "{mean} {truth} {}", error.sqrt());
    assert!(error.sqrt() < 0.03 * truth);

    // Twenty-four standard errors and more.
    let found: Vec<_> = (0..24).map(|seed| whole(&naive(&stage, &d, threshold, most, seed))).collect();
    let (mean, error) = mean_of(&found)[0];
    println!("naive {mean:.4} +- {:.4}", error.sqrt());
    assert!(mean < truth - 10.0 * error.sqrt(), "the naive way is dark: {mean} {truth} {}", error.sqrt());
}

/// Every way of following light, also where it lands far from the pixel that started it, by blocks of the picture.
#[test]
fn all_pipelines_are_true_in_the_mean() {
    // Light paths have to do where there is a wall to be lit.
    let stages = [bodies(), lit_wall()];
    let seeds = if petzval_testkit::is_thorough() { 24 } else { 12 };
    // The threshold is one that some blocks reach and others do not.
    for (lens, model, pipeline, integrator, threshold) in [
        ("wide-angle-smith-f3.4", Model::Lens, Pipeline::FilmFirst, Integrator::Path, 0.4),
        ("wide-angle-smith-f3.4", Model::Lens, Pipeline::Hero, Integrator::Path, 0.3),
        ("biconvex-50mm", Model::Lens, Pipeline::Hero, Integrator::Path, 0.3),
        ("biconvex-50mm", Model::Lens, Pipeline::SceneFirst, Integrator::Path, 0.3),
        ("wide-angle-smith-f3.4", Model::Lens, Pipeline::Auto, Integrator::Bidirectional, 0.15),
        ("biconvex-50mm", Model::Thin, Pipeline::Auto, Integrator::Path, 0.3),
    ] {
        let d = description(model, lens);
        let stage = &stages[usize::from(integrator == Integrator::Bidirectional)];
        let with = |noise: f32, samples: u32, seed: u32| {
            let s = Settings { min_samples: 4, pipeline, integrator, ..settings(samples, noise, seed) };
            render(stage, &d, s)
        };
        let adaptive: Vec<Done> = (0..seeds).map(|seed| with(threshold, 32, seed)).collect();
        let uniform: Vec<_> = (0..seeds).map(|seed| blocks(&with(0.0, 16, 1000 + seed).picture)).collect();
        let one = &adaptive[0];
        let s = &one.statistics;
        let sum: u32 = one.counts.iter().sum();
        assert_eq!(s.mean_samples, f64::from(sum) / f64::from(WIDTH * HEIGHT));
        assert_eq!(
            (Some(s.samples), Some(s.most_samples)),
            (one.counts.iter().copied().min(), one.counts.iter().copied().max())
        );
        assert!(s.samples >= 4 && s.most_samples <= 32 && s.samples < s.most_samples, "{lens} {pipeline:?} {s:?}");
        let adaptive: Vec<_> = adaptive.iter().map(|done| blocks(&done.picture)).collect();
        let (a, b) = (mean_of(&adaptive), mean_of(&uniform));
        let squares: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a.0 - b.0).powi(2) / (a.1 + b.1).max(1e-12)).collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        println!("{lens} {model:?} {pipeline:?} {integrator:?}: {:.1} samples, squares {mean:.2}", s.mean_samples);
        // One, to what 24 blocks of 3 channels that depend on another leave of it; that 12 pictures know their own spread to a
        // fifth adds a tenth.
        assert!(mean < 1.7, "{lens} {pipeline:?} {mean} {squares:?}");
        assert!(squares[squares.len() - CHANNELS..].iter().all(|s| *s < 16.0), "{lens} {pipeline:?} {squares:?}");
    }
}

/// The bits do not depend on the number of threads, also where light lands beyond the pixels that a block keeps, and in the pictures on the
/// way.
#[test]
fn the_same_bits_for_any_number_of_threads() {
    let stage = bodies();
    for (lens, pipeline, integrator) in [
        ("biconvex-50mm", Pipeline::Hero, Integrator::Path),
        ("biconvex-50mm", Pipeline::SceneFirst, Integrator::Path),
        ("wide-angle-smith-f3.4", Pipeline::FilmFirst, Integrator::Path),
        ("wide-angle-smith-f3.4", Pipeline::Auto, Integrator::Bidirectional),
    ] {
        let d = description(Model::Lens, lens);
        let one = |threads: usize| {
            let (width, height) = (75, 43);
            let s = Settings { threads, pipeline, integrator, width, height, min_samples: 4, ..settings(50, 0.1, 3) };
            let job = finished(&stage, &d, s);
            assert!((job.progress() - 1.0).abs() < 1e-6 && job.samples_done() == 50);
            let picture = job.film().picture();
            // What was shown is the same picture in parts.
            let mut shown = vec![[f32::NAN; 4]; picture.len()];
            for tile in job.take_tiles() {
                let r = tile.rect;
                for (i, pixel) in (0..).zip(tile.pixels) {
                    shown[((r.y + i / r.width) * width + r.x + i % r.width) as usize] = pixel;
                }
            }
            assert!(shown == picture && job.take_tiles().is_empty());
            (picture, job.film().sample_counts())
        };
        let first = one(1);
        assert!(first == one(2) && first == one(5), "{lens} {pipeline:?}");
    }
}

/// A picture whose corner blocks are too small for two halves, one with no more samples than the first look takes, and one
/// that is stopped.
#[test]
fn small_pictures_and_few_samples() {
    let (stage, d) = (bodies(), description(Model::Lens, "wide-angle-smith-f3.4"));
    let corner = render(&stage, &d, Settings { width: 9, height: 9, ..settings(100, 0.5, 1) });
    assert_eq!(corner.counts[80], 100, "a block of one pixel has nobody to ask");
    let few = render(&stage, &d, settings(10, 0.1, 1));
    assert!(few.counts.iter().all(|&n| n == 10) && few.statistics.counts.camera_rays == u64::from(10 * WIDTH * HEIGHT));
    let (most, fine) = (1 << 20, 1e-6);
    let job = Job::start(stage, Camera::new(&d, WIDTH, HEIGHT).unwrap(), settings(most, fine, 1)).unwrap();
    assert!(!job.wait(Duration::from_millis(300)));
    job.stop();
    assert!(job.wait(Duration::from_millis(300)));
    assert!(job.progress() < 1.0 && job.statistics().samples > 0);
    assert!(job.film().picture().iter().all(|p| p[3] > 0.99 && p.iter().all(|c| c.is_finite())));
}

/// A wall on the left that a lamp behind the camera lights, before an even sky.
fn lit_wall() -> Arc<PreparedScene> {
    let grey = Material::diffuse("grey", Rgb::splat(0.8), Rgb::ZERO);
    let wall = (grey, vec![(DVec3::new(-1.5, 0.0, -3.0), 1.3)]);
    let lamp = (glow(20.0, 20.0, 20.0), vec![(DVec3::new(-1.0, 0.5, 1.0), 0.5)]);
    stage(&[wall, lamp], 0.2)
}

/// Samples go where the noise is: to a wall that a lamp lights, not to the even sky.
#[test]
fn samples_go_where_noise_is() {
    let (stage, d) = (lit_wall(), description(Model::Pinhole, "biconvex-50mm"));
    let done = render(&stage, &d, settings(1024, 0.005, 1));
    let mean = |columns: std::ops::Range<u32>| {
        let of = (0..WIDTH * HEIGHT).filter(|i| columns.contains(&(i % WIDTH)));
        of.clone().map(|i| f64::from(done.counts[i as usize])).sum::<f64>() / of.count() as f64
    };
    assert!(mean(32..48) == 16.0 && mean(0..16) > 40.0, "{} {}", mean(32..48), mean(0..16));
}
