//! Determinism, stopping, and whole pictures with a known answer.

use super::*;
use crate::Rgb;
use crate::camera::{CameraDescription, Model};
use crate::sampler::warp::Filter;
use crate::scene::{SceneBuilder, mesh::MeshDescription, world::World};
use glam::{DMat4, DVec3, Vec3};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

pub(super) fn settings(samples: u32, threads: usize) -> Settings {
    Settings {
        width: 75,
        height: 50,
        samples,
        seed: 4,
        threads,
        max_bounces: 4,
        with_data: true,
        ..Settings::default()
    }
}

fn description(model: Model) -> CameraDescription {
    CameraDescription {
        model,
        lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses/wide-angle-smith-f3.4.lens"),
        spectrum: crate::camera::Spectrum::Visible,
        ..CameraDescription::default()
    }
    .with(|c| {
        c.focus.distance = Some(3.0);
        c.film.width_mm = 90.0;
        c.film.height_mm = 60.0;
        c.film.tilt_rad = 0.1;
    })
}

/// The camera of a model, made at its first use: the maps of a lens take longer than a small picture.
pub(super) fn camera(model: Model) -> Camera {
    static MADE: Mutex<Vec<(Model, Camera)>> = Mutex::new(Vec::new());
    // A test that has failed leaves the table whole.
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, camera)) = made.iter().find(|(one, _)| *one == model) {
        return camera.clone();
    }
    let camera = Camera::new(&description(model), 75, 50).unwrap();
    made.push((model, camera.clone()));
    camera
}

pub(super) fn stage() -> Arc<PreparedScene> {
    let mut builder = SceneBuilder::new();
    let triangle = MeshDescription {
        name: "triangle".into(),
        positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(triangle).unwrap();
    let place = DMat4::from_translation(DVec3::new(0.0, 0.0, -3.0));
    builder.add_instance("triangle", mesh, place, &[], true, true).unwrap();
    builder.set_world(World { color: Rgb::ONE, ..Default::default() }).unwrap();
    Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)))
}

fn picture(samples: u32, threads: usize, model: Model) -> (Vec<[f32; 4]>, Statistics) {
    let job = Job::start(stage(), camera(model), settings(samples, threads)).unwrap();
    assert!(job.wait(Duration::from_secs(120)));
    (job.film().picture(), job.statistics())
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    for model in [Model::Lens, Model::Pinhole, Model::Thin, Model::Thick, Model::Paraxial] {
        let (one, _) = picture(23, 1, model);
        for threads in [2, 5] {
            assert!(one == picture(23, threads, model).0, "{model:?} with {threads} threads");
        }
    }
}

#[test]
fn statistics_count_what_was_done() {
    let (_, s) = picture(20, 2, Model::Lens);
    assert_eq!(s.samples, 20);
    assert_eq!(s.counts.camera_rays, 20 * 75 * 50);
    assert!(s.counts.camera_rays_lost < s.counts.camera_rays / 5, "{}", s.counts.camera_rays_lost);
    assert!(s.counts.rays >= s.counts.camera_rays - s.counts.camera_rays_lost);
    assert_eq!(s.counts.non_finite, 0);
    assert!(s.failure.is_none());
}

/// The furnace through the pinhole: the triangle reflects less than the world is bright, all else is one.
#[test]
fn a_white_world_is_white_through_a_pinhole() {
    let (pixels, _) = picture(16, 2, Model::Pinhole);
    assert!(pixels.iter().all(|p| p[0] <= 1.0 + 1e-3 && p[0] > 0.7 && p[3] == 1.0));
    assert!((pixels[0][1] - 1.0).abs() < 1e-5);
    assert!(pixels[25 * 75 + 37][1] < 0.95);
}

#[test]
fn stopping_is_quick_and_keeps_what_is_there() {
    let job = Job::start(stage(), camera(Model::Lens), settings(1 << 20, 2)).unwrap();
    assert!(!job.wait(Duration::from_millis(300)));
    job.stop();
    // A tile's pixel takes at most some milliseconds; 0.3 s is the promise to the user.
    assert!(job.wait(Duration::from_millis(300)));
    let s = job.statistics();
    assert!(s.samples > 0 && s.samples < 1 << 20);
    assert!(job.film().picture().iter().any(|p| p[0] > 0.5));
    assert!(job.progress() < 1.0);
}

