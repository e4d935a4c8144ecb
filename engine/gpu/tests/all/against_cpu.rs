// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays on the device beside the CPU's tracer in f64, lens by lens, both ways.
//!
//! Errors are taken over what the data allow, as docs/numerics.md has it: over the change of the ray that leaves when one number of
//! the ray that enters moves by a unit in its last place. The device may be off by twice what the CPU's f32 is off. A ray that is lost
//! otherwise than in f64 must be so near to an edge that some roundings of the ray that enters decide.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use crate::common::{gpu, lens_paths, random, rays, shipped, system};
use glam::DVec3;
use petzval_gpu::device::Gpu;
use petzval_gpu::error::CpuOnly;
use petzval_gpu::kernel::{LensKernel, LineRay};
use petzval_gpu::lens::LensTable;
use petzval_gpu::number::Number;
use petzval_gpu::shader::{self, GROUP, Style};
use petzval_optics::diaphragm::ApertureMask;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::lane::Real;
use petzval_optics::system::{System, SystemSettings};
use petzval_optics::trace::{Lost, Ray, Tracer, Travel};

const WAVELENGTHS_NM: [f64; 5] = [404.66, 486.13, 546.07, 587.56, 706.52];
const RAYS: u32 = 2000;
const WAYS: [Travel; 2] = [Travel::FromScene, Travel::FromFilm];

/// What rays came to beside the CPU's f64.
#[derive(Clone, Copy, Debug, Default)]
struct Report {
    rays: usize,
    passed: usize,
    /// Largest errors of the point and of the direction over what the data allow, of the device and of the CPU's own numbers of
    /// that kind.
    device: [f64; 2],
    cpu: [f64; 2],
    /// Sums of the squares of the same.
    device_squares: [f64; 2],
    cpu_squares: [f64; 2],
    /// Rays of another fate than in f64, and those of them that no rounding explains.
    other_fate: usize,
    unexplained: usize,
}

impl Report {
    fn mean(squares: [f64; 2], passed: usize) -> [f64; 2] {
        squares.map(|sum| (sum / passed.max(1) as f64).sqrt())
    }
}

type Fate = Result<Ray, Lost>;

fn on_cpu<R: Real>(tracer: &Tracer<R>, travel: Travel, ray: Ray) -> Fate {
    match travel {
        Travel::FromScene => tracer.from_scene(ray),
        Travel::FromFilm => tracer.from_film(ray),
    }
}

/// The ray with the numbers of its entry each changed by some units in the last place of `N`.
fn moved<N: Number>(tracer: &Tracer, travel: Travel, ray: Ray, by: [f64; 6]) -> Ray {
    let (p, d) = tracer.enter(travel, ray);
    let epsilon = N::EPSILON.to_f64();
    let change = |v: DVec3, by: &[f64]| v + DVec3::new(v.x * by[0], v.y * by[1], v.z * by[2]) * epsilon;
    let (near, direction) = (change(p, &by[..3]), change(d, &by[3..]));
    // Of the vertex that `near` is seen from: where the other way ends.
    let back = if travel == Travel::FromScene { Travel::FromFilm } else { Travel::FromScene };
    let z = tracer.leave(back, DVec3::ZERO, DVec3::Z).origin.z;
    Ray { origin: near.with_z(near.z + z), direction }
}

/// How far the ray that leaves moves, point and direction, when one number of the one that enters does.
fn sensitivity<N: Number>(tracer: &Tracer, travel: Travel, ray: Ray, out: Ray) -> [f64; 2] {
    let mut most = [0.0f64; 2];
    for i in 0..6 {
        let try_by = |sign: f64| {
            let mut by = [0.0; 6];
            by[i] = sign;
            on_cpu(tracer, travel, moved::<N>(tracer, travel, ray, by)).ok()
        };
        if let Some(other) = try_by(1.0).or_else(|| try_by(-1.0)) {
            most[0] = most[0].max((other.origin - out.origin).length());
            most[1] = most[1].max((other.direction - out.direction).length());
        }
    }
    most
}

fn is_same_fate(a: &Fate, b: &Fate) -> bool {
    match (a, b) {
        (Ok(_), Ok(_)) => true,
        (Err(a), Err(b)) => a == b,
        _ => false,
    }
}

