use super::*;
use crate::calibration::{CameraToFit, Model, SeenDirection};
use crate::chief_rays::turned;
use crate::formats::lens;
use crate::glass::{Catalogue, Medium, line_nm};
use crate::prescription::NextMedium;
use crate::prescription::moving::Part;
use std::path::Path;

const SIZE: [u32; 2] = [1920, 1280];
const PITCH_MM: f64 = 36.0 / 1920.0;

fn lens_of(name: &str) -> Prescription {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses").join(name);
    lens::read(&path, Catalogue::shipped()).unwrap()
}

/// A calibration of a lens by the rays of its picture, with a film that stands `behind_mm` too far and looks at infinity; the axis stands
/// 7.5 and -4 pixels beside the middle.
fn calibrated(lens: &Prescription, behind_mm: f64) -> Calibration {
    let system = System::new(lens, &LensSettings::default()).unwrap();
    let film = FilmPlane::upright(Paraxial::new(&system, line_nm::D).film_z_mm + behind_mm);
    let rays = FilmChiefRays::new(&system, line_nm::D, film).unwrap();
    let centre_px = [967.5, 636.0];
    let seen = |i: u32| {
        let point_px = DVec2::new(48.0 * f64::from(i % 41), 64.0 * f64::from(i / 41));
        let from_axis = (point_px - DVec2::from(centre_px)) * PITCH_MM;
        let chief = rays.at(DVec2::new(-from_axis.x, from_axis.y), None).unwrap();
        SeenDirection { point_px, direction: turned(chief.scene.direction), weight: 1.0 / 861.0 }
    };
    let seen: Vec<SeenDirection> = (0..861).map(seen).collect();
    let camera = CameraToFit {
        model: Model::OpenCv,
        size_px: SIZE,
        focal_px: [Paraxial::new(&system, line_nm::D).efl_mm.unwrap() / PITCH_MM; 2],
        centre_px,
        is_symmetric: true,
        coefficients: Some(["k1", "k2", "k3", "k4", "k5", "k6"].map(str::to_owned).to_vec()),
    };
    crate::calibration::fit(&camera, &seen).unwrap().calibration
}

fn task<'a>(lens: &'a Prescription, settings: &'a LensSettings, calibration: &'a Calibration) -> LensToFit<'a> {
    LensToFit {
        prescription: lens,
        settings,
        calibration,
        pitch_mm: [PITCH_MM; 2],
        wavelength_nm: line_nm::D,
        focus_distance_mm: None,
        adjusted: &[Adjusted::FocalLength],
        gaps: None,
    }
}

/// The focal length of a lens that is 2.3 % larger, and the only residual is that of the calibration's formula.
#[test]
fn a_larger_lens_is_found() {
    let (lens, settings) = (lens_of("nikkor-28-f1.4.lens"), LensSettings::default());
    let calibration = calibrated(&lens.scaled(1.023), 0.0);
    let found = fit(&task(&lens, &settings, &calibration)).unwrap();
    assert!((found.scale - 1.023).abs() < 2e-6, "{}", found.scale);
    let [before, after] = found.misfit;
    // Before, heights are off by 2.3 %: in the corner of 1147 pixels 26.
    assert!((before.worst_px - 0.023 / 1.023 * 1147.0).abs() < 1.0 && before.worst_px > 20.0, "{before:?}");
    assert!(after.rms_px < 0.01 && after.worst_px < 0.05, "{after:?}");
    assert!((after.worst_mm / after.worst_px - PITCH_MM).abs() < 1e-12);
    assert_eq!(found.prescription.surfaces[0].thickness_mm, lens.surfaces[0].thickness_mm * found.scale);
    assert!(found.alike.is_empty() && found.part == 1.0);
}

