// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors of a device come back in one line.

use crate::common::{gpu, rays, shipped};
use glam::DVec3;
use petzval_gpu::device::{DeviceChoice, Gpu, devices};
use petzval_gpu::error::GpuError;
use petzval_gpu::flood::{Beam, Cut, Flood};
use petzval_gpu::kernel::LensKernel;
use petzval_gpu::lens::LensTable;
use petzval_gpu::shader::Style;
use petzval_optics::surface::Failure;
use petzval_optics::trace::{Lost, Ray, Travel};

fn kernel(gpu: &Gpu) -> LensKernel<f32> {
    let lens = LensTable::new(&shipped("cooke-triplet-50mm"), &[550.0], Travel::FromScene).expect("a plain lens");
    LensKernel::new(gpu, &lens, Style::Loaded).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_cpu_is_no_device() {
    assert!(Gpu::open(&DeviceChoice::Cpu).is_ok_and(|gpu| gpu.is_none()));
}

#[test]
fn an_unknown_name_lists_the_devices() {
    let error = Gpu::open(&DeviceChoice::Named("no such card".to_owned())).expect_err("no device has this name");
    match devices().first() {
        None => assert_eq!(error, GpuError::NoDevice),
        Some(device) => assert!(error.to_string().contains(&device.name), "{error}"),
    }
}

#[test]
fn a_lost_device_is_an_error_and_stays_one() {
    let Some(gpu) = gpu() else { return };
    let kernel = kernel(&gpu);
    let ray = Ray { origin: DVec3::new(0.0, 0.0, -10.0), direction: DVec3::Z };
    assert!(kernel.trace(&[(ray, 0)]).is_ok_and(|results| results[0].is_ok()));
    gpu.close();
    for _ in 0..2 {
        let error = kernel.trace(&[(ray, 0)]).expect_err("the device is gone");
        assert!(matches!(error, GpuError::Lost { .. }), "{error:?}");
        assert!(!error.to_string().contains('\n') && error.to_string().contains("choose cpu"), "{error}");
    }
}

#[test]
fn a_shader_that_is_refused_is_an_error() {
    let Some(gpu) = gpu() else { return };
    let lens = LensTable::new(&shipped("cooke-triplet-50mm"), &[550.0], Travel::FromScene).expect("a plain lens");
    let error = LensKernel::<f32>::with_text(&gpu, &lens, "fn trace() { nonsense }".to_owned()).err();
    assert!(matches!(error, Some(GpuError::Rejected { .. })), "{error:?}");
    // The device is none the worse for it.
    assert!(kernel(&gpu).trace(&[]).is_ok_and(|results| results.is_empty()));
}

#[test]
fn more_than_a_device_holds_is_an_error() {
    let Some(gpu) = gpu() else { return };
    let system = shipped("cooke-triplet-50mm");
    let lens = LensTable::new(&system, &[550.0], Travel::FromFilm).expect("a plain lens");
    let beam = Beam::fitted(&system, &system.at_wavelength(550.0));
    // 32 GB of sums.
    let cut = Cut { group: 64, rays_each: 1, groups: u32::MAX, dispatches: 1 };
    let error = Flood::<f32>::new(&gpu, &lens, Style::Loaded, cut, &beam).and_then(|flood| flood.run()).err();
    assert!(matches!(error, Some(GpuError::TooLarge { .. } | GpuError::OutOfMemory { .. })), "{error:?}");
}

#[test]
fn a_wavelength_that_is_not_there_is_an_error() {
    let Some(gpu) = gpu() else { return };
    let ray = Ray { origin: DVec3::ZERO, direction: DVec3::Z };
    assert_eq!(kernel(&gpu).trace(&[(ray, 1)]), Err(GpuError::NoSuchWavelength { asked: 1, known: 1 }));
}

#[test]
fn numbers_that_are_none_miss() {
    let Some(gpu) = gpu() else { return };
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let ray = Ray { origin: DVec3::new(bad, 0.0, -1.0), direction: DVec3::Z };
        let missed = Err(Lost { surface: 0, reason: Failure::Missed });
        assert_eq!(kernel(&gpu).trace(&[(ray, 0)]), Ok(vec![missed]));
    }
}

#[test]
fn a_lens_of_no_wavelength_is_an_error() {
    let lens = LensTable::new(&shipped("cooke-triplet-50mm"), &[], Travel::FromFilm);
    assert_eq!(lens.err(), Some(GpuError::NoWavelength));
}

/// Rays made on the device are those made on the CPU: as many of them pass, but for some at rims.
#[test]
fn rays_that_are_made_on_the_device_get_through_as_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    for name in ["wide-angle-smith-f3.4", "cellphone-5.6mm-f3.5"] {
        let system = shipped(name);
        let tracer = system.at_wavelength(550.0);
        let beam = Beam::fitted(&system, &tracer);
        // Wider than what gets through, so that rims count.
        let beam = Beam { half_pupil_mm: 2.0 * beam.half_pupil_mm, ..beam };
        let lens = LensTable::new(&system, &[550.0], Travel::FromFilm).expect("a lens that devices trace");
        let cut = Cut { group: 64, rays_each: 4, groups: 16, dispatches: 3 };
        let last_z = system.last_vertex_z_mm();
        let passed = (0..cut.rays() as u32).filter(|&i| tracer.from_film(beam.ray(i, last_z)).is_ok()).count() as u64;
        for style in [Style::Loaded, Style::Written] {
            let flood = Flood::<f32>::new(&gpu, &lens, style, cut, &beam).unwrap_or_else(|error| panic!("{error}"));
            let [first, again] = [0, 1].map(|_| flood.run().unwrap_or_else(|error| panic!("{error}")));
            assert_eq!((first.rays, first.passed, first.sum), (cut.rays(), again.passed, again.sum));
            assert!(first.passed.abs_diff(passed) <= 6, "{name} {style:?}: {} and {passed}", first.passed);
            assert!(passed > 1000 && passed < cut.rays(), "{name}: {passed}");
        }
    }
}

#[test]
fn many_rays_come_back_in_their_order() {
    let Some(gpu) = gpu() else { return };
    let system = shipped("cooke-triplet-50mm");
    let tracer = system.at_wavelength(550.0);
    let rays: Vec<_> = rays(&system, Travel::FromScene, 30_000).into_iter().map(|ray| (ray, 0)).collect();
    let results = kernel(&gpu).trace(&rays).unwrap_or_else(|error| panic!("{error}"));
    let near = |(ray, _): &(Ray, u32), result: &Result<Ray, Lost>| match (tracer.from_scene(*ray), result) {
        (Ok(a), Ok(b)) => (a.origin - b.origin).length() < 1e-3,
        (a, b) => a.is_err() && b.is_err(),
    };
    let far = rays.iter().zip(&results).filter(|(ray, result)| !near(ray, result)).count();
    assert!(far <= 3, "{far}");
}
