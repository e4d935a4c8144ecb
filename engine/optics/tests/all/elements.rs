//! Toroids, aspheres, decentred and tilted elements, by closed forms.

use crate::common::repository;
use glam::DVec3;
use petzval_optics::focus::film_z_for_focus_mm;
use petzval_optics::formats::lens::{self, parse};
use petzval_optics::glass::Catalogue;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};
use proptest::prelude::*;

fn tracer(text: &str) -> Tracer {
    let lens = parse(text, "test", Catalogue::shipped()).unwrap_or_else(|e| panic!("{e}"));
    System::new(&lens, &LensSettings::default()).unwrap().at_wavelength(587.5618)
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray { origin: origin.into(), direction: DVec3::from(direction).normalize() }
}

/// z at which the outgoing ray crosses the axis in the plane of x (0) or of y (1).
fn crossing(out: Ray, axis: usize) -> f64 {
    out.origin.z - out.origin[axis] / out.direction[axis] * out.direction.z
}

#[test]
fn a_cylinder_focuses_one_way() {
    // Plano-convex, n = 1.5, power (n - 1) / R; the curved side last, so that the focus lies R / (n - 1) behind it.
    for (row, power) in [("-40 100 air 20 0 0 0", 1), ("0 100 air 20 0 0 -40", 0)] {
        let lens =
            tracer(&format!("#radius thickness glass diameter conic isstop radius_x\n0 5 1.5 20 0 1 0\n{row}\n"));
        let out = lens.from_scene(ray([1e-4, 1e-4, -10.0], [0.0, 0.0, 1.0])).unwrap();
        assert!((crossing(out, power) - 85.0).abs() < 1e-6, "{}", crossing(out, power));
        assert_eq!(out.direction[1 - power], 0.0, "the other way it is a plate");
    }
}

#[test]
fn a_toroid_has_two_focal_lengths() {
    let lens =
        tracer("#radius thickness glass diameter conic isstop radius_x\n0 5 1.5 20 0 1 0\n-40 100 air 20 0 0 -25");
    let out = lens.from_scene(ray([1e-4, 1e-4, -10.0], [0.0, 0.0, 1.0])).unwrap();
    assert!((crossing(out, 0) - 55.0).abs() < 1e-6 && (crossing(out, 1) - 85.0).abs() < 1e-6);
    // Turned by 90 degrees about the axis the sections change places.
    let turned = tracer(
        "#radius thickness glass diameter conic isstop radius_x tilt_z\n0 5 1.5 20 0 1 0 0\n-40 100 air 20 0 0 -25 90",
    );
    let out = turned.from_scene(ray([1e-4, 1e-4, -10.0], [0.0, 0.0, 1.0])).unwrap();
    assert!((crossing(out, 0) - 85.0).abs() < 1e-6 && (crossing(out, 1) - 55.0).abs() < 1e-6);
}

/// A parabola written as an asphere, and one written as a conic: parallel light converges in one point, exactly.
#[test]
fn a_parabola_by_its_r_squared_term_is_stigmatic() {
    for text in [
        "#radius thickness glass diameter conic isstop a2\n0 -100 mirror 100 0 1 -0.0025",
        "#radius thickness glass diameter conic isstop\n-200 -100 mirror 100 -1 1",
        "#radius thickness glass diameter conic isstop radius_x a2\n0 -100 mirror 100 0 1 0 -0.0025",
    ] {
        let mirror = tracer(text);
        let is_cylinder = text.contains("radius_x");
        for (x, y) in [(0.0, 10.0), (30.0, -20.0), (-5.0, 45.0)] {
            let out = mirror.from_scene(ray([x, y, -300.0], [0.0, 0.0, 1.0])).unwrap();
            let focus = out.origin + out.direction * (-(out.origin.z + 100.0) / -out.direction.z.abs()).abs();
            assert!(focus.y.abs() < 1e-12 && (is_cylinder || focus.x.abs() < 1e-12), "{text}: {focus}");
        }
    }
}

