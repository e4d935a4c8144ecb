//! Rendered pictures in files.

use crate::doorway::away;
use crate::error::Error;
use petzval_pictures::merge;
use pyo3::prelude::*;
use serde_json::json;
use std::path::PathBuf;

#[pyfunction]
pub(crate) fn merge_pictures_json(py: Python<'_>, files: Vec<PathBuf>, output: PathBuf) -> Result<String, Error> {
    let merged = away(py, || merge::merge(&files, &output))??;
    Ok(json!({"samples": merged.samples, "is_exact": merged.is_exact}).to_string())
}
