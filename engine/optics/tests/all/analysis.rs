//! Spots, fans, transfer functions, distortion and illumination against the reference data and closed forms.

// A comparison that NaN fails.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use petzval_optics::analysis::Analysis;
use petzval_optics::analysis::mtf::MtfError;
use petzval_optics::focus::Focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::seidel::Seidel;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::Ray;

use crate::common::{lens_names, number, reference_json, system};

const UP: f64 = FRAC_PI_2;

fn parsed(text: &str, settings: &LensSettings) -> System {
    System::new(&lens::parse(text, "test", Catalogue::shipped()).unwrap(), settings).unwrap()
}

fn at_infinity(system: &System) -> Focus {
    Focus::at_infinity(system, line_nm::D)
}

/// Root mean square radius of the spot of 127 places of the stop about its middle, as the reference has it from 50-digit rays.
#[test]
fn spots_of_rays_through_given_places_of_the_stop() {
    let table = reference_json("paraxial.json");
    let mut compared = 0;
    let mut bad = Vec::new();
    for name in lens_names() {
        // The reference's spots lie on flat films.
        let system = system(&name);
        if system.film_radius_mm().is_some() {
            continue;
        }
        for spot in table[&name]["spots_d"].as_array().into_iter().flatten() {
            let field_deg = spot["field_deg"].as_f64().unwrap();
            let Some(rms_mm) = spot["rms_at_paraxial_focus"].as_str().map(|text| text.parse::<f64>().unwrap()) else {
                continue;
            };
            let analysis = Analysis::new(&system, at_infinity(&system), &[line_nm::D], 0, UP).unwrap();
            let rings = (1..=6).flat_map(|ring| (0..6 * ring).map(move |i| (ring, i)));
            let places = rings.map(|(ring, i)| {
                let [radius, turn] = [0.999 * f64::from(ring) / 6.0, TAU * f64::from(i) / f64::from(6 * ring)];
                [radius * turn.cos(), radius * turn.sin()]
            });
            let places: Vec<[f64; 2]> = std::iter::once([0.0; 2]).chain(places).collect();
            let landings: Vec<[f64; 2]> = analysis.through_stop(field_deg, &places).into_iter().flatten().collect();
            let expected = spot["rays"].as_u64().unwrap() as usize;
            let n = landings.len() as f64;
            let middle = [0, 1].map(|i| landings.iter().map(|at| at[i]).sum::<f64>() / n);
            let square = |at: &[f64; 2]| (at[0] - middle[0]).powi(2) + (at[1] - middle[1]).powi(2);
            let found = (landings.iter().map(square).sum::<f64>() / n).sqrt();
            compared += 1;
            // The reference aims in double precision, and says itself that 1e-9 of its sums can be asked for; stigmatic
            // lenses have nothing but that.
            let size = Paraxial::new(&system, line_nm::D).efl_mm.map_or(1.0, f64::abs);
            if landings.len() != expected || !((found - rms_mm).abs() <= 1e-7 * rms_mm + 1e-11 * size) {
                bad.push(format!("{name} {field_deg}: {} of {expected} rays, {found} {rms_mm}", landings.len()));
            }
        }
    }
    assert!(bad.is_empty(), "{} of {compared}:\n{}", bad.len(), bad.join("\n"));
    assert!(compared > 60, "{compared}");
}

/// A spot of a lens with little aberration out of focus is the cone's section: its radius by the working f-number, its root mean
/// square that of a disc, and its light as far up as the field's angle says.
#[test]
fn a_spot_out_of_focus_is_a_disc() {
    let settings = LensSettings { f_number: Some(8.0), ..LensSettings::default() };
    let system = parsed("# no aberration on the axis\n0 10 1.5 40 0 1\n -50 100 air 60 -2.25 0", &settings);
    let focus = at_infinity(&system);
    let film_z_mm = focus.film_z_mm + 2.0;
    let analysis = Analysis::new(&system, focus, &[line_nm::D], 0, UP).unwrap().with_film_at(film_z_mm);
    let spot = analysis.spot(0.0, 201).unwrap();
    let radius = 2.0 / 16.0;
    // The cone's edge leans by its sine, not its tangent: (1/16)^2 / 2 is 0.2 %; a grid of 201 knows the disc to 0.3 %.
    assert!((spot.largest_mm / radius - 1.0).abs() < 0.01, "{}", spot.largest_mm);
    assert!((spot.rms_mm / (radius / 2f64.sqrt()) - 1.0).abs() < 0.005, "{}", spot.rms_mm);
    assert!(spot.centroid_mm[1].abs() < 1e-12 && spot.chief_mm.unwrap()[1].abs() < 1e-9);
}

