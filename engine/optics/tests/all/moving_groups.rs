//! Lenses that move inside: zoomed and focused as wholes, held against paraxial conjugates and exact rays.

use glam::DVec3;
use petzval_optics::focus::{Anchor, FocusError, Focusing, GroupsError, focus_distance_for_film_mm};
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{FocalLength, LensSettings, System, SystemError};
use petzval_optics::trace::Ray;

const D: f64 = line_nm::D;

fn zoom() -> Prescription {
    lens::read(&crate::common::repository("lenses").join("zoom-nikon-57-143-f2.8.lens"), Catalogue::shipped()).unwrap()
}

fn at(mm: f64) -> LensSettings {
    LensSettings { focal_length: FocalLength::Millimetres(mm), ..LensSettings::default() }
}

/// The ends are those of the printed table: 80 to 200 mm, over 1.398, and F/2.8.
#[test]
fn a_zoom_has_the_focal_length_that_is_asked_for() {
    let zoom = zoom();
    let mut vertices = Vec::new();
    for mm in [57.21, 60.0, 70.0, 85.0, 100.0, 125.0, 143.07] {
        let system = System::new(&zoom, &at(mm)).unwrap();
        let paraxial = Paraxial::new(&system, D);
        assert!((paraxial.efl_mm.unwrap() / mm - 1.0).abs() < 1e-6, "{mm}: {:?}", paraxial.efl_mm);
        // Nothing was scaled: the film stays where it is, to the cam's own error between the positions of the table.
        assert_eq!(system.scale(), 1.0);
        assert!((paraxial.bfd_mm.unwrap() - 28.74).abs() < 0.06, "{mm}: {:?}", paraxial.bfd_mm);
        assert!((2.6..3.1).contains(&system.widest_f_number()), "{mm}: {}", system.widest_f_number());
        vertices.push(system.last_vertex_z_mm());
    }
    // Neither does the lens grow: its first and its last group stand still, to the same error.
    assert!(vertices.iter().all(|z| (z - vertices[0]).abs() < 0.08), "{vertices:?}");
    // As it lies in the file: the short end.
    let published = Paraxial::new(&System::new(&zoom, &LensSettings::default()).unwrap(), D);
    assert!((published.efl_mm.unwrap() - 57.206).abs() < 1e-3);
}

#[test]
fn beyond_its_range_a_zoom_says_so() {
    for mm in [50.0, 150.0] {
        let error = System::new(&zoom(), &at(mm)).unwrap_err();
        assert!(matches!(error, SystemError::BeyondZoom { asked_mm, .. } if asked_mm == mm), "{error}");
        assert!(error.to_string().contains("57.2 to 143.1"), "{error}");
    }
}

/// The groups move until the film, where it stands, is the conjugate of the distance, whatever it is counted from; a ray
/// near the axis from there crosses the axis in the film.
#[test]
fn groups_focus_and_the_film_stays() {
    let zoom = zoom();
    for mm in [57.3, 80.0, 143.0] {
        let at_infinity = System::new(&zoom, &at(mm)).unwrap();
        let film_behind = Paraxial::new(&at_infinity, D).bfd_mm.unwrap();
        for anchor in [Anchor::EntrancePupil, Anchor::FrontVertex, Anchor::Film] {
            let focusing = Focusing { anchor, ..Focusing::default() };
            let mut last = 0.0;
            for distance in [50_000.0, 5000.0, 2500.0, 2100.0] {
                let focused = focusing.by_groups(&zoom, &at(mm), D, distance).unwrap();
                let system = &focused.system;
                assert!((focused.film_z_mm - system.last_vertex_z_mm() - film_behind).abs() < 1e-9);
                assert!((focusing.distance_mm(system, D, focused.film_z_mm) / distance - 1.0).abs() < 1e-9);
                assert!(focused.travel > last, "{mm} {anchor:?} {distance}: {}", focused.travel);
                last = focused.travel;
                let object = DVec3::Z
                    * (Paraxial::new(system, D).entrance_pupil.z_mm.unwrap()
                        - focus_distance_for_film_mm(system, D, focused.film_z_mm));
                let direction = (DVec3::new(0.02, 0.0, 0.0) - object).normalize();
                let out = system.at_wavelength(D).from_scene(Ray { origin: object, direction }).unwrap();
                let crossing = out.origin.z - out.origin.x / out.direction.x * out.direction.z;
                // Aberrations of third order at this height: 1e-6 of the focal length.
                assert!((crossing - focused.film_z_mm).abs() < 1e-3, "{mm} {distance}: {crossing}");
            }
        }
    }
}

/// A focused zoom keeps its opening and its name, but breathes: its focal length changes.
#[test]
fn focusing_breathes_and_keeps_the_diaphragm() {
    let zoom = zoom();
    let settings = LensSettings { f_number: Some(5.6), ..at(100.0) };
    let infinity = System::new(&zoom, &settings).unwrap();
    let near = Focusing::default().by_groups(&zoom, &settings, D, 1800.0).unwrap().system;
    assert_eq!(near.diaphragm(), infinity.diaphragm());
    assert_eq!(near.f_number(), infinity.f_number());
    let efl = |system: &System| Paraxial::new(system, D).efl_mm.unwrap();
    assert!(efl(&near) > 1.05 * efl(&infinity), "{} {}", efl(&near), efl(&infinity));
}

