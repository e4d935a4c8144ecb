//! The fields of a lens against counts of rays: many, blindly, through the lens as it is and through the same lens with
//! no rim but the stop's.

use crate::common::prescription;
use glam::DVec3;
use petzval_optics::focus::Focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};
use petzval_optics::vignetting::Vignetting;

/// Rays along one side of the beam's bounds.
const SIDE: i32 = 250;
/// Cells along the stop's diameter in which its area is counted.
const CELLS: f64 = 80.0;
/// Factor of the widened rims, which stop nothing: a larger one lets rays find other ways to the stop than those of the
/// beam.
const RIMS: f64 = 1.5;
/// Rays across and along the plane in which the beam is looked for: far out it is wide and thin.
const COARSE: [i32; 2] = [31, 4001];

struct Counter {
    real: Tracer,
    /// No rim but the stop's.
    free: Tracer,
    stop: usize,
    stop_radius: f64,
    size: f64,
    pupil_z: f64,
    object_z: Option<f64>,
}

/// Numbers of rays that came through.
#[derive(Default)]
struct Count {
    /// Rays that pass the stop alone.
    beam: usize,
    /// Rays of the beam that pass the whole lens.
    passed: usize,
    /// Parts of the stop's area that are filled.
    filled: usize,
}

impl Counter {
    fn new(prescription: &Prescription, f_number: Option<f64>, distance_mm: f64) -> Self {
        let settings = LensSettings { f_number, ..LensSettings::default() };
        let system = System::new(prescription, &settings).unwrap();
        let mut open = prescription.clone();
        for (i, row) in open.surfaces.iter_mut().enumerate().filter(|(i, _)| *i != prescription.stop) {
            assert_eq!(row.obstruction_mm, 0.0, "surface {i}");
            row.semi_diameter_mm = row.shape.reach_mm().min(RIMS * row.semi_diameter_mm);
        }
        let free = System::new(&open, &settings).unwrap();
        let pupil_z = Paraxial::new(&system, line_nm::D).entrance_pupil.z_mm.unwrap();
        Self {
            real: system.at_wavelength(line_nm::D),
            free: free.at_wavelength(line_nm::D),
            stop: system.stop(),
            stop_radius: system.stop_semi_diameter_mm(),
            size: RIMS * system.surfaces()[0].semi_diameter_mm,
            pupil_z,
            object_z: distance_mm.is_finite().then_some(pupil_z - distance_mm),
        }
    }

    /// The ray of the field that crosses the plane through the first vertex and at right angles to it at (x, y).
    fn ray(&self, degrees: f64, x: f64, y: f64) -> Ray {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let target = DVec3::new(x, y * cos, -y * sin);
        match self.object_z {
            None => Ray { origin: target, direction: DVec3::new(0.0, sin, cos) },
            Some(z) => {
                let origin = DVec3::new(0.0, -(self.pupil_z - z) * sin / cos, z);
                Ray { origin, direction: (target - origin).normalize() }
            }
        }
    }

    /// Counts the rays of a grid over the bounds of the beam; half of it, the lens being symmetric.
    fn count(&self, degrees: f64) -> Count {
        // The bounds, from coarse to fine.
        let (mut low, mut high) = ([0.0, -self.size], [self.size; 2]);
        for sides in [COARSE, [101; 2], [101; 2]] {
            let step = [0, 1].map(|i| (high[i] - low[i]) / f64::from(sides[i] - 1));
            let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            for place in 0..sides[0] * sides[1] {
                let at = [place % sides[0], place / sides[0]].map(f64::from);
                let at = [0, 1].map(|i| low[i] + step[i] * at[i]);
                if self.free.from_scene(self.ray(degrees, at[0], at[1])).is_ok() {
                    for i in 0..2 {
                        (least[i], most[i]) = (least[i].min(at[i]), most[i].max(at[i]));
                    }
                }
            }
            if least[0] > most[0] {
                return Count::default();
            }
            (low, high) = ([0, 1].map(|i| least[i] - step[i]), [0, 1].map(|i| most[i] + step[i]));
        }
        let mut count = Count::default();
        let mut cells = std::collections::HashSet::new();
        let mut hits = Vec::new();
        for place in 0..SIDE * SIDE {
            let at = [place % SIDE, place / SIDE].map(|i| (f64::from(i) + 0.5) / f64::from(SIDE));
            let at = [0, 1].map(|i| low[i] + (high[i] - low[i]) * at[i]);
            let ray = self.ray(degrees, at[0], at[1]);
            if self.free.from_scene(ray).is_err() {
                continue;
            }
            count.beam += 1;
            hits.clear();
            if self.real.from_scene_recording(ray, &mut hits).is_ok() {
                count.passed += 1;
                let at_stop = hits[self.stop] / self.stop_radius * (CELLS / 2.0);
                cells.insert([at_stop.x.abs().floor() as i32, at_stop.y.floor() as i32]);
            }
        }
        count.filled = cells.len();
        count
    }
}

