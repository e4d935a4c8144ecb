//! Small lights far out of focus, traced to the lens: the picture of path tracing alone, with less noise.

use crate::cameras::camera;
use crate::scenes::{self, Room};
use glam::{DMat4, DVec3};
use petzval_optics::system::FocalLength;
use petzval_render::Rgb;
use petzval_render::camera::clip::Clip;
use petzval_render::camera::shutter::{Exposure, Shutter};
use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::integrator::path::parts::{LightPass, Parts, Seen};
use petzval_render::integrator::{Integrator, PreparedScene};
use petzval_render::job::{Job, OutputOptions, Settings};
use petzval_render::nodes::OF_MATERIALS;
use petzval_render::pipeline::Pipeline;
use petzval_render::pipeline::aiming::AimedReport;
use petzval_render::scene::closure::Closure;
use petzval_render::scene::graph::Graph;
use petzval_render::scene::lamp::{Lamp, LampKind};
use petzval_render::scene::material::Material;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 32;
/// Side of a block whose mean is compared, pixels.
const BLOCK: u32 = 4;

/// A long lens wide open on a small film, focused far before the lights.
fn description() -> CameraDescription {
    CameraDescription {
        model: Model::Lens,
        lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses/wide-angle-smith-f3.4.lens"),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.lens.focal_length = FocalLength::Millimetres(80.0);
        c.focus.distance = Some(1.0);
        c.film.width_mm = 12.0;
        c.film.height_mm = 8.0;
    })
}

fn settings(light_tracing: bool, samples: u32, seed: u32) -> Settings {
    Settings {
        width: WIDTH,
        height: HEIGHT,
        samples,
        seed,
        threads: 2,
        max_bounces: 2,
        light_tracing,
        ..Settings::default()
    }
}

/// Lights of every kind before a dark wall; their size, Blender units, is about that radius.
fn lights(radius: f32) -> Arc<PreparedScene> {
    room_of_lights(radius).finish()
}

/// The lights of [`lights`] in fog that glows faintly, with the camera in it; the density is even, or rises from the floor.
fn foggy(radius: f32, is_even: bool) -> Arc<PreparedScene> {
    let density = if is_even { "0.08" } else { r#"{"node": 1, "socket": "Value"}"# };
    let nodes = format!(
        r#"{{"nodes": [
            {{"type": "ShaderNodeVolumePrincipled", "inputs": {{"Color": [0.7, 0.8, 0.9], "Density": {density}, "Anisotropy": 0.3,
                "Emission Strength": 0.002, "Emission Color": [1, 1, 1], "Blackbody Intensity": 0}}}},
            {{"type": "ShaderNodeMath", "options": {{"operation": "MULTIPLY_ADD"}},
                "inputs": {{"Value": {{"node": 2, "socket": "Y"}}, "Value_001": 0.5, "Value_002": 0.1}}}},
            {{"type": "ShaderNodeSeparateXYZ", "inputs": {{"Vector": {{"node": 3, "socket": "Object"}}}}}},
            {{"type": "ShaderNodeTexCoord", "inputs": {{}}}}
        ], "surface": null, "volume": {{"node": 0, "socket": "Volume"}}, "displacement": null}}"#
    );
    let (graph, reports) = Graph::of(&petzval_nodes::Graph::from_json(&nodes).unwrap(), 0, OF_MATERIALS);
    assert_eq!(reports, Vec::<String>::new());
    let mut room = room_of_lights(radius);
    room.put(scenes::ball(8), Material::new("fog", Arc::new(graph)), scenes::place([0.0; 3], [0.0; 3], 12.0));
    room.finish()
}