#[test]
fn what_is_too_near_is_named_with_the_nearest() {
    let focusing = Focusing { anchor: Anchor::FrontVertex, ..Focusing::default() };
    let error = focusing.by_groups(&zoom(), &at(80.0), D, 800.0).unwrap_err();
    let GroupsError::Focus(FocusError::TooClose { nearest_mm, .. }) = error else { panic!("{error}") };
    // The table ends at 1250 mm.
    assert!((nearest_mm - 1250.0).abs() < 5.0, "{nearest_mm}");
    assert!(focusing.by_groups(&zoom(), &at(80.0), D, -1.0).is_err());
    assert_eq!(focusing.by_groups(&zoom(), &at(80.0), D, f64::INFINITY).unwrap().travel, 0.0);
}

/// A prime whose rear doublet moves: its scale is that at infinity, whatever the focus.
#[test]
fn a_scaled_prime_focuses_inside() {
    let text =
        "# moving: 1 3\n# position: 20 40\n# position: focus=800 17 43\n#radius thickness glass diameter conic isstop
                80 4 1.6 30 0 0\n -400 20 air 30 0 1\n 90 4 1.6 28 0 0\n -200 40 air 28 0 0";
    let lens = lens::parse(text, "prime.lens", Catalogue::shipped()).unwrap();
    let moving = lens.moving.as_ref().unwrap();
    assert!(moving.focuses() && moving.zoom_range_mm().is_none());
    for mm in [50.0, 200.0] {
        let infinity = System::new(&lens, &at(mm)).unwrap();
        assert!((Paraxial::new(&infinity, D).efl_mm.unwrap() / mm - 1.0).abs() < 1e-12);
        let focused = Focusing::default().by_groups(&lens, &at(mm), D, 40.0 * mm).unwrap();
        assert_eq!(focused.system.scale(), infinity.scale());
        assert!(focused.travel > 0.0 && focused.travel < 1.0, "{}", focused.travel);
        // The body does not grow: the group moves between front and film.
        let film = Paraxial::new(&infinity, D).bfd_mm.unwrap() + infinity.last_vertex_z_mm();
        assert!((focused.film_z_mm - film).abs() < 1e-9 * mm);
    }
}

#[test]
fn lines_that_make_no_table_are_named_with_their_place() {
    let rows = "#radius thickness glass diameter conic isstop\n50 4 1.5 20 0 1\n0 40 air 20 0 0\n";
    let cases = [
        ("# moving: 0 x\n", "1:11: '0 x' is no list of surfaces"),
        ("# moving: 7\n# position: 4\n", "1:11: surface 7 has no such part"),
        (
            "# moving: radius:1 radius:1\n# position: 4 4\n",
            "1:11: surface 1 has no such part to move, or it is named twice",
        ),
        ("# moving: colour:1\n", "1:11: 'colour:1' is no list of surfaces"),
        ("# moving: index_shift:1\n# position: 0.1\n", "1:11: behind surface 1 is a mirror, or air"),
        ("# moving: 1\n", "1:11: gaps that move need both lines"),
        ("# position: 4\n", "1:13: gaps that move need both lines"),
        ("# moving: 1\n# position: 40 3\n", "2:13: 2 numbers where 1 parts move"),
        ("# moving: 1\n# position: zoom=-3 40\n", "2:13: 'zoom=-3 40' is no position"),
        ("# moving: 1\n# position: 40\n# position: focus=inf 41\n", "3:13: this zoom and focus were given before"),
        ("# moving: 1\n# position: focus=100 40\n", "2:13: no position has focus=inf"),
        ("# moving: 1\n# position: zoom=50 40\n# position: 41\n", "a zoom and others not"),
    ];
    for (lines, expected) in cases {
        let error = lens::parse(&format!("{lines}{rows}"), "x.lens", Catalogue::shipped()).unwrap_err().to_string();
        assert!(error.starts_with("x.lens:") && error.contains(expected), "{lines:?}: {error}");
    }
}

/// The diaphragm of a zoom may open with the focal length: F/4 from end to end, and nearly so between the positions of the table.
#[test]
fn a_zoom_keeps_its_f_number() {
    let path = crate::common::repository("lenses/nikkor-z-24-70-f4.lens");
    let prescription = lens::read(&path, Catalogue::shipped()).unwrap();
    for (focal_mm, allowed) in [(24.72, 1e-4), (30.0, 0.02), (46.31, 1e-4), (55.0, 0.02), (67.91, 1e-4)] {
        let settings = LensSettings { focal_length: FocalLength::Millimetres(focal_mm), ..LensSettings::default() };
        let system = System::new(&prescription, &settings).unwrap();
        assert!((system.f_number() / 4.0 - 1.0).abs() < allowed, "{focal_mm}: {}", system.f_number());
        let stopped = LensSettings { f_number: Some(8.0), ..settings };
        let stopped = System::new(&prescription, &stopped).unwrap();
        assert!((stopped.f_number() - 8.0).abs() < 1e-9 && !stopped.f_number_was_clamped());
    }
}
