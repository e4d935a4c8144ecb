//! Smallest spots against spots measured ray by ray, and against Gaussian optics where that is exact.

use super::*;
use crate::focus::{Anchor, Focusing, film_z_for_focus_mm};
use crate::formats::lens;
use crate::glass::{Catalogue, line_nm};
use crate::paraxial::Paraxial;
use crate::system::LensSettings;

const D: [(f64, f64); 1] = [(line_nm::D, 1.0)];

fn system(file: &str, f_number: Option<f64>) -> System {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses")).join(file);
    let prescription = lens::read(&path, Catalogue::shipped()).unwrap();
    System::new(&prescription, &LensSettings { f_number, ..LensSettings::default() }).unwrap()
}

/// Mean square of the spot that an even grid of rays to the front glass makes on a film: no map, no sums, no parabola.
fn spot(system: &System, wavelengths: &[(f64, f64)], point: DVec3, film: &FilmPlane) -> f64 {
    let (frame, radius) = (film.frame(), system.surfaces()[0].semi_diameter_mm);
    let mut landed: Vec<(DVec3, f64)> = Vec::new();
    for &(nm, weight) in wavelengths {
        let tracer = system.at_wavelength(nm);
        for i in 0..400 * 400 {
            let at = |k: i32| (f64::from(k) + 0.5) / 200.0 - 1.0;
            let target = DVec3::new(at(i % 400), at(i / 400), 0.0) * radius;
            let ray = Ray { origin: point, direction: (target - point).normalize() };
            if let Ok(out) = tracer.from_scene(ray)
                && let Some([u, v]) = frame.meet(&out)
            {
                landed.push((frame.at(u, v).point, weight));
            }
        }
    }
    assert!(landed.len() > 1000, "{}", landed.len());
    let sum: f64 = landed.iter().map(|(_, w)| w).sum();
    let middle = landed.iter().map(|(p, w)| *p * *w).sum::<DVec3>() / sum;
    landed.iter().map(|(p, w)| w * (*p - middle).length_squared()).sum::<f64>() / sum
}

/// Distance of the film from the smallest spot by the grid: the vertex of the parabola through three of its spots.
fn off_by_grid(spot: impl Fn(f64) -> f64, step: f64) -> f64 {
    let [low, here, high] = [spot(-step), spot(0.0), spot(step)];
    0.5 * step * (low - high) / (low - 2.0 * here + high)
}

#[test]
fn nothing_is_smaller_than_the_smallest_spot() {
    for (file, point, turned, curvature_per_mm) in [
        ("double-gauss-f1.35.lens", DVec3::new(0.0, 0.0, -1500.0), [0.0, 0.0], 0.0),
        ("double-gauss-f1.35.lens", DVec3::new(300.0, -150.0, -1500.0), [0.1, -0.05], 0.0),
        ("wide-angle-smith-f3.4.lens", DVec3::new(-900.0, 300.0, -2000.0), [0.0, 0.2], 0.0),
        ("reflex-nikkor-500-f8.lens", DVec3::new(50.0, 20.0, -9000.0), [0.0, 0.0], 0.0),
        ("eye-navarro.lens", DVec3::new(200.0, 100.0, -2000.0), [0.0, 0.0], -1.0 / 12.0),
    ] {
        let system = system(file, None);
        let turned = FilmPlane { tilt_rad: turned[0], swing_rad: turned[1], ..FilmPlane::upright(0.0) };
        let film = FilmPlane { curvature_per_mm, ..turned };
        for wavelengths in [&D[..], &PHOTOPIC] {
            let found = Autofocus::new(&system, wavelengths).film(Subject::Point(point), &film).unwrap();
            let at = |off: f64| spot(&system, wavelengths, point, &FilmPlane { z_mm: found.film_z_mm + off, ..film });
            let off = off_by_grid(at, 0.02);
            // Two ways to spread some hundred rays over the pupil's rim: the spot's size agrees to a few hundredths of
            // itself, its place to the same part of the depth of focus, spot over slope.
            let depth = found.rms_mm * 2.0 * system.f_number() + 0.005;
            assert!(off.abs() < 0.05 * depth, "{file} {point}: {off} of {depth}");
            let rms = at(0.0).sqrt();
            assert!((rms / found.rms_mm - 1.0).abs() < 0.05, "{file} {point}: {rms} {}", found.rms_mm);
        }
    }
}