fn room_of_lights(radius: f32) -> Room {
    let mut room = Room::new();
    let size = f64::from(radius);
    let lamp = |kind, watts: f32| scenes::lamp(kind, watts);
    let (soft, hard) = (LampKind::Point { radius, soft: true }, LampKind::Point { radius, soft: false });
    room.light(lamp(soft, 0.05), DMat4::from_translation(DVec3::new(-0.22, 0.12, -4.5)));
    room.light(lamp(hard, 0.06), DMat4::from_translation(DVec3::new(0.2, 0.1, -4.2)));
    let towards_camera = |at| scenes::place(at, [0.0, PI + 0.3, 0.0], 1.0);
    let flat = LampKind::Area { size: [2.0 * radius, 3.0 * radius], ellipse: true, half_spread_rad: 1.2 };
    room.light(lamp(flat, 0.01), towards_camera([0.02, -0.12, -4.4]));
    let spot = LampKind::Spot { radius, half_angle_rad: 0.8, blend: 0.4, soft: false };
    room.light(lamp(spot, 0.05), towards_camera([-0.2, -0.1, -4.0]));
    let glowing = |light: f32| Material::diffuse("glowing", Rgb::splat(0.5), Rgb::new(0.5, 0.8, 1.0) * light);
    room.put(scenes::ball(6), glowing(8.0), scenes::place([0.05, 0.08, -4.6], [0.3, 0.2, 0.1], size));
    room.put(scenes::square(), glowing(8.0), scenes::place([0.25, -0.08, -4.5], [0.5, -0.7, 0.0], size));
    // Half of the soft lamp's light comes through a pane.
    let matte = Closure::Diffuse { color: Rgb::new(0.8, 0.3, 0.3), roughness: 0.0 };
    let pane = Material::even("pane", [(0.5, matte), (0.5, Closure::Transparent { color: Rgb::new(1.0, 0.8, 0.6) })]);
    room.put(scenes::square(), pane, scenes::place([-0.15, 0.1, -3.0], [0.1, 0.2, 0.0], 0.06));
    room
}

/// The results of a render.
struct Rendered {
    picture: Vec<[f32; 4]>,
    report: AimedReport,
    emission: Option<Vec<[f32; 3]>>,
}

fn render_with(stage: &Arc<PreparedScene>, d: &CameraDescription, s: Settings, beside: OutputOptions) -> Rendered {
    let camera: Camera = camera(d, s.width, s.height);
    let beside = OutputOptions { clip: Clip::new(d, &camera), ..beside };
    let job = Job::start_with(stage.clone(), vec![camera], s, beside).unwrap();
    assert!(job.wait(Duration::from_secs(600)));
    let statistics = job.statistics();
    assert!(statistics.failure.is_none() && statistics.counts.non_finite == 0, "{statistics:?}");
    Rendered {
        picture: job.film().picture(),
        report: job.report().light_tracing,
        emission: job.part(LightPass::Emission),
    }
}

/// A picture, and the decision on the lights.
fn render(stage: &Arc<PreparedScene>, d: &CameraDescription, s: Settings) -> (Vec<[f32; 4]>, AimedReport) {
    let Rendered { picture, report, .. } = render_with(stage, d, s, OutputOptions::default());
    (picture, report)
}

/// Means of blocks by channel.
fn blocks<const N: usize>(picture: &[[f32; N]]) -> Vec<f64> {
    let across = WIDTH / BLOCK;
    let mut sums = vec![0.0; 3 * (across * HEIGHT / BLOCK) as usize];
    for (i, pixel) in (0..).zip(picture) {
        let block = (i / WIDTH / BLOCK * across + i % WIDTH / BLOCK) as usize;
        for channel in 0..3 {
            sums[3 * block + channel] += f64::from(pixel[channel]) / f64::from(BLOCK * BLOCK);
        }
    }
    sums
}

/// Mean over renders, and the variance of one.
fn statistics(renders: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let n = renders.len() as f64;
    let of = |i: usize| {
        let mean = renders.iter().map(|r| r[i]).sum::<f64>() / n;
        [mean, renders.iter().map(|r| (r[i] - mean).powi(2)).sum::<f64>() / (n - 1.0)]
    };
    (0..renders[0].len()).map(of).collect()
}

/// Holds renders with light tracing against others without, block by block. Twelve of each follow Student's distribution with 22 or fewer
/// degrees of freedom: of 288 numbers one beyond 5.5 has a probability of 0.5 %, and with the least noise of 1 % less.
fn agree(name: &str, with: &[Vec<f64>], without: &[Vec<f64>]) {
    let (a, b) = (statistics(with), statistics(without));
    let n = with.len() as f64;
    let brightest = b.iter().map(|m| m[0]).fold(0.0, f64::max);
    let z: Vec<f64> = a
        .iter()
        .zip(&b)
        .map(|(a, b)| (a[0] - b[0]) / ((a[1] + b[1]) / n + (0.01 * b[0] + 1e-3 * brightest).powi(2)).sqrt())
        .collect();
    let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
    let largest = z.iter().fold(0.0, |m: f64, z| m.max(z.abs()));
    let sum = |all: &[[f64; 2]]| all.iter().map(|m| m[0]).sum::<f64>();
    println!("{name}: z rms {rms:.2}, largest {largest:.2}, whole {:.4}", sum(&a) / sum(&b));
    assert!(rms < 1.3 && largest < 5.5, "{name}: {rms} {largest}");
    // Of six discs together: the noise without is 0.5 %.
    assert!((sum(&a) / sum(&b) - 1.0).abs() < 0.02, "{name}: {} {}", sum(&a), sum(&b));
}

