//! Files of lenses and glasses, texts of coatings, aperture masks, and any rays through any lens.

use std::path::Path;
use std::sync::OnceLock;

use glam::DVec3;
use petzval_optics::coating::Coating;
use petzval_optics::diaphragm::{ApertureMask, Diaphragm};
use petzval_optics::formats::{self, agf, lens, rii, zmx};
use petzval_optics::glass::Catalogue;
use petzval_optics::lane::Real;
use petzval_optics::prescription::Prescription;
use petzval_optics::single_surface::SingleSurface;
use petzval_optics::surface::{Asphere, Conic, Shape, Toroid};
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};

use super::bytes::Bytes;
use super::one_line;
use super::systems::{self, Kinds};

/// A lens is read or refused in one line; a lens that is read can be set up, and comes back from its written file with the same rays.
pub fn lens(bytes: &[u8], name: &str) {
    match formats::parse_bytes(bytes, Path::new(name), Catalogue::shipped(), None) {
        Ok(reading) => comes_back(&reading.prescription),
        Err(error) => one_line(&error),
    }
}

/// A FlareSim file: one of another program that ends in `.lens`, which its first lines tell.
pub fn flaresim(bytes: &[u8]) {
    lens(&[b"surfaces:\n", bytes].concat(), "flare.lens");
}

/// Asserts that a lens comes back from each format in which all of it can be written: its surfaces to the last bit, and its rays.
fn comes_back(prescription: &Prescription) {
    let system = System::new(prescription, &LensSettings::default());
    for (write, name) in [(lens::write as fn(&_, &_) -> _, "x.lens"), (zmx::write, "x.zmx")] {
        let (text, lost): (String, Vec<String>) = write(prescription, Catalogue::shipped());
        let back = formats::parse_bytes(text.as_bytes(), Path::new(name), Catalogue::shipped(), None);
        if !lost.is_empty() {
            continue;
        }
        let back = back.unwrap_or_else(|error| panic!("{error}\n{text}")).prescription;
        assert_eq!(back.surfaces.len(), prescription.surfaces.len(), "{text}");
        for (a, b) in back.surfaces.iter().zip(&prescription.surfaces) {
            assert_eq!((a.shape, a.semi_diameter_mm), (b.shape, b.semi_diameter_mm), "{text}");
            assert_eq!((a.thickness_mm, a.obstruction_mm), (b.thickness_mm, b.obstruction_mm), "{text}");
        }
        let again = System::new(&back, &LensSettings::default());
        match (&system, &again) {
            (Ok(one), Ok(other)) => same_rays(one, other, prescription, &text),
            (one, other) => assert_eq!(one.is_ok(), other.is_ok(), "{text}"),
        }
    }
}

/// Asserts that rays go through two lenses alike: to the last bit, or where surfaces are tilted, whose angles go through degrees in a file, to
/// some roundings of the lens's size.
fn same_rays(one: &System, other: &System, prescription: &Prescription, text: &str) {
    let is_posed = prescription.surfaces.iter().any(|row| !row.pose.is_identity());
    let semi = one.surfaces()[0].semi_diameter_mm;
    for i in 0..5 {
        let height = semi * (0.2 * f64::from(i) - 0.35);
        let direction = DVec3::new(0.02 * f64::from(i), 0.05, 1.0).normalize();
        let ray = Ray { origin: DVec3::new(0.3 * height, height, 0.0) - direction * (2.0 * semi), direction };
        let (a, b) = (one.at_wavelength(550.0).from_scene(ray), other.at_wavelength(550.0).from_scene(ray));
        if !is_posed {
            assert_eq!(a, b, "{ray:?}\n{text}");
        } else if let (Ok(a), Ok(b)) = (a, b) {
            // 2^-30: what is amplified a million times on the way still tells a tilt of another sign.
            assert!((a.direction - b.direction).length() < 1e-9, "{a:?} {b:?}\n{text}");
        }
    }
}

/// A lens that is made, written in each format and read again.
pub fn convert(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let prescription = systems::prescription(&mut bytes, Kinds::WithGradients);
    if prescription.check().is_ok() {
        comes_back(&prescription);
    }
}