fn fields(prescription: &Prescription, f_number: Option<f64>, distance_mm: f64) -> Vignetting {
    let settings = LensSettings { f_number, ..LensSettings::default() };
    let system = System::new(prescription, &settings).unwrap();
    let focus = Focus::at_distance(&system, line_nm::D, distance_mm).unwrap();
    Vignetting::new(&system, line_nm::D, &focus)
}

fn check(what: &str, prescription: &Prescription, f_number: Option<f64>, distance_mm: f64) {
    let fields = fields(prescription, f_number, distance_mm);
    let counter = Counter::new(prescription, f_number, distance_mm);
    let free = fields.free_field_deg.unwrap();
    assert_eq!(fields.axial_beam_cut_by, None, "{what}");
    let inside = counter.count(0.995 * free);
    assert!(inside.beam > 2500 && inside.passed == inside.beam, "{what}: {} of {}", inside.passed, inside.beam);
    let axial = counter.count(0.0).filled as f64;
    let outside = counter.count(1.02 * free + 0.02);
    // Some rays are cut, or miss a surface, so that the stop is not filled.
    let is_cut = outside.passed < outside.beam || (outside.filled as f64) < 0.99 * axial;
    assert!(is_cut, "{what}: nothing is cut at {}", 1.02 * free + 0.02);

    let half = counter.count(fields.half_field_deg.unwrap()).filled as f64;
    // Cells on the edge of the beam count as full, and the areas that were searched are good to 2 %.
    assert!((half / axial - 0.5).abs() < 0.03, "{what}: {}", half / axial);

    let largest = fields.largest_field_deg.unwrap();
    assert!(counter.count(0.99 * largest).passed > 0, "{what}: nothing comes at {}", 0.99 * largest);
    assert_eq!(counter.count(largest + 0.002).passed, 0, "{what}: beyond {largest}");
}

#[test]
fn fields_are_those_of_counted_rays() {
    for name in ["double-gauss-f2-available", "tessar-brendel", "cassegrain-f12", "schmidt-flat-field"] {
        check(name, &prescription(name), None, f64::INFINITY);
    }
}

/// Two strong menisci before a simple objective: it sees 213 degrees, badly.
const WIDEST_FISHEYE: &str = "#radius thickness glass diameter conic isstop
    84 4 1.8 76 0 0\n 29.6 19.2 air 58.3 0 0\n -174 2.5 1.8 57 0 0\n 17.8 18.3 air 34.5 0 0\n 42.7 8 1.75 20 0 0
    -42.7 3 air 20 0 0\n 0 3 air 5 0 1\n 60 6 1.7 14 0 0\n -25 30 air 14 0 0";

#[test]
fn fields_behind_the_first_vertex_too() {
    let fisheye = lens::parse(WIDEST_FISHEYE, "fisheye", Catalogue::shipped()).unwrap();
    let fields = fields(&fisheye, None, f64::INFINITY);
    assert!(fields.free_field_deg > Some(100.0) && fields.largest_field_deg > Some(108.0), "{fields:?}");
    check("fisheye", &fisheye, None, f64::INFINITY);
    // A field of less.
    if petzval_testkit::is_thorough() {
        check("laikin-fisheye-170", &prescription("laikin-fisheye-170"), Some(4.0), f64::INFINITY);
        check("eye-gullstrand-exact", &prescription("eye-gullstrand-exact"), None, f64::INFINITY);
    }
}

#[test]
fn fields_of_a_near_plane() {
    check("tessar-brendel", &prescription("tessar-brendel"), None, 400.0);
    check("biogon-21-f4.5", &prescription("biogon-21-f4.5"), Some(11.0), 120.0);
}

#[test]
fn a_rim_that_cuts_the_axial_beam_is_named() {
    for (name, surface) in [("sonnar-50-f2", 4), ("kreitzer-tele", 3), ("double-gauss-f2-tronnier", 2)] {
        let prescription = prescription(name);
        let wide_open = fields(&prescription, None, f64::INFINITY);
        assert_eq!((wide_open.axial_beam_cut_by, wide_open.free_field_deg), (Some(surface), Some(0.0)), "{name}");
        let count = Counter::new(&prescription, None, f64::INFINITY).count(0.0);
        assert!(count.passed < count.beam, "{name}");
        // Half and largest are those of what comes through on the axis.
        assert!(wide_open.half_field_deg > Some(1.0) && wide_open.half_field_deg < wide_open.largest_field_deg);
        check(name, &prescription, Some(8.0), f64::INFINITY);
    }
}