/// The derivative of the path is the place where the ray lands: fans of the two kinds say the same of a lens. On the axis and off, in
/// air and, for an eye, in water.
#[test]
fn the_slope_of_a_wave_fan_is_the_ray_fan() {
    for (name, field) in [("cooke-triplet-50mm", 10.0), ("double-gauss-f2-available", 7.0), ("cassegrain-f12", 0.2)] {
        let system = system(name);
        let p = Paraxial::new(&system, line_nm::D);
        let analysis = Analysis::new(&system, at_infinity(&system), &[line_nm::D], 0, UP).unwrap();
        let fans = analysis.fans(field, 2001).unwrap();
        for fan in [&fans.tangential[0].rays, &fans.sagittal[0].rays] {
            let largest = fan.iter().map(|ray| ray.error_mm.abs()).fold(0.0, f64::max);
            // dW = (ε / R) dy on the exit pupil's sphere, its height R n' u' by the stop's place: about the paraxial slope.
            let slope = 0.5 / p.f_number.unwrap();
            for pair in fan.windows(2).filter(|pair| pair[1].pupil - pair[0].pupil < 0.01) {
                let rise = (pair[1].path_waves - pair[0].path_waves) * line_nm::D * 1e-6;
                let by_path = rise / (pair[1].pupil - pair[0].pupil) / slope;
                let by_ray = 0.5 * (pair[0].error_mm + pair[1].error_mm);
                // The paraxial slope holds to the cosine of the field and to the pupil's own aberrations.
                assert!(
                    (by_path.abs() - by_ray.abs()).abs() < 0.15 * by_ray.abs() + 0.01 * largest,
                    "{name} at {}: {by_path} {by_ray}",
                    pair[0].pupil
                );
            }
            assert!(fan.iter().any(|ray| ray.path_waves.abs() > 0.05), "{name}");
        }
    }
}

/// The contrast of a perfect lens with a round pupil: 2/π (acos ν − ν √(1 − ν²)), ν over the cut-off.
fn perfect(nu: f64) -> f64 {
    if nu >= 1.0 { 0.0 } else { 2.0 / PI * (nu.acos() - nu * (1.0 - nu * nu).sqrt()) }
}

#[test]
fn a_stigmatic_lens_transfers_what_diffraction_leaves() {
    for (name, f_number) in [("newtonian-f5", 5.0), ("plano-hyperbolic-50mm", 8.0), ("cassegrain-f12", 12.0)] {
        let prescription = crate::common::prescription(name);
        let settings = LensSettings { f_number: Some(f_number), ..LensSettings::default() };
        let system = System::new(&prescription, &settings).unwrap();
        let analysis = Analysis::new(&system, at_infinity(&system), &[line_nm::D], 0, UP).unwrap();
        let cutoff_per_mm = 1.0 / (line_nm::D * 1e-6 * system.f_number());
        let mtf = analysis.mtf(0.0, cutoff_per_mm / 20.0, 22).unwrap();
        for curve in [&mtf.sagittal, &mtf.tangential] {
            for (i, contrast) in curve.contrast.iter().enumerate() {
                // Some 130 cells over the pupil know its area to 0.3 %; a slope of 1 / 2N is the sine to 1 / 8 N².
                let truth = perfect(i as f64 / 20.0);
                assert!((contrast - truth).abs() < 6e-3, "{name} {i}: {contrast} {truth}");
                assert!((curve.limit[i] - truth).abs() < 6e-3, "{name} {i}");
                assert!((curve.geometric[i] - 1.0).abs() < 1e-3, "{name} {i}: {}", curve.geometric[i]);
            }
        }
    }
}