/// A glass catalogue is read or refused in one line; its indices are finite.
pub fn catalogue(bytes: &[u8]) {
    match agf::parse_bytes(bytes, "x.agf") {
        Ok((media, _)) => media.iter().for_each(|medium| assert!(medium.index(587.6).is_finite())),
        Err(error) => one_line(&error),
    }
}

/// A glass of refractiveindex.info is read or refused in one line; its index is finite.
pub fn glass_page(bytes: &[u8]) {
    match rii::parse_bytes(bytes, "x.yml", "X") {
        Ok(medium) => assert!(medium.index(587.6).is_finite()),
        Err(error) => one_line(&error),
    }
}

/// A coating's text is read or refused in one line; what it reflects and lets through are parts of the light; its name is read as itself.
pub fn coating(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Coating::parse(text) {
        Ok(coating) => {
            assert_eq!(Coating::parse(coating.name()).as_ref(), Ok(&coating), "{text:?}");
            for cosine in [1.0, 0.7, 0.1, 0.0] {
                for (from, to) in [(1.0, 1.5), (1.8, 1.0), (1.5, 1.5)] {
                    for nm in [380.0, 550.0, 780.0] {
                        let split = coating.split(from, to, nm, cosine);
                        for polarization in 0..2 {
                            let parts = [split.reflected[polarization], split.transmitted[polarization]];
                            let are_parts = parts.iter().all(|part| (0.0..=1.0 + 1e-9).contains(part));
                            let is_all = parts[0] + parts[1] <= 1.0 + 1e-9;
                            assert!(are_parts && is_all, "{text:?} {from} {to} {nm} {cosine}: {split:?}");
                        }
                    }
                }
            }
        }
        Err(error) => one_line(&error),
    }
}

/// An aperture mask is made or refused in one line; its samples are finite and open, its area is no more than the circle's.
pub fn mask(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let side = bytes.below(12);
    let is_of_floats = bytes.once_in(128);
    let count = if bytes.once_in(8) { bytes.below(200) } else { side * side };
    let values: Vec<f32> =
        (0..count).map(|_| if is_of_floats { bytes.any_f32() } else { f32::from(bytes.byte()) / 255.0 }).collect();
    match ApertureMask::new(side, &values) {
        Ok(mask) => {
            let radius = 3.0;
            let diaphragm = Diaphragm::masked(radius, std::sync::Arc::new(mask), 0.7);
            let area = diaphragm.area_mm2();
            // Cells on the rim are tried at points: of a picture this coarse the area may be more than the circle.
            assert!(area > 0.0 && area <= 4.0 * radius * radius, "{area}");
            for i in 0..20 {
                let [x, y] = diaphragm.sample([f64::from(i) / 20.0, f64::from(i * 7 % 20) / 20.0]);
                assert!(x.hypot(y) <= radius * (1.0 + 1e-9), "{x} {y}");
            }
        }
        Err(error) => one_line(&error),
    }
}

/// Lenses of each kind: of spheres, aspheres, mirrors, cylinders, gradients, and one whose groups move.
fn lenses() -> &'static [(Tracer, Tracer<f32>)] {
    static LENSES: OnceLock<Vec<(Tracer, Tracer<f32>)>> = OnceLock::new();
    LENSES.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
        let names = [
            "wide-angle-smith-f3.4",
            "phone-4.1-f1.8",
            "questar-3.5",
            "anamorphic-2x-double-gauss",
            "eye-liou-brennan",
            "zoom-nikon-57-143-f2.8",
            "laikin-fisheye-170",
        ];
        let tracer = |name: &str| {
            let path = folder.join(name).with_extension("lens");
            let path = if path.exists() { path } else { folder.join(format!("{name}.lens")) };
            let reading = formats::read(&path, Catalogue::shipped()).unwrap_or_else(|error| panic!("{error}"));
            let system = System::new(&reading.prescription, &LensSettings::default());
            let tracer = system.unwrap_or_else(|error| panic!("{name}: {error}")).at_wavelength(550.0);
            let single = tracer.cast();
            (tracer, single)
        };
        names.map(tracer).into()
    })
}