#[test]
fn stopping_down_frees_the_field() {
    let prescription = prescription("tessar-brendel");
    let free = |f_number| fields(&prescription, Some(f_number), f64::INFINITY).free_field_deg.unwrap();
    let largest = |f_number| fields(&prescription, Some(f_number), f64::INFINITY).largest_field_deg.unwrap();
    for (wide, small) in [(4.5, 8.0), (8.0, 16.0)] {
        assert!(free(small) > free(wide) && largest(small) < largest(wide) + 1e-3);
    }
}

fn lens(rows: &str) -> System {
    let text = format!("#radius thickness glass diameter conic isstop decenter_y\n{rows}");
    System::new(&lens::parse(&text, "test", Catalogue::shipped()).unwrap(), &LensSettings::default()).unwrap()
}

#[test]
fn two_holes_in_a_row_have_the_fields_of_geometry() {
    // A stop of 10 mm, 100 mm before a hole of 20 mm, in air.
    let holes = lens("0 100 air 10 0 1 0\n 0 10 air 20 0 0 0");
    let focus = Focus::at_infinity(&holes, 550.0);
    let fields = Vignetting::new(&holes, 550.0, &focus);
    let at = |shift: f64| (shift / 100.0f64).atan().to_degrees();
    assert!((fields.free_field_deg.unwrap() - at(5.0)).abs() < 1e-6);
    // Circles of radii 5 and 10 share half of the small one where their centres are 9.4 mm apart.
    let shared = |d: f64| {
        let (r, s): (f64, f64) = (5.0, 10.0);
        let (a, b) = ((d * d + r * r - s * s) / (2.0 * d), (d * d - r * r + s * s) / (2.0 * d));
        r * r * (a / r).acos() + s * s * (b / s).acos() - a * (r * r - a * a).sqrt() - b * (s * s - b * b).sqrt()
    };
    let half = 100.0 * fields.half_field_deg.unwrap().to_radians().tan();
    assert!((shared(half) / (25.0 * std::f64::consts::PI) - 0.5).abs() < 5e-3, "{half}");
    assert!((fields.largest_field_deg.unwrap() - at(15.0)).abs() < 1e-3);
}

/// A mirror that is its own stop keeps its beam until light comes along its rim: there its slope is y / R.
#[test]
fn a_mirror_is_free_until_light_grazes_its_rim() {
    for (radius, diameter) in [(-2000.0f64, 200.0), (-500.0, 200.0)] {
        let system = lens(&format!("{radius} {} mirror {diameter} -1 1 0", 0.5 * radius));
        let focus = Focus::at_infinity(&system, line_nm::D);
        let free = Vignetting::new(&system, line_nm::D, &focus).free_field_deg.unwrap();
        let expected = 90.0 - (0.5 * diameter / -radius).atan().to_degrees();
        // Rays are aimed at the rim to a part in 1e9; where they graze it that is the root of it in angle.
        assert!((free - expected).abs() < 2e-3, "{free} rather than {expected}");
    }
}

#[test]
fn a_lens_without_symmetry_has_the_narrowest_of_its_fields() {
    // The second hole 2 mm higher: less room below.
    let holes = lens("0 100 air 10 0 1 0\n 0 10 air 20 0 0 2");
    let fields = Vignetting::new(&holes, 550.0, &Focus::at_infinity(&holes, 550.0));
    let at = |shift: f64| (shift / 100.0f64).atan().to_degrees();
    assert!((fields.free_field_deg.unwrap() - at(3.0)).abs() < 1e-6);
    assert!((fields.largest_field_deg.unwrap() - at(13.0)).abs() < 1e-3);
}

#[test]
fn what_has_no_such_field_has_none() {
    // A lone stop passes all that comes from before it.
    let hole = lens("0 10 air 10 0 1 0");
    let fields = Vignetting::new(&hole, 550.0, &Focus::at_infinity(&hole, 550.0));
    assert_eq!(fields.axial_beam_cut_by, None);
    assert!(fields.largest_field_deg.is_some_and(|deg| deg > 89.9 && deg < 90.01), "{fields:?}");
    let telecentric = lens("50 0 1.5 30 0 0 0\n 0 100 air 30 0 0 0\n 0 20 air 5 0 1 0");
    let fields = Vignetting::new(&telecentric, 550.0, &Focus::at_infinity(&telecentric, 550.0));
    assert_eq!(fields, Vignetting::default());
}