const RENDERS: u32 = 12;

/// A lens that is turned away from the lights, and shifted by 20 mm to see them: they are as far off its axis as nothing in the picture is without
/// the shift.
#[test]
fn a_shifted_lens_gets_rays_of_lights_too() {
    let stage = lights(0.004);
    let aimed = |shift_mm: f64| {
        let d = description().with(|c| {
            c.film.shift_mm = [shift_mm, 0.0];
            // The film is 87 mm behind the lens.
            c.matrix_world = DMat4::from_rotation_y((shift_mm / 87.0).atan());
        });
        render(&stage, &d, settings(true, 1, 0)).1.aimed
    };
    let (straight, shifted) = (aimed(0.0), aimed(20.0));
    assert!(straight > 0 && shifted + 1 >= straight, "{straight} {shifted}");
}

#[test]
fn the_picture_is_that_of_camera_rays_alone() {
    let stage = lights(0.012);
    let many = |d: &CameraDescription, traced: bool, samples: u32, first: u32| -> Vec<Vec<f64>> {
        let one = |k| {
            let (picture, report) = render(&stage, d, settings(traced, samples, first + k));
            assert_eq!((report.lights, report.aimed), if traced { (6, 6) } else { (0, 0) }, "{report:?}");
            blocks(&picture)
        };
        (0..RENDERS).map(one).collect()
    };
    let d = description();
    agree("all kinds", &many(&d, true, 32, 1), &many(&d, false, 128, 101));
    // One wavelength, which camera rays without light tracing follow film-first.
    let grey = CameraDescription { wavelength_nm: Some(550.0), ..d };
    agree("one wavelength", &many(&grey, true, 32, 1), &many(&grey, false, 128, 101));
    let film_first = Settings { pipeline: Pipeline::FilmFirst, ..settings(true, 1, 1) };
    assert_eq!(render(&stage, &grey, film_first).1.aimed, 0, "the user has asked for another pipeline");
}

#[test]
fn lights_in_fog_are_those_of_camera_rays_alone() {
    let d = description();
    for (name, is_even) in [("even fog", true), ("fog that varies", false)] {
        let stage = foggy(0.012, is_even);
        let many = |traced: bool, samples: u32, first: u32| -> Vec<Vec<f64>> {
            let one = |k| {
                let (picture, report) = render(&stage, &d, settings(traced, samples, first + k));
                assert_eq!(report.aimed, if traced { 6 } else { 0 }, "{report:?}");
                blocks(&picture)
            };
            (0..RENDERS).map(one).collect()
        };
        let (with, without) = (many(true, 32, 1), many(false, 128, 101));
        agree(name, &with, &without);
        // What is won at equal samples: noise of the fog itself is left.
        let noise = |all: &[Vec<f64>], samples: f64| statistics(all).iter().map(|m| m[1] * samples).sum::<f64>();
        let won = noise(&without, 128.0) / noise(&with, 32.0);
        println!("{name}: variance {won:.1} times lower");
        assert!(won > 5.0, "{name}: {won}");
    }
}

/// Through a clip plane, from a place beside render space's origin, and in the pass of emission.
#[test]
fn what_the_camera_does_not_see_is_not_traced() {
    let stage = lights(0.012);
    let d = CameraDescription { clip: [0.1, 4.45], ..description() };
    let aside = Exposure::new(&Shutter::default()).displaced(DVec3::new(0.03, -0.02, 0.1));
    let seen = || Seen::by(DMat4::IDENTITY, DVec3::ZERO, false, [0.0, 1.0, 1.0]);
    let many = |traced: bool, samples: u32, first: u32| -> [Vec<Vec<f64>>; 2] {
        let one = |k| {
            let beside = OutputOptions {
                exposure: Some(aside.clone()),
                parts: Parts::new(&[LightPass::Emission], seen()),
                ..OutputOptions::default()
            };
            let Rendered { picture, report, emission } =
                render_with(&stage, &d, settings(traced, samples, first + k), beside);
            // The others lie beyond the plane.
            assert_eq!(report.aimed, if traced { 2 } else { 0 }, "{report:?}");
            [blocks(&picture), blocks(&emission.unwrap())]
        };
        let all: Vec<[Vec<f64>; 2]> = (0..RENDERS).map(one).collect();
        [0, 1].map(|which| all.iter().map(|both| both[which].clone()).collect())
    };
    let (with, without) = (many(true, 32, 1), many(false, 128, 101));
    agree("clipped", &with[0], &without[0]);
    agree("emission", &with[1], &without[1]);
}

