//! A written lens reads back as the same lens, to the last bit.

use petzval_optics::formats::{lens, zmx};
use petzval_optics::glass::Catalogue;
use petzval_optics::prescription::{NextMedium, Prescription};

use super::{foreign, parse};
use crate::common::repository;

/// All that a ray hits is the same, to the last bit.
pub(super) fn assert_same(name: &str, a: &Prescription, b: &Prescription) {
    assert_eq!(a.surfaces.len(), b.surfaces.len(), "{name}");
    for (i, (a, b)) in a.surfaces.iter().zip(&b.surfaces).enumerate() {
        assert_eq!(a.shape, b.shape, "{name} {i}");
        assert_eq!(a.thickness_mm.to_bits(), b.thickness_mm.to_bits(), "{name} {i}");
        assert_eq!(a.semi_diameter_mm, b.semi_diameter_mm, "{name} {i}");
        assert_eq!(a.obstruction_mm, b.obstruction_mm, "{name} {i}");
        assert_eq!(a.coating, b.coating, "{name} {i}");
        match (&a.behind, &b.behind) {
            (NextMedium::Mirror, NextMedium::Mirror) => {}
            (NextMedium::Medium(a), NextMedium::Medium(b)) => {
                for nm in [300.0, 365.0, 404.7, 486.1, 550.0, 587.6, 656.3, 780.0, 1014.0] {
                    assert_eq!(a.index(nm).to_bits(), b.index(nm).to_bits(), "{name} {i} {a:?} {b:?}");
                    assert_eq!(a.internal_transmittance(nm, 3.0), b.internal_transmittance(nm, 3.0));
                }
                assert_eq!(a.range_nm(), b.range_nm(), "{name} {i} {a:?}");
            }
            _ => panic!("{name} {i}"),
        }
    }
    assert_eq!((a.stop, a.film_radius_mm), (b.stop, b.film_radius_mm), "{name}");
    assert_eq!(a.moving, b.moving, "{name}");
    assert_eq!(a.name, b.name);
    let said = |lens: &Prescription| (lens.metadata.f_number, lens.metadata.half_field_deg, lens.metadata.film_mm);
    assert_eq!(said(a), said(b), "{name}");
}

fn shipped() -> Vec<(String, Prescription)> {
    let files = std::fs::read_dir(repository("lenses")).unwrap().map(|entry| entry.unwrap().path());
    let lenses: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|ending| ending == "lens"))
        .map(|path| (path.display().to_string(), lens::read(&path, Catalogue::shipped()).unwrap()))
        .collect();
    assert!(lenses.len() >= 40);
    lenses
}

pub(super) fn again(
    lens: &Prescription,
    write: fn(&Prescription, &Catalogue) -> (String, Vec<String>),
    name: &str,
) -> Prescription {
    let (text, _) = write(lens, Catalogue::shipped());
    parse(name, &text).unwrap_or_else(|error| panic!("{error}\n{text}")).prescription
}

#[test]
fn lens_files_come_back() {
    for (name, lens) in shipped() {
        let (text, lost) = lens::write(&lens, Catalogue::shipped());
        assert_eq!(lost, [] as [String; 0], "{name}");
        let rows = text.lines().filter(|line| !line.starts_with('#'));
        assert!(rows.into_iter().all(|row| !row.starts_with("1/")), "{name}: a radius was not found again\n{text}");
        let back = again(&lens, lens::write, "x.lens");
        assert_same(&name, &lens, &back);
        for (a, b) in lens.surfaces.iter().zip(&back.surfaces) {
            assert_eq!(a.pose, b.pose);
            assert_eq!(a.behind, b.behind, "{name}: the glass keeps its name and maker");
        }
    }
}

#[test]
fn zemax_files_come_back() {
    for (name, lens) in shipped() {
        let back = again(&lens, zmx::write, "x.zmx");
        assert_same(&name, &lens, &back);
        // And once more through the other.
        assert_same(&name, &lens, &again(&back, lens::write, "x.lens"));
    }
}

#[test]
fn files_of_other_programs_come_back() {
    for name in [
        "ag_dblgauss.seq",
        "questar35.seq",
        "schmidt.seq",
        "eyepiece.zmx",
        "planar-1897.zmx",
        "cooke.len",
        "canon-11-24.txt",
    ] {
        let lens = foreign(name).prescription;
        assert_same(name, &lens, &again(&lens, lens::write, "x.lens"));
        assert_same(name, &lens, &again(&lens, zmx::write, "x.zmx"));
    }
}

/// Curvatures that are the reciprocal of no floating-point number, decentred elements, odd and high powers, private
/// glasses.
#[test]
fn what_is_rare_comes_back_too() {
    let text = "# name: rare\n# glass: OWN rational 400-700 2.1 1 -0.01 2 0.3 2 0.01\n# transmittance: OWN 400:0.9@10 700:0.99@25\n\
        # glass: T table 350-800 0.35 1.6 0.5 1.58 0.6 1.57 0.8 1.56\n# element: 1-2 decenter_x=0.05 tilt_y=0.1\n\
        #radius thickness glass diameter conic isstop obstruction radius_x a3 a4 a20 tilt_z\n\
        1/0.0123456789012345 3 OWN 10 -0.5 0 1 0 1e-5 0 1e-25 0\n-33.3 2 T 10 0 1 0 -20 0 1e-6 0 3\n\
        -77.7 50 hikari:SF11 10 0 0 0 -77.7 0 0 0 0\n";
    let lens = parse("rare.lens", text).unwrap().prescription;
    let back = again(&lens, lens::write, "x.lens");
    assert_same("rare", &lens, &back);
    for (a, b) in lens.surfaces.iter().zip(&back.surfaces) {
        // Angles go through degrees.
        let (a, b) = (a.pose.parts(), b.pose.parts());
        let far = [a.0, a.1]
            .as_flattened()
            .iter()
            .zip([b.0, b.1].as_flattened())
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(far < 1e-15, "{a:?} {b:?}");
    }
    let (_, lost) = zmx::write(&lens, Catalogue::shipped());
    assert!(lost.iter().any(|what| what.contains("surface 1 stands beside its place")), "{lost:?}");
    // All curvatures that a Zemax file may hold.
    for i in 0..500 {
        let curvature = 0.01 + f64::from(i) * 1.234_567_891e-5;
        let file = format!(
            "MODE SEQ\nUNIT MM\nENPD 5\nSURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  CURV {curvature}\n  DISZ 2\n  GLAS N-BK7\n  DIAM 5\n\
             SURF 2\n  DISZ 40\n  DIAM 5\nSURF 3\n"
        );
        let lens = parse("c.zmx", &file).unwrap().prescription;
        assert_same("curvature", &lens, &again(&lens, lens::write, "x.lens"));
    }
}

/// A hyperboloid beside a cylinder has no row of its own in a file with radii across: that is said. A sphere has.
#[test]
fn a_surface_of_revolution_beside_a_toroid_is_said_to_be_lost() {
    let lost = |conic: f64| {
        let text =
            "#radius thickness glass diameter conic isstop radius_x\n50 3 N-BK7 10 0 1 0\n-40 50 air 10 0 0 -40\n";
        let mut lens = parse("x.lens", text).unwrap().prescription;
        lens.surfaces[1].shape = petzval_optics::surface::Shape::conic(-40.0, conic);
        lens::write(&lens, Catalogue::shipped()).1
    };
    assert_eq!(lost(0.0), [] as [String; 0]);
    assert!(lost(-1.5).iter().any(|what| what.contains("surface 1 is one of revolution")), "{:?}", lost(-1.5));
}
