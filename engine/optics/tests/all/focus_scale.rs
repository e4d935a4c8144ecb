//! Focus distances counted from each anchor, against exact rays near the axis; the two relations against each other.

use crate::common::{lens_names, system};
use glam::DVec3;
use petzval_optics::focus::{Anchor, FocusError, Focusing, Relation, film_z_for_focus_mm};
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::System;
use petzval_optics::trace::Ray;

const ANCHORS: [Anchor; 3] = [Anchor::EntrancePupil, Anchor::FrontVertex, Anchor::Film];

fn focusing(anchor: Anchor, relation: Relation) -> Focusing {
    Focusing { anchor, relation }
}

/// The z at which a ray from the axis at `object_z` that hits the first vertex 1e-5 of the focal length beside it crosses the axis again.
fn crossing(system: &System, object_z: f64, size: f64) -> f64 {
    let origin = DVec3::new(0.0, 0.0, object_z);
    let direction = (DVec3::new(1e-5 * size, 0.0, 0.0) - origin).normalize();
    let out = system.at_wavelength(line_nm::D).from_scene(Ray { origin, direction }).unwrap();
    out.origin.z - out.origin.x / out.direction.x * out.direction.z
}

#[test]
fn what_is_at_the_distance_is_sharp_from_each_anchor() {
    let mut seen = 0;
    for name in lens_names() {
        let system = system(&name);
        let info = Paraxial::new(&system, line_nm::D);
        let size = info.efl_mm.unwrap();
        for anchor in ANCHORS {
            for factor in [5.0, 30.0, 300.0] {
                let how = focusing(anchor, Relation::Exact);
                // Clear of the nearest, wherever the lens is thick.
                let distance = factor * size + 2.0 * (info.total_track_mm.abs() + info.ffd_mm.unwrap().abs());
                let film = how.film_z_mm(&system, line_nm::D, distance).unwrap();
                let object_z = how.origin_z_mm(&system, line_nm::D, film) - distance;
                let crossed = crossing(&system, object_z, size);
                // Aberrations of such a ray are below 1e-9 of the focal length.
                assert!((crossed - film).abs() < 1e-7 * size, "{name} {anchor:?} {distance}: {crossed} {film}");
                let back = how.distance_mm(&system, line_nm::D, film);
                // A rounding of the film's place counts by the square of the reduction.
                assert!((back / distance - 1.0).abs() < 1e-9 * factor, "{name} {anchor:?}: {back} {distance}");
                seen += 1;
            }
        }
    }
    assert!(seen > 60, "{seen}");
}

/// The image at the closest distance between object and film is as large as the object: four focal lengths and the gap of the principal
/// planes.
#[test]
fn no_film_is_nearer_to_what_it_shows_than_at_life_size() {
    let system = system("biconvex-50mm");
    let info = Paraxial::new(&system, line_nm::D);
    let gap = info.image_principal_plane_mm.unwrap() - info.object_principal_plane_mm.unwrap();
    let nearest = 4.0 * info.efl_mm.unwrap() + gap;
    let how = focusing(Anchor::Film, Relation::Exact);
    let film = |distance| how.film_z_mm(&system, line_nm::D, distance);
    let life_size = info.image_principal_plane_mm.unwrap() + 2.0 * info.efl_mm.unwrap();
    // The film's place goes with the root of what the distance has over the nearest.
    assert!((film(nearest * (1.0 + 1e-12)).unwrap() - life_size).abs() < 1e-3);
    let Err(FocusError::TooClose { nearest_mm, .. }) = film(nearest * 0.999) else { panic!() };
    assert!((nearest_mm - nearest).abs() < 1e-9);
}

/// The thin relation in air is the exact one counted from the object principal plane; its two distances obey 1/U + 1/V = 1/f in every lens,
/// eyes too.
#[test]
fn the_thin_relation_is_the_papers() {
    for name in lens_names() {
        let system = system(&name);
        let info = Paraxial::new(&system, line_nm::D);
        let (f, h) = (info.efl_mm.unwrap(), info.object_principal_plane_mm.unwrap());
        for anchor in ANCHORS {
            let how = focusing(anchor, Relation::Thin);
            let distance = 20.0 * f + 3.0 * h.abs();
            let Ok(film) = how.film_z_mm(&system, line_nm::D, distance) else { continue };
            let behind = (film - info.image_principal_plane_mm.unwrap()).abs();
            assert!((1.0 / distance + 1.0 / behind - 1.0 / f).abs() < 1e-12 / f, "{name}");
            assert!((how.distance_mm(&system, line_nm::D, film) / distance - 1.0).abs() < 1e-11, "{name}");
            if system.image_index(line_nm::D) == 1.0 {
                let from_pupil = distance + info.entrance_pupil.z_mm.unwrap() - h;
                let exact = film_z_for_focus_mm(&system, line_nm::D, from_pupil).unwrap();
                assert!((film - exact).abs() < 1e-9 * f, "{name}: {film} {exact}");
            }
            let far = how.film_z_mm(&system, line_nm::D, f64::INFINITY).unwrap();
            assert!((far - info.image_focal_plane_mm.unwrap()).abs() < 1e-9 * f, "{name}");
            assert_eq!(how.distance_mm(&system, line_nm::D, info.image_principal_plane_mm.unwrap()), 0.0);
        }
        let close = focusing(Anchor::EntrancePupil, Relation::Thin).film_z_mm(&system, line_nm::D, 0.5 * f);
        assert!(matches!(close, Err(FocusError::TooClose { nearest_mm, .. }) if nearest_mm == f), "{name}");
    }
}

#[test]
fn infinity_is_the_same_for_all() {
    let system = system("biconvex-50mm");
    let expected = Paraxial::new(&system, line_nm::D).image_focal_plane_mm.unwrap();
    for anchor in ANCHORS {
        for relation in [Relation::Exact, Relation::Thin] {
            let how = focusing(anchor, relation);
            let film = how.film_z_mm(&system, line_nm::D, f64::INFINITY).unwrap();
            assert!((film - expected).abs() < 1e-10);
            let bad = how.film_z_mm(&system, line_nm::D, f64::NAN);
            assert!(matches!(bad, Err(FocusError::NotPositive { .. })));
        }
    }
}
