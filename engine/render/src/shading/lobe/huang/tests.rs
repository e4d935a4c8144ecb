//! Fibres of rough scales: samples carry what is evaluated, clear fibres keep their light, dark ones mirror alone.

use super::*;
use std::f32::consts::FRAC_PI_2;

fn fibre(alpha: f32, tilt: f32, sigma: f32) -> RoughFibre {
    let sigma = Rgb::new(sigma, 0.3 * sigma, 0.0);
    RoughFibre { sigma, alpha, ior: 1.55, tilt, parts: [1.0; 3], offset: 0.2, coverage: 1.0, aspect: 1.0 }
}

/// A direction of the fibre's frame.
fn direction(along: f32, about: f32) -> Vec3A {
    let ((sin, cos), (s, c)) = (along.sin_cos(), about.sin_cos());
    Vec3A::new(cos * c, cos * s, sin)
}

fn octant(wi: Vec3A) -> usize {
    usize::from(wi.x > 0.0) + 2 * usize::from(wi.y > 0.0) + 4 * usize::from(wi.z > 0.0)
}

/// The light that is scattered into each octant, by even steps over all directions.
fn integrals(lobe: &Huang) -> [Rgb; 8] {
    let n = 240;
    let mut sums = [Rgb::ZERO; 8];
    for i in 0..n * n {
        let step = |k: u32| (k as f32 + 0.5) / n as f32;
        let along = PI * step(i / n) - FRAC_PI_2;
        let wi = direction(along, TAU * step(i % n) - PI);
        sums[octant(wi)] += lobe.evaluate(wi) * (along.cos() * PI * TAU / (n * n) as f32);
    }
    sums
}

/// Sampled directions carry the light that is evaluated, of the whole width and of the part of it that a pixel sees.
#[test]
fn samples_carry_what_is_scattered() {
    for (alpha, tilt, coverage, aspect, about) in [
        (0.2, 0.0, 1.0, 1.0, 0.0),
        (0.5, 0.06, 1.0, 1.0, 0.0),
        (0.3, 0.035, 1.0, 1.0, 0.0),
        (0.3, 0.0, 1e-2, 1.0, 0.0),
        (0.4, 0.05, 1e-2, 1.0, 0.0),
        (0.3, 0.0, 1.0, 0.85, 0.7),
        (0.4, 0.04, 1.0, 0.6, -2.0),
        (0.4, 0.0, 1e-2, 0.7, 2.9),
    ] {
        for along in [0.0f32, 0.6, -1.1] {
            let lobe = Huang::new(&RoughFibre { coverage, aspect, ..fibre(alpha, tilt, 0.4) }, direction(along, about));
            let n = 1 << 15;
            let mut sums = [Rgb::ZERO; 8];
            for i in 0..n {
                let [u0, u1, u2, _] = sobol_burley::sample_4d(i, 0, 5);
                if let Some((wi, weight)) = lobe.sample(u2, [u0, u1]) {
                    assert!((wi.length() - 1.0).abs() < 1e-3 && weight.min_element() >= 0.0, "{wi} {weight}");
                    sums[octant(wi)] += weight / n as f32;
                }
            }
            let want = integrals(&lobe);
            let all: Rgb = want.iter().sum();
            let found: Rgb = sums.iter().sum();
            // Longer ways are estimated in one way where directions are sampled, and in another where they are evaluated, as published.
            assert!(
                (found - all).abs().max_element() < 0.05,
                "{alpha} {tilt} {coverage} {aspect} {along}: {found} for {all}"
            );
            for (which, (found, want)) in sums.iter().zip(want).enumerate() {
                let off = (*found - want).abs().max_element();
                assert!(off < 0.03, "{alpha} {tilt} {coverage} {aspect} {along}, {which}: {found} for {want}");
            }
        }
    }
}

/// A clear fibre neither swallows light nor makes any, about: facets restore what single scattering loses, and the longest ways are a
/// series.
#[test]
fn a_clear_fibre_keeps_about_all_light() {
    for (alpha, along, aspect, about) in [
        (0.1, 0.0, 1.0, 0.0),
        (0.3, 0.0, 1.0, 0.0),
        (0.3, 0.7, 1.0, 0.0),
        (0.6, -0.4, 1.0, 0.0),
        (0.3, 0.0, 0.85, 0.0),
        (0.3, 0.3, 0.6, 1.2),
    ] {
        let fibre = RoughFibre { aspect, ..fibre(alpha, 0.0, 0.0) };
        let light: Rgb = integrals(&Huang::new(&fibre, direction(along, about))).iter().sum();
        assert!((light.x - 1.0).abs() < 0.12, "{alpha} {along} {aspect}: {light}");
    }
}

/// A fibre that absorbs everything mirrors alone, and its albedo is the Fresnel reflectance of its width's mean.
#[test]
fn a_dark_fibre_mirrors_alone() {
    let fibre = RoughFibre { sigma: Rgb::splat(1e6), ..fibre(0.05, 0.0, 0.0) };
    let light: Rgb = integrals(&Huang::new(&fibre, Vec3A::X)).iter().sum();
    let n = 1000;
    let across_width = |i: i32| fresnel::dielectric(across((i as f32 + 0.5) / n as f32), 1.55) / n as f32;
    let mean: f32 = (0..n).map(across_width).sum();
    assert!((light.x - mean).abs() < 0.05 * mean, "{light} for {mean}");
}