/// Stopped down on the axis, the smallest spot is at the paraxial image: near, far and at infinity, with mirrors too.
#[test]
fn stopped_down_it_is_the_paraxial_focus() {
    for file in ["double-gauss-f2-available.lens", "tessar-brendel.lens", "newtonian-f5.lens", "questar-3.5.lens"] {
        let system = system(file, Some(128.0));
        let focal = Paraxial::new(&system, line_nm::D).efl_mm.unwrap();
        let pupil = Paraxial::new(&system, line_nm::D).entrance_pupil.z_mm.unwrap();
        let auto = Autofocus::new(&system, &D);
        for distance in [20.0 * focal, f64::INFINITY] {
            let subject = match distance.is_finite() {
                true => Subject::Point(DVec3::new(0.0, 0.0, pupil - distance)),
                false => Subject::Direction(DVec3::NEG_Z),
            };
            let paraxial = film_z_for_focus_mm(&system, line_nm::D, distance).unwrap();
            match auto.film(subject, &FilmPlane::upright(0.0)) {
                // Spherical aberration goes with the square of the aperture: 1/64 of the focal length to either side.
                Ok(found) => {
                    let off = found.film_z_mm - paraxial;
                    assert!(off.abs() < 3e-4 * focal, "{file} {distance}: {off}");
                }
                // The obstruction is larger than the opening.
                Err(error) => assert!(
                    error == AutofocusError::NothingThrough && system.surfaces().iter().any(|s| s.obstruction_mm > 0.0),
                    "{file}: {error}"
                ),
            }
        }
    }
}

#[test]
fn what_has_no_image_is_refused() {
    let system = system("tessar-brendel.lens", None);
    let auto = Autofocus::new(&system, &D);
    let film = FilmPlane::upright(0.0);
    let on = |x: f64, z: f64| auto.film(Subject::Point(DVec3::new(x, 0.0, z)), &film);
    assert_eq!(on(0.0, -20.0), Err(AutofocusError::NoRealImage));
    assert_eq!(on(1e6, -1000.0), Err(AutofocusError::NothingThrough));
    assert_eq!(on(0.0, 1.0), Err(AutofocusError::NothingThrough));
}

/// Three points at their own depths: a film moved either way has no smaller spot at any of them.
#[test]
fn three_points_are_sharp_at_once() {
    for (file, points) in [
        (
            "double-gauss-f2-available.lens",
            [[-200.0, -100.0, -1800.0], [250.0, -80.0, -1200.0], [40.0, 200.0, -2600.0]],
        ),
        ("wide-angle-smith-f3.4.lens", [[-400.0, -300.0, -2000.0], [400.0, -300.0, -2200.0], [0.0, 500.0, -6000.0]]),
    ] {
        let system = system(file, Some(5.6));
        let auto = Autofocus::new(&system, &PHOTOPIC);
        let points = points.map(DVec3::from);
        let film = auto.film_through(points.map(Subject::Point)).unwrap();
        assert!(film.tilt_rad.abs() > 0.005, "{film:?}");
        for point in points {
            let found = auto.film(Subject::Point(point), &film).unwrap();
            assert!((found.film_z_mm - film.z_mm).abs() < 1e-8, "{file}: {} {}", found.film_z_mm, film.z_mm);
            let at = |off: f64| spot(&system, &PHOTOPIC, point, &FilmPlane { z_mm: film.z_mm + off, ..film });
            let off = off_by_grid(at, 0.02);
            // As for one point.
            let depth = found.rms_mm * 2.0 * system.f_number() + 0.005;
            assert!(off.abs() < 0.05 * depth, "{file} {point}: {off} of {depth}");
        }
    }
}

