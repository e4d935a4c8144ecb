//! The exact tracer against the table of hard cases, which has 30 digits.

use serde_json::Value;

use super::super::inputs::{BigConic, Inputs, Surface};
use super::super::trace::trace_inputs;
use super::super::{Big, Case, Shape, Status};

fn text(value: &Value) -> &str {
    value.as_str().unwrap()
}

fn big(value: &Value) -> Big {
    Big::parse(text(value)).unwrap()
}

fn number(value: &Value) -> f64 {
    text(value).parse().unwrap()
}

fn numbers(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| number(&value[i]))
}

fn case_of(entry: &Value) -> (Case, Inputs) {
    let surface = &entry["surface"];
    let (radius, conic) = (number(&surface["radius"]), number(&surface["k"]));
    let case = Case {
        shape: Shape::Conic { curvature: if radius == 0.0 { 0.0 } else { 1.0 / radius }, conic },
        origin: numbers(&entry["origin"]),
        direction: numbers(&entry["direction"]),
        side: entry["side"].as_f64().unwrap_or_else(|| number(&entry["side"])),
        n1: number(&entry["n1"]),
        n2: number(&entry["n2"]),
        mirror: surface["mirror"].as_bool().unwrap(),
        semi_diameter: surface["semi_diameter"].as_str().map(|x| x.parse().unwrap()),
        obstruction: 0.0,
    };
    let mut inputs = Inputs::new(&case);
    // The table gives radii, whose reciprocals are no machine numbers.
    let c = if radius == 0.0 { Big::new(0.0) } else { Big::new(1.0) / Big::new(radius) };
    inputs.surface = Surface::Conic(BigConic { c, k: Big::new(conic) });
    (case, inputs)
}

/// The value below which the reference's 50 digits are noise about 0, mm.
const REFERENCE_NOISE: f64 = 1e-40;

/// Number of decimal digits in which two vectors agree.
fn digits(found: &[Big], expected: &[Big]) -> f64 {
    let length = |v: &[Big]| v.iter().fold(Big::new(0.0), |sum, x| sum + x.squared()).sqrt();
    let error: Vec<Big> = found.iter().zip(expected).map(|(f, e)| f - e).collect();
    let (error, size) = (length(&error), length(expected));
    if error <= Big::new(REFERENCE_NOISE) {
        return 40.0;
    }
    if size.is_zero() { 0.0 } else { -(error / size).to_f64().log10() }
}

/// Digits that were printed, at most `most`.
fn printed(number: &Value, most: usize) -> usize {
    let mantissa = text(number).split(['e', 'E']).next().unwrap();
    let digits = mantissa.trim_start_matches(['-', '0', '.']).chars().filter(char::is_ascii_digit).count();
    digits.min(most)
}

#[test]
fn the_reference_is_met_to_its_last_digits() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/hard-cases.json");
    let table: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let cases = table["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 289);
    let mut bad = Vec::new();
    let mut fewest = 40f64;
    for entry in cases {
        let (case, inputs) = case_of(entry);
        let truth = trace_inputs(&inputs);
        let expect = &entry["expect"];
        let status = match text(&expect["status"]) {
            "ok" => Status::Ok,
            "miss" => Status::Missed,
            "wrong_sheet" => Status::WrongSheet,
            "vignetted" => Status::OutsideAperture,
            "tir" => Status::TotalInternalReflection,
            other => panic!("{other}"),
        };
        let id = text(&entry["id"]);
        if truth.status != status {
            bad.push(format!("{id}: {:?}, expected {status:?}", truth.status));
            continue;
        }
        let mut check = |what: &str, found: Option<&[Big]>| {
            let entry = &expect[what];
            if entry.is_null() {
                return;
            }
            let expected: Vec<Big> = entry.as_array().map_or_else(|| vec![big(entry)], |v| v.iter().map(big).collect());
            let found = found.map_or(0.0, |found| digits(found, &expected));
            // Of lost rays a discriminant is printed to ten digits.
            let is_lost = status != Status::Ok && expected.len() == 1;
            let wanted = if is_lost { printed(entry, 29).saturating_sub(1) } else { 28 };
            fewest = if is_lost { fewest } else { fewest.min(found) };
            if found < wanted as f64 {
                bad.push(format!("{id}: {what} to {found:.1} digits of {wanted}"));
            }
        };
        let hit = truth.hit.as_ref();
        let one = std::slice::from_ref;
        check("t", hit.map(|h| one(&h.t)));
        check("disc", truth.discriminant.as_ref().map(one));
        check("point", hit.map(|h| &h.point[..]));
        check("normal", hit.map(|h| &h.normal[..]));
        check("dir", truth.direction.as_ref().map(|d| &d[..]));
        check("cos_i", hit.map(|h| one(&h.cosine)));
        // Between equal indices it is left at 1 there.
        if case.n1 != case.n2 {
            check("cos_t2", hit.and_then(|h| h.radicand.as_ref()).map(one));
        }
    }
    assert!(bad.is_empty(), "{} of fewest digits {fewest:.1}:\n{}", bad.len(), bad.join("\n"));
}
