//! Focus: conjugates against exact rays near the axis; the film plane.

use std::f64::consts::FRAC_PI_2;

use crate::common::{lens_names, system};
use glam::DVec3;
use petzval_optics::focus::{
    FilmPlane, Focus, FocusError, film_z_for_focus_mm, focus_distance_for_film_mm, magnification,
};
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::seidel::Seidel;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::Ray;

/// Lenses that focus on something; all but the telescopes' short distances do.
fn focusing() -> impl Iterator<Item = (String, System)> {
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

/// Exact rays have the magnification and the working f-number, through mirrors too: six of the lenses have them, one of
/// those an odd number.
#[test]
fn exact_rays_have_the_magnification_and_the_working_f_number() {
    let mut mirrors = 0;
    for (name, system) in focusing() {
        let info = Paraxial::new(&system, line_nm::D);
        let (pupil, size) = (info.entrance_pupil.z_mm.unwrap(), info.efl_mm.unwrap());
        let nearest = pupil - info.ffd_mm.unwrap().min(0.0);
        let mirror =
            |s: &&petzval_optics::system::Surface| matches!(s.element, petzval_optics::system::Element::Reflect { .. });
        mirrors += usize::from(system.surfaces().iter().any(|s| mirror(&s)));
        for focal_lengths in [3.0, 100.0] {
            let distance = nearest + focal_lengths * size;
            let focus = Focus::at_distance(&system, line_nm::D, distance).unwrap();
            let object = focus.object_plane_mm.unwrap();
            assert!((object - (pupil - distance)).abs() < 1e-12 * distance, "{name}");
            let tracer = system.at_wavelength(line_nm::D);
            // From `height` in the object plane to `at_pupil` in the entrance pupil.
            let on_film = |height: f64, at_pupil: f64| {
                let origin = DVec3::new(0.0, height, object);
                let direction = (DVec3::new(0.0, at_pupil, pupil) - origin).normalize();
                let out = tracer.from_scene(Ray { origin, direction }).unwrap();
                let slope = out.direction.y / out.direction.z;
                (out.origin.y + (focus.film_z_mm - out.origin.z) * slope, slope)
            };
            let small = 1e-4 * info.entrance_pupil.diameter_mm.unwrap();
            let (height, _) = on_film(small, 0.0);
            let m = focus.magnification.unwrap();
            assert!((height / small / m - 1.0).abs() < 1e-6, "{name}: {} {m}", height / small);
            let (_, slope) = on_film(0.0, small);
            let full = slope.abs() / small * info.entrance_pupil.diameter_mm.unwrap() / 2.0;
            let expected = 0.5 / (system.image_index(line_nm::D) * full);
            let working = focus.working_f_number.unwrap();
            assert!((working / expected - 1.0).abs() < 1e-6, "{name}: {working} {expected}");
        }
        let far = Focus::at_distance(&system, line_nm::D, f64::INFINITY).unwrap();
        let infinity = Focus::at_infinity(&system, line_nm::D);
        assert!((far.film_z_mm - infinity.film_z_mm).abs() < 1e-12 * (size + far.film_z_mm.abs()), "{name}");
        assert_eq!((far.object_plane_mm, far.magnification), (None, Some(0.0)));
        assert_eq!(far.working_f_number, info.f_number);
    }
    assert_eq!(mirrors, 6);
}

fn lens(rows: &str) -> System {
    let text = format!("#radius thickness glass diameter conic isstop\n{rows}");
    System::new(&lens::parse(&text, "test", Catalogue::shipped()).unwrap(), &LensSettings::default()).unwrap()
}

#[test]
fn what_is_infinite_is_none_and_no_number_is_none() {
    let window = lens("0 5 1.5 20 0 1\n 0 50 air 20 0 0");
    let flat_mirror = lens("0 -150 mirror 50 0 1");
    // Thin lenses of f = 100 and -50 mm, 50 mm apart.
    let galilean = lens("50 0 1.5 20 0 1\n 0 50 air 20 0 0\n 0 0 1.5 20 0 0\n 25 30 air 20 0 0");
    for afocal in [&window, &flat_mirror, &galilean] {
        let info = Paraxial::new(afocal, line_nm::D);
        let planes = [info.efl_mm, info.bfd_mm, info.ffd_mm, info.image_focal_plane_mm, info.object_principal_plane_mm];
        assert_eq!(planes, [None; 5]);
        assert_eq!(info.f_number, None);
        let focus = Focus::at_infinity(afocal, line_nm::D);
        assert_eq!((focus.magnification, focus.working_f_number), (None, None));
        assert_eq!(focus.film_z_mm, afocal.film_z_published_mm());
        assert_eq!(Focus::at_distance(afocal, line_nm::D, 1000.0), Err(FocusError::NoRealImage));
        let sums = Seidel::new(afocal, line_nm::D, None).unwrap().total();
        assert!(sums.seidel.iter().chain(&sums.chromatic).all(|x| x.is_finite()));
    }
    // The stop in the rear focal plane of the front: seen from the scene at infinity.
    let telecentric = lens("50 0 1.5 30 0 0\n 0 100 air 30 0 0\n 0 20 air 5 0 1");
    let info = Paraxial::new(&telecentric, line_nm::D);
    assert_eq!((info.entrance_pupil.z_mm, info.entrance_pupil.diameter_mm, info.f_number), (None, None, None));
    let focus = Focus::at_infinity(&telecentric, line_nm::D);
    assert_eq!((focus.magnification, focus.working_f_number), (Some(0.0), None));
    assert_eq!(Focus::at_distance(&telecentric, line_nm::D, 1000.0), Err(FocusError::NoEntrancePupil));
    // A wavelength at which a glass has no index: N-BK7's formula, said to hold where it does not.
    let glass = lens(
        "# glass: X sellmeier 100-2500 0 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\n\
         50 5 X 30 0 0\n -50 40 air 30 0 1",
    );
    let opaque_nm = 140.0;
    assert!(Paraxial::new(&glass, opaque_nm).efl_mm.is_none());
    assert_eq!(Seidel::new(&glass, opaque_nm, None), None);
    assert!(Focus::at_infinity(&glass, opaque_nm).film_z_mm.is_finite());
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
    let film = FilmPlane { shift_mm: [3.0, -1.0], ..FilmPlane::upright(60.0) };
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
