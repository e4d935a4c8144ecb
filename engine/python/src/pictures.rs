//! Rendered pictures in files.

use crate::doorway::away;
use crate::error::Error;
use crate::memory::free_memory_bytes;
use petzval_pictures::{complete, merge};
use pyo3::prelude::*;
use serde_json::json;
use std::path::PathBuf;

#[pyfunction]
pub(crate) fn merge_pictures_json(py: Python<'_>, files: Vec<PathBuf>, output: PathBuf) -> Result<String, Error> {
    let memory_bytes = free_memory_bytes().unwrap_or(u64::MAX);
    let merged = away(py, || merge::merge(&files, &output, memory_bytes))??;
    Ok(json!({"samples": merged.samples, "is_exact": merged.is_exact}).to_string())
}

/// See the stub.
#[pyfunction]
pub(crate) fn check_exr(py: Python<'_>, file: PathBuf) -> Result<[usize; 2], Error> {
    Ok(away(py, || complete::size_of_complete(&file))??)
}