#[test]
fn passes_add_up() {
    for n in [1, 2, 3, 16, 17, 64, 100, 1000] {
        let list = passes(n);
        assert_eq!(list.iter().map(|p| p.1).sum::<u32>(), n);
        assert!(list.windows(2).all(|w| w[0].0 + w[0].1 == w[1].0));
    }
}

/// Samples 0..8 and 8..16 of one seed average to samples 0..16: renders can be split.
#[test]
fn ranges_of_samples_merge() {
    let render = |first, samples| {
        let s = Settings { sample_offset: first, ..settings(samples, 2) };
        let job = Job::start(stage(), camera(Model::Lens), s).unwrap();
        assert!(job.wait(Duration::from_secs(60)));
        job.film().picture()
    };
    let (a, b, all) = (render(0, 8), render(8, 8), render(0, 16));
    for ((a, b), c) in a.iter().zip(&b).zip(&all) {
        assert!((0.5 * (a[0] + b[0]) - c[0]).abs() < 1e-5);
    }
}

#[test]
fn settings_out_of_range_are_refused() {
    let start = |s: Settings| Job::start(stage(), camera(Model::Pinhole), s).map(|_| ()).unwrap_err().to_string();
    assert!(start(settings(0, 1)).contains("at least one"));
    assert!(start(Settings { width: 0, ..settings(1, 1) }).contains("resolution 0 x 50"));
    assert!(start(Settings { clamp_indirect: -1.0, ..settings(1, 1) }).contains("clamped at -1"));
    assert!(start(Settings { filter: Filter::Gaussian(f32::NAN), ..settings(1, 1) }).contains("filter"));
}