/// A film that stands 0.4 mm too far, and, in a lens that is focused by its film, the focus distance of that place.
#[test]
fn a_displaced_film_is_found() {
    let (lens, settings) = (lens_of("double-gauss-f2-tronnier.lens"), LensSettings::default());
    let calibration = calibrated(&lens, 0.4);
    let start = task(&lens, &settings, &calibration);
    let found = fit(&LensToFit { adjusted: &[Adjusted::FilmDistance], ..start.clone() }).unwrap();
    let [before, after] = found.state;
    assert!((after.film_distance_mm - before.film_distance_mm - 0.4).abs() < 1e-4, "{after:?}");
    assert!(found.misfit[1].worst_px < 0.01, "{:?}", found.misfit);
    // Size and film do the same to the picture of a lens whose pupil hardly wanders.
    let both = fit(&LensToFit { adjusted: &[Adjusted::FocalLength, Adjusted::FilmDistance], ..start.clone() }).unwrap();
    assert_eq!(both.alike.len(), 1, "{:?}", both.alike);
    let twice = LensToFit { adjusted: &[Adjusted::Focus, Adjusted::FilmDistance], ..start.clone() };
    assert_eq!(fit(&twice).unwrap_err(), LensFitError::FocusIsFilm);
    assert_eq!(fit(&LensToFit { adjusted: &[], ..start }).unwrap_err(), LensFitError::Nothing);
}

/// A gap that is 0.25 mm wider, beside the focal length. The other gaps stay.
#[test]
fn a_wider_gap_is_found() {
    let (lens, settings) = (lens_of("nikkor-24-f1.8.lens"), LensSettings::default());
    let air = NextMedium::Medium(Medium::air());
    let moves = |i: usize| lens.moving.as_ref().is_some_and(|moving| moving.parts().contains(&Part::gap(i)));
    let is_wide = |i: &usize| lens.surfaces[*i].behind == air && lens.surfaces[*i].thickness_mm > 3.0 && !moves(*i);
    let surface = (0..lens.surfaces.len() - 1).find(is_wide).unwrap();
    let mut other = lens.clone();
    other.surfaces[surface].thickness_mm += 0.25;
    let calibration = calibrated(&other, 0.0);
    let gaps = Some(GapsToFit { tolerance: Tolerance::Millimetres(0.5), surfaces: Some(vec![surface]) });
    let found = fit(&LensToFit { gaps, ..task(&lens, &settings, &calibration) }).unwrap();
    let change = found.gaps[0].gap_mm[1] - found.gaps[0].gap_mm[0];
    // The calibration's formula leaves some hundredths of a pixel, of which the gap takes its part.
    assert!((change - 0.25).abs() < 0.02 && (found.scale - 1.0).abs() < 2e-4, "{change} {}", found.scale);
    assert!(
        found.misfit[1].rms_px < 0.02 && found.misfit[0].rms_px > 10.0 * found.misfit[1].rms_px,
        "{:?}",
        found.misfit
    );
    // Within a smaller tolerance it stops at its end.
    let gaps = Some(GapsToFit { tolerance: Tolerance::Millimetres(0.1), surfaces: Some(vec![surface]) });
    let held = fit(&LensToFit { gaps, ..task(&lens, &settings, &calibration) }).unwrap();
    assert!((held.gaps[0].gap_mm[1] - held.gaps[0].gap_mm[0] - 0.1).abs() < 1e-9, "{:?}", held.gaps);
}

#[test]
fn gaps_that_are_none_are_named() {
    let (lens, settings) = (lens_of("double-gauss-f2-tronnier.lens"), LensSettings::default());
    let calibration = calibrated(&lens, 0.0);
    let with = |tolerance, surfaces| {
        let gaps = Some(GapsToFit { tolerance, surfaces });
        fit(&LensToFit { gaps, ..task(&lens, &settings, &calibration) }).unwrap_err()
    };
    assert!(matches!(with(Tolerance::Part(0.1), Some(vec![0])), LensFitError::NoGap { surface: 0, .. }));
    assert_eq!(with(Tolerance::Part(1.5), None), LensFitError::Tolerance(1.5));
    assert_eq!(with(Tolerance::Millimetres(-1.0), None), LensFitError::Tolerance(-1.0));
}
