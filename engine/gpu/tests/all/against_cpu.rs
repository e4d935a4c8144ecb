// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays on the device beside the CPU's tracer, lens by lens, both ways; and that these tests find faults.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use petzval_gpu::kernel::{LensKernel, LineRay};
use petzval_gpu::lens::LensTable;
use petzval_gpu::number::Number;
use petzval_gpu::shader::{self, GROUP, Style};
use petzval_optics::diaphragm::ApertureMask;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Travel};

use crate::common::{gpu, lens_paths, shipped, system};
use crate::compare::{
    Allowed, DOUBLE, RAYS, Report, SINGLE, WAVELENGTHS_NM, WAYS, compare, fault, line_rays, report_of,
};

/// Blades differ from lens to lens.
fn settings(i: usize) -> LensSettings {
    let (blades, blade_curvature) = [(0, 0.0), (6, 0.0), (7, 0.4)][i % 3];
    LensSettings { blades, blade_curvature, blade_rotation_rad: 0.3, ..LensSettings::default() }
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

/// Lenses that nobody makes, with features that the library lacks or has few of.
const HARD: [(&str, &str); 7] = [
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
    // Rays bend, in a medium that is tilted with its surface, and one that begins where it ends.
    (
        "gradients",
        "# glass: G cauchy 0-inf 1.5 0.004 -2\n# gradient: G from=0.5 z1=0.02 z2=-0.001 r2=-0.002 z1r2=0.0001\n\
         # glass: H constant 0-inf 1.6\n# gradient: H r2=-0.001 r4=1e-6\n\
         #radius thickness glass diameter conic isstop decenter_x tilt_x a4\n\
         20 6 G 12 -0.5 0 0.3 3 0\n -60 3 H 12 0 1 0 -2 1e-6\n -30 3 1.6 12 0 0 0 0 0\n 0 30 air 12 0 0 0 0 0",
    ),
];

/// Rays that graze the first surface, if it is a sphere.
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

/// The tests find faults: shaders broken on purpose.
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
        ("a pose", 2, "return axis(s, 0u) * v.x", "return axis(s, 1u) * v.x"),
        ("an odd power", 3, "value * 1.5", "value * 1.4"),
        ("a toroid", 4, "let half = 0.5 * c;", "let half = 0.5001 * c;"),
        ("the critical angle", 5, "radicand = (incident - critical) * (incident + critical);", "radicand = -1.0;"),
        (
            "a field",
            6,
            "let across = index * (sums.by_square + sums.by_square);",
            "let across = index * 2.001 * sums.by_square;",
        ),
        ("a landing", 6, "const LANDINGS_any = 4u;", "const LANDINGS_any = 1u;"),
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