/// Stopped down near the axis, the film is Scheimpflug's: the object plane and the film, carried on, meet in one line
/// where they reach the principal planes at the same height.
#[test]
fn the_planes_meet_as_scheimpflug_says() {
    let system = system("double-gauss-f2-available.lens", Some(64.0));
    let info = Paraxial::new(&system, line_nm::D);
    let (before, behind) = (info.object_principal_plane_mm.unwrap(), info.image_principal_plane_mm.unwrap());
    // A plane through (0, 0, before − 1000) that rises towards the lens: z = before − 1000 + 2 y.
    let on_plane = |x: f64, y: f64| Subject::Point(DVec3::new(x, y, before - 1000.0 + 2.0 * y));
    let film = Autofocus::new(&system, &D)
        .film_through([on_plane(-9.0, -9.0), on_plane(9.0, -9.0), on_plane(0.0, 9.0)])
        .unwrap();
    // The object plane reaches its principal plane at y = 500. The film: y rises along (0, cos tilt, sin tilt).
    let height = (behind - film.z_mm) / film.tilt_rad.tan();
    // Field curvature over 9 mm at 20 mm-radii of the film's scale is some 1e-4 of the image's distance.
    assert!((height / 500.0 - 1.0).abs() < 0.01, "{height} {film:?}");
    // The rays are spread over the pupil's two sides alike to a thousandth.
    assert!(film.swing_rad.abs() < 1e-3 * film.tilt_rad.abs(), "{film:?}");
    let focused = Focusing { anchor: Anchor::FrontVertex, ..Focusing::default() };
    let middle = focused.film_z_mm(&system, line_nm::D, 1000.0 - before).unwrap();
    assert!((film.z_mm - middle).abs() < 0.01, "{} {middle}", film.z_mm);
}

#[test]
fn points_that_make_no_plane_are_refused() {
    let system = system("double-gauss-f2-available.lens", Some(8.0));
    let auto = Autofocus::new(&system, &D);
    let film = |points: [[f64; 3]; 3]| auto.film_through(points.map(|p| Subject::Point(DVec3::from(p))));
    let line = film([[0.0, 0.0, -1000.0], [10.0, 20.0, -1500.0], [20.0, 40.0, -2000.0]]);
    assert_eq!(line, Err(SharpPlaneError::Collinear));
    let unseen = film([[0.0, 0.0, -1000.0], [100.0, 20.0, -1500.0], [0.0, 1e5, -1000.0]]);
    assert_eq!(unseen, Err(SharpPlaneError::Point { number: 3, source: AutofocusError::NothingThrough }));
    let too_close = 0.9 * Paraxial::new(&system, line_nm::D).ffd_mm.unwrap();
    let close = film([[0.0, 0.0, too_close], [100.0, 20.0, -1500.0], [0.0, 100.0, -1000.0]]);
    assert_eq!(close, Err(SharpPlaneError::Point { number: 1, source: AutofocusError::NoRealImage }));
    // A plane along the line of sight: the film would be one, too.
    let along = film([[0.0, 0.0, -1000.0], [0.0, 1.0, -1500.0], [100.0, 0.5, -1200.0]]);
    assert!(matches!(along, Err(SharpPlaneError::TooSteep | SharpPlaneError::Collinear)), "{along:?}");
}

/// Every third shipped lens (all of them by `make test-all`), at f/8, on the axis and well off it, finds a film, and no stray rays spread
/// the spot.
#[test]
fn every_lens_finds_its_focus() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses"));
    let mut found = 0;
    for path in petzval_testkit::lenses::third(folder, 0) {
        let system = system(path.file_name().unwrap().to_str().unwrap(), Some(8.0));
        let info = Paraxial::new(&system, line_nm::D);
        let (Some(focal), Some(pupil)) = (info.efl_mm, info.entrance_pupil.z_mm) else { continue };
        if focal < 0.0 || film_z_for_focus_mm(&system, line_nm::D, 100.0 * focal).is_err() {
            continue;
        }
        let auto = Autofocus::new(&system, &PHOTOPIC);
        let slope = system.half_field_deg().unwrap_or(1.0).min(30.0).to_radians().tan() * 0.5;
        let upright = FilmPlane::upright(0.0);
        let film = FilmPlane { curvature_per_mm: system.film_radius_mm().map_or(0.0, f64::recip), ..upright };
        for slope in [0.0, slope] {
            let point = DVec3::new(slope * 100.0 * focal, 0.0, pupil - 100.0 * focal);
            let sharpest = auto.film(Subject::Point(point), &film).unwrap();
            // What f/8 makes of a film a tenth of the focal length out of place: far more than any of them has.
            assert!(sharpest.rms_mm < 0.005 * focal, "{} {slope}: {sharpest:?} {focal}", path.display());
            found += 1;
        }
    }
    assert!(found > 30, "{found}");
}
