//! Single surfaces in hard places, against 30 digits.

// A comparison that NaN fails.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use crate::common::{number, reference_json, vector};
use petzval_optics::single_surface::SingleSurface;
use petzval_optics::surface::{Failure, Shape};
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

/// True if the failure is the reference's: its `miss` may be a crossing of the wrong sheet and the other way round.
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
    let sensitivity = &case["ulp_sensitivity"];
    let flips = sensitivity["status_flips"].as_bool().unwrap();
    // The README's fair tolerance.
    let tolerance = |what: &str| (10.0 * number(&sensitivity[what])).max(1e-11);
    let lost = |reason| match is_status(reason, status) || flips {
        true => Ok(()),
        false => Err(format!("{reason:?}, expected {status}")),
    };

    let semi = if surface["semi_diameter"].is_null() { f64::INFINITY } else { number(&surface["semi_diameter"]) };
    let single = SingleSurface {
        shape: Shape::conic(number(&surface["radius"]), number(&surface["k"])),
        side,
        from: number(&case["n1"]),
        to: number(&case["n2"]),
        is_mirror: surface["mirror"].as_bool().unwrap(),
        semi_diameter_mm: semi,
        obstruction_mm: 0.0,
    };
    let outcome = single.trace::<f64>(vector(&case["origin"]), vector(&case["direction"]));
    if let (Some(hit), Value::Array(_)) = (outcome.hit, &expect["point"]) {
        let error = (hit.point - vector(&expect["point"])).length();
        if !(error <= tolerance("point")) {
            return Err(format!("point off by {error:e} of {:e}", tolerance("point")));
        }
        let error = (hit.normal - vector(&expect["normal"])).length();
        let curvature = single.shape.profile().base.curvature.abs();
        if !(error <= tolerance("direction").max(tolerance("point") * curvature)) {
            return Err(format!("normal off by {error:e}"));
        }
    }
    let out = match outcome.direction {
        Ok(out) => out,
        Err(reason) => return lost(reason),
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
