//! Focus: conjugates against exact rays near the axis; the film plane.

mod common;

use std::f64::consts::FRAC_PI_2;

use common::{lens_names, system};
use glam::DVec3;
use petzval_optics::focus::{FilmPlane, FocusError, film_z_for_focus_mm, focus_distance_for_film_mm, magnification};
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::trace::Ray;

/// Lenses that focus on something; all but the telescopes' short distances do.
fn focusing() -> impl Iterator<Item = (String, petzval_optics::system::System)> {
    lens_names().into_iter().map(|name| (name.clone(), system(&name)))
}

#[test]
fn exact_rays_near_the_axis_meet_on_the_film() {
    for (name, system) in focusing() {
        let info = Paraxial::new(&system, line_nm::D);
        let (pupil, size) = (info.entrance_pupil.z_mm.unwrap(), info.efl_mm.unwrap());
        for factor in [30.0, 100.0, f64::INFINITY] {
            let distance = factor * size - info.ffd_mm.unwrap().min(0.0) + pupil.max(0.0);
            let film = film_z_for_focus_mm(&system, line_nm::D, distance).unwrap();
            // A ray 1e-5 of the focal length off the axis: aberrations are below 1e-9.
            let height = 1e-5 * size;
            let ray = if distance.is_infinite() {
                Ray { origin: DVec3::new(height, 0.0, -size), direction: DVec3::Z }
            } else {
                let origin = DVec3::new(0.0, 0.0, pupil - distance);
                Ray { origin, direction: (DVec3::new(height, 0.0, 0.0) - origin).normalize() }
            };
            let out = system.at_wavelength(line_nm::D).from_scene(ray).unwrap();
            let crossing = out.origin.z - out.origin.x / out.direction.x * out.direction.z;
            assert!((crossing - film).abs() < 1e-7 * size, "{name} at {distance}: {crossing} {film}");
        }
    }
}

#[test]
fn distance_and_film_undo_each_other() {
    for (name, system) in focusing() {
        let info = Paraxial::new(&system, line_nm::D);
        for factor in [3.0, 17.0, 1000.0] {
            let nearest = info.entrance_pupil.z_mm.unwrap() - info.ffd_mm.unwrap().min(0.0);
            let distance = nearest + factor * info.efl_mm.unwrap();
            let film = film_z_for_focus_mm(&system, line_nm::D, distance).unwrap();
            let back = focus_distance_for_film_mm(&system, line_nm::D, film);
            // Far away, a rounding of the film's place is much: the longitudinal magnification is factor².
            assert!((back / distance - 1.0).abs() < 1e-11 * factor, "{name}: {back} {distance}");
            let m = magnification(&system, line_nm::D, film);
            // Newton: m = −f / x, x from the object focal point.
            let x = distance - info.entrance_pupil.z_mm.unwrap() + info.ffd_mm.unwrap();
            let f = info.efl_mm.unwrap() / system.image_index(line_nm::D);
            assert!((m + f / x).abs() < 1e-10, "{name}: {m} {}", -f / x);
        }
        let film = film_z_for_focus_mm(&system, line_nm::D, f64::INFINITY).unwrap();
        assert!((film - info.image_focal_plane_mm.unwrap()).abs() < 1e-9 * info.efl_mm.unwrap());
        assert!(focus_distance_for_film_mm(&system, line_nm::D, film).abs() > 1e9 * info.efl_mm.unwrap(), "{name}");
    }
}

#[test]
fn what_cannot_be_sharp_says_what_can() {
    let system = system("double-gauss-f2-available");
    let nearest = match film_z_for_focus_mm(&system, line_nm::D, 10.0) {
        Err(FocusError::TooClose { nearest_mm, .. }) => nearest_mm,
        other => panic!("{other:?}"),
    };
    assert!(film_z_for_focus_mm(&system, line_nm::D, nearest * 1.001).is_ok());
    assert!(film_z_for_focus_mm(&system, line_nm::D, nearest * 0.999).is_err());
    for bad in [0.0, -3.0, f64::NAN, f64::NEG_INFINITY] {
        assert!(matches!(film_z_for_focus_mm(&system, line_nm::D, bad), Err(FocusError::NotPositive { .. })));
    }
}

#[test]
fn the_film_turns_about_its_axes() {
    let film = FilmPlane { z_mm: 60.0, tilt_rad: 0.0, swing_rad: 0.0, shift_mm: [3.0, -1.0] };
    assert_eq!(film.point(1.0, 2.0), DVec3::new(4.0, 1.0, 60.0));
    assert_eq!(film.normal(), DVec3::NEG_Z);
    let tilted = FilmPlane { tilt_rad: 0.3, ..FilmPlane::upright(60.0) };
    assert_eq!(tilted.point(5.0, 0.0), DVec3::new(5.0, 0.0, 60.0));
    assert!((tilted.point(0.0, 1.0) - DVec3::new(0.0, 0.3f64.cos(), 60.0 + 0.3f64.sin())).length() < 1e-14);
    let swung = FilmPlane { swing_rad: FRAC_PI_2, ..FilmPlane::upright(60.0) };
    assert!((swung.point(1.0, 0.0) - DVec3::new(0.0, 0.0, 59.0)).length() < 1e-14);
    let both = FilmPlane { tilt_rad: 0.2, swing_rad: -0.4, shift_mm: [2.0, 1.0], ..FilmPlane::upright(60.0) };
    let (a, b, c) = (both.point(0.0, 0.0), both.point(1.0, 0.0), both.point(0.0, 1.0));
    assert!((b - a).dot(both.normal()).abs() < 2e-14 && (c - a).dot(both.normal()).abs() < 2e-14);
    assert!(both.normal().z < 0.0);
}