/// Far out of focus rays alone give the contrast that is left: 2 J1(x) / x of the disc; and diffraction adds nothing that could be seen.
#[test]
fn far_out_of_focus_contrast_is_that_of_a_disc() {
    let settings = LensSettings { f_number: Some(8.0), ..LensSettings::default() };
    let system = System::new(&crate::common::prescription("plano-hyperbolic-50mm"), &settings).unwrap();
    // 27 waves.
    let defocus = 8.0;
    let focus = at_infinity(&system);
    let film_z_mm = focus.film_z_mm + defocus;
    let analysis = Analysis::new(&system, focus, &[line_nm::D], 0, UP).unwrap().with_film_at(film_z_mm);
    let mtf = analysis.mtf(0.0, 0.3, 25).unwrap();
    let radius = defocus / 16.0;
    for i in 1..25 {
        let x = TAU * radius * 0.3 * i as f64;
        let truth = (2.0 * bessel_j1(x) / x).abs();
        assert!((mtf.tangential.geometric[i] - truth).abs() < 0.01, "{i}: {} {truth}", mtf.tangential.geometric[i]);
        assert!((mtf.tangential.contrast[i] - truth).abs() < 0.02, "{i}: {} {truth}", mtf.tangential.contrast[i]);
    }
}

/// The Bessel function J₁ by its series, for the small arguments here.
fn bessel_j1(x: f64) -> f64 {
    let (mut term, mut sum) = (x / 2.0, x / 2.0);
    for k in 1..60 {
        term *= -(x * x / 4.0) / (f64::from(k) * f64::from(k + 1));
        sum += term;
    }
    sum
}

/// A quarter of a wave of defocus leaves 80 % of the middle of the point's light (Rayleigh), so contrast at half the cut-off falls from
/// 0.39 to the values that Hopkins (1955) tables: here by the autocorrelation itself, as an integral along the shift.
#[test]
fn a_little_out_of_focus_contrast_is_hopkins() {
    let settings = LensSettings { f_number: Some(8.0), ..LensSettings::default() };
    let system = System::new(&crate::common::prescription("plano-hyperbolic-50mm"), &settings).unwrap();
    let wavelength_mm = line_nm::D * 1e-6;
    // W20 = δz / 8 N² is half a wave.
    let w20_waves = 0.5;
    let defocus = 8.0 * 64.0 * w20_waves * wavelength_mm;
    let focus = at_infinity(&system);
    let film_z_mm = focus.film_z_mm + defocus;
    let analysis = Analysis::new(&system, focus, &[line_nm::D], 0, UP).unwrap().with_film_at(film_z_mm);
    let cutoff = 1.0 / (wavelength_mm * system.f_number());
    let mtf = analysis.mtf(0.0, cutoff / 16.0, 16).unwrap();
    for i in 1..16 {
        // Pupil of radius 1, shifted by 2 ν: the phase difference is 2π W20 4 ν x, the overlap's height 2 (√(1 − (|x| + ν)²)).
        let nu = f64::from(i) / 16.0;
        let steps = 4000;
        let sum: f64 = (0..steps)
            .map(|k| {
                let x = (1.0 - nu) * (2.0 * (f64::from(k) + 0.5) / f64::from(steps) - 1.0);
                let height = 2.0 * (1.0 - (x.abs() + nu).powi(2)).max(0.0).sqrt();
                height * (TAU * w20_waves * 4.0 * nu * x).cos() * 2.0 * (1.0 - nu) / f64::from(steps)
            })
            .sum();
        let truth = (sum / PI).abs();
        let found = mtf.sagittal.contrast[i as usize];
        assert!((found - truth).abs() < 8e-3, "{i}: {found} {truth}");
    }
}