/// A render of a part of the picture has the light that this part has in the whole.
#[test]
fn a_part_of_the_picture_has_its_light() {
    let stage = lights(0.006);
    let d = description();
    // A larger picture, so that tiles are left out; about the lamp above on the right.
    let s = |window, seed| Settings { width: 192, height: 128, window, ..settings(true, 8, seed) };
    let window = [128, 66, 40, 40];
    let light = |picture: &[[f32; 4]]| -> f64 {
        let [left, bottom, width, height] = window.map(|pixels| pixels as usize);
        let rows = picture.chunks(192).skip(bottom).take(height);
        rows.flat_map(|row| &row[left..left + width]).map(|pixel| f64::from(pixel[1])).sum()
    };
    let (whole, report) = render(&stage, &d, s(None, 1));
    let (part, of_part) = render(&stage, &d, s(Some(window), 2));
    assert!(report.aimed == 6 && of_part.aimed == 6, "{report:?} {of_part:?}");
    assert!(part[..192 * 8].iter().all(|pixel| pixel[1] == 0.0), "nothing far from the window is rendered");
    // The disc takes 600 pixels, each with eight rays or more.
    let ratio = light(&part) / light(&whole);
    assert!(light(&whole) > 10.0 && (ratio - 1.0).abs() < 0.02, "{ratio}");
}

/// Bidirectional paths with traced lights take the picture that path tracing takes by camera rays alone, of all wavelengths and of one.
#[test]
fn bidirectional_paths_share_the_lights_too() {
    let stage = lights(0.012);
    let d = description();
    let grey = CameraDescription { wavelength_nm: Some(550.0), ..d.clone() };
    let moved = || OutputOptions {
        exposure: Some(Exposure::new(&Shutter::default()).displaced(DVec3::new(0.03, -0.02, 0.1))),
        ..OutputOptions::default()
    };
    for (name, d, clamp_direct, beside) in [
        ("all wavelengths", &d, 0.0, OutputOptions::default as fn() -> _),
        ("one", &grey, 0.0, OutputOptions::default),
        ("aside", &d, 0.0, moved),
        // Half of the brightest lamp's radiance: what is clamped is the light of the ray, not its weighted parts. Scattered light is clamped
        // otherwise than in path tracing.
        ("clamped", &d, 4.0, OutputOptions::default),
    ] {
        let many = |integrator, traced: bool, samples: u32, first: u32| -> Vec<Vec<f64>> {
            let one = |k| {
                let s = Settings { integrator, clamp_direct, ..settings(traced, samples, first + k) };
                let Rendered { picture, report, .. } = render_with(&stage, d, s, beside());
                assert_eq!(report.aimed, if traced { 6 } else { 0 }, "{report:?}");
                blocks(&picture)
            };
            (0..RENDERS).map(one).collect()
        };
        let traced = many(Integrator::Bidirectional, true, 32, 1);
        let alone = if clamp_direct == 0.0 { Integrator::Path } else { Integrator::Bidirectional };
        agree(name, &traced, &many(alone, false, 128, 101));
    }
}

/// The smaller a light, the more is won: one of 2 mm before a pupil of 24 mm is hit 0.002 times a sample, whose variance is 500 times its
/// square, and more where the rays of lights are stratified. Measured: 1500.
#[test]
fn small_lights_lose_their_noise() {
    [Integrator::Path, Integrator::Bidirectional].into_iter().for_each(small_lights_lose_their_noise_by);
}

