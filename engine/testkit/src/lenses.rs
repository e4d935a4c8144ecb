//! The lens files for tests that go through all lenses.

use std::path::{Path, PathBuf};

/// The gradient-index eye: its rays are integrated step by step, and a camera with it takes 20 s to set up.
const SLOW: &str = "eye-liou-brennan.lens";

/// The paths of the `.lens` files in `folder`, sorted. The slow gradient-index eye is left out unless [`is_thorough`](crate::is_thorough);
/// `tests/lens/test_white_world.py` has it in every run.
///
/// # Panics
/// If the folder cannot be read.
pub fn shipped(folder: impl AsRef<Path>) -> Vec<PathBuf> {
    let folder = folder.as_ref();
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "lens"));
    if !crate::is_thorough() {
        paths.retain(|path| !path.ends_with(SLOW));
    }
    paths.sort();
    paths
}

/// Every third of the [`shipped`] lenses, from number `first` on: for tests that take a second or so for each lens. All of them if
/// [`is_thorough`](crate::is_thorough).
///
/// # Panics
/// If the folder cannot be read.
pub fn third(folder: impl AsRef<Path>, first: usize) -> Vec<PathBuf> {
    let step = if crate::is_thorough() { 1 } else { 3 };
    shipped(folder).into_iter().skip(first % step).step_by(step).collect()
}