#[test]
fn fields_that_are_dark_and_steps_that_are_too_fine_are_named() {
    let system = system("double-gauss-f1.35");
    let analysis = Analysis::new(&system, at_infinity(&system), &[line_nm::D], 0, UP).unwrap();
    assert_eq!(analysis.mtf(70.0, 10.0, 5), Err(MtfError::Dark));
    assert!(matches!(analysis.mtf(0.0, 0.01, 5), Err(MtfError::TooFine { .. })));
    assert!(analysis.spot(70.0, 21).is_none() && analysis.fans(70.0, 21).is_none());
    assert!(Analysis::new(&system, at_infinity(&system), &[], 0, UP).is_none());
}

/// Heights of middle rays are those of the reference's, to every digit that its aiming has; and near the axis focus and distortion go as
/// Seidel's sums say.
#[test]
fn near_the_axis_field_curvature_distortion_and_colour_are_third_order() {
    for name in ["cooke-triplet-50mm", "double-gauss-f2-available", "tessar-brendel", "biotar-1927", "petzval-kodak"] {
        let system = system(name);
        let p = Paraxial::new(&system, line_nm::D);
        let lines = [line_nm::D, line_nm::F, line_nm::C];
        let analysis = Analysis::new(&system, at_infinity(&system), &lines, 0, UP).unwrap();
        let field_deg = 0.5;
        let chief = analysis.chief_ray(field_deg).unwrap();
        let sums = Seidel::at_field(&system, line_nm::D, None, field_deg).unwrap().total();
        let [_, _, s3, s4, s5] = sums.seidel;
        // n' u' of the ray past the rim of the entrance pupil; Welford, Aberrations of Optical Systems (1986), section 8.
        let nu = -0.5 / p.f_number.unwrap();
        let third_order = [
            ("tangential", chief.tangential_focus_mm.unwrap(), -(3.0 * s3 + s4) / (2.0 * nu * nu)),
            ("sagittal", chief.sagittal_focus_mm.unwrap(), -(s3 + s4) / (2.0 * nu * nu)),
            ("distortion", chief.height_mm - chief.straight_height_mm.unwrap(), s5 / (2.0 * nu)),
            ("colour", chief.colour_mm[1].unwrap() - chief.colour_mm[2].unwrap(), sums.chromatic[1] / nu),
        ];
        for (what, found, third_order) in third_order {
            // The fifth order is about (half a degree over the half field)² of the third; heights of sources that far apart are known to
            // 1e-10 of the focal length. Dispersion from F to C is no small difference: it is left out how colours are bent twice.
            let error = (found - third_order).abs();
            let part = if what == "colour" { 0.06 } else { 0.02 };
            assert!(
                error < part * third_order.abs() + 2e-9 * p.efl_mm.unwrap(),
                "{name} {what}: {found} {third_order}"
            );
        }
        assert!((analysis.height_by_slope_mm() / p.efl_mm.unwrap() - 1.0).abs() < 1e-8, "{name}");
    }
}

#[test]
fn middle_rays_land_where_the_reference_has_them() {
    let mut compared = 0;
    for name in ["cooke-triplet-50mm", "double-gauss-f2-tronnier", "pbrt-fisheye-10mm", "biogon-21-f4.5"] {
        let system = system(name);
        let film_z_mm = system.film_z_published_mm();
        let focus = Focus { film_z_mm, ..at_infinity(&system) };
        let analysis = Analysis::new(&system, focus, &[line_nm::D], 0, UP).unwrap();
        for ray in reference_json(&format!("rays/{name}.json"))["rays"].as_array().unwrap() {
            let is_middle = ray["pu"].as_array().is_some_and(|pu| pu.iter().all(|x| number(x) == 0.0));
            if !is_middle || ray["w"] != "d" || ray["s"] != "ok" {
                continue;
            }
            let found = analysis.chief_ray(ray["th"].as_f64().unwrap()).unwrap().height_mm;
            let expected = number(&ray["f"][1]);
            assert!((found - expected).abs() < 1e-8, "{name} {}: {found} {expected}", ray["th"]);
            compared += 1;
        }
    }
    assert!(compared >= 8, "{compared}");
}

