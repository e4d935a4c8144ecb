//! The reference data, read.
#![allow(dead_code, unreachable_pub)]

use std::path::PathBuf;

use glam::DVec3;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{LensSettings, System};
use serde_json::Value;

/// A path from the top of the repository.
pub fn repository(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// A JSON file of the reference data.
pub fn reference_json(path: &str) -> Value {
    let path = repository("tests/reference").join(path);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Names of all lenses of the reference data that a lens file can hold.
pub fn lens_names() -> Vec<String> {
    let folder = repository("tests/reference/lenses");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .filter_map(|entry| entry.unwrap().file_name().to_str()?.strip_suffix(".lens").map(str::to_owned))
        .collect();
    names.sort();
    assert_eq!(names.len(), 39);
    names
}

/// Names of the lenses of the reference data that need terms of higher order.
pub const ASPHERES: [&str; 2] = ["cellphone-radial-polynomial", "schmidt-flat-field"];

/// A reference lens as published.
pub fn prescription(name: &str) -> Prescription {
    if ASPHERES.contains(&name) {
        return lens::parse(&aspheric_lens_file(name), name, Catalogue::shipped()).unwrap_or_else(|e| panic!("{e}"));
    }
    let path = repository("tests/reference/lenses").join(format!("{name}.lens"));
    lens::read(&path, Catalogue::shipped()).unwrap_or_else(|e| panic!("{e}"))
}

/// The rows of a lens that the reference data hold as JSON, as a lens file.
fn aspheric_lens_file(name: &str) -> String {
    let lens = reference_json(&format!("lenses/{name}.json"));
    let powers: Vec<String> = (2..=20).map(|power| format!("a{power}")).collect();
    let mut text = format!("#radius thickness glass diameter conic isstop {}\n", powers.join(" "));
    for row in lens["surfaces"].as_array().unwrap() {
        let words: Vec<String> = (0..6).map(|i| row[i].as_str().map_or(row[i].to_string(), str::to_owned)).collect();
        let mut terms = vec!["0".to_owned(); 19];
        for term in row[6].as_array().unwrap() {
            terms[term[0].as_u64().unwrap() as usize - 2] = term[1].as_str().unwrap().to_owned();
        }
        text += &format!("{} {}\n", words.join(" "), terms.join(" "));
    }
    text
}

/// A reference lens, wide open.
pub fn system(name: &str) -> System {
    System::new(&prescription(name), &LensSettings::default()).unwrap()
}

/// A number, written as one or as a decimal string.
pub fn number(value: &Value) -> f64 {
    match value {
        Value::String(text) => text.parse().unwrap(),
        other => other.as_f64().unwrap_or_else(|| panic!("{other} is no number")),
    }
}

/// Three numbers.
pub fn vector(value: &Value) -> DVec3 {
    DVec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}