/// A slanted plane, out of focus, through a lens with a tilted film: the mean of points of a plane lies in it, and the
/// picture of a place is where the place is seen.
#[test]
fn passes_of_data_lie_on_what_the_lens_sees() {
    let mut builder = SceneBuilder::new();
    let quad = MeshDescription {
        name: "quad".into(),
        positions: [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(quad).unwrap();
    let turn = DMat4::from_rotation_y(0.5);
    let place = DMat4::from_translation(DVec3::new(100.0, 50.0, -4.5));
    builder.add_instance("quad", mesh, place * turn, &[], true, true).unwrap();
    let origin = DVec3::new(100.0, 50.0, 0.0);
    let stage = Arc::new(PreparedScene::new(builder.build(origin)));
    let normal = turn.transform_vector3(DVec3::Z).as_vec3();
    for pipeline in [Pipeline::FilmFirst, Pipeline::Hero, Pipeline::SceneFirst] {
        let settings = Settings { pipeline, ..settings(64, 2) };
        let job = Job::start(stage.clone(), camera(Model::Lens), settings).unwrap();
        assert!(job.wait(Duration::from_secs(120)));
        let (depth, position, normals) =
            (job.data(DataPass::Depth), job.data(DataPass::Position), job.data(DataPass::Normal));
        let at = |list: &[f32], x: usize, y: usize| Vec3::from_slice(&list[3 * (y * 75 + x)..]);
        for (x, y) in (4..46).flat_map(|y| (4..71).map(move |x| (x, y))) {
            let p = at(&position, x, y);
            // Single precision at a hundred units.
            assert!((p - place.transform_point3(DVec3::ZERO).as_vec3()).dot(normal).abs() < 2e-4, "{pipeline:?} {p}");
            assert!((depth[y * 75 + x] + p.z).abs() < 2e-4);
            assert!((at(&normals, x, y) - normal).length() < 1e-4);
        }
        // Right and up in the picture are right and up in the world, evenly about the middle.
        let across = at(&position, 60, 25).x - at(&position, 15, 25).x;
        assert!(across > 1.0 && at(&position, 37, 40).y - at(&position, 37, 10).y > 0.5);
        let info = crate::camera::lens_info(&description(Model::Lens), 75, 50).unwrap();
        let (seen, far) = (at(&position, 37, 25).x - 100.0, depth[25 * 75 + 37]);
        // The middle looks along the axis, to a pixel and the blur's noise.
        assert!(
            seen.abs() < 1.5 * far * (info.picture_width_mm / info.viewport_focal_length_mm) as f32 / 75.0,
            "{seen}"
        );
    }
    // Nothing there: background.
    let empty = Arc::new(PreparedScene::new(SceneBuilder::new().build(DVec3::ZERO)));
    let job = Job::start(empty, camera(Model::Lens), settings(2, 1)).unwrap();
    assert!(job.wait(Duration::from_secs(120)));
    assert!(job.data(DataPass::Depth).iter().all(|&d| d == FARTHEST));
    assert!(job.data(DataPass::Normal).iter().all(|&n| n == 0.0));
}

/// A diaphragm that closes and a focus that moves while the shutter is open: the mean of the pictures at each time.
#[test]
fn a_lens_that_moves_takes_the_mean_of_its_pictures() {
    let at = |i: usize| {
        let d = description(Model::Lens).with(|c| {
            c.focus.distance = Some([2.2, 3.0, 6.0][i]);
            c.lens.f_number = Some([4.0, 5.6, 8.0][i]);
        });
        Camera::new(&d, 75, 50).unwrap()
    };
    let picture = |cameras: Vec<Camera>, samples| {
        let job = Job::start_moving(stage(), cameras, settings(samples, 2)).unwrap();
        assert!(job.wait(Duration::from_secs(120)));
        job.film().picture()
    };
    let together = picture((0..3).map(at).collect(), 192);
    let apart: Vec<_> = (0..3).map(|i| picture(vec![at(i)], 64)).collect();
    let mean = |x: usize, y: usize, pixels: &[[f32; 4]]| {
        (0..25).map(|i| pixels[(y + i / 5) * 75 + x + i % 5][1]).sum::<f32>() / 25.0
    };
    for (x, y) in (0..70).step_by(7).flat_map(|x| (0..45).step_by(6).map(move |y| (x, y))) {
        let expected = apart.iter().map(|p| mean(x, y, p)).sum::<f32>() / 3.0;
        // Noise of 25 pixels with 192 samples each.
        assert!((mean(x, y, &together) - expected).abs() < 0.02, "{x} {y}: {} {expected}", mean(x, y, &together));
    }
    assert!(Job::start_moving(stage(), Vec::new(), settings(1, 1)).is_err());
}

/// Mattes and vectors: the same bits for any number of threads, and the way of a thing that moves across before a camera
/// that stands is that of its picture.
#[test]
fn mattes_and_vectors_do_not_depend_on_threads() {
    use crate::camera::tools::imaging::Imaging;
    use crate::film::cryptomatte::id;
    let mut builder = SceneBuilder::new();
    let triangle = MeshDescription {
        name: "triangle".into(),
        positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let mesh = builder.add_mesh(triangle).unwrap();
    let at = |x: f64| DMat4::from_translation(DVec3::new(x, 0.0, -3.0));
    for name in ["still", "moves"] {
        let place = DMat4::from_translation(DVec3::new(0.0, if name == "still" { 0.5 } else { -0.5 }, 0.0));
        let instance = builder.add_instance(name, mesh, place * at(0.0), &[], true, true).unwrap().unwrap();
        if name == "moves" {
            builder.set_moved(instance, [place * at(-0.1), place * at(0.3)]).unwrap();
        }
    }
    let stage = Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)));
    let render = |model: Model, threads: usize| {
        let imaging = || Imaging::new(&description(model), 75, 50, DVec3::ZERO).unwrap();
        let motion = Some(Motion::new(imaging(), [imaging(), imaging()], 75, 50));
        let beside = OutputOptions {
            mattes: vec![MatteLayer::Object, MatteLayer::Asset],
            matte_levels: 3,
            motion,
            ..OutputOptions::default()
        };
        let job = Job::start_with(stage.clone(), vec![camera(model)], settings(37, threads), beside).unwrap();
        assert!(job.wait(Duration::from_secs(120)));
        let bits = |list: Vec<f32>| list.into_iter().map(f32::to_bits).collect::<Vec<u32>>();
        [job.matte(MatteLayer::Object), job.matte(MatteLayer::Asset), job.data(DataPass::Vector)].map(bits)
    };
    for model in [Model::Lens, Model::Pinhole] {
        let one = render(model, 1);
        assert!(one == render(model, 3));
        assert_eq!(one[0], one[1]);
        // Below the upper triangle.
        let pixel = 6 * 75 + 37;
        let names = &one[0][8 * pixel..][..4];
        assert_eq!((names[0], f32::from_bits(names[1])), (id("moves"), 1.0));
        let vector: Vec<f32> = one[2][4 * pixel..][..4].iter().map(|&bits| f32::from_bits(bits)).collect();
        if model == Model::Pinhole {
            let pixels_per_unit = 75.0 * 50.0 / 36.0 / 3.0;
            let expected = [-0.1 * pixels_per_unit, 0.0, -0.3 * pixels_per_unit, 0.0];
            // Single precision.
            assert!(vector.iter().zip(expected).all(|(v, e)| (v - e).abs() < 1e-3), "{vector:?}");
        } else {
            assert!((vector[2] / vector[0] - 3.0).abs() < 0.05 && vector[0] < -1.0, "{vector:?}");
        }
        // The corner sees nothing, which lies still.
        assert_eq!(one[2][..4], [0; 4]);
    }
}