/// A hole before a film: the configuration factor of a disc (Howell, Catalog of Radiation Heat Transfer, B-12), which is the cosine's
/// fourth power where the hole is small.
#[test]
fn a_hole_lights_a_film_by_the_cosines_fourth_power() {
    for radius in [0.5, 10.0] {
        let system = parsed(&format!("0 50 air {} 0 1", 2.0 * radius), &LensSettings::default());
        let focus = at_infinity(&system);
        let analysis = Analysis::new(&system, focus, &[line_nm::D], 0, UP).unwrap();
        let angles = [0.0, 10.0, 25.0, 40.0];
        let found = analysis.illumination(&angles);
        assert_eq!(found.len(), angles.len(), "{radius} {found:?}");
        let factor = |h: f64| {
            let (d2, h2, r2) = (2500.0, h * h, radius * radius);
            0.5 * (1.0 - (h2 + d2 - r2) / ((h2 + d2 + r2).powi(2) - 4.0 * h2 * r2).sqrt())
        };
        for (angle, light) in angles.iter().zip(found) {
            let expected = factor(light.height_mm) / factor(0.0);
            // 65,536 directions know the area of an ellipse to a part in a thousand.
            assert!((light.relative.unwrap() / expected - 1.0).abs() < 2e-3, "{radius} {angle}: {light:?} {expected}");
            assert!((light.projected_sr / (PI * factor(light.height_mm)) - 1.0).abs() < 2e-3);
            let fourth = angle.to_radians().cos().powi(4);
            assert!(radius > 1.0 || (expected / fourth - 1.0).abs() < 1e-3);
        }
    }
}

/// An anamorphic lens shows the other's focal length at the other azimuth.
#[test]
fn azimuths_of_an_anamorphic_lens_differ() {
    let path = crate::common::repository("lenses/anamorphic-2x-double-gauss.lens");
    let prescription = lens::read(&path, Catalogue::shipped()).unwrap();
    let system = System::new(&prescription, &LensSettings::default()).unwrap();
    let slope = |azimuth: f64| {
        let analysis = Analysis::new(&system, at_infinity(&system), &[line_nm::D], 0, azimuth).unwrap();
        let chief = analysis.chief_ray(2.0).unwrap();
        chief.height_mm / 2f64.to_radians().tan()
    };
    assert!((slope(UP) - 100.0).abs() < 0.2 && (slope(0.0) - 50.0).abs() < 0.2, "{} {}", slope(UP), slope(0.0));
}

