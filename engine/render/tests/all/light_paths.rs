//! Light paths through real lenses: the picture that path tracing makes, made from the other end.

mod lenses;

use crate::cameras::camera;
use crate::scenes;
use glam::DVec3;
use petzval_optics::system::FocalLength;
use petzval_render::camera::clip::Clip;
use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::film::Film;
use petzval_render::integrator::{
    Integrator, PreparedScene,
    bidirectional::Techniques,
    path::{Approximations, KindLimits, Limits},
};
use petzval_render::job::{Job, OutputOptions, Settings};
use petzval_render::pipeline::{Pipeline, RenderContext, render_tile};
use petzval_render::sampler::{
    pattern::Pattern,
    raster::Raster,
    warp::{Filter, PixelFilter},
};
use petzval_render::scene::lamp::LampKind;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 32;
/// Side of a block whose mean is compared, pixels.
const BLOCK: usize = 8;
const FIGURE_3: &str = "wide-angle-smith-f3.4";

fn description(lens: &str) -> CameraDescription {
    CameraDescription {
        model: Model::Lens,
        lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../lenses/{lens}.lens")),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.lens.focal_length = FocalLength::Millimetres(80.0);
        c.focus.distance = Some(3.5);
        c.film.width_mm = 48.0;
        c.film.height_mm = 32.0;
    })
}

fn settings(integrator: Integrator, samples: u32, seed: u32) -> Settings {
    Settings {
        width: WIDTH,
        height: HEIGHT,
        samples,
        seed,
        threads: 2,
        max_bounces: 5,
        integrator,
        ..Settings::default()
    }
}

fn render(stage: &Arc<PreparedScene>, d: &CameraDescription, s: Settings) -> Vec<[f32; 4]> {
    let camera = camera(d, s.width, s.height);
    let beside = OutputOptions { clip: Clip::new(d, &camera), ..OutputOptions::default() };
    let job = Job::start_with(stage.clone(), vec![camera], s, beside).unwrap();
    assert!(job.wait(Duration::from_secs(600)));
    let statistics = job.statistics();
    assert!(statistics.failure.is_none() && statistics.counts.non_finite == 0, "{statistics:?}");
    job.film().picture()
}

/// Light that ends in the lens after at least one scattering, alone.
fn light_alone(
    stage: &PreparedScene,
    d: &CameraDescription,
    samples: u32,
    seed: u32,
    max_bounces: u32,
) -> Vec<[f32; 4]> {
    let camera = camera(d, WIDTH, HEIGHT);
    let raster = Raster::new(WIDTH, HEIGHT, PixelFilter::new(Filter::BlackmanHarris(1.5)));
    let limits = Limits {
        max_bounces,
        kinds: KindLimits::default(),
        clamp_direct: f32::INFINITY,
        clamp_indirect: f32::INFINITY,
        approximations: Approximations::default(),
        hide_sky: false,
        film_glass: None,
        openness: 0.5,
        roulette: 1.0,
    };
    let light_paths = Some(Techniques::LightAlone);
    let shot = RenderContext {
        stage,
        cameras: std::slice::from_ref(&camera),
        clip: None,
        pipeline: Pipeline::Hero,
        light_paths,
        raster: &raster,
        limits,
        pattern: Pattern::independent(seed),
        motion: None,
        exposure: None,
        parts: &Default::default(),
        aimed: None,
        bake: None,
    };
    let film = Film::new(WIDTH, HEIGHT, true, false);
    for tile in 0..film.tile_count() {
        let mut patch = film.patch(tile);
        render_tile(&shot, film.rect(tile), [0, samples], &mut patch, &|| false).unwrap();
        film.add_pass(tile, 0, patch, samples).map_err(|_| "out of order").unwrap();
    }
    film.picture()
}

/// Means of blocks, by channel; the last entries are the whole picture's.
fn blocks(picture: &[[f32; 4]]) -> Vec<f64> {
    let (w, h) = (WIDTH as usize, HEIGHT as usize);
    let mut sums = vec![0.0; 3 * (w / BLOCK) * (h / BLOCK) + 3];
    let last = sums.len() - 3;
    for (i, pixel) in picture.iter().enumerate() {
        let block = i / w / BLOCK * (w / BLOCK) + i % w / BLOCK;
        for c in 0..3 {
            sums[3 * block + c] += f64::from(pixel[c]) / (BLOCK * BLOCK) as f64;
            sums[last + c] += f64::from(pixel[c]) / (w * h) as f64;
        }
    }
    sums
}

