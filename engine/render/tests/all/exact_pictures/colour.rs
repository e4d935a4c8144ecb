//! Places of points in the picture, wavelength by wavelength: image heights of the reference data, and the fringes of
//! colour that hero makes of a point off the axis.

use super::exact::Exact;
use super::studio::{Exposure, Lamp, in_three, lamps, lens, shoot};
use glam::{DMat2, DVec2, DVec3};
use petzval_optics::glass::Catalogue;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::{LensSettings, System};
use petzval_render::camera::lens::real_lens::precision::Precision;
use petzval_render::camera::{Camera, CameraDescription, lens_info};
use petzval_render::pipeline::Pipeline;
use serde_json::Value;
use std::path::Path;

/// The pixel that errors are counted in: a film of 36 mm in 1920, for a lens of 50 mm.
const PIXEL_PER_FOCAL_LENGTH: f64 = 36.0 / 1920.0 / 50.0;

/// Rays about the one of the reference data, of some 4000 that fill the pupil.
const NEAREST: usize = 60;

fn reference(lens: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../tests/reference/rays/{lens}.json"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn vector(value: &Value) -> DVec3 {
    let [x, y, z] = [0, 1, 2].map(|i| value[i].as_f64().unwrap());
    DVec3::new(x, y, z)
}

/// A ray's slopes dx/dz and dy/dz, and its point in the plane z = 0.
fn slope_and_place(origin: DVec3, direction: DVec3) -> [DVec2; 2] {
    let slope = direction.truncate() / direction.z;
    [slope, origin.truncate() - slope * origin.z]
}

/// The slope of the pencil's ray through a place: the pencil is so thin that they change evenly over it.
fn slope_at(pencil: &[[DVec2; 2]], place: DVec2) -> DVec2 {
    let n = pencil.len() as f64;
    let [slope, middle] = [0, 1].map(|i| pencil.iter().map(|ray| ray[i]).sum::<DVec2>() / n);
    let (mut places, mut both) = (DMat2::ZERO, DMat2::ZERO);
    for [s, p] in pencil {
        let away = *p - middle;
        places += DMat2::from_cols(away * away.x, away * away.y);
        both += DMat2::from_cols((*s - slope) * away.x, (*s - slope) * away.y);
    }
    slope + both * places.inverse() * (place - middle)
}

/// The film point that a chief ray of the reference data hits sees along that ray, at F, d and C alike: the camera has the lens's
/// colour errors to a fiftieth of a pixel.
#[test]
#[expect(clippy::too_many_lines, reason = "a picture, and all that is read from it")]
fn image_heights_are_those_of_the_reference() {
    let lenses = [
        ("wide-angle-smith-f3.4", "seed-wide-angle"),
        ("double-gauss-f2-tronnier", "double-gauss-f2-tronnier"),
        ("tessar-brendel", "tessar-brendel"),
        ("pbrt-telephoto-250mm", "pbrt-telephoto-250mm"),
        ("laikin-fisheye-170", "laikin-fisheye-170"),
        ("biogon-21-f4.5", "biogon-21-f4.5"),
    ];
    let (mut seen, mut largest, mut largest_fringe) = (0, 0.0f64, 0.0f64);
    for (name, table) in lenses {
        let table = reference(table);
        let rays = table["rays"].as_array().unwrap();
        let is_chief = |r: &&Value| {
            r["pu"].as_array().is_some_and(|pu| pu.iter().all(|p| p.as_f64() == Some(0.0))) && r["s"] == "ok"
        };
        let mut heights = Vec::new();
        for line in ["F", "d", "C"] {
            let chiefs: Vec<&Value> =
                rays.iter().filter(is_chief).filter(|r| r["w"] == line && r["f"].is_array()).collect();
            assert!(chiefs.len() >= 3, "{name} {line}");
            let on_film: Vec<DVec3> = chiefs.iter().map(|r| vector(&r["f"])).collect();
            let last_vertex_z = vector(chiefs[0]["h"].as_array().unwrap().last().unwrap()).z;
            let widest = on_film.iter().fold(1.0f64, |m, f| m.max(f.truncate().length()));
            let side = 2.2 * widest;
            let d = CameraDescription {
                wavelength_nm: Some(1000.0 * table["wavelength_um"][line].as_str().unwrap().parse::<f64>().unwrap()),
                // Angles are compared more finely than a picture of a hundred pixels needs.
                precision: Precision::Double,
                ..lens(name)
            }
            .with(|c| {
                c.focus.film_distance_mm = Some(on_film[0].z - last_vertex_z);
                c.film.width_mm = side;
                c.film.height_mm = side;
                c.lens.f_number = Some(8.0);
            });
            let camera = Camera::new(&d, 100, 100).unwrap();
            let info = lens_info(&d, 100, 100).unwrap();
            let prescription = petzval_optics::formats::lens::read(&d.lens_path, Catalogue::shipped()).unwrap();
            let system = System::new(&prescription, &LensSettings::default()).unwrap();
            let pupil_z_mm = Paraxial::new(&system, d.wavelength_nm.unwrap()).entrance_pupil.z_mm.unwrap();
            for (ray, film) in chiefs.iter().zip(&on_film) {
                let p = (-film.truncate() / side).as_vec2();
                let mut found: Vec<[DVec2; 2]> = (0..4096)
                    .map(|i| sobol_burley::sample_4d(i, 0, 7))
                    .filter_map(|u| camera.sample(p, [u[0], u[1]], 0.5))
                    .map(|r| slope_and_place(r.ray.origin.as_dvec3(), r.ray.direction.as_dvec3()))
                    .collect();
                assert!(found.len() > 3000, "{name} {line}: {} rays", found.len());
                let mut start = vector(&ray["o"]) - DVec3::new(0.0, 0.0, pupil_z_mm);
                start /= d.scale_mm_per_unit;
                let [slope, place] = slope_and_place(start, vector(&ray["d"]));
                let away_from = |ray: &[DVec2; 2]| (ray[1] - place).length();
                found.sort_by(|a, b| away_from(a).total_cmp(&away_from(b)));
                found.truncate(NEAREST);
                let tan = slope.length();
                // A slope's step at the field tan θ is that much of the angle, or more.
                let away = (slope_at(&found, place) - slope).length() / (1.0 + tan * tan);
                assert!(away < 0.02 * PIXEL_PER_FOCAL_LENGTH, "{name} {line} {}: {away}", ray["th"]);
                largest = largest.max(away / PIXEL_PER_FOCAL_LENGTH);
                seen += 1;
            }
            heights.push((on_film, info.efl_mm.unwrap()));
        }
        for (f, c) in heights[0].0.iter().zip(&heights[2].0) {
            largest_fringe =
                largest_fringe.max((*f - *c).truncate().length() / (PIXEL_PER_FOCAL_LENGTH * heights[1].1));
        }
    }
    println!("{seen} chief rays within {largest:.4} pixels, F to C up to {largest_fringe:.1} pixels apart");
    assert!(seen > 60 && largest_fringe > 2.0, "{seen} {largest_fringe}");
}

