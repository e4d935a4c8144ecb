//! Errors of f32 on the rays of the reference tables: the bounds that docs/numerics.md states.

use crate::common::{ASPHERES, lens_names, number, reference_json, system, vector};
use glam::DVec3;
use petzval_optics::glass::line_nm;
use petzval_optics::trace::{Ray, Tracer};
use serde_json::Value;

/// Hits by the size of the lens: 24 roundings of 6e-8. The largest seen is 1.4e-6, in the 170-degree fisheye.
const HIT: f64 = 24.0 * 6e-8;
/// Hits of rays that are lost, by the size of the lens: their last hits may graze. The largest seen is 9.5e-6, in the
/// Sonnar.
const HIT_OF_LOST: f64 = 2e-5;
/// Directions of half of all rays through a lens: 8 roundings. The largest seen is 4.4e-7, in a telescope of 57 m.
const MEDIAN_DIRECTION: f64 = 8.0 * 6e-8;
/// Any direction. A ray that grazes the front of the fisheye at 85 degrees has lost 1.8e-5.
const WORST_DIRECTION: f64 = 4e-5;

/// Errors of the rays of one lens: hits, directions.
#[derive(Default)]
struct Errors {
    hit: f64,
    directions: Vec<f64>,
}

#[test]
fn single_precision_keeps_its_promise() {
    let mut count = 0;
    for name in lens_names().into_iter().chain(ASPHERES.map(str::to_owned)) {
        let table = reference_json(&format!("rays/{name}.json"));
        let system = system(&name);
        let size = system.surfaces().iter().fold(1.0, |m: f64, s| m.max(s.z_mm.abs()).max(s.semi_diameter_mm));
        let mut errors = Errors::default();
        for (line, nm) in [("F", line_nm::F), ("d", line_nm::D), ("C", line_nm::C)] {
            let after: Vec<f64> = table["n"][line].as_array().unwrap().iter().map(|n| number(n).abs()).collect();
            let tracer: Tracer<f32> = system.with_indices(nm, &after).cast();
            for (key, is_reverse) in [("rays", false), ("reverse", true)] {
                for (i, ray) in table[key].as_array().unwrap().iter().enumerate().filter(|(_, ray)| ray["w"] == line) {
                    compare(&format!("{name} {key} {i}"), &tracer, ray, is_reverse, size, &mut errors);
                    count += 1;
                }
            }
        }
        errors.directions.sort_by(f64::total_cmp);
        let (worst, median) = (*errors.directions.last().unwrap(), errors.directions[errors.directions.len() / 2]);
        println!("{name}: hits {:.1e}, directions median {median:.1e} worst {worst:.1e}", errors.hit);
        assert!(errors.hit < HIT && median < MEDIAN_DIRECTION && worst < WORST_DIRECTION, "{name}");
    }
    assert!(count > 6000);
}

/// Status and surface are those of the table (no ray of it lies within 1e-9 of a rim, and none so near that f32 would
/// tell otherwise); the errors of hits and direction are noted in `errors`.
fn compare(what: &str, tracer: &Tracer<f32>, ray: &Value, is_reverse: bool, size: f64, errors: &mut Errors) {
    let start = Ray { origin: vector(&ray["o"]), direction: vector(&ray["d"]).normalize() };
    let mut hits = Vec::new();
    let result = match is_reverse {
        true => tracer.from_film_recording(start, &mut hits),
        false => tracer.from_scene_recording(start, &mut hits),
    };
    let expected: Vec<DVec3> = ray["h"].as_array().unwrap().iter().map(vector).collect();
    assert_eq!(result.is_ok(), ray["s"] == "ok", "{what}: {result:?}");
    assert_eq!(result.err().map(|lost| lost.surface as u64), ray["i"].as_u64(), "{what}: {result:?}");
    assert_eq!(hits.len(), expected.len(), "{what}");
    let hit = hits.iter().zip(&expected).fold(0.0, |m: f64, (a, b)| m.max((*a - *b).length() / size));
    assert!(hit < HIT_OF_LOST, "{what}: {hit:e}");
    if let Ok(out) = result {
        errors.hit = errors.hit.max(hit);
        errors.directions.push((out.direction - vector(&ray["e"])).length());
        assert!((out.direction.length() - 1.0).abs() < 4e-16, "{what}: a unit vector in f64");
    }
}
