//! Several stops, field stops, and flat glass beside or under the diaphragm: exact rays against geometry.

use glam::{DVec2, DVec3};
use petzval_optics::formats::lens::parse;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Failure, Ray, Tracer};

const TRIPLET: &str = "22.01359 3.25896 SK16 19 0 0\n-435.76044 6.00755 air 19 0 0\n-22.21328 0.99997 F2 10 0 0\n\
    20.29192 4.75041 air 7.6124 0 1\n79.6836 2.95208 SK16 15 0 0\n-18.39533 42.20778 air 15 0 0\n";

fn system(rows: &str) -> System {
    System::new(&parse(rows, "test", Catalogue::shipped()).unwrap(), &LensSettings::default()).unwrap()
}

/// Rays from many sides, some of which no stop lets through.
fn rays() -> Vec<Ray> {
    let mut rays = Vec::new();
    for field in 0..8 {
        let (sin, cos) = (2.9 * f64::from(field)).to_radians().sin_cos();
        for i in 0..400 {
            // A spiral that fills the front evenly.
            let at = DVec2::from_angle(2.399_963 * f64::from(i)) * 9.0 * (f64::from(i) / 400.0).sqrt();
            rays.push(Ray {
                origin: DVec3::new(at.x, at.y - 5.0 * sin / cos, -5.0),
                direction: DVec3::new(0.0, sin, cos),
            });
        }
    }
    rays
}

/// The point at which a ray that has left the lens crosses a plane.
fn crossing(ray: &Ray, z: f64) -> DVec2 {
    (ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z)).truncate()
}

fn last_vertex_z(system: &System) -> f64 {
    system.surfaces().last().unwrap().z_mm
}

#[test]
fn a_fixed_stop_and_a_field_stop_stop_what_passes_outside_and_nothing_else() {
    let plain = system(TRIPLET);
    // 5 mm behind the last glass a fixed stop, and a field stop 2 mm before the film.
    let stopped = TRIPLET.replace("-18.39533 42.20778", "-18.39533 5") + "0 35.20778 air 7 0 0\n0 2 air 21 0 0\n";
    let stopped = system(&stopped);
    assert_eq!((stopped.stop(), stopped.surface_count()), (3, 8));
    let last = last_vertex_z(&plain);
    let (tracer, more): (Tracer, Tracer) = (plain.at_wavelength(line_nm::D), stopped.at_wavelength(line_nm::D));
    let mut counts = [0; 3];
    for ray in rays() {
        let Ok(out) = tracer.from_scene(ray) else {
            assert!(more.from_scene(ray).is_err());
            continue;
        };
        let at = [(last + 5.0, 3.5), (last + 40.20778, 10.5)].map(|(z, radius)| crossing(&out, z).length() <= radius);
        match more.from_scene(ray) {
            Ok(same) => {
                assert!(at[0] && at[1]);
                assert!((same.direction - out.direction).length() < 1e-15);
                counts[0] += 1;
            }
            Err(lost) => {
                assert_eq!(lost.reason, Failure::OutsideAperture);
                assert_eq!(lost.surface, if at[0] { 7 } else { 6 });
                assert!(!(at[0] && at[1]));
                counts[if at[0] { 2 } else { 1 }] += 1;
            }
        }
    }
    assert!(counts.iter().all(|&count| count > 50), "{counts:?}");
    // The diaphragm alone makes the f-number.
    let f_number = |system: &System| Paraxial::new(system, line_nm::D).f_number.unwrap();
    assert!((f_number(&plain) - f_number(&stopped)).abs() < 1e-12);
}

/// A plate of thickness t moves a ray that hits it at the angle i sideways by t sin(i - r) / cos r, and does not turn it.
#[test]
fn flat_glass_beside_the_diaphragm_and_under_it_is_a_plate() {
    let (thickness, index) = (4.0, 1.6);
    let glass = "0 4 1.6 30 0 0\n0 3 air 30 0 0\n";
    let before = format!("{glass}0 10 air 12 0 1\n");
    let behind = "0 3 air 12 0 1\n0 4 1.6 30 0 0\n0 10 air 30 0 0\n";
    let touching = "0 0 air 12 0 1\n0 4 1.6 30 0 0\n0 13 air 30 0 0\n";
    let on_its_face = "0 4 1.6 12 0 1\n0 13 air 30 0 0\n";
    let inside = "0 1 1.6 30 0 0\n0 3 1.6 12 0 1\n0 13 air 30 0 0\n";
    for (rows, stop) in [(before.as_str(), 2), (behind, 0), (touching, 0), (on_its_face, 0), (inside, 1)] {
        let system = system(rows);
        assert_eq!(system.stop(), stop, "{rows}");
        let tracer: Tracer = system.at_wavelength(line_nm::D);
        let mut counts = [0; 2];
        for ray in rays() {
            let mut hits = Vec::new();
            match tracer.from_scene_recording(ray, &mut hits) {
                Ok(out) => {
                    counts[0] += 1;
                    assert!((out.direction - ray.direction).length() < 1e-15, "{rows}");
                    assert!(hits[stop].truncate().length() <= 6.0, "{rows}");
                    let sin = ray.direction.truncate().length();
                    let inside = (sin / index).asin();
                    let expected = thickness * (sin.asin() - inside).sin() / inside.cos();
                    let shift = (out.origin - ray.origin).cross(ray.direction).length();
                    assert!((shift - expected).abs() < 1e-13, "{rows}: {shift} {expected}");
                }
                Err(lost) => {
                    counts[1] += 1;
                    assert_eq!((lost.surface, lost.reason), (stop, Failure::OutsideAperture), "{rows}");
                    assert!(hits[stop].truncate().length() > 6.0, "{rows}");
                }
            }
        }
        assert!(counts[0] > 500 && counts[1] > 200, "{rows}: {counts:?}");
    }
}

/// The picture behind a field stop in the focal plane of a first lens, shown again by a second: the field ends where the hole does.
#[test]
fn a_field_stop_ends_the_field() {
    use petzval_optics::focus::Focus;
    use petzval_optics::vignetting::Vignetting;
    // Two paraboloids, stigmatic for the axis, far enough from one another; a hole of 10 mm in the focal plane between them, 1000 mm
    // behind the first.
    let rows = "-2000 -1000 mirror 100 -1 1\n0 -500 air 10 0 0\n1000 490 mirror 400 -1 0\n";
    let system = system(rows);
    let focus = Focus::at_infinity(&system, line_nm::D);
    // The picture is infinitely far behind the second: any film shows the field.
    let fields = Vignetting::new(&system, line_nm::D, &focus);
    // Coma widens the spot to about 3 / 16 of the angle over the f-number squared, 5 um at the rim of the hole.
    let rim = (5.0f64 / 1000.0).atan().to_degrees();
    assert!((fields.half_field_deg.unwrap() / rim - 1.0).abs() < 2e-3, "{fields:?} {rim}");
    assert!((fields.largest_field_deg.unwrap() / rim - 1.0).abs() < 4e-3, "{fields:?} {rim}");
}

#[test]
fn a_second_diaphragm_is_refused_with_advice() {
    let error = parse(&TRIPLET.replace("15 0 0\n-18", "15 0 1\n-18"), "two.lens", Catalogue::shipped()).unwrap_err();
    let error = error.to_string();
    assert!(error.starts_with("two.lens:5:") && error.contains("the first is in line 4"), "{error}");
    assert!(error.contains("a fixed stop is a row with isstop 0 and the same medium before and behind"), "{error}");
}
