// SPDX-License-Identifier: GPL-3.0-or-later
//! Results of rays on a device beside those of the CPU's tracer in f64.
//!
//! Errors are taken over those that the data allow, as docs/numerics.md has it: over the change of the ray that leaves when one number of
//! the ray that enters moves by a unit in its last place. The device may be off by twice the error of the CPU's f32. A ray that is lost
//! otherwise than in f64 must be so near to an edge that some roundings of the ray that enters decide.

use glam::DVec3;
use petzval_gpu::device::Gpu;
use petzval_gpu::kernel::{LensKernel, LineRay};
use petzval_gpu::lens::LensTable;
use petzval_gpu::number::Number;
use petzval_gpu::shader::Style;
use petzval_optics::lane::Real;
use petzval_optics::system::System;
use petzval_optics::trace::{Lost, Ray, Tracer, Travel};

use crate::common::{random, rays};

pub(crate) const WAVELENGTHS_NM: [f64; 5] = [404.66, 486.13, 546.07, 587.56, 706.52];
pub(crate) const RAYS: u32 = 2000;
pub(crate) const WAYS: [Travel; 2] = [Travel::FromScene, Travel::FromFilm];

/// Results of rays beside the CPU's f64.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Report {
    pub(crate) rays: usize,
    pub(crate) passed: usize,
    /// Largest errors of the point and of the direction over the error that the data allow, of the device and of the CPU's own numbers of
    /// that kind.
    pub(crate) device: [f64; 2],
    pub(crate) cpu: [f64; 2],
    /// Sums of the squares of the same.
    pub(crate) device_squares: [f64; 2],
    pub(crate) cpu_squares: [f64; 2],
    /// Rays of another fate than in f64; those of them that no rounding explains, and results that are no rays.
    pub(crate) other_fate: usize,
    pub(crate) unexplained: usize,
}

impl Report {
    pub(crate) fn mean(squares: [f64; 2], passed: usize) -> [f64; 2] {
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

/// Sensitivity of the ray that leaves, point and direction, to the numbers of the one that enters.
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

pub(crate) fn compare<N: Number>(system: &System, travel: Travel, rays: &[LineRay], results: &[Fate]) -> Report {
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
        if !result.origin.is_finite() || (result.direction.length() - 1.0).abs() > 1e-12 {
            report.unexplained += 1;
            continue;
        }
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
pub(crate) fn line_rays(system: &System, travel: Travel, count: u32) -> Vec<LineRay> {
    rays(system, travel, count).into_iter().zip((0..WAVELENGTHS_NM.len() as u32).cycle()).collect()
}

pub(crate) fn report_of<N: Number>(gpu: &Gpu, system: &System, travel: Travel, style: Style) -> Report {
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

/// The greatest error of a device over the CPU's.
#[derive(Clone, Copy)]
pub(crate) struct Allowed {
    worst: f64,
    mean: f64,
}

/// The limits of the device's f32 beside the CPU's.
pub(crate) const SINGLE: Allowed = Allowed { worst: 2.0, mean: 2.0 };
/// The limits of the difference of the device's f64 from the CPU's, beside the error of the CPU's f32, each in its own units. There is no truth
/// beyond f64 here: both have errors, and their worst are not of the same rays.
pub(crate) const DOUBLE: Allowed = Allowed { worst: 6.0, mean: 3.0 };
/// Errors below this many units are as good as rounded arithmetic gets, whichever of two is smaller.
const LEAST: f64 = 2.0;

/// The reason why the device is not as good as it must be.
pub(crate) fn fault(report: &Report, allowed: Allowed) -> Option<String> {
    let Report { rays, passed, device, cpu, other_fate, unexplained, .. } = *report;
    let [device_mean, cpu_mean] = [report.device_squares, report.cpu_squares].map(|sum| Report::mean(sum, passed));
    let is_off = |device: [f64; 2], cpu: [f64; 2], times: f64, least: f64| {
        device.iter().zip(cpu).any(|(d, c)| d.is_nan() || *d > times * c.max(least))
    };
    if unexplained > 0 {
        return Some(format!("{unexplained} of {rays} rays have a fate that no rounding explains, or are none"));
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
