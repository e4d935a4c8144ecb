//! Seidel and chromatic sums against exact rays when aperture and field become small.

use crate::common::{ASPHERES, lens_names, system};
use glam::DVec3;
use petzval_optics::focus::Focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::seidel::Seidel;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};

/// Exact rays of one lens, conjugate and scale of aperture and field, seen against the Gaussian image.
struct Bench<'a> {
    tracer: Tracer,
    info: &'a Paraxial,
    focus: &'a Focus,
    image_index: f64,
    /// Slope of the chief ray.
    slope: f64,
}

impl Bench<'_> {
    /// The vector by which the ray through (x, y) of the entrance pupil, in mm, misses the Gaussian image.
    fn miss(&self, x: f64, y: f64) -> DVec3 {
        let pupil_z = self.info.entrance_pupil.z_mm.unwrap();
        let at_pupil = DVec3::new(x, y, pupil_z);
        let (ray, ideal) = match self.focus.object_plane_mm {
            None => {
                let direction = DVec3::new(0.0, self.slope, 1.0).normalize();
                (Ray { origin: at_pupil, direction }, self.slope * self.info.efl_mm.unwrap() / self.image_index)
            }
            Some(object_z) => {
                let origin = DVec3::new(0.0, -(pupil_z - object_z) * self.slope, object_z);
                let direction = (at_pupil - origin).normalize();
                (Ray { origin, direction }, origin.y * self.focus.magnification.unwrap())
            }
        };
        let out = self.tracer.from_scene(ray).unwrap();
        let on_film = out.origin + out.direction * ((self.focus.film_z_mm - out.origin.z) / out.direction.z);
        on_film - DVec3::new(0.0, ideal, self.focus.film_z_mm)
    }

    /// The sums that exact rays at `scale` of the aperture and of the field have, were there no higher orders.
    fn sums(&self, scale: f64, axial: &Self) -> [f64; 5] {
        let radius = scale * self.info.entrance_pupil.diameter_mm.unwrap() / 2.0;
        let slope = -0.5 / self.focus.working_f_number.unwrap();
        // Times n'u' at full aperture, over the scale of a third order.
        let whole = slope / scale.powi(3);
        let chief = self.miss(0.0, 0.0).y * whole;
        let (above, below) = (self.miss(0.0, radius).y * whole, self.miss(0.0, -radius).y * whole);
        let sagittal = self.miss(radius, 0.0).x * whole;
        let spherical = 2.0 * axial.miss(0.0, radius).y * whole;
        let coma = (0.5 * (above + below) - chief) / 1.5;
        // 3 S_III + S_IV and S_III + S_IV.
        let meridional = (above - below) - spherical;
        let across = 2.0 * sagittal - spherical;
        let astigmatism = 0.5 * (meridional - across);
        [spherical, coma, astigmatism, across - astigmatism, 2.0 * chief]
    }
}

