//! Every ray of the reference tables, both ways: status, failing surface, hits, last direction.
//!
//! The tables hold correctly rounded doubles of a 50-digit trace.

use crate::common::{ASPHERES, lens_names, number, reference_json, system, vector};
use glam::DVec3;
use petzval_optics::glass::line_nm;
use petzval_optics::trace::{Failure, Ray, Tracer};
use serde_json::Value;

/// Hits agree to this part of the lens's size, directions to this part of 1. The start direction is normalised here
/// in doubles and twenty surfaces add a rounding or two each: 3e-14 is the largest seen.
const TOLERANCE: f64 = 1e-13;

const LINES: [(&str, f64); 3] = [("F", line_nm::F), ("d", line_nm::D), ("C", line_nm::C)];

#[test]
fn indices_of_the_catalogue_are_those_of_the_tables() {
    for name in lens_names() {
        let table = reference_json(&format!("rays/{name}.json"));
        let system = system(&name);
        for (line, nm) in LINES {
            let after = indices(&table, line);
            assert_eq!(after.len(), system.surface_count());
            for (i, expected) in after.iter().enumerate() {
                use petzval_optics::system::Element;
                let index = match &system.surfaces()[i].element {
                    Element::Refract { to, .. } => to.index(nm),
                    Element::Reflect { medium } => medium.index(nm),
                };
                assert!((index - expected.abs()).abs() < 1e-12, "{name} surface {i} {line}: {index} {expected}");
            }
        }
    }
}

fn indices(table: &Value, line: &str) -> Vec<f64> {
    table["n"][line].as_array().unwrap().iter().map(number).collect()
}

fn tracers(name: &str, table: &Value) -> Vec<(&'static str, Tracer)> {
    let system = system(name);
    let after = |line| indices(table, line).iter().map(|n: &f64| n.abs()).collect::<Vec<_>>();
    LINES.iter().map(|(line, nm)| (*line, system.with_indices(*nm, &after(line)))).collect()
}

fn is_status(found: Option<Failure>, expected: &str) -> bool {
    match expected {
        "ok" => found.is_none(),
        "miss" | "wrong_sheet" => matches!(found, Some(Failure::Missed | Failure::WrongSheet)),
        "vignetted" => matches!(found, Some(Failure::OutsideAperture)),
        "tir" => matches!(found, Some(Failure::TotalInternalReflection)),
        other => panic!("unknown status {other}"),
    }
}

#[test]
fn rays_of_the_tables_are_reproduced() {
    let mut count = 0;
    let mut worst = (0.0, String::new());
    for name in lens_names().into_iter().chain(ASPHERES.map(str::to_owned)) {
        let table = reference_json(&format!("rays/{name}.json"));
        let tracers = tracers(&name, &table);
        let size = system(&name).surfaces().iter().fold(1.0, |m: f64, s| m.max(s.z_mm.abs()).max(s.semi_diameter_mm));
        for (key, is_reverse) in [("rays", false), ("reverse", true)] {
            for (i, ray) in table[key].as_array().unwrap().iter().enumerate() {
                let what = format!("{name} {key} {i}");
                let (_, tracer) = tracers.iter().find(|(line, _)| *line == ray["w"]).unwrap();
                let error = check(&what, tracer, ray, is_reverse, size);
                if error > worst.0 {
                    worst = (error, what);
                }
                count += 1;
            }
        }
    }
    println!("{count} rays, largest error {:.2e} of the tolerance's unit at {}", worst.0, worst.1);
    assert!(count > 6000);
}

/// Compares one ray; returns its largest relative error.
fn check(what: &str, tracer: &Tracer, ray: &Value, is_reverse: bool, size: f64) -> f64 {
    let start = Ray { origin: vector(&ray["o"]), direction: vector(&ray["d"]).normalize() };
    let mut hits = Vec::new();
    let result = match is_reverse {
        true => tracer.from_film_recording(start, &mut hits),
        false => tracer.from_scene_recording(start, &mut hits),
    };
    let plain = if is_reverse { tracer.from_film(start) } else { tracer.from_scene(start) };
    assert_eq!(result, plain, "{what}: recording changes the result");
    let status = ray["s"].as_str().unwrap();
    assert!(is_status(result.err().map(|lost| lost.reason), status), "{what}: {result:?}, expected {status}");
    if let Err(lost) = result {
        assert_eq!(lost.surface as u64, ray["i"].as_u64().unwrap(), "{what}");
    }
    let expected: Vec<DVec3> = ray["h"].as_array().unwrap().iter().map(vector).collect();
    assert_eq!(hits.len(), expected.len(), "{what}");
    let mut worst: f64 = 0.0;
    for (hit, expected) in hits.iter().zip(&expected) {
        worst = worst.max((*hit - *expected).length() / size);
    }
    if let Ok(out) = result {
        worst = worst.max((out.direction - vector(&ray["e"])).length());
        assert!((out.direction.length() - 1.0).abs() < 4e-16, "{what}");
    }
    assert!(worst < TOLERANCE, "{what}: error {worst:e}");
    worst
}