#[test]
fn a_tilted_plate_moves_a_ray_aside_by_the_known_amount() {
    // Both faces turned about the first vertex as one.
    let (n, thickness, tilt) = (1.5, 5.0, 30f64.to_radians());
    let plate = tracer("# element: 0-1 tilt_x=30\n0 5 1.5 40 0 1\n0 10 air 40 0 0");
    for origin in [[0.0, 0.0, -10.0], [2.0, -3.0, -10.0]] {
        let out = plate.from_scene(ray(origin, [0.0, 0.0, 1.0])).unwrap();
        let inside = (tilt.sin() / n).asin();
        let aside = thickness * (tilt - inside).sin() / inside.cos();
        assert!((out.direction - DVec3::Z).length() < 1e-14);
        // Turned right-handed about x, the normal leans to -y; the ray bends towards it inside.
        assert!((out.origin.y - (origin[1] - aside)).abs() < 1e-13, "{} {aside}", out.origin.y);
        assert!((out.origin.x - origin[0]).abs() < 1e-14);
    }
}

#[test]
fn a_sphere_turned_about_its_centre_is_itself() {
    // The centre of the rear face lies 50 mm before its vertex; the tilt about the vertex moves it, the decentre back.
    let tilt = 5f64.to_radians();
    let plain = tracer("0 60 1.5 20 0 1\n-50 100 air 60 0 0");
    let moved = 50.0 * tilt.sin();
    // About x a tilt moves the centre from (0, 0, -50) to y = +50 sin, z = -50 cos: 0.19 mm short of the old one.
    let text = format!(
        "#radius thickness glass diameter conic isstop tilt_x decenter_y\n0 {} 1.5 20 0 1 0 0\n-50 100 air 60 0 0 5 {}",
        60.0 - 50.0 * (1.0 - tilt.cos()),
        -moved
    );
    let tilted = tracer(&text);
    for direction in [[0.0, 0.0, 1.0], [0.1, 0.05, 1.0]] {
        let ray = ray([1.0, 2.0, -10.0], direction);
        let (a, b) = (plain.from_scene(ray).unwrap(), tilted.from_scene(ray).unwrap());
        assert!((a.direction - b.direction).length() < 1e-14 && (a.origin - b.origin).length() < 1e-12);
    }
}

#[test]
fn decentring_the_whole_lens_is_moving_the_ray() {
    let name = "double-gauss-f2-available";
    let text = std::fs::read_to_string(repository(&format!("lenses/{name}.lens"))).unwrap();
    let moved = tracer(&format!("# element: 0-10 decenter_x=1.5 decenter_y=-0.5\n{text}"));
    let plain = tracer(&text);
    let shift = DVec3::new(1.5, -0.5, 0.0);
    for direction in [[0.0, 0.0, 1.0], [0.05, -0.06, 1.0]] {
        let start = ray([3.0, -4.0, -40.0], direction);
        let (a, b) = (plain.from_scene(start), moved.from_scene(Ray { origin: start.origin + shift, ..start }));
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!((a.origin + shift - b.origin).length() < 1e-12 && (a.direction - b.direction).length() < 1e-14);
    }
}