/// True if a ray that enters some roundings beside this one has this fate in f64.
fn is_near_edge<N: Number>(tracer: &Tracer, travel: Travel, ray: Ray, fate: &Fate) -> bool {
    let tries = [2.0, 8.0, 32.0].into_iter().flat_map(|size| (0..40u32).map(move |i| (size, i)));
    tries.into_iter().any(|(size, i)| {
        let by = [0, 1, 2, 3, 4, 5].map(|axis| (2.0 * random(i, axis) - 1.0) * size);
        is_same_fate(&on_cpu(tracer, travel, moved::<N>(tracer, travel, ray, by)), fate)
    })
}

fn compare<N: Number>(system: &System, travel: Travel, rays: &[LineRay], results: &[Fate]) -> Report {
    let tracers: Vec<Tracer> = WAVELENGTHS_NM.iter().map(|&nm| system.at_wavelength(nm)).collect();
    let casts: Vec<Tracer<N>> = tracers.iter().map(Tracer::cast).collect();
    let size = system.surfaces().iter().fold(1.0, |m: f64, s| m.max(s.z_mm.abs()).max(s.semi_diameter_mm));
    let epsilon = N::EPSILON.to_f64();
    let mut report = Report { rays: rays.len(), ..Report::default() };
    assert_eq!(rays.len(), results.len());
    for (&(ray, line), result) in rays.iter().zip(results) {
        let tracer = &tracers[line as usize];
        let truth = on_cpu(tracer, travel, ray);
        let own = on_cpu(&casts[line as usize], travel, ray);
        if !is_same_fate(&truth, result) {
            report.other_fate += 1;
            if !is_same_fate(&own, result) && !is_near_edge::<N>(tracer, travel, ray, result) {
                report.unexplained += 1;
                if report.unexplained <= 3 {
                    println!("{} {travel:?}: f64 {truth:?}, f32 {own:?}, device {result:?}", system.name());
                }
            }
            continue;
        }
        let (Ok(truth), Ok(result)) = (truth, result) else { continue };
        assert!(result.origin.is_finite() && (result.direction.length() - 1.0).abs() < 1e-12);
        report.passed += 1;
        let allowed = sensitivity::<N>(tracer, travel, ray, truth);
        let allowed = [allowed[0] + epsilon * size, allowed[1] + epsilon];
        let errors = |out: &Ray| {
            [(out.origin - truth.origin).length() / allowed[0], (out.direction - truth.direction).length() / allowed[1]]
        };
        for (which, error) in errors(result).into_iter().enumerate() {
            report.device[which] = report.device[which].max(error);
            report.device_squares[which] += error * error;
        }
        if let Ok(own) = own {
            for (which, error) in errors(&own).into_iter().enumerate() {
                report.cpu[which] = report.cpu[which].max(error);
                report.cpu_squares[which] += error * error;
            }
        }
    }
    report
}

/// Rays of all wavelengths in turn.
fn line_rays(system: &System, travel: Travel, count: u32) -> Vec<LineRay> {
    rays(system, travel, count).into_iter().zip((0..WAVELENGTHS_NM.len() as u32).cycle()).collect()
}

fn report_of<N: Number>(gpu: &Gpu, system: &System, travel: Travel, style: Style) -> Report {
    let lens = LensTable::new(system, &WAVELENGTHS_NM, travel).expect("a lens that devices trace");
    let rays = line_rays(system, travel, RAYS);
    let kernel = LensKernel::<N>::new(gpu, &lens, style).unwrap_or_else(|error| panic!("{error}"));
    let results = kernel.trace(&rays).unwrap_or_else(|error| panic!("{error}"));
    let report = compare::<N>(system, travel, &rays, &results);
    if N::NAME == "f32" {
        return report;
    }
    // The CPU's f64 is the truth here, so its own errors are 0: those of its f32 stand for them.
    let Report { cpu, cpu_squares, .. } = compare::<f32>(system, travel, &rays, &results);
    Report { cpu, cpu_squares, ..report }
}

/// How many times the CPU's error a device may be off.
#[derive(Clone, Copy)]
struct Allowed {
    worst: f64,
    mean: f64,
}

