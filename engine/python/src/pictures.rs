//! Rendered pictures in files.

use crate::error::Error;
use crate::gil::without_gil;
use crate::memory::free_memory_bytes;
use petzval_pictures::{complete, merge};
use pyo3::prelude::*;
use serde_json::json;
use std::path::PathBuf;

#[pyfunction]
pub(crate) fn merge_pictures_json(py: Python<'_>, files: Vec<PathBuf>, output: PathBuf) -> Result<String, Error> {
    let memory_bytes = free_memory_bytes().unwrap_or(u64::MAX);
    let merged = without_gil(py, || merge::merge(&files, &output, memory_bytes))??;
    Ok(json!({"samples": merged.samples, "is_exact": merged.is_exact}).to_string())
}

/// See the stub.
#[pyfunction]
pub(crate) fn check_exr(py: Python<'_>, file: PathBuf) -> Result<[usize; 2], Error> {
    Ok(without_gil(py, || complete::size_of_complete(&file))??)
}