/// The contrast on the axis of a real lens, by another way: rays of one meridian, their waves summed to the light of a point by a Hankel
/// transform, and that light transformed again. Paths by the hits and the indices alone.
#[test]
fn on_the_axis_contrast_is_that_of_the_points_light() {
    let name = "cooke-triplet-50mm";
    let system = system(name);
    let film_z_mm = system.film_z_published_mm();
    let focus = Focus { film_z_mm, ..at_infinity(&system) };
    let found = Analysis::new(&system, focus, &[line_nm::D], 0, UP).unwrap().mtf(0.0, 20.0, 6).unwrap();

    let tracer = system.at_wavelength(line_nm::D);
    let indices = [1.0, 1.620_410_081_530_312_6, 1.0, 1.620_040_137_246_267_8, 1.0, 1.620_410_081_530_312_6];
    // Sine of the slope, path to the foot of the perpendicular from the film's middle, for a height.
    let of_height = |y: f64| {
        let mut hits = Vec::new();
        let ray = Ray { origin: DVec3::new(0.0, y, 0.0), direction: DVec3::Z };
        let out = tracer.from_scene_recording(ray, &mut hits).ok()?;
        let before = std::iter::once(ray.origin).chain(hits.iter().copied());
        let path: f64 = before.zip(&hits).zip(indices).map(|((a, b), n)| n * (*b - a).length()).sum();
        let to_film = DVec3::new(0.0, 0.0, film_z_mm) - out.origin;
        Some((-out.direction.y, path + to_film.dot(out.direction)))
    };
    let mut edge = [0.0, 6.0];
    for _ in 0..50 {
        let middle = 0.5 * (edge[0] + edge[1]);
        edge[usize::from(of_height(middle).is_none())] = middle;
    }
    let rays = 1200;
    let step = edge[0] / f64::from(rays);
    let wave = TAU / (line_nm::D * 1e-6);
    let (_, axis) = of_height(0.0).unwrap();
    // Light goes as y dy, and so is spread over s ds.
    let waves: Vec<(f64, f64, f64)> = (0..rays)
        .map(|i| {
            let y = (f64::from(i) + 0.5) * step;
            let ((s, path), (a, _), (b, _)) =
                (of_height(y).unwrap(), of_height(y - 0.4 * step).unwrap(), of_height(y + 0.4 * step).unwrap());
            let slope = (b - a) / 0.8 / step;
            (s, (y * s * slope).sqrt() * step, wave * (path - axis))
        })
        .collect();
    // Beyond 60 µm lies less than a part in a hundred of the light, thinly.
    let (places, farthest) = (1500, 0.06);
    let width = farthest / f64::from(places);
    let light: Vec<(f64, f64)> = (0..places)
        .map(|i| {
            let r = (f64::from(i) + 0.5) * width;
            let sum = waves.iter().fold([0.0; 2], |[re, im], (s, a, phase)| {
                let a = a * bessel_j0(wave * s * r);
                [re + a * phase.cos(), im + a * phase.sin()]
            });
            (r, (sum[0] * sum[0] + sum[1] * sum[1]) * r)
        })
        .collect();
    let transform = |nu: f64| light.iter().map(|(r, light)| light * bessel_j0(TAU * nu * r)).sum::<f64>();
    for i in 1..6 {
        let truth = transform(20.0 * f64::from(i)).abs() / transform(0.0);
        let contrast = found.tangential.contrast[i as usize];
        assert!((contrast - truth).abs() < 0.01, "{i}: {contrast} {truth}");
    }
}

/// The Bessel function J₀ by its integral, a mean over half a turn: exact to rounding where there are more places than half of x.
fn bessel_j0(x: f64) -> f64 {
    let places = 24 + (x.abs() / 2.0) as usize;
    (0..places).map(|i| (x * (PI * (i as f64 + 0.5) / places as f64).sin()).cos()).sum::<f64>() / places as f64
}

/// optiland, its rays aimed at the stop, of lenses with the reference's indices.
#[test]
fn distortion_and_field_curvature_are_another_programs() {
    for (name, table) in reference_json("foreign/reports.json").as_object().unwrap() {
        if name.starts_with('_') {
            continue;
        }
        let system = system(name);
        let film_z_mm = system.last_vertex_z_mm() + table["film_from_last_vertex_mm"].as_f64().unwrap();
        let focus = Focus { film_z_mm, ..at_infinity(&system) };
        let analysis = Analysis::new(&system, focus, &[line_nm::D], 0, UP).unwrap();
        let of = |key: &str, i: usize| table[key][i].as_f64().unwrap();
        for i in 1..6 {
            let chief = analysis.chief_ray(of("fields_deg", i)).unwrap();
            let distortion = 100.0 * (chief.height_mm / chief.straight_height_mm.unwrap() - 1.0);
            // It aims to a millionth of the stop's radius, and takes the slopes of its neighbours over a difference.
            let compare = |what: &str, found: f64, expected: f64| {
                assert!(
                    (found - expected).abs() < 1e-6 + 1e-5 * expected.abs(),
                    "{name} {i} {what}: {found} {expected}"
                );
            };
            compare("distortion", distortion, of("distortion_percent", i));
            compare("tangential", chief.tangential_focus_mm.unwrap(), of("tangential_focus_mm", i));
            compare("sagittal", chief.sagittal_focus_mm.unwrap(), of("sagittal_focus_mm", i));
        }
    }
}