/// What the device's f32 is allowed beside the CPU's.
const SINGLE: Allowed = Allowed { worst: 2.0, mean: 2.0 };
/// What the difference of the device's f64 from the CPU's is allowed beside the CPU's f32, each in its own units. There is no truth
/// beyond f64 here: both have errors, and their worst are not of the same rays.
const DOUBLE: Allowed = Allowed { worst: 6.0, mean: 3.0 };
/// Errors below this many units are as good as rounded arithmetic gets, whichever of two is smaller.
const LEAST: f64 = 2.0;

/// Why the device is not as good as it must be.
fn fault(report: &Report, allowed: Allowed) -> Option<String> {
    let Report { rays, passed, device, cpu, other_fate, unexplained, .. } = *report;
    let [device_mean, cpu_mean] = [report.device_squares, report.cpu_squares].map(|sum| Report::mean(sum, passed));
    let is_off = |device: [f64; 2], cpu: [f64; 2], times: f64, least: f64| {
        device.iter().zip(cpu).any(|(d, c)| d.is_nan() || *d > times * c.max(least))
    };
    if unexplained > 0 {
        return Some(format!("{unexplained} of {rays} rays have a fate that no rounding explains"));
    }
    if other_fate * 100 > rays {
        return Some(format!("{other_fate} of {rays} rays have another fate"));
    }
    if is_off(device, cpu, allowed.worst, LEAST) {
        return Some(format!("worst errors {device:.1?} beside {cpu:.1?}"));
    }
    if is_off(device_mean, cpu_mean, allowed.mean, 0.25 * LEAST) {
        return Some(format!("mean errors {device_mean:.2?} beside {cpu_mean:.2?}"));
    }
    None
}

/// Blades differ from lens to lens.
fn settings(i: usize) -> SystemSettings {
    let (blades, blade_curvature) = [(0, 0.0), (6, 0.0), (7, 0.4)][i % 3];
    SystemSettings { blades, blade_curvature, blade_rotation_rad: 0.3, ..SystemSettings::default() }
}

