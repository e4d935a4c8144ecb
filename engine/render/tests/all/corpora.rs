//! The kept corpora of the fuzz targets (`engine/fuzz`), through the same properties on a stable compiler.

#[path = "../../../fuzz/src/lib.rs"]
mod fuzz;

use fuzz::systems::{Compared, compared};
use fuzz::{TARGETS, films};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz")
}

/// The kept inputs of a target, by their names.
fn inputs(target: &str) -> Vec<(String, Vec<u8>)> {
    let files = std::fs::read_dir(folder().join("corpus").join(target)).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<_> = files.map(|path| (path.display().to_string(), std::fs::read(&path).unwrap())).collect();
    found.sort();
    found
}

fn stems(of: &str) -> BTreeSet<String> {
    let files = std::fs::read_dir(folder().join(of)).unwrap().map(|entry| entry.unwrap().path());
    files.map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect()
}

#[test]
fn every_kept_input_has_its_property() {
    for (target, property) in TARGETS {
        let inputs = inputs(target);
        assert!(inputs.len() >= 2, "{target}: {} kept inputs", inputs.len());
        for (name, bytes) in inputs {
            // Shown where the property fails.
            println!("{name}");
            property(&bytes);
        }
    }
}

#[test]
fn every_target_is_there() {
    let names: BTreeSet<String> = TARGETS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(names.len(), TARGETS.len());
    assert_eq!(stems("fuzz_targets"), names);
    assert_eq!(stems("corpus"), names);
    let manifest = std::fs::read_to_string(folder().join("Cargo.toml")).unwrap();
    assert!(names.iter().all(|name| manifest.contains(&format!("path = \"fuzz_targets/{name}.rs\""))));
}

/// Whole films, as they are written today, are taken up: so the kept ones, which are made of such, reach what lies behind checksums.
#[test]
fn whole_films_are_taken_up() {
    let [(_, checkpoints), (_, shares)] = films::seeds();
    assert!(checkpoints.iter().all(|bytes| films::takes_up(bytes)));
    assert!(shares.iter().all(|bytes| films::joins(bytes)));
}

/// The rays of the kept systems are held against exact ones, not all left out as such of which the data tell nothing.
#[test]
fn the_exact_tracer_judges() {
    let mut sum = Compared::default();
    for (_, bytes) in inputs("system") {
        let one = compared(&bytes);
        sum = Compared {
            hits: sum.hits + one.hits,
            directions: sum.directions + one.directions,
            losses: sum.losses + one.losses,
        };
    }
    assert!(sum.hits > 100 && sum.directions > 40 && sum.losses > 20, "{sum:?}");
}
