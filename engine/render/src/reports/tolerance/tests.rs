//! Tolerances, tested by closed forms and by the lens's own measures.

use super::*;
use crate::reports::{ReportSettings, report};
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use serde_json::{Value, json};

/// A paraboloid mirror: without aberrations on the axis.
const MIRROR: &str = "#radius thickness glass diameter conic isstop\n-2000 -1000 mirror 100 -1 1\n";
const TRIPLET: &str = "#radius thickness glass diameter conic isstop\n40.1 6 SK4 34 0 0\n-537 10 air 34 0 0\n-47 1 SF2 26 0 0\n\
                       40 1 air 26 0 0\n0 9.8 air 25 0 1\n234.5 6 SK4 28 0 0\n-37.9 85 air 28 0 0\n";

fn options(change: Value) -> Value {
    let mut all = json!({
        "radius_percent": 0.0, "thickness_mm": 0.0, "index": 0.0, "decenter_mm": 0.0, "tilt_deg": 0.0, "trials": 2, "seed": 1,
        "frequency_per_mm": 20.0, "rays": 21, "compensator": "none", "distribution": "uniform"
    });
    for (key, value) in change.as_object().unwrap() {
        all[key] = value.clone();
    }
    all
}

fn found(text: &str, fields_deg: &[f64], change: Value) -> Value {
    let lens = lens::parse(text, "test.lens", Catalogue::shipped()).unwrap();
    let settings = ReportSettings {
        fields_deg: fields_deg.to_vec(),
        wavelengths_nm: vec![550.0],
        azimuth_deg: 90.0,
        focus_distance_mm: None,
        best_focus: false,
        defocus_mm: 0.0,
    };
    let text = report("tolerance", &lens, &LensSettings::default(), &settings, options(change)).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// A mirror whose radius is ε too long has its focus ε f farther; the cone's section there has the radius ε f / 2N, and a root mean square
/// of that over the root of two. The film makes up for all of it.
#[test]
fn a_radius_that_is_too_long_defocuses() {
    let of = |compensator: &str| {
        found(MIRROR, &[0.0], json!({ "radius_percent": 0.1, "compensator": compensator, "rays": 81 }))
    };
    let none = of("none");
    let rms = none["sensitivities"][0]["plus"]["rms_mm"].as_f64().unwrap();
    let expected = 1.0 / (2.0 * 10.0) / 2f64.sqrt();
    assert!((rms / expected - 1.0).abs() < 0.01, "{rms} {expected}");
    assert_eq!(none["sensitivities"][0]["kind"], "radius");
    assert_eq!(none["sensitivities"][0]["size"], 0.1);
    let film = of("back-focus");
    let plus = &film["sensitivities"][0]["plus"];
    assert!(plus["rms_mm"].as_f64().unwrap() < 1e-3 * expected, "{plus}");
    // Light runs towards -z after a mirror.
    assert!((plus["compensation"].as_f64().unwrap() + 1.0).abs() < 1e-3, "{plus}");
}

/// Random draws lie within the tolerances and are the same for the same seed.
#[test]
fn lenses_drawn_at_random_are_within_their_tolerances() {
    for distribution in [Distribution::Normal, Distribution::Uniform] {
        let mut random = Random::new(3, 7);
        let drawn: Vec<f64> = (0..4000).map(|_| random.within(distribution)).collect();
        assert!(drawn.iter().all(|one| one.abs() <= 1.0));
        let mean = drawn.iter().sum::<f64>() / 4000.0;
        let spread = (drawn.iter().map(|one| one * one).sum::<f64>() / 4000.0).sqrt();
        // A uniform one's is 1 / √3, that of a normal one of σ = 1/2 cut off at 2 σ is 0.4398 (Johnson, Kotz and Balakrishnan 1994, 13.10).
        let expected = if distribution == Distribution::Uniform { 3f64.sqrt().recip() } else { 0.4398 };
        assert!(mean.abs() < 0.03 && (spread / expected - 1.0).abs() < 0.03, "{mean} {spread}");
    }
    let change = json!({ "radius_percent": 0.2, "decenter_mm": 0.05, "tilt_deg": 0.05, "thickness_mm": 0.05, "index": 5e-4,
                         "trials": 24, "compensator": "back-focus" });
    let [first, second] = [(); 2].map(|()| found(TRIPLET, &[0.0, 10.0], change.clone()));
    assert_eq!(first["trials"], second["trials"]);
    let other = found(TRIPLET, &[0.0, 10.0], {
        let mut c = change.clone();
        c["seed"] = json!(2);
        c
    });
    assert_ne!(first["trials"], other["trials"]);
    // Parts of the lenses, in order, and a lens whose parts deviate is worse in the middle than the nominal one.
    let rms: Vec<f64> = first["quantiles"].as_array().unwrap().iter().map(|q| q["rms_mm"].as_f64().unwrap()).collect();
    assert!(rms.is_sorted() && rms[1] > first["nominal"]["rms_mm"].as_f64().unwrap(), "{rms:?}");
}

/// Without deviations every lens is the nominal one.
#[test]
fn a_lens_without_tolerances_is_the_nominal_one() {
    let found = found(TRIPLET, &[0.0, 10.0], json!({ "compensator": "none" }));
    assert_eq!(found["sensitivities"], json!([]));
    assert_eq!(found["trials"][0], found["nominal"]);
    assert_eq!(found["fields_deg"], json!([0.0, 10.0, -10.0]));
}
