//! Drawings show surfaces and rays at their places.

use crate::common::{ASPHERES, lens_names, prescription, repository, system};
use petzval_optics::drawing::Drawing;
use petzval_optics::focus::Focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::glass::line_nm::D;
use petzval_optics::system::{FocalLength, LensSettings, System};

fn drawn(system: &System, angles_deg: &[f64], count: usize) -> Drawing {
    Drawing::new(system, &Focus::at_infinity(system, D), D, angles_deg, count)
}

/// The light on the axis of every lens is drawn: as many rays as were asked for, the outermost past a rim, each through all surfaces where
/// these are drawn.
#[test]
fn rays_go_through_the_surfaces_as_they_are_drawn() {
    for name in lens_names().iter().map(String::as_str).chain(ASPHERES) {
        let system = system(name);
        let drawing = drawn(&system, &[0.0], 7);
        assert_eq!(drawing.surfaces.len(), system.surface_count(), "{name}");
        let rays = &drawing.fields[0].rays;
        assert_eq!(rays.len(), 7, "{name}");
        let mut fullest: f64 = 0.0;
        for ray in rays {
            assert_eq!(ray.len(), system.surface_count() + 2, "{name}");
            for (i, (profile, [z, y])) in drawing.surfaces.iter().zip(&ray[1..]).enumerate() {
                let rim = profile.points.iter().fold(0.0, |rim: f64, p| rim.max(p[1].abs()));
                assert!(y.abs() <= rim * (1.0 + 1e-9), "{name} {i}: {y} of {rim}");
                let next = profile.points.iter().position(|p| p[1] >= *y).unwrap_or(profile.points.len() - 1).max(1);
                let [below, above] = [profile.points[next - 1], profile.points[next]];
                let between = below[0] + (above[0] - below[0]) * (y - below[1]) / (above[1] - below[1]);
                // A chord leaves its arc by an eighth of the second difference; towards a steep rim that grows, within a piece.
                let bends = profile.points.windows(3).map(|p| (p[0][0] - 2.0 * p[1][0] + p[2][0]).abs());
                let sagitta = bends.fold(0.0, f64::max);
                assert!((z - between).abs() <= sagitta + 1e-9, "{name} {i}: {z} {between} {sagitta}");
                let opening = if i == drawing.stop { drawing.stop_semi_diameter_mm } else { rim };
                fullest = fullest.max(y.abs() / opening);
            }
        }
        assert!(fullest > 1.0 - 1e-6, "{name}: the beam ends at {fullest} of a rim");
    }
}

/// A lens without spherical aberration brings all of them together, and a parallel beam comes in parallel.
#[test]
fn a_stigmatic_lens_has_one_image_point() {
    let system = system("descartes-ellipsoid");
    let drawing = drawn(&system, &[0.0], 9);
    for ray in &drawing.fields[0].rays {
        let end = ray.last().unwrap();
        assert!(end[1].abs() < 1e-9, "{end:?}");
        assert!((ray[0][1] - ray[1][1]).abs() < 1e-12);
    }
}

/// Light from the side comes in at its angle; the film is as high as the rays that reach it.
#[test]
fn fields_come_from_their_angles() {
    let system = system("double-gauss-f2-tronnier");
    let drawing = drawn(&system, &[0.0, 14.0], 5);
    for ray in &drawing.fields[1].rays {
        let slope = (ray[1][1] - ray[0][1]) / (ray[1][0] - ray[0][0]);
        assert!((slope - 14f64.to_radians().tan()).abs() < 1e-12);
    }
    let highest = drawing.fields[1].rays.iter().map(|ray| ray.last().unwrap()[1]).fold(f64::MIN, f64::max);
    // The focal length times the tangent, to a few per cent of distortion and coma.
    assert!((highest / (100.7 * 14f64.to_radians().tan()) - 1.0).abs() < 0.03, "{highest}");
    let ends = [drawing.film[0][1], drawing.film.last().unwrap()[1]];
    assert!((ends[1] - highest).abs() < 1e-9 && (ends[0] + highest).abs() < 1e-9);
}