fn system(name: &str, more: &str) -> System {
    let text = std::fs::read_to_string(repository(&format!("lenses/{name}.lens"))).unwrap();
    let lens = lens::parse(&format!("{more}\n{text}"), name, Catalogue::shipped()).unwrap();
    System::new(&lens, &LensSettings::default()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Light through aspheres, toroids and misaligned elements finds its way back, as it must.
    #[test]
    fn every_way_leads_back(x in -0.9..0.9f64, y in -0.9..0.9f64, u in -0.2..0.2f64, v in -0.2..0.2f64) {
        for (name, more) in [
            ("anamorphic-2x-double-gauss", ""),
            ("cellphone-5.6mm-f3.5", ""),
            ("schmidt-flat-field", ""),
            ("double-gauss-f2-available", "# element: 2-4 decenter_x=0.4 tilt_x=2 tilt_y=-1"),
        ] {
            let system = system(name, more);
            let tracer = system.at_wavelength(550.0);
            let semi = 0.5 * system.surfaces()[0].semi_diameter_mm;
            let start = ray([x * semi, y * semi, -semi], [u, v, 1.0]);
            let Ok(out) = tracer.from_scene(start) else { continue };
            let back = Ray { origin: out.origin + out.direction, direction: -out.direction };
            // A hit on a rim may fall outside on the way back, by rounding.
            let Ok(back) = tracer.from_film(back) else { continue };
            let there = start.origin + start.direction * (back.origin - start.origin).dot(start.direction);
            prop_assert!((back.direction + start.direction).length() < 1e-11, "{name}: {} {}", back.direction, start.direction);
            prop_assert!((back.origin - there).length() < 1e-11 * system.last_vertex_z_mm().abs().max(1.0), "{name}");
        }
    }
}

/// The shipped anamorphic lens: an afocal pair that halves angles across, before 100 mm.
#[test]
fn an_anamorphic_lens_squeezes_by_two() {
    let system = system("anamorphic-2x-double-gauss", "");
    let tracer = system.at_wavelength(587.5618);
    let film = film_z_for_focus_mm(&system, 587.5618, f64::INFINITY).unwrap();
    let image = |start: [f64; 2], slopes: [f64; 2]| {
        let out = tracer.from_scene(ray([start[0], start[1], -10.0], [slopes[0], slopes[1], 1.0])).unwrap();
        out.origin + out.direction * ((film - out.origin.z) / out.direction.z)
    };
    let angle = 1e-4;
    let (across, up) = (image([0.0; 2], [angle, 0.0]), image([0.0; 2], [0.0, angle]));
    // To the angle's square, and the rounding of the cylinders' radii in the file.
    assert!((across.x / angle - 50.0).abs() < 0.01 && (up.y / angle - 100.0).abs() < 0.01, "{across} {up}");
    // Both sections are sharp in one plane: parallel rays through the pupil's edge meet within some hundredths.
    for start in [[5.0, 0.0], [0.0, 10.0], [4.0, 8.0]] {
        assert!((image(start, [angle, 0.0]) - across).length() < 0.05, "{start:?}");
    }
}

#[test]
fn scaling_scales_every_kind_of_number() {
    use petzval_optics::system::FocalLength;
    for (name, more) in [
        ("cellphone-5.6mm-f3.5", "# element: 2-4 decenter_x=0.04 tilt_x=2"),
        ("anamorphic-2x-double-gauss", "# element: 4-6 decenter_y=0.4 tilt_y=1"),
    ] {
        let text = std::fs::read_to_string(repository(&format!("lenses/{name}.lens"))).unwrap();
        let lens = lens::parse(&format!("{more}\n{text}"), name, Catalogue::shipped()).unwrap();
        let larger = LensSettings { focal_length: FocalLength::Scale(3.7), ..LensSettings::default() };
        let one = System::new(&lens, &LensSettings::default()).unwrap().at_wavelength(550.0);
        let scaled = System::new(&lens, &larger).unwrap().at_wavelength(550.0);
        for (x, y) in [(0.1, 0.2), (-0.3, 0.1)] {
            let start = ray([x, y, -2.0], [0.02, -0.03, 1.0]);
            let (a, b) = (one.from_scene(start), scaled.from_scene(Ray { origin: start.origin * 3.7, ..start }));
            let (a, b) = (a.unwrap(), b.unwrap());
            assert!(
                (a.direction - b.direction).length() < 1e-14 && (a.origin * 3.7 - b.origin).length() < 1e-12,
                "{name}"
            );
        }
    }
}