#[test]
fn small_apertures_and_fields_have_these_aberrations_at_any_distance() {
    let mut bad = Vec::new();
    for name in lens_names().into_iter().chain(ASPHERES.map(str::to_owned)) {
        // Odd powers of the sag are of second order: rays near the axis follow them.
        if name == "cellphone-radial-polynomial" {
            continue;
        }
        let system = system(&name);
        let info = Paraxial::new(&system, line_nm::D);
        let nearest = info.entrance_pupil.z_mm.unwrap() - info.ffd_mm.unwrap().min(0.0);
        for focal_lengths in [f64::INFINITY, 20.0, 3.0] {
            let distance = nearest + focal_lengths * info.efl_mm.unwrap();
            let focus = Focus::at_distance(&system, line_nm::D, distance).unwrap();
            let seidel = Seidel::new(&system, line_nm::D, focus.object_plane_mm).unwrap();
            let at = |scale: f64| {
                let tracer = system.at_wavelength(line_nm::D);
                let image_index = system.image_index(line_nm::D);
                let bench = |slope| Bench { tracer: tracer.clone(), info: &info, focus: &focus, image_index, slope };
                bench(scale * seidel.field_deg.to_radians().tan()).sums(scale, &bench(0.0))
            };
            // The next order goes with the square of the scale.
            let (near, far) = (at(0.01), at(0.02));
            let largest = seidel.total().seidel.iter().fold(0.0f64, |m, s| m.max(s.abs()));
            for i in 0..5 {
                let (found, sum) = ((4.0 * near[i] - far[i]) / 3.0, seidel.total().seidel[i]);
                let error = (found - sum).abs() / largest;
                if error > 1e-3 || error.is_nan() {
                    bad.push(format!("{name} at {distance}: S{} {found} {sum} ({error:e})", i + 1));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{} values:\n{}", bad.len(), bad.join("\n"));
}

/// A doublet of little dispersion, where colour is of first order: its index at F less that at C is 1e-5.
fn weakly_dispersing() -> System {
    let text = "#radius thickness glass diameter conic isstop
        0 4 air 12 0 1\n 60 6 1.52/52000 30 0 0\n -45 2 1.7/35000 30 0 0\n -140 80 air 30 0 0";
    System::new(&lens::parse(text, "doublet", Catalogue::shipped()).unwrap(), &LensSettings::default()).unwrap()
}

#[test]
fn colours_part_by_the_chromatic_sums() {
    let system = weakly_dispersing();
    for distance in [f64::INFINITY, 500.0] {
        let focus = |nm| Focus::at_distance(&system, nm, distance).unwrap();
        let d = focus(line_nm::D);
        let seidel = Seidel::new(&system, line_nm::D, d.object_plane_mm).unwrap();
        let [axial, lateral] = seidel.total().chromatic;
        let slope = -0.5 / d.working_f_number.unwrap();
        let longitudinal = focus(line_nm::F).film_z_mm - focus(line_nm::C).film_z_mm;
        assert!((longitudinal + axial / (slope * slope)).abs() < 1e-3 * longitudinal.abs(), "{longitudinal}");
        // The chief ray, bent a little less than it is at the full field.
        let height = |nm: f64| {
            let pupil = DVec3::ZERO;
            let along = DVec3::new(0.0, 1e-4, 1.0).normalize();
            let out = system.at_wavelength(nm).from_scene(Ray { origin: pupil, direction: along }).unwrap();
            (out.origin + out.direction * ((d.film_z_mm - out.origin.z) / out.direction.z)).y
        };
        let transverse = (height(line_nm::F) - height(line_nm::C)) / 1e-4 * seidel.field_deg.to_radians().tan();
        assert!((transverse - lateral / slope).abs() < 2e-3 * transverse.abs(), "{transverse} {}", lateral / slope);
    }
}

#[test]
fn a_pupil_at_infinity_has_no_sums() {
    // The stop in the rear focal plane of what stands before it.
    let text = "#radius thickness glass diameter conic isstop\n 50 0 1.5 30 0 0\n 0 100 air 30 0 0\n 0 20 air 5 0 1";
    let prescription = lens::parse(text, "telecentric", Catalogue::shipped()).unwrap();
    let system = System::new(&prescription, &LensSettings::default()).unwrap();
    assert_eq!(Paraxial::new(&system, line_nm::D).entrance_pupil.z_mm, None);
    assert_eq!(Seidel::new(&system, line_nm::D, None), None);
}

#[test]
fn sums_follow_the_opening_and_the_field() {
    let prescription = crate::common::prescription("tessar-brendel");
    let at = |f_number: Option<f64>, field: f64| {
        let settings = LensSettings { f_number, ..LensSettings::default() };
        let system = System::new(&prescription, &settings).unwrap();
        (system.f_number(), Seidel::at_field(&system, line_nm::D, None, field).unwrap().total())
    };
    let (open, wide) = at(None, 20.0);
    let (_, small) = at(Some(2.0 * open), 20.0);
    let (_, narrow) = at(None, 10.0);
    let field = 10f64.to_radians().tan() / 20f64.to_radians().tan();
    for i in 0..5 {
        let closed = 0.5f64.powi([4, 3, 2, 2, 1][i]);
        let nearer = field.powi([0, 1, 2, 2, 3][i]);
        assert!((small.seidel[i] / wide.seidel[i] - closed).abs() < 1e-12, "S{}", i + 1);
        assert!((narrow.seidel[i] / wide.seidel[i] - nearer).abs() < 1e-12, "S{}", i + 1);
    }
    assert!((small.chromatic[0] / wide.chromatic[0] - 0.25).abs() < 1e-12);
    assert!((small.chromatic[1] / wide.chromatic[1] - 0.5).abs() < 1e-12);
}
