//! The choice holds for rays that it was not made on, for every lens; and double precision is kept where it is needed.

use super::*;
use crate::camera::tests::with_lens;
use crate::camera::{Camera, CameraDescription};
use crate::sampler::PathSampler;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::surface::Section;
use petzval_optics::system::{FocalLength, LensSettings, System};
use std::path::{Path, PathBuf};

/// Every lens of the cabinet and of the reference tables.
fn lenses() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = |name: &str| petzval_testkit::lenses::shipped(root.join(name));
    let mut all = folder("lenses");
    // Most of the reference tables' lenses are in both.
    let names: Vec<_> = all.iter().map(|path| path.file_name().map(ToOwned::to_owned)).collect();
    all.extend(
        folder("tests/reference/lenses")
            .into_iter()
            .filter(|path| !names.contains(&path.file_name().map(ToOwned::to_owned))),
    );
    all
}

/// Focused at infinity, before a film of 16:9 that holds the lens's field.
pub(in crate::camera) fn camera(path: &Path, size: [u32; 2], more: impl Fn(&mut CameraDescription)) -> Camera {
    let prescription = lens::read(path, Catalogue::shipped()).unwrap();
    let system = System::new(&prescription, &LensSettings::default()).unwrap();
    let efl = Paraxial::in_section(&system, Section::Y, line_nm::D).efl_mm.unwrap().abs();
    let field = system.half_field_deg().unwrap_or(20.0).to_radians();
    let half_diagonal = efl * if field > 1.0 { field } else { field.tan() };
    let half_diagonal = system.film_radius_mm().map_or(half_diagonal, |radius| half_diagonal.min(0.8 * radius.abs()));
    let [width, height] = [16.0, 9.0].map(|side: f64| 2.0 * half_diagonal * side / 16.0f64.hypot(9.0));
    let mut d = CameraDescription { lens_path: path.into(), ..with_lens("", width, height, 0.0) }
        .with(|c| c.focus.distance = None);
    more(&mut d);
    Camera::new(&d, size[0], size[1]).unwrap()
}

/// Rays that have nothing in common with those of [`fan`].
fn random(i: u32) -> Request {
    let mut sampler = PathSampler::new(i, 17, 0, 5);
    let ([x, y, u, v], [u_wavelength, ..]) = (sampler.next_4d(), sampler.next_4d());
    Request { place: Vec2::new(x - 0.5, y - 0.5), u_lens: [u, v], u_wavelength, ..Request::default() }
}

/// The largest error of so many times [`RAYS`] other rays.
fn worst_of_others(lens: &RealLens, size: [u32; 2], times: u32) -> f64 {
    let (single, double) = (lens.outward(), lens.outward());
    (0..times).map(|k| worst_px(lens, &single, &double, size, |i| random(i + k * RAYS))).fold(0.0, f64::max)
}

/// Four times as many rays as were tried stay within the error of those, whichever numbers were then chosen.
#[test]
fn the_error_holds_for_other_rays() {
    let (mut singles, mut all) = (0, 0);
    // Each lens in one of the two sizes, or in both.
    for (number, path) in lenses().into_iter().enumerate() {
        let sizes = [[1920, 1080], [7680, 4320]];
        let sizes = if petzval_testkit::is_thorough() { &sizes[..] } else { &sizes[number % 2..][..1] };
        for &size in sizes {
            let camera = camera(&path, size, |_| {});
            let lens = camera.traced_lens().unwrap();
            let (chosen, others) = (lens.precision(), worst_of_others(lens, size, 4));
            let what =
                format!("{} {size:?}: {}, {:.5} {others:.5}", lens.info().lens_name, chosen.name(), chosen.error_px);
            println!("{what}");
            assert_eq!(chosen.is_single, chosen.error_px <= TOLERANCE_PX, "{what}");
            assert!(others < chosen.error_px && chosen.error_px < 1.0, "{what}");
            singles += usize::from(chosen.is_single);
            all += 1;
        }
    }
    // Most cameras, and nearly all in full HD.
    assert!(all > 50 && 2 * singles > all, "{singles} of {all}");
}

/// The pixels of a telescope are small against the roundings of its rays; so are those of a long lens in 8K.
#[test]
fn double_precision_stays_where_it_is_needed() {
    let shipped = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses").join(format!("{name}.lens"));
    for (name, size) in [("hubble-rc", [1920, 1080]), ("pbrt-telephoto-250mm", [7680, 4320])] {
        let choose = |asked| {
            let camera = camera(&shipped(name), size, |d| d.precision = asked);
            *camera.traced_lens().unwrap().precision()
        };
        let [auto, single, double] = [Precision::Auto, Precision::Single, Precision::Double].map(choose);
        assert!(!auto.is_single && single.is_single && !double.is_single, "{name}");
        // Told in any case.
        assert!(auto.error_px > TOLERANCE_PX && auto.error_px == single.error_px && auto.error_px == double.error_px);
    }
}

/// The squares of the lens's lengths overflow single precision.
#[test]
fn a_lens_of_a_thousand_light_years_has_double_precision() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses/tessar-brendel.lens");
    let camera = camera(&shipped, [1920, 1080], |d| {
        d.lens.focal_length = FocalLength::Scale(1e20);
        (d.film.width_mm, d.film.height_mm) = (1e20 * d.film.width_mm, 1e20 * d.film.height_mm);
    });
    let chosen = camera.traced_lens().unwrap().precision();
    assert!(!chosen.is_single && chosen.error_px == f64::INFINITY, "{}", chosen.error_px);
}

/// The measure finds rays that go elsewhere, and rays that are lost.
#[test]
fn another_lens_is_told_apart() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses/tessar-brendel.lens");
    let size = [1920, 1080];
    let camera_at = |focus| camera(&shipped, size, |d| d.focus.distance = focus);
    let (far, near) = (camera_at(None), camera_at(Some(1.0)));
    let (far, near) = (far.traced_lens().unwrap(), near.traced_lens().unwrap());
    // The rays of another focus are those of other film points.
    assert!(
        worst_px(far, &near.outward(), &far.outward(), size, |i| fan(&Evenly::default(), i)) > 100.0 * TOLERANCE_PX
    );
    // Through a smaller opening go fewer.
    let stopped = camera(&shipped, size, |d| d.lens.f_number = Some(16.0));
    let stopped = stopped.traced_lens().unwrap();
    assert_eq!(worst_px(far, &stopped.outward(), &far.outward(), size, |i| fan(&Evenly::default(), i)), f64::INFINITY);
}
