//! Single surfaces in hard places, against 30 digits.

// A comparison that NaN fails.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod common;

use common::{number, reference_json, vector};
use petzval_optics::interface::{Interface, reflect};
use petzval_optics::surface::{Failure, Shape};
use petzval_optics::vector::Vector;
use serde_json::Value;

#[test]
fn every_hard_case_comes_out() {
    let table = reference_json("hard-cases.json");
    let cases = table["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 289);
    let mut bad = Vec::new();
    for case in cases {
        if let Err(why) = check(case) {
            bad.push(format!("{}: {why}", case["id"].as_str().unwrap()));
        }
    }
    assert!(bad.is_empty(), "{} cases:\n{}", bad.len(), bad.join("\n"));
}

/// What the reference calls `miss` may be a crossing of the wrong sheet and the other way round.
fn is_status(found: Failure, expected: &str) -> bool {
    match expected {
        "miss" | "wrong_sheet" => matches!(found, Failure::Missed | Failure::WrongSheet),
        "vignetted" => found == Failure::OutsideAperture,
        "tir" => found == Failure::TotalInternalReflection,
        _ => false,
    }
}

fn check(case: &Value) -> Result<(), String> {
    let surface = &case["surface"];
    let expect = &case["expect"];
    let status = expect["status"].as_str().unwrap();
    let side = number(&case["side"]);
    let direction = vector(&case["direction"]).normalize();
    let sensitivity = &case["ulp_sensitivity"];
    let flips = sensitivity["status_flips"].as_bool().unwrap();
    // The README's fair tolerance.
    let tolerance = |what: &str| (10.0 * number(&sensitivity[what])).max(1e-11);
    let lost = |reason| match is_status(reason, status) || flips {
        true => Ok(()),
        false => Err(format!("{reason:?}, expected {status}")),
    };

    let shape = Shape::conic(number(&surface["radius"]), number(&surface["k"]));
    let d = Vector::from_f64(direction);
    let hit = match shape.intersect(Vector::from_f64(vector(&case["origin"])), d, side) {
        Ok(hit) => hit,
        Err(reason) => return lost(reason),
    };
    let semi = if surface["semi_diameter"].is_null() { f64::INFINITY } else { number(&surface["semi_diameter"]) };
    let point = hit.point.of(0);
    let is_outside = point.truncate().length_squared() > semi * semi;
    if let Value::Array(_) = &expect["point"] {
        let error = (point - vector(&expect["point"])).length();
        if !(error <= tolerance("point")) {
            return Err(format!("point off by {error:e} of {:e}", tolerance("point")));
        }
        let normal = hit.normal.of(0) / hit.normal_squared.sqrt();
        let error = (normal - vector(&expect["normal"])).length();
        if !(error <= tolerance("direction").max(tolerance("point") * shape.profile().base.curvature.abs())) {
            return Err(format!("normal off by {error:e}"));
        }
    }
    if is_outside {
        return lost(Failure::OutsideAperture);
    }
    let (n1, n2) = (number(&case["n1"]), number(&case["n2"]));
    let out = match surface["mirror"].as_bool().unwrap() {
        true => reflect(d, &hit, side).of(0),
        false if n1 == n2 => direction,
        false => match Interface::new(n1, n2).refract(d, &hit, side) {
            (out, true) => out.of(0),
            (_, false) => return lost(Failure::TotalInternalReflection),
        },
    };
    if status != "ok" {
        return if flips { Ok(()) } else { Err(format!("ok, expected {status}")) };
    }
    let error = (out - vector(&expect["dir"])).length();
    if !(error <= tolerance("direction")) {
        return Err(format!("direction off by {error:e} of {:e}", tolerance("direction")));
    }
    Ok(())
}
