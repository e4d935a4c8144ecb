//! Properties of every ray through every lens.

use crate::common::{lens_names, prescription, system};
use glam::DVec3;
use petzval_optics::glass::line_nm;
use petzval_optics::interface::{Interface, reflect};
use petzval_optics::surface::{Conic, Shape};
use petzval_optics::system::{FocalLength, LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};
use petzval_optics::vector::Vector;
use proptest::prelude::*;

fn all_lenses() -> Vec<(String, System, Tracer)> {
    let with_tracer = |name: String| {
        let system = system(&name);
        let tracer = system.at_wavelength(line_nm::D);
        (name, system, tracer)
    };
    lens_names().into_iter().map(with_tracer).collect()
}

fn unit() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, 0.0..std::f64::consts::TAU).prop_map(|(z, phi)| {
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    })
}

/// A ray that starts before the first vertex, aimed into the front glass.
fn into(system: &System, [x, y, u, v]: [f64; 4]) -> Ray {
    let semi = system.surfaces()[0].semi_diameter_mm;
    let start = DVec3::new(x * semi, y * semi, -2.0 * semi);
    let field = system.half_field_deg().unwrap_or(10.0).min(40.0).to_radians().tan();
    Ray { origin: start, direction: DVec3::new(u * field, v * field, 1.0).normalize() }
}

/// Numbers that break code: huge, tiny, signed zeros, subnormal.
fn nasty() -> impl Strategy<Value = f64> {
    prop_oneof![
        -100.0..100.0f64,
        Just(0.0),
        Just(-0.0),
        Just(1e300),
        Just(-1e300),
        Just(5e-324),
        Just(1e-160),
        any::<f64>().prop_filter("finite", |x| x.is_finite()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn a_ray_that_passed_comes_back(numbers in prop::array::uniform4(-0.9..0.9f64)) {
        for (name, system, tracer) in all_lenses() {
            let ray = into(&system, numbers);
            let mut hits = Vec::new();
            let Ok(out) = tracer.from_scene_recording(ray, &mut hits) else { continue };
            // From a point on its way to the film.
            let size = hits.iter().fold(system.surfaces()[0].semi_diameter_mm, |m, h| m.max(h.length()));
            let start = Ray { origin: out.origin + out.direction * (0.3 * size), direction: -out.direction };
            let mut back_hits = Vec::new();
            let back = tracer.from_film_recording(start, &mut back_hits);
            let back = match back {
                Ok(back) => back,
                // A hit on a rim may fall outside on the way back, by rounding.
                Err(lost) => {
                    let rim = system.surfaces()[lost.surface].semi_diameter_mm;
                    let hit = hits[lost.surface].truncate().length();
                    prop_assert!((hit / rim - 1.0).abs() < 1e-9, "{name}: {lost:?} at {hit} of {rim}");
                    continue;
                }
            };
            back_hits.reverse();
            for (there, back) in hits.iter().zip(&back_hits) {
                prop_assert!((*there - *back).length() < 1e-10 * size, "{name}: {there} {back}");
            }
            prop_assert!((back.direction + ray.direction).length() < 1e-10, "{name}");
        }
    }

    #[test]
    fn twice_the_lens_has_twice_the_path(numbers in prop::array::uniform4(-0.9..0.9f64), doubled in -3i32..4) {
        let factor = 2f64.powi(doubled);
        for name in ["seed-wide-angle", "eye-navarro", "cassegrain-f12"] {
            let prescription = prescription(name);
            let settings = LensSettings { focal_length: FocalLength::Scale(factor), ..LensSettings::default() };
            let one = System::new(&prescription, &LensSettings::default()).unwrap();
            let scaled = System::new(&prescription, &settings).unwrap();
            let ray = into(&one, numbers);
            let larger = Ray { origin: ray.origin * factor, ..ray };
            let (a, b) = (one.at_wavelength(550.0).from_scene(ray), scaled.at_wavelength(550.0).from_scene(larger));
            match (a, b) {
                // Powers of two: the same numbers to the last bit.
                (Ok(a), Ok(b)) => prop_assert!(a.direction == b.direction && a.origin * factor == b.origin),
                (a, b) => prop_assert_eq!(a.err(), b.err()),
            }
        }
    }

    #[test]
    fn finite_rays_give_finite_rays_or_reasons(p in prop::array::uniform3(nasty()), d in unit()) {
        let ray = Ray { origin: DVec3::from(p), direction: d };
        for (name, _, tracer) in all_lenses() {
            for result in [tracer.from_scene(ray), tracer.from_film(ray)].into_iter().flatten() {
                prop_assert!(result.origin.is_finite() && result.direction.is_finite(), "{name}: {ray:?}");
                prop_assert!((result.direction.length() - 1.0).abs() < 1e-12, "{name}: {ray:?}");
            }
        }
    }

    #[test]
    fn hits_lie_on_the_surface_and_face_the_side(
        c in prop_oneof![Just(0.0), -0.1..0.1f64, -1e-9..1e-9f64],
        k in prop_oneof![Just(0.0), Just(-1.0), -5.0..3.0f64],
        p in prop::array::uniform3(-30.0..30.0f64),
        d in unit(),
        side in prop_oneof![Just(1.0), Just(-1.0)],
        n in 1.0..2.0f64,
        n2 in 1.0..2.0f64,
    ) {
        let shape = Shape::Conic(Conic { curvature: c, conic: k });
        let ray = Vector::from_f64(d);
        let Ok(hit) = shape.intersect(Vector::from_f64(DVec3::from(p)), ray, side) else { return Ok(()) };
        let point = hit.point.of(0);
        let on = c * (point.length_squared() + k * point.z * point.z) - 2.0 * point.z;
        // The rounding of the terms, steeper where the surface is.
        let terms = c.abs() * (1.0 + k.abs()) * point.length_squared() + 2.0 * point.length() + 30.0;
        prop_assert!(on.abs() < 1e-13 * terms, "{on:e} of {terms}");
        prop_assert!(1.0 - (1.0 + k) * c * point.z >= 0.0);
        let cosine = hit.normal.dot(ray);
        prop_assert!(cosine * side > -1e-7 * hit.normal.of(0).length());
        let normal = hit.normal.of(0).normalize();
        // Snell: the tangential parts are in the ratio of the indices.
        if let (out, true) = Interface::new(n, n2).refract(ray, &hit, side) {
            let out = out.of(0);
            let tangential = |v: DVec3| v - normal * v.dot(normal);
            let error = (tangential(d) * n - tangential(out) * n2).length();
            prop_assert!(error < 1e-9, "{error:e}");
            prop_assert!(out.dot(normal) * side > -1e-6, "it goes on to the other side");
            prop_assert!((out.length() - 1.0).abs() < 1e-7);
        }
        let mirrored = reflect(ray, &hit, side).of(0);
        prop_assert!((mirrored.dot(normal) + d.dot(normal)).abs() < 1e-7);
    }
}