/// A mirror in the way of its own light is drawn with the light beside it.
#[test]
fn an_obstruction_parts_the_beam() {
    let text = "#radius thickness glass diameter conic isstop obstruction
        0 750 air 250 0 0 85
        -2000 -700 mirror 250 -1 1 0
        -900 900 mirror 85 -4 0 0";
    let lens = lens::parse(text, "cassegrain", Catalogue::shipped()).unwrap();
    let drawing = drawn(&System::new(&lens, &LensSettings::default()).unwrap(), &[0.0], 9);
    assert_eq!(drawing.surfaces[0].hole_mm, 42.5);
    let heights: Vec<f64> = drawing.fields[0].rays.iter().map(|ray| ray[1][1]).collect();
    assert_eq!(heights.len(), 9);
    // From the rims of both: half of the rays on each side, and none through the middle.
    assert!((heights[0] + 125.0).abs() < 1e-6 && (heights[8] - 125.0).abs() < 1e-6, "{heights:?}");
    assert!(heights.iter().all(|y| y.abs() >= 42.5) && heights.iter().any(|y| y.abs() < 45.0), "{heights:?}");
    assert_eq!(drawing.surfaces.iter().filter(|s| s.is_mirror).count(), 2);
}

/// A stop that is closed lets a narrower beam through, and none comes from behind the lens.
#[test]
fn the_stop_is_obeyed() {
    let lens = prescription("cooke-triplet-50mm");
    let closed = System::new(&lens, &LensSettings { f_number: Some(11.0), ..LensSettings::default() }).unwrap();
    let widest = |system: &System| {
        let drawing = drawn(system, &[0.0], 3);
        drawing.fields[0].rays.iter().map(|ray| ray[0][1].abs()).fold(0.0, f64::max)
    };
    let open = System::new(&lens, &LensSettings::default()).unwrap();
    assert!((widest(&open) / widest(&closed) - 11.0 / open.f_number()).abs() < 0.03);
    assert_eq!(drawn(&open, &[170.0], 3).fields[0].rays.len(), 0);
}

/// The angles need not be given: they are the design's, or follow from its rims.
#[test]
fn usual_angles_are_those_of_the_design() {
    let angles = |name: &str| {
        let system = system(name);
        let focus = Focus::at_infinity(&system, D);
        Drawing::usual_angles_deg(&system, &focus, D)
    };
    let known = angles("double-gauss-f2-tronnier");
    assert_eq!(known.len(), 3);
    assert!((known[1] / known[2] - 0.7).abs() < 1e-12 && (known[2] - 22.0).abs() < 1e-12, "{known:?}");
    let mut unsaid = prescription("double-gauss-f2-tronnier");
    unsaid.metadata.half_field_deg = None;
    let unsaid = System::new(&unsaid, &LensSettings::default()).unwrap();
    let found = Drawing::usual_angles_deg(&unsaid, &Focus::at_infinity(&unsaid, D), D);
    assert!(found.len() == 3 && (5.0..40.0).contains(&found[2]), "{found:?}");
    // A zoom at its long end does not see as far as its file says of the short one.
    let zoom = zoom_at(143.0);
    let found = Drawing::usual_angles_deg(&zoom, &Focus::at_infinity(&zoom, D), D);
    assert!(found.len() == 3 && found[2] < 10.0, "{found:?}");
    assert!(drawn(&zoom, &found, 3).fields.iter().all(|field| field.rays.len() == 3));
}

fn zoom_at(focal_length_mm: f64) -> System {
    let path = repository("lenses").join("zoom-nikon-57-143-f2.8.lens");
    let lens = lens::read(&path, Catalogue::shipped()).unwrap();
    let focal_length = FocalLength::Millimetres(focal_length_mm);
    System::new(&lens, &LensSettings { focal_length, ..LensSettings::default() }).unwrap()
}