fn small_lights_lose_their_noise_by(integrator: Integrator) {
    let stage = lights(0.002);
    let d = description();
    let many = |traced: bool| -> Vec<[f64; 2]> {
        let one = |k: u32| {
            let (picture, _) = render(&stage, &d, Settings { integrator, ..settings(traced, 16, 1 + k) });
            picture.iter().map(|pixel| f64::from(pixel[1])).collect()
        };
        statistics(&(0..16).map(one).collect::<Vec<Vec<f64>>>())
    };
    let (with, without) = (many(true), many(false));
    // The pixels of the discs.
    let brightest = with.iter().map(|m| m[0]).fold(0.0, f64::max);
    let lit: Vec<usize> = (0..with.len()).filter(|&i| with[i][0] > 0.3 * brightest).collect();
    let noise = |all: &[[f64; 2]]| lit.iter().map(|&i| all[i][1]).sum::<f64>();
    println!("{} pixels: variance {:.1} times lower", lit.len(), noise(&without) / noise(&with));
    assert!(lit.len() > 50 && noise(&without) > 200.0 * noise(&with), "{} {}", noise(&without), noise(&with));
}

#[test]
fn large_and_dim_lights_are_left_to_the_camera() {
    let d = description();
    let aimed = |stage| render(&stage, &d, settings(true, 1, 1)).1;
    // As large as their blur.
    assert_eq!(aimed(lights(0.1)).aimed, 0);
    let mut room = Room::new();
    let dim = Lamp { color: Rgb::splat(1e-7), ..scenes::lamp(LampKind::Point { radius: 0.004, soft: true }, 1.0) };
    room.light(dim, DMat4::from_translation(DVec3::new(0.0, 0.0, -4.5)));
    assert_eq!(aimed(room.finish()).aimed, 0);
    // In focus.
    let sharp = description().with(|c| c.focus.distance = Some(4.4));
    assert_eq!(render(&lights(0.012), &sharp, settings(true, 1, 1)).1.aimed, 0);
}

/// Pixels that get as many samples as they need: light of rays from lights is right in the mean, and no error of the pixels in whose turn
/// they were sent.
#[test]
fn pixels_far_from_the_lights_need_no_more_samples() {
    let stage = lights(0.012);
    let d = description();
    let s =
        |traced, threshold, samples, seed| Settings { noise_threshold: threshold, ..settings(traced, samples, seed) };
    let mean =
        |picture: &[[f32; 4]]| picture.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / picture.len() as f64;
    let samples = |traced| {
        let job = Job::start(stage.clone(), camera(&d, WIDTH, HEIGHT), s(traced, 0.1, 1024, 1)).unwrap();
        assert!(job.wait(Duration::from_secs(600)));
        (job.statistics().mean_samples, mean(&job.film().picture()))
    };
    let ((traced, light), (plain, _)) = (samples(true), samples(false));
    let truth = mean(&render(&stage, &d, s(true, 0.0, 1024, 2)).0);
    println!("{traced} samples for {plain}; light {light}, {truth}");
    assert!(traced < 0.8 * plain, "{traced} {plain}");
    assert!((light / truth - 1.0).abs() < 0.02, "{light} {truth}");
}

/// A ball whose normals point inwards glows as well.
#[test]
fn a_ball_may_be_inside_out() {
    let mut room = Room::new();
    let mut ball = scenes::ball(6);
    ball.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    ball.corner_normals = None;
    let glowing = Material::diffuse("glowing", Rgb::splat(0.5), Rgb::splat(20.0));
    room.put(ball, glowing, scenes::place([0.0, 0.0, -4.5], [0.0; 3], 0.004));
    let (picture, report) = render(&room.finish(), &description(), settings(true, 64, 1));
    assert_eq!(report.aimed, 1, "{report:?}");
    // The area of its image, by the magnification of 80 mm, which are 87 mm focused at 1 m, for 4.5 m, and 48 pixels on 12 mm. The wall
    // that it lights adds some of a tenth.
    let light: f64 = picture.iter().map(|pixel| f64::from(pixel[1])).sum();
    let expected = 20.0 * PI * (0.004_f64 * 87.0 / 4.5 * 48.0 / 12.0).powi(2);
    assert!((light / expected - 1.05).abs() < 0.08, "{light} {expected}");
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let stage = lights(0.004);
    let one = |threads| render(&stage, &description(), Settings { threads, ..settings(true, 7, 5) }).0;
    let first = one(1);
    assert!(first.iter().any(|p| p[1] > 0.1));
    assert!(first == one(4));
}
