//! A lens scaled to another focal length: every length scales, no angle does (Wu et al. 2011, §4).

use crate::common::{ASPHERES, lens_names, prescription, repository, system};
use glam::DVec3;
use petzval_optics::focus::Focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::seidel::Seidel;
use petzval_optics::system::{FocalLength, LensSettings, System};
use petzval_optics::trace::Ray;
use petzval_optics::vignetting::Vignetting;

const WAVELENGTHS_NM: [f64; 4] = [400.0, line_nm::F, line_nm::D, 900.0];
/// Relative; sums of large and small lengths to this part of the largest.
const TOLERANCE: f64 = 1e-12;

/// All reference lenses, and those of this repository that are anamorphic or have aspheres.
fn prescriptions() -> Vec<(String, Prescription)> {
    let shipped = ["anamorphic-2x-double-gauss", "cellphone-5.6mm-f3.5", "schmidt-flat-field"];
    let read = |name: &str| {
        let path = repository("lenses").join(format!("{name}.lens"));
        (name.to_owned(), lens::read(&path, Catalogue::shipped()).unwrap())
    };
    let reference = lens_names().into_iter().chain(ASPHERES.map(str::to_owned));
    reference.map(|name| (name.clone(), prescription(&name))).chain(shipped.map(read)).collect()
}

/// The numbers of a lens at a wavelength: its lengths in mm, and those without a length. Infinite lengths are `None`.
fn described(system: &System, nm: f64, distance_mm: f64) -> (Vec<Option<f64>>, Vec<Option<f64>>) {
    let p = Paraxial::new(system, nm);
    let focus = Focus::at_distance(system, nm, distance_mm).unwrap();
    let sums = Seidel::new(system, nm, focus.object_plane_mm).unwrap();
    let mut lengths = vec![
        p.efl_mm,
        p.bfd_mm,
        p.ffd_mm,
        p.object_principal_plane_mm,
        p.image_principal_plane_mm,
        p.object_focal_plane_mm,
        p.image_focal_plane_mm,
        p.entrance_pupil.z_mm,
        p.entrance_pupil.diameter_mm,
        p.exit_pupil.z_mm,
        p.exit_pupil.diameter_mm,
        Some(p.stop_diameter_mm),
        Some(p.film_z_mm),
        p.petzval_radius_mm,
        Some(p.total_track_mm),
        focus.object_plane_mm,
        Some(focus.film_z_mm),
    ];
    lengths.extend(sums.by_surface.iter().flat_map(|s| [&s.seidel[..], &s.chromatic].concat()).map(Some));
    (lengths, vec![p.f_number, focus.magnification, focus.working_f_number, Some(sums.field_deg)])
}

fn assert_scaled(what: &str, plain: &[Option<f64>], scaled: &[Option<f64>], factor: f64, size: f64) {
    assert_eq!(plain.len(), scaled.len());
    for (i, (plain, scaled)) in plain.iter().zip(scaled).enumerate() {
        assert_eq!(plain.is_some(), scaled.is_some(), "{what}: number {i}");
        let (Some(plain), Some(scaled)) = (plain, scaled) else { continue };
        let error = (plain * factor - scaled).abs() / (factor * plain.abs().max(size));
        assert!(error < TOLERANCE, "{what}: number {i}: {plain} {scaled} ({error:e})");
    }
}

#[test]
fn lengths_scale_and_angles_do_not() {
    for (name, prescription) in prescriptions() {
        let published = System::new(&prescription, &LensSettings::default()).unwrap();
        let info = Paraxial::new(&published, line_nm::D);
        let efl = info.efl_mm.unwrap();
        let nearest = info.entrance_pupil.z_mm.unwrap() - info.ffd_mm.unwrap().min(0.0);
        let distance = nearest + 10.0 * efl;
        let size = published.surfaces().iter().map(|s| s.thickness_mm.abs()).sum::<f64>().max(efl);
        for (focal_length, factor) in [
            (FocalLength::Scale(0.37), 0.37),
            (FocalLength::Scale(1.0), 1.0),
            (FocalLength::Millimetres(135.0), 135.0 / efl),
        ] {
            let settings = LensSettings { focal_length, ..LensSettings::default() };
            let scaled = System::new(&prescription, &settings).unwrap();
            assert!((scaled.scale() / factor - 1.0).abs() < TOLERANCE, "{name}");
            for nm in WAVELENGTHS_NM {
                let what = format!("{name} times {factor} at {nm} nm");
                let (lengths, numbers) = described(&published, nm, distance);
                let (lengths2, numbers2) = described(&scaled, nm, distance * factor);
                assert_scaled(&what, &lengths, &lengths2, factor, size);
                assert_scaled(&what, &numbers, &numbers2, 1.0, 1.0);
                assert_rays_scale(&what, [&published, &scaled], nm, factor, size);
            }
        }
    }
}

/// Exact rays go the same way, `factor` times as far.
fn assert_rays_scale(what: &str, [plain, scaled]: [&System; 2], nm: f64, factor: f64, size: f64) {
    let semi = plain.surfaces()[0].semi_diameter_mm;
    for i in 0..20 {
        let at = |by: i32| f64::from(i * by % 19) / 9.5 - 1.0;
        let origin = DVec3::new(0.5 * semi * at(3), 0.5 * semi * at(7), -semi);
        let direction = DVec3::new(0.1 * at(11), 0.1 * at(13), 1.0).normalize();
        let trace = |system: &System, by: f64| {
            let mut hits = Vec::new();
            let ray = Ray { origin: origin * by, direction };
            (system.at_wavelength(nm).from_scene_recording(ray, &mut hits), hits)
        };
        let ((out, hits), (out2, hits2)) = (trace(plain, 1.0), trace(scaled, factor));
        assert_eq!((out.err(), hits.len()), (out2.err(), hits2.len()), "{what}: ray {i}");
        for (hit, hit2) in hits.iter().zip(&hits2) {
            assert!((*hit * factor - *hit2).length() < 1e-11 * factor * size, "{what}: ray {i}");
        }
        if let (Ok(out), Ok(out2)) = (out, out2) {
            assert!((out.direction - out2.direction).length() < 1e-11, "{what}: ray {i}");
        }
    }
}

#[test]
fn fields_do_not_scale() {
    for name in ["tessar-brendel", "laikin-fisheye-170", "cassegrain-f12"] {
        let plain = system(name);
        let settings = LensSettings { focal_length: FocalLength::Scale(3.0), ..LensSettings::default() };
        let scaled = System::new(&prescription(name), &settings).unwrap();
        let fields = |system: &System| {
            let fields = Vignetting::new(system, line_nm::D, &Focus::at_infinity(system, line_nm::D));
            assert_eq!(fields.axial_beam_cut_by, None);
            [fields.free_field_deg, fields.half_field_deg, fields.largest_field_deg].map(Option::unwrap)
        };
        for (a, b) in fields(&plain).into_iter().zip(fields(&scaled)) {
            assert!((a - b).abs() < 2e-4, "{name}: {a} {b}");
        }
    }
}