fn name(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn every_lens<N: Number>(styles: &[Style], allowed: Allowed) {
    let Some(gpu) = gpu() else { return };
    if !gpu.has::<N>() {
        println!("skipped: {} does not compute in {}", gpu.info().name, N::NAME);
        return;
    }
    println!("{} ({})", gpu.info().name, gpu.info().driver);
    let (mut faults, mut all, mut lenses) = (Vec::new(), Report::default(), 0);
    for (i, path) in lens_paths().iter().enumerate() {
        let system = system(path, &settings(i));
        if system.has_gradients() {
            assert_eq!(LensTable::new(&system, &[550.0], WAYS[0]).err(), Some(CpuOnly::Gradient));
            continue;
        }
        lenses += 1;
        for travel in WAYS {
            for &style in styles {
                let report = report_of::<N>(&gpu, &system, travel, style);
                let mean = [report.device_squares, report.cpu_squares].map(|sum| Report::mean(sum, report.passed));
                println!(
                    "{:34} {travel:?} {style:?}: {} of {} pass, {} other fates; worst {:.1?} beside {:.1?}, mean {:.2?} beside {:.2?}",
                    name(path),
                    report.passed,
                    report.rays,
                    report.other_fate,
                    report.device,
                    report.cpu,
                    mean[0],
                    mean[1]
                );
                if let Some(fault) = fault(&report, allowed) {
                    faults.push(format!("{} {travel:?} {style:?}: {fault}", name(path)));
                }
                all.rays += report.rays;
                all.passed += report.passed;
                all.other_fate += report.other_fate;
                for which in 0..2 {
                    all.device[which] = all.device[which].max(report.device[which]);
                    all.cpu[which] = all.cpu[which].max(report.cpu[which]);
                }
            }
        }
    }
    println!("{lenses} lenses, {} rays, {} pass, {} other fates", all.rays, all.passed, all.other_fate);
    println!("worst {:.1?} beside {:.1?}", all.device, all.cpu);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(lenses > 50 && all.passed * 4 > all.rays, "{lenses} lenses, {} rays pass", all.passed);
}

#[test]
fn every_lens_in_single_precision() {
    every_lens::<f32>(&[Style::Loaded, Style::Written], SINGLE);
}

#[test]
fn every_lens_in_double_precision() {
    every_lens::<f64>(&[Style::Loaded], DOUBLE);
}

/// Lenses that nobody makes, with what the library lacks or has little of.
const HARD: [(&str, &str); 6] = [
    // Rays graze its rim.
    ("ball", "#radius thickness glass diameter conic isstop\n 5 10 1.5168/64.17 9.99999 0 1\n -5 2.3 air 9.999 0 0"),
    (
        "eccentric",
        "#radius thickness glass diameter conic isstop\n 60 6 1.6/50 18 -40 1\n -45 3 air 17 25 0\n 80 4 1.7/30 17 -17 0\n 0 40 air 17 0 0",
    ),
    (
        "beside its place",
        "#radius thickness glass diameter conic isstop decenter_x decenter_y decenter_z tilt_x tilt_y tilt_z\n\
         40 6 1.6/50 25 -0.5 0 0.4 -0.3 0.1 2 -3 10\n -60 3 air 25 0 0 0 0.5 0 -4 1 0\n 0 2 air 14 0 1 0.2 0 0 0 5 20\n\
         -30 3 1.7/30 20 0 0 0 0 0.2 0 0 0\n 90 40 air 20 0 0 -0.3 0.3 0 3 3 3",
    ),
    (
        "odd powers",
        "#radius thickness glass diameter conic isstop a2 a3 a4 a5 a6 a7 a10 a20\n\
         50 6 1.6/50 24 -2 1 1e-3 2e-4 -1e-5 1e-6 2e-8 -3e-9 1e-12 -1e-23\n 0 2 air 24 0 0 0 -3e-4 2e-5 0 0 0 0 0\n\
         0 4 1.7/30 24 0 0 -2e-2 0 0 0 0 0 0 0\n -40 40 air 24 1 0 0 0 1e-5 0 -1e-8 0 0 0",
    ),
    (
        "toroids",
        "#radius thickness glass diameter conic isstop radius_x a4 obstruction tilt_z\n\
         60 6 1.6/50 24 -1 1 30 1e-6 3 30\n 0 3 air 24 0 0 -80 0 0 0\n 45 4 1.7/30 22 0 0 0 0 0 15\n -50 40 air 22 0 0 90 -2e-6 2 0",
    ),
    // Rays meet the rear surface at the critical angle, and an oblate and a hyperbolic mirror on their far sides.
    (
        "critical",
        "#radius thickness glass diameter conic isstop obstruction\n 20 12 2.0/30 33 0.4 1 0\n -18 5 air 35 0 0 0\n\
         -90 -30 mirror 60 -3 0 0\n 60 50 mirror 30 2 0 4",
    ),
];

/// Rays that graze the surface that they meet first, if it is a sphere.
fn grazing(system: &System, travel: Travel) -> Vec<LineRay> {
    let surfaces = system.surfaces();
    let (surface, direction) = match travel {
        Travel::FromScene => (&surfaces[0], DVec3::Z),
        Travel::FromFilm => (&surfaces[surfaces.len() - 1], -DVec3::Z * system.light_direction_at_film()),
    };
    let height = |i: u32| (1.0 - 1e-7 * f64::from(i)) / surface.shape.profile().base.curvature;
    let ray = |i| Ray { origin: DVec3::new(0.0, height(i), surface.z_mm) - direction * 10.0, direction };
    (0..RAYS).map(|i| (ray(i), i % 5)).collect()
}

fn hard_lens(i: usize) -> System {
    let prescription =
        lens::parse(HARD[i].1, "hard.lens", Catalogue::shipped()).unwrap_or_else(|error| panic!("{error}"));
    System::new(&prescription, &settings(i)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn hard_surfaces() {
    let Some(gpu) = gpu() else { return };
    let (mut faults, mut reasons) = (Vec::new(), HashSet::new());
    for (i, (name, _)) in HARD.into_iter().enumerate() {
        let system = hard_lens(i);
        for travel in WAYS {
            let lens = LensTable::new(&system, &WAVELENGTHS_NM, travel).expect("a lens that devices trace");
            let mut rays = line_rays(&system, travel, 2 * RAYS);
            rays.extend(grazing(&system, travel));
            for style in [Style::Loaded, Style::Written] {
                let kernel = LensKernel::<f32>::new(&gpu, &lens, style).unwrap_or_else(|error| panic!("{error}"));
                let results = kernel.trace(&rays).unwrap_or_else(|error| panic!("{error}"));
                reasons.extend(results.iter().filter_map(|result| Some(result.err()?.reason)));
                let report = compare::<f32>(&system, travel, &rays, &results);
                println!("{name} {travel:?} {style:?}: {report:?}");
                faults.extend(fault(&report, SINGLE).map(|fault| format!("{name} {travel:?} {style:?}: {fault}")));
                assert!(report.passed > 200, "{name} {travel:?}: {report:?}");
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // All but that an iteration finds nothing, which no test has seen.
    assert_eq!(reasons.len(), 6, "{reasons:?}");
}

/// A ring with a hole of its own shape, grey at its edges.
fn mask() -> ApertureMask {
    const SIDE: usize = 64;
    let at = |i: usize| (2.0 * i as f32 + 1.0) / SIDE as f32 - 1.0;
    let value = |i: usize| {
        let (x, y) = (at(i % SIDE), at(i / SIDE));
        (1.2 - x * x - 2.0 * y * y).min(3.0 * (x + 0.3).abs() + y.abs() - 0.2).clamp(0.0, 1.0)
    };
    ApertureMask::new(SIDE, &(0..SIDE * SIDE).map(value).collect::<Vec<_>>()).expect("a square, bright in parts")
}

#[test]
fn an_aperture_mask() {
    let Some(gpu) = gpu() else { return };
    let system = shipped("cooke-triplet-50mm").with_aperture_mask(Arc::new(mask()), 0.4).expect("a finite angle");
    for travel in WAYS {
        for style in [Style::Loaded, Style::Written] {
            let report = report_of::<f32>(&gpu, &system, travel, style);
            assert_eq!(fault(&report, SINGLE), None, "{travel:?} {style:?}");
            // Some of what passes the lens's rims does not pass the mask.
            let open = report_of::<f32>(&gpu, &shipped("cooke-triplet-50mm"), travel, style);
            assert!(
                report.passed * 10 < open.passed * 9 && report.passed > 200,
                "{} of {}",
                report.passed,
                open.passed
            );
        }
    }
}

/// The tests see what is wrong: shaders broken on purpose.
#[test]
fn a_broken_shader_is_seen() {
    let Some(gpu) = gpu() else { return };
    let broken = [
        ("an index", 0, "let incident = at.cosine * ratio;", "let incident = at.cosine * ratio * 1.00001;"),
        ("a rim", 2, "squared <= clear_squared", "squared <= clear_squared * 1.01"),
        ("a reason", 2, "return Passage(at.point, d, OUTSIDE_APERTURE);", "return Passage(at.point, d, MISSED);"),
        ("a root", 0, "under = cosine * side - b;", "under = -cosine * side - b;"),
        ("the care at small discriminants", 0, "q = difference_of_products(b, b, a, cc);", "q = q * 1.1;"),
        ("the step on the sag", 1, "if (abs(k) > ECCENTRIC)", "if (abs(k) > 1e9)"),
        ("a pose", 2, "p = axis(s, 0u) * p.x", "p = axis(s, 1u) * p.x"),
        ("an odd power", 3, "value * 1.5", "value * 1.4"),
        ("a toroid", 4, "let half = 0.5 * c;", "let half = 0.5001 * c;"),
        ("the critical angle", 5, "radicand = (incident - critical) * (incident + critical);", "radicand = -1.0;"),
        ("a mirror", 5, "quotient(at.cosine * (side + side)", "quotient(at.cosine * side"),
    ];
    let travel = Travel::FromScene;
    for (what, lens, good, bad) in broken {
        let system = hard_lens(lens);
        let lens = LensTable::new(&system, &WAVELENGTHS_NM, travel).expect("a lens that devices trace");
        let mut rays = line_rays(&system, travel, RAYS);
        rays.extend(grazing(&system, travel));
        let faults = |text: String| {
            let kernel = LensKernel::<f32>::with_text(&gpu, &lens, text).unwrap_or_else(|error| panic!("{error}"));
            let results = kernel.trace(&rays).unwrap_or_else(|error| panic!("{error}"));
            fault(&compare::<f32>(&system, travel, &rays, &results), SINGLE)
        };
        let text = shader::trace::<f32>(&lens, Style::Loaded, GROUP);
        assert!(text.contains(good), "{what}");
        let found = faults(text.replace(good, bad));
        println!("{what}: {found:?}");
        assert!(found.is_some(), "{what} may be wrong, and no test sees it");
    }
}
