//! Determinism, stopping, and whole pictures with a known answer.

use super::*;
use crate::Rgb;
use crate::camera::{CameraDescription, Model};
use crate::scene::{SceneBuilder, mesh::MeshDescription, world::World};
use glam::{DMat4, DVec3, Vec3};
use std::path::Path;

fn settings(samples: u32, threads: usize) -> Settings {
    Settings {
        width: 75,
        height: 50,
        samples,
        seed: 4,
        sample_offset: 0,
        threads,
        max_bounces: 4,
        clamp_indirect: 0.0,
        filter_width_px: 1.5,
        transparent_film: false,
        pipeline: Pipeline::Auto,
    }
}

fn camera(model: Model) -> Camera {
    let d = CameraDescription {
        object_name: "Camera".into(),
        model,
        matrix_world: DMat4::IDENTITY,
        pinhole_focal_length_mm: 50.0,
        pinhole_film_width_mm: 36.0,
        pinhole_shift: [0.0, 0.0],
        lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses/wide-angle-smith-f3.4.lens"),
        focal_length_mm: None,
        focal_scale: None,
        f_number: None,
        blades: 0,
        blade_rotation_rad: 0.0,
        focus_distance: Some(3.0),
        focusing: Default::default(),
        focus_point_world: None,
        film_distance_mm: None,
        film_width_mm: 90.0,
        film_height_mm: 60.0,
        tilt_rad: 0.1,
        swing_rad: 0.0,
        shift_mm: [0.0, 0.0],
        scale_mm_per_unit: DVec3::splat(1000.0),
        wavelength_nm: None,
        spectrum: crate::camera::Spectrum::Visible,
    };
    Camera::new(&d, 75, 50).unwrap()
}

fn stage() -> Arc<Stage> {
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
    Arc::new(Stage::new(builder.build(DVec3::ZERO)))
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
    assert!(start(Settings { filter_width_px: f32::NAN, ..settings(1, 1) }).contains("filter"));
}
