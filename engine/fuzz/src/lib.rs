//! The properties that fuzz targets test, by the targets' names. No target knows of libFuzzer: a test of the stable compiler replays the kept
//! corpora through the same functions.
//!
//! A reader of anything gives an answer or an error of one line, and never panics; an answer then does what it is for, with finite numbers.

// Each of its users, the targets and the test, leaves some of it unused.
#![allow(dead_code, unreachable_pub)]

pub mod bytes;
pub mod calibrations;
pub mod films;
pub mod graphs;
pub mod lenses;
pub mod pictures;
pub mod scenes;
pub mod sensors;
pub mod systems;

use std::fmt::Display;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// A property of an input's bytes.
pub type Property = fn(&[u8]);

/// The targets, in the order of their names.
pub const TARGETS: [(&str, Property); 30] = [
    ("agf", lenses::catalogue),
    ("bench", |bytes| lenses::lens(bytes, "x.txt")),
    ("calibration", calibrations::calibration),
    ("camera", sensors::camera),
    ("checkpoint", films::checkpoint),
    ("coating", lenses::coating),
    ("convert", lenses::convert),
    ("flaresim", lenses::flaresim),
    ("gradient", systems::gradient),
    ("graph", graphs::graph),
    ("ies", graphs::ies),
    ("lens", |bytes| lenses::lens(bytes, "x.lens")),
    ("lensfun", calibrations::lensfun),
    ("mask", lenses::mask),
    ("merge", pictures::merge_inputs),
    ("nodes", graphs::nodes),
    ("oslo", |bytes| lenses::lens(bytes, "x.len")),
    ("pbrt", |bytes| lenses::lens(bytes, "x.dat")),
    ("rays", lenses::rays),
    ("rii", lenses::glass_page),
    ("scene", scenes::scene),
    ("sensor", sensors::sensor),
    ("seq", |bytes| lenses::lens(bytes, "x.seq")),
    ("settings", sensors::settings),
    ("share", films::share),
    ("st_map", calibrations::st_map),
    ("surface", lenses::surface),
    ("system", systems::system),
    ("texture", scenes::texture),
    ("zmx", |bytes| lenses::lens(bytes, "x.zmx")),
];

/// The property of a target.
///
/// # Panics
/// If there is no such target.
pub fn property(target: &str) -> Property {
    let found = TARGETS.iter().find(|(name, _)| *name == target);
    found.unwrap_or_else(|| panic!("there is no target {target}")).1
}

/// Asserts that a message is one line.
pub(crate) fn one_line(message: &dyn Display) {
    let text = message.to_string();
    assert!(!text.contains('\n'), "{text}");
}

/// A folder of its own, removed at the end.
pub(crate) struct Scratch(PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("petzval-fuzz-{}-{name}-{number}", std::process::id()));
        assert!(std::fs::create_dir_all(&folder).is_ok(), "{}", folder.display());
        Self(folder)
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