/// Red, green and blue of a point lie as far apart in hero's picture as exact rays put them, which is several pixels
/// here.
#[test]
fn fringes_of_colour_are_as_wide_as_by_exact_rays() {
    const SIDE: u32 = 16;
    const SEEDS: u32 = 6;
    for (name, x, y) in [("tessar-brendel", 0.35, 0.2), ("biogon-21-f4.5", -0.4, 0.6), ("eye-navarro", 0.2, -0.3)] {
        let far = 100.0;
        let d = in_three(&lens(name)).with(|c| c.lens.f_number = Some(16.0));
        let wide = d.with(|c| {
            c.film.width_mm = 10.0;
            c.film.height_mm = 10.0;
        });
        let point = Lamp { at: far * DVec3::new(x, y, -1.0), half_side: 1e-4 };
        let exact = Exact::new(&wide, [1, 1]);
        let first = exact.picture_of(&point, 30_000);
        let middle = exact.on_film(first.centroids[1]);
        // Such pixels that the colours are two and a half apart.
        let apart = |i: usize, j: usize| (first.centroids[i] - first.centroids[j]).length() * 10.0;
        let fringe_mm = apart(0, 1).max(apart(1, 2)).max(apart(0, 2));
        let pixel_mm = fringe_mm / 2.5;
        let film_mm = pixel_mm * f64::from(SIDE);
        let d = wide.with(|c| {
            c.film.width_mm = film_mm;
            c.film.height_mm = film_mm;
            c.film.shift_mm = [-middle.x, -middle.y];
        });
        let half_side = pixel_mm / middle.length() * x.hypot(y) * far;
        let lamp = Lamp { half_side, ..point };
        let truth = Exact::new(&d, [SIDE; 2]).picture_of(&lamp, 200_000);
        let centroids = |picture: &[[f64; 3]]| {
            [0, 1, 2].map(|c| {
                let (mut sum, mut at) = (0.0, DVec2::ZERO);
                for (i, pixel) in picture.iter().enumerate() {
                    let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
                    sum += pixel[c];
                    at += pixel[c] * (DVec2::new(f64::from(x), f64::from(y)) + 0.5);
                }
                at / sum
            })
        };
        let expected = centroids(&truth.pixels);
        let stage = lamps(&[lamp]);
        let e = Exposure { pixels: [SIDE; 2], pipeline: Pipeline::Hero, samples: 800 };
        let found: Vec<[DVec2; 3]> = (0..SEEDS).map(|seed| centroids(&shoot(&stage, &d, &e, seed))).collect();
        for (one, other, colours) in [(0, 1, "red and green"), (2, 1, "blue and green")] {
            let fringe = expected[one] - expected[other];
            let errors: Vec<DVec2> = found.iter().map(|f| f[one] - f[other] - fringe).collect();
            let mean = errors.iter().sum::<DVec2>() / f64::from(SEEDS);
            let noise =
                errors.iter().map(|e| (*e - mean).length_squared()).sum::<f64>() / f64::from(SEEDS * (SEEDS - 1));
            println!(
                "{name} {colours}: {fringe:.3}, error {mean:.4}, noise {:.4}, spread {:.1}",
                noise.sqrt(),
                truth.spread_px
            );
            assert!(fringe.length() > 0.3 && noise.sqrt() < 0.009, "{name} {colours}: {fringe} {noise}");
            assert!(mean.length() < 0.02, "{name} {colours}: {mean}");
        }
        let expected_place = (expected[1] - DVec2::splat(0.5 * f64::from(SIDE))).length();
        assert!(expected_place < 1.0, "{name}: the window is {expected_place} pixels off");
        let place = found.iter().map(|f| f[1] - expected[1]).sum::<DVec2>() / f64::from(SEEDS);
        assert!(place.length() < 0.04, "{name}: {place}");
    }
}