/// Ranges of samples, rendered apart, joined by their counts with the remainders of their sums: the whole to the last bit.
#[test]
fn ranges_of_samples_make_the_whole() {
    use crate::integrator::Integrator;
    let render = |settings: Settings| {
        let job = Job::start(stage(), camera(Model::Lens), settings).unwrap();
        assert!(job.wait(Duration::from_secs(120)));
        (job.film().picture(), job.film().remainders())
    };
    let kinds = [
        Settings { pipeline: Pipeline::FilmFirst, ..settings(0, 2) },
        Settings { pipeline: Pipeline::Hero, film_exposure: 0.5, ..settings(0, 2) },
        Settings { integrator: Integrator::Bidirectional, ..settings(0, 2) },
    ];
    for kind in kinds {
        let (whole, _) = render(Settings { samples: 30, ..kind.clone() });
        let mut sums = vec![[0.0f64; 4]; whole.len()];
        let mut by_means = vec![[0.0f64; 4]; whole.len()];
        for (sample_offset, samples) in [(0u32, 7u32), (7, 19), (26, 4)] {
            let (picture, rest) = render(Settings { samples, sample_offset, ..kind.clone() });
            for (i, pixel) in picture.iter().enumerate() {
                for c in 0..4 {
                    let coarse = f64::from(pixel[c]) * f64::from(samples);
                    by_means[i][c] += coarse;
                    sums[i][c] += coarse + f64::from(rest[i][0][c]) + f64::from(rest[i][1][c]);
                }
            }
        }
        let joined = |sums: &[[f64; 4]]| sums.iter().map(|s| s.map(|s| (s / 30.0) as f32)).collect::<Vec<_>>();
        assert!(joined(&sums) == whole, "{:?}", kind.pipeline);
        // Their means alone do not: the test would see it.
        assert!(joined(&by_means) != whole, "{:?}", kind.pipeline);
    }
}

/// A part of a picture is that part of the whole one, and the rest is not rendered; where light spreads, the pixels that are not near the
/// edge.
#[test]
fn a_window_is_the_same_picture() {
    let window = [40, 20, 20, 12];
    for (model, pipeline) in [(Model::Pinhole, Pipeline::FilmFirst), (Model::Lens, Pipeline::Hero)] {
        let render = |window| {
            let settings = Settings { width: 150, height: 100, window, pipeline, ..settings(3, 2) };
            let camera = Camera::new(&description(model), 150, 100).unwrap();
            let job = Job::start(stage(), camera, settings).unwrap();
            assert!(job.wait(Duration::from_secs(120)));
            assert_eq!((job.samples_done(), job.progress()), (3, 1.0));
            (job.film().picture(), job.statistics().counts.camera_rays)
        };
        let ((whole, all), (part, fewer)) = (render(None), render(Some(window)));
        assert!(2 * fewer < all, "{fewer} of {all}");
        let [x, y, width, height] = window;
        for (i, (a, b)) in whole.iter().zip(&part).enumerate() {
            let (column, row) = (i as u32 % 150, i as u32 / 150);
            if (x..x + width).contains(&column) && (y..y + height).contains(&row) {
                // Sums of far light come in another order.
                assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{model:?} {column} {row}: {a:?} {b:?}");
            }
        }
        assert_eq!(part[0], [0.0; 4]);
    }
}