/// Mean and the variance of the mean, over renders with different seeds.
fn statistics(renders: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let n = renders.len() as f64;
    (0..renders[0].len())
        .map(|i| {
            let mean = renders.iter().map(|r| r[i]).sum::<f64>() / n;
            let variance = renders.iter().map(|r| (r[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
            (mean, variance / n)
        })
        .collect()
}

struct Comparison {
    largest_z: f64,
    /// Root mean square over the blocks.
    rms_z: f64,
    whole_z: [f64; 3],
    means: [f64; 2],
    /// Mean standard deviation of a block over its mean.
    noise: [f64; 2],
}

fn compare(a: &[Vec<f64>], b: &[Vec<f64>]) -> Comparison {
    let (a, b) = (statistics(a), statistics(b));
    let last = a.len() - 3;
    // Twelve renders tell the noise of a caustic's rare bright paths too low: a block's is taken as 1 % at least,
    // and as something where all is dark.
    let least = |i: usize| if i < last { 0.01 * a[i].0 + 0.001 * a[last].0 } else { 0.0 };
    let z = |i: usize| (a[i].0 - b[i].0) / (a[i].1 + b[i].1 + least(i).powi(2)).sqrt();
    let all: Vec<f64> = (0..last).map(z).collect();
    let noise = |s: &[(f64, f64)]| {
        s[..last].iter().map(|m| m.1.sqrt()).sum::<f64>() / s[..last].iter().map(|m| m.0).sum::<f64>()
    };
    Comparison {
        largest_z: all.iter().fold(0.0, |m, z| m.max(z.abs())),
        rms_z: (all.iter().map(|z| z * z).sum::<f64>() / all.len() as f64).sqrt(),
        whole_z: [z(last), z(last + 1), z(last + 2)],
        means: [a[last + 1].0, b[last + 1].0],
        noise: [noise(&a), noise(&b)],
    }
}

/// Renders of each kind, with independent seeds.
const RENDERS: u32 = 12;

/// Renders both ways and compares.
fn agree(name: &str, stage: &Arc<PreparedScene>, d: &CameraDescription, path_samples: u32, samples: u32) {
    let many = |integrator, samples: u32, first: u32| -> Vec<Vec<f64>> {
        (0..RENDERS).map(|k| blocks(&render(stage, d, settings(integrator, samples, first + k)))).collect()
    };
    let a = many(Integrator::Path, path_samples, 1);
    let b = many(Integrator::Bidirectional, samples, 101);
    let c = compare(&a, &b);
    let Comparison { largest_z, rms_z, whole_z, means, noise } = &c;
    println!("{name}: z max {largest_z:.2} rms {rms_z:.2} whole {whole_z:.2?} means {means:.5?} noise {noise:.4?}");
    check(name, &c);
}

/// A z of twelve renders each follows Student's distribution with 22 or fewer degrees of freedom: one of three beyond 3.5 has a probability
/// of 0.6 %, one of a hundred blocks beyond 5 of 0.5 %, and with the least noise that they are given, less. A whole picture's 3.5 standard
/// errors are 1 % (glowing meshes, leaves) to 3 % (box) of its mean, and 6 % for a caustic; a block's 5 are 5 to 25 % of its own.
fn check(name: &str, c: &Comparison) {
    assert!(c.whole_z.iter().all(|z| z.abs() < 3.5), "{name}: whole picture {:?}, means {:?}", c.whole_z, c.means);
    assert!(c.rms_z < 1.3 && c.largest_z < 5.0, "{name}: blocks {} {}", c.rms_z, c.largest_z);
}

#[test]
fn light_alone_makes_the_same_picture_of_matte_things() {
    let stage = scenes::matte();
    // Tilted and shifted, so that no symmetry hides a wrong sign.
    let d = description(FIGURE_3).with(|c| {
        c.film.tilt_rad = 0.15;
        c.film.swing_rad = -0.1;
        c.film.shift_mm = [4.0, -3.0];
    });
    let a: Vec<_> = (0..RENDERS)
        .map(|k| blocks(&render(&stage, &d, Settings { max_bounces: 1, ..settings(Integrator::Path, 12, 1 + k) })))
        .collect();
    let b: Vec<_> = (0..RENDERS).map(|k| blocks(&light_alone(&stage, &d, 12, 101 + k, 1))).collect();
    check("light alone", &compare(&a, &b));
}

/// A small square off the axis: its place and brightness by light paths.
#[test]
fn a_point_is_where_the_camera_sees_it() {
    let stage = scenes::small_square();
    let d = description(FIGURE_3);
    let centre = |picture: &[[f32; 4]]| {
        let mut sums = [0.0f64; 3];
        for (i, pixel) in picture.iter().enumerate() {
            let (x, y) = (i % WIDTH as usize, i / WIDTH as usize);
            for (sum, part) in sums.iter_mut().zip([1.0, x as f64 + 0.5, y as f64 + 0.5]) {
                *sum += f64::from(pixel[1]) * part;
            }
        }
        [sums[0], sums[1] / sums[0], sums[2] / sums[0]]
    };
    let seen = centre(&render(&stage, &d, settings(Integrator::Path, 192, 1)));
    let made = centre(&light_alone(&stage, &d, 64, 2, 0));
    // Right of the middle and above it, in a picture whose rows start from below.
    assert!(seen[1] > 30.0 && seen[2] > 20.0, "{seen:?}");
    // Some thousand of the camera's samples hit the square's few pixels.
    assert!((made[0] / seen[0] - 1.0).abs() < 0.03, "{made:?} {seen:?}");
    assert!((made[1] - seen[1]).abs() < 0.05 && (made[2] - seen[2]).abs() < 0.05, "{made:?} {seen:?}");
}

#[test]
fn a_box_under_a_lamp() {
    agree("box", &scenes::box_under_a_lamp(), &description(FIGURE_3), 12, 5);
}

#[test]
fn caustics() {
    let small = LampKind::Area { size: [0.2, 0.2], ellipse: false, half_spread_rad: 1.6 };
    agree("caustic", &scenes::caustic(small), &description(FIGURE_3), 60, 5);
    agree("rough caustic", &scenes::rough_caustic(), &description(FIGURE_3), 32, 5);
}

#[test]
fn glowing_meshes() {
    agree("emissive", &scenes::emissive(), &description(FIGURE_3), 12, 5);
}

#[test]
fn suns() {
    agree("wide sun", &scenes::sun(0.1), &description(FIGURE_3), 24, 5);
}

#[test]
fn a_sky_with_an_image() {
    agree("image sky", &scenes::image_sky(), &description(FIGURE_3), 12, 5);
}

#[test]
fn transparent_leaves() {
    agree("leaves", &scenes::leaves(), &description(FIGURE_3), 12, 5);
}

#[test]
fn lamps_of_all_kinds() {
    agree("lamps", &scenes::many_lamps(), &description(FIGURE_3), 12, 5);
}

/// The near and the far part of a scene are left out in the same way; the parts left out still emit, and cast shadows.
#[test]
fn what_is_clipped() {
    let stage = scenes::box_under_a_lamp();
    let whole = description(FIGURE_3);
    let clipped = CameraDescription { clip: [3.45, 4.5], ..whole.clone() };
    let mean = |d| *blocks(&render(&stage, d, settings(Integrator::Path, 4, 1))).last().unwrap();
    let (all, some) = (mean(&whole), mean(&clipped));
    assert!((some / all - 1.0).abs() > 0.05, "{all} {some}");
    agree("clipped", &stage, &clipped, 12, 5);
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let stage = scenes::box_under_a_lamp();
    let one = |threads| {
        render(&stage, &description(FIGURE_3), Settings { threads, ..settings(Integrator::Bidirectional, 7, 5) })
    };
    let first = one(1);
    assert!(first.iter().any(|p| p[1] > 0.1));
    assert!(first == one(4));
}

#[test]
fn cameras_that_take_no_light_paths_say_so() {
    let start = |d: &CameraDescription| {
        let camera = Camera::new(d, WIDTH, HEIGHT).unwrap();
        let job = Job::start(scenes::small_square(), camera, settings(Integrator::Bidirectional, 1, 1));
        job.map(|_| ()).unwrap_err().to_string()
    };
    let d = description(FIGURE_3);
    for model in [Model::Pinhole, Model::Thin, Model::Thick, Model::Paraxial] {
        let error = start(&CameraDescription { model, ..d.clone() });
        assert!(error.contains("choose the lens as camera"), "{error}");
    }
    let stretched = CameraDescription { scale_mm_per_unit: DVec3::new(1000.0, 1000.0, 900.0), ..d };
    assert!(start(&stretched).contains("one scale for all three axes"));
}

/// The world may be left out of the picture, and light limited, the same way.
#[test]
fn what_the_camera_does_not_see_still_shines() {
    let stage = scenes::image_sky();
    let s = |integrator| Settings { transparent_film: true, ..settings(integrator, 64, 3) };
    let d = description(FIGURE_3);
    let alpha = |picture: &[[f32; 4]]| picture.iter().map(|p| p[3]).sum::<f32>() / picture.len() as f32;
    let (a, b) = (render(&stage, &d, s(Integrator::Path)), render(&stage, &d, s(Integrator::Bidirectional)));
    assert!((alpha(&a) - alpha(&b)).abs() < 1e-3 && alpha(&a) > 0.2, "{} {}", alpha(&a), alpha(&b));
    let (mean_a, mean_b) = (blocks(&a), blocks(&b));
    let last = mean_a.len() - 2;
    // Two renders of 100 000 paths each.
    assert!((mean_a[last] / mean_b[last] - 1.0).abs() < 0.03, "{} {}", mean_a[last], mean_b[last]);
}