/// Rays of any numbers, as a list of rays may have them, through shipped lenses: an answer of finite numbers, or the reason why there is none.
pub fn rays(bytes: &[u8]) {
    fn of<R: Real>(tracer: &Tracer<R>, ray: Ray) {
        for from_film in [false, true] {
            let mut hits = Vec::new();
            let result = match from_film {
                true => tracer.from_film_recording(ray, &mut hits),
                false => tracer.from_scene_recording(ray, &mut hits),
            };
            assert!(hits.iter().all(|hit| hit.is_finite()), "{ray:?}: {hits:?}");
            if let Ok(out) = result {
                assert!(out.origin.is_finite() && out.direction.is_finite(), "{ray:?}: {out:?}");
            }
        }
    }
    let mut bytes = Bytes::new(bytes);
    let (tracer, single) = &lenses()[bytes.below(lenses().len())];
    while !bytes.is_empty() {
        let is_any = bytes.once_in(128);
        let mut number = || if is_any { bytes.any_f64() } else { 40.0 * bytes.part() };
        let origin = DVec3::new(number(), number(), number());
        let direction = DVec3::new(number(), number(), number());
        // As the reader of lists does: numbers are finite, as JSON has no others, and a direction has a length.
        let largest = direction.abs().max_element();
        if !(origin.is_finite() && direction.is_finite() && largest > 0.0) {
            continue;
        }
        let ray = Ray { origin, direction: (direction / largest).normalize() };
        of(tracer, ray);
        of(single, ray);
    }
}

/// Any ray at any surface, as cases for `petzval surface` may have them: all numbers of an answer are finite.
pub fn surface(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    while !bytes.is_empty() {
        let is_any = bytes.once_in(64);
        let mut number = || if is_any { bytes.any_f64() } else { bytes.part() };
        let mut finite = || Some(number()).filter(|x| x.is_finite()).unwrap_or(0.0);
        let base = Conic { curvature: finite(), conic: finite() };
        let terms: Vec<(u32, f64)> = (0..3).map(|i| (2 + 3 * i, finite())).collect();
        let profile = Asphere::new(base, &terms);
        let across = finite();
        let numbers: [f64; 10] = std::array::from_fn(|_| finite());
        let kind = bytes.byte();
        let surface = SingleSurface {
            shape: match kind % 3 {
                0 => Shape::Conic(base),
                1 => Shape::Asphere(profile),
                _ => Shape::Toroid(Toroid { profile, across }),
            },
            side: if kind & 4 == 0 { 1.0 } else { -1.0 },
            from: numbers[0].abs().max(0.1),
            to: numbers[1].abs().max(0.1),
            is_mirror: kind & 8 != 0,
            semi_diameter_mm: if kind & 16 == 0 { f64::INFINITY } else { numbers[2].abs() },
            obstruction_mm: numbers[3].abs(),
        };
        let origin = DVec3::new(numbers[4], numbers[5], numbers[6]);
        let direction = DVec3::new(numbers[7], numbers[8], numbers[9]);
        let largest = direction.abs().max_element();
        if largest.is_nan() || largest <= 0.0 {
            continue;
        }
        let direction = direction / largest;
        for outcome in [surface.trace::<f64>(origin, direction), surface.trace::<f32>(origin, direction)] {
            let is_finite = outcome.direction.is_none_or_finite()
                && outcome
                    .hit
                    .is_none_or(|hit| hit.t_mm.is_finite() && hit.point.is_finite() && hit.normal.is_finite());
            assert!(is_finite, "{surface:?} {origin:?} {direction:?}: {outcome:?}");
        }
    }
}

trait NoneOrFinite {
    fn is_none_or_finite(&self) -> bool;
}

impl<E> NoneOrFinite for Result<DVec3, E> {
    fn is_none_or_finite(&self) -> bool {
        self.as_ref().map_or(true, |direction| direction.is_finite())
    }
}
